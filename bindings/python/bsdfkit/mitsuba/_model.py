"""A whole BSDF on flat arrays: the four pairs of sides, Lambertian parts, trees, matrices and render forms together."""

from types import SimpleNamespace

import bsdfkit
import drjit as dr
import mitsuba as mi
import numpy as np

from .._flat import BACK, FRONT, flat, pair_of
from ._matrices import Matrices, rings_of
from ._renders import Renders
from ._square import square_to_disk
from ._trees import Trees

# Totals below this scatter nothing, as in bsdfkit.
BLACK = 1e-6
# The largest number below 1.
LAST = 1.0 - 2.0**-24


class Model:
    """Answers eval, pdf and sample of arrays of directions."""

    def __init__(self, bsdf):
        # The types of the variant that is set now; a query may come when another one is.
        self.types = T = SimpleNamespace(
            Float=mi.Float, UInt32=mi.UInt32, Bool=mi.Bool, Two=mi.Vector2f, Vector=mi.Vector3f, Four=mi.Vector4f,
            Single=dr.float32_array_t(mi.Float), Half=dr.float16_array_t(mi.Float), FourHalves=dr.float16_array_t(mi.Vector4f),
        )
        self.representations = {c.representation for c in bsdf.components}
        arrays = flat(bsdf)
        for pair in range(4):
            if len(arrays.of(pair)) > 1:
                raise bsdfkit.LimitError("expected one component a pair of sides, found more: use a scalar variant")
        self.groups = []
        renders = [a for a in arrays.answers if a.stored.render]
        if renders:
            self.groups.append(Renders(renders, T))
        for rank in (3, 4):
            own = [a for a in arrays.answers if a.stored.is_tree and a.stored.rank == rank]
            if own:
                self.groups.append(Trees(own, T, lambda levels: _grid(bsdf, levels)))
        matrices = [a for a in arrays.answers if not (a.stored.is_tree or a.stored.render)]
        while matrices:
            bases = rings_of(matrices[0])
            alike = [a for a in matrices if all(np.array_equal(x, y) for x, y in zip(rings_of(a), bases))]
            self.groups.append(Matrices(alike, T))
            matrices = [a for a in matrices if not any(a is b for b in alike)]
        grey = np.all(arrays.lambertian == arrays.lambertian[:, 1:2])
        self.coloured = not grey or any(g.coloured for g in self.groups)
        channels = (1, 0, 2) if self.coloured else (1,)
        self.lambertian = T.Float(arrays.lambertian[:, channels].T.astype(np.float32).ravel())
        self.drawn_lambertian = T.Float(arrays.lambertian[:, 1].astype(np.float32))
        self.diffuse = arrays.lambertian[:, 1] > 0.0
        self.glossy = np.array([bool(arrays.of(p)) for p in range(4)])
        # Whether a draw tells its f: nowhere two parts, no colour, no table but f's own, no render form.
        self.told = not self.coloured and not (self.diffuse & self.glossy).any()
        self.told &= not any(isinstance(g, Renders) or isinstance(g, Trees) and g.grids for g in self.groups)
        self.anisotropic = any(g.anisotropic for g in self.groups)

    def _on(self, pairs, pair, selection, active):
        """Lanes whose pair is in `pairs` and whose sense is selected: (reflection, transmission)."""
        found = self.types.Bool(False)
        for p in pairs:
            if selection[0 if p in (0, 3) else 1]:
                found |= pair == p
        return found & active

    def _pair(self, wi, wo):
        T = self.types
        return dr.select(wi.z > 0.0, T.UInt32(0), T.UInt32(2)) + dr.select(wo.z > 0.0, T.UInt32(0), T.UInt32(1))

    def eval(self, wi, wo, active, selection, pair=None):
        """f, 1/sr: (x, y, z) with x and z None where the data are grey, and what draws are in proportion to; `pair` where it is known."""
        pair = self._pair(wi, wo) if pair is None else pair
        T = self.types
        lambertian = self._on(range(4), pair, selection, active)
        count = 3 if self.coloured else 1
        f = [dr.gather(T.Float, self.lambertian, pair + 4 * c, lambertian) * dr.inv_pi for c in range(count)]
        drawn = dr.gather(T.Float, self.drawn_lambertian, pair, lambertian) * dr.inv_pi
        for group in self.groups:
            on = self._on(group.pairs, pair, selection, active)
            (x, y, z), own_drawn = group.value_and_drawn(pair, wi, wo, on)
            found = (y, y if x is None else x, y if z is None else z)
            for c in range(count):
                f[c] += dr.select(on, found[c], 0.0)
            drawn += own_drawn
        return (f[1], f[0], f[2]) if self.coloured else (None, f[0], None), drawn

    def totals(self, wi, active, selection):
        """Totals of Lambertian reflection and transmission and of the others, and where draws of these begin."""
        T = self.types
        back = ~(wi.z > 0.0)
        pairs = dr.select(back, T.UInt32(3), T.UInt32(0)), dr.select(back, T.UInt32(2), T.UInt32(1))
        found, begins = [], []
        for sense, pair in enumerate(pairs):
            on = self._on(range(4), pair, selection, active)
            found.append(dr.gather(T.Float, self.drawn_lambertian, pair, on))
        for sense, pair in enumerate(pairs):
            total, begin = T.Float(0.0), {}
            for n, group in enumerate(self.groups):
                if selection[sense] and any((p in (0, 3)) == (sense == 0) for p in group.pairs):
                    on = self._on(group.pairs, pair, selection, active)
                    own, begin[n] = group.total(pair, wi, on)
                    total += own
            found.append(total)
            begins.append(begin)
        return found, begins

    def pdf(self, wi, wo, drawn, active, selection):
        """Density of `sample`, 1/sr of solid angle."""
        totals, _ = self.totals(wi, active, selection)
        total = totals[0] + totals[1] + totals[2] + totals[3]
        return dr.select(active & (total > BLACK), drawn * dr.abs(wo.z) / total, 0.0)

    def sample(self, wi, u1, u2, active, selection):
        """A direction, its pair of sides, whether it is transmitted, whether there is one, the total; f where `self.told`, else None."""
        T = self.types
        totals, begins = self.totals(wi, active, selection)
        total = totals[0] + totals[1] + totals[2] + totals[3]
        target, part, sum_ = u1 * total, T.UInt32(0), T.Float(0.0)
        below, own = T.Float(0.0), totals[0]
        last = T.UInt32(0)
        for n in range(4):
            # Beyond the last one that is not empty rounding does not lead.
            last = dr.select(totals[n] > 0.0, n, last)
        for n in range(3):
            sum_ += totals[n]
            ahead = (target >= sum_) & (n < last)
            part = dr.select(ahead, n + 1, part)
            below, own = dr.select(ahead, sum_, below), dr.select(ahead, totals[n + 1], own)
        # What is left of the number that chose the part is another one.
        spare = dr.clip((target - below) / dr.select(own > 0.0, own, 1.0), 0.0, LAST)
        u = SimpleNamespace(x=u2.x, y=u2.y, spare=spare)
        active &= total > BLACK
        transmitted = (part & 1) == 1
        x = y = T.Float(0.0)
        if self.diffuse.any():
            x, y = square_to_disk(u2.x, u2.y)
        f = None
        front = wi.z > 0.0
        pair = dr.select(transmitted, dr.select(front, T.UInt32(1), T.UInt32(2)), dr.select(front, T.UInt32(0), T.UInt32(3)))
        told = self.told and all(g.original for g in self.groups)
        if told:
            f = dr.gather(T.Float, self.lambertian, pair, active) * dr.inv_pi
        for n, group in enumerate(self.groups):
            on = self._on(group.pairs, pair, selection, active & (part >= 2))
            reflected, crossed = begins[0].get(n), begins[1].get(n)
            if reflected is None and crossed is None:
                continue
            if reflected is None or crossed is None:
                begin = crossed if reflected is None else reflected
            else:
                begin = dr.select(transmitted, crossed, reflected)
            gx, gy, value = group.draw(pair, wi, begin, u, on)
            x, y = dr.select(on, gx, x), dr.select(on, gy, y)
            if told:
                f = dr.select(on, value, f)
        z = dr.sqrt(dr.maximum(1.0 - dr.fma(x, x, y * y), 1e-8))
        wo = T.Vector(x, y, dr.select(front ^ transmitted, z, -z))
        return wo, pair, transmitted, active, total, f

    def diffuse_reflectance(self, wi, active):
        """Reflectance (x, y, z) of the Lambertian parts."""
        pair = dr.select(wi.z > 0.0, self.types.UInt32(0), self.types.UInt32(3))
        count = 3 if self.coloured else 1
        f = [dr.gather(self.types.Float, self.lambertian, pair + 4 * c, active) for c in range(count)]
        return (f[1], f[0], f[2]) if count == 3 else (None, f[0], None)

    def parameters(self):
        """Names of what can be changed, and the object and the attribute where it is."""
        yield "lambertian", self, "lambertian"
        for n, group in enumerate(self.groups):
            prefix = "" if len(self.groups) == 1 else f"group{n}_"
            for name in group.parameters():
                yield prefix + name, group, name

    def changed(self, keys):
        """Takes note of changed parameters: draws of Lambertian parts follow, others stay those of the file."""
        self.drawn_lambertian = self.types.Float(
            dr.gather(self.types.Float, dr.detach(self.lambertian), dr.arange(self.types.UInt32, 4))
        )
        for group in self.groups:
            group.original &= bool(keys) and not any(k.endswith("values") for k in keys)


def _grid(bsdf, levels):
    """f of light from the back to the front or the other way, whichever is stored the other way round alone.

    Means of four points a cell: shape (known, n, n), n = 2^levels, known = n / 2.
    """
    stored = next(c for c in bsdf.components if c.incident != c.scattered)
    side = 1.0 if stored.scattered == "front" else -1.0
    n = 1 << levels
    known = (np.arange(n // 2) + 0.5) / n
    sine = 1.0 - 2.0 * known
    # Travel direction +X: so light comes from -X.
    wi = np.stack([-sine, np.zeros_like(sine), side * np.sqrt(1.0 - sine**2)], axis=-1)
    at = (np.arange(2 * n) + 0.5) / (2 * n)
    t, s = np.meshgrid(at, at, indexing="ij")
    a, b = 2.0 * s - 1.0, 2.0 * t - 1.0
    wide = np.abs(a) > np.abs(b)
    small, large = np.where(wide, b, a), np.where(wide, a, b)
    turn = np.where(large == 0.0, 0.0, small / np.where(large == 0.0, 1.0, large)) * (np.pi / 4.0)
    x, y = large * np.cos(turn), large * np.sin(turn)
    x, y = np.where(wide, x, y), np.where(wide, y, x)
    wo = np.stack([x, y, -side * np.sqrt(np.maximum(1.0 - x * x - y * y, 0.0))], axis=-1)
    chosen = bsdfkit.Components.TRANSMISSION & bsdfkit.Components.NON_LAMBERTIAN
    f = bsdf.eval(wi[:, None, None], wo[None], components=chosen)
    return f.reshape(n // 2, n, 2, n, 2).mean(axis=(2, 4))
