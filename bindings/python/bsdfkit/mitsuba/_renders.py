"""Queries of render forms by gathers, for the llvm and cuda variants.

Convention: `bindings/c/include/bsdfkit_device_render.h` explains every step; names are alike. Draws differ: there the tables of the
nodes about an incidence are blended; here one of them is chosen by its share, which has the same density and a third of the gathers.
"""

from types import SimpleNamespace

import drjit as dr
import numpy as np

from ._bank import ISOTROPIC, PLANE, Bank
from ._chart import Chart
from ._numbers import Numbers, select
from ._square import square_to_disk

_LAST = 1.0 - 2.0**-24
# Distance over `core` about the peak within which densities are those there.
_MIDDLE = 1e-6


class Renders:
    """The render forms of a BSDF; answers as `Trees`."""

    def __init__(self, answers, types):
        self.types = T = types
        self.pairs = [a.pair for a in answers]
        bank, numbers = Bank(), {}
        own, draws = np.zeros(4, np.uint32), np.zeros(4, np.uint32)
        swapped, even = np.zeros(4, bool), np.zeros(4, bool)
        for a in answers:
            if id(a.stored) not in numbers:
                numbers[id(a.stored)] = bank.add(a.stored.render, a.stored.arrays)
            own[a.pair] = draws[a.pair] = numbers[id(a.stored)]
            swapped[a.pair] = a.swapped
            if a.swapped:
                reverse = a.stored.render.get("reverse")
                if reverse is None:
                    # Without a table to draw from, all directions are as likely as their projected solid angle.
                    even[a.pair] = True
                else:
                    draws[a.pair] = bank.add(reverse, a.stored.arrays, "render.reverse")
        bank.finish()
        self.table, self.layer = Numbers(bank.tables, T), Numbers(bank.layers, T)
        self._own, self._draws = self._by_pair(own, bank.count), self._by_pair(draws, bank.count)
        self.swapped, self.even = T.Bool(swapped) if swapped.any() else None, T.Bool(even) if even.any() else None
        both = {0, 3} & set(self.pairs) and {1, 2} & set(self.pairs)
        self.shared = bool(both) and self.swapped is None and not isinstance(self._own, int)
        self.most_layers = int(bank.tables["layers"].max())
        self.coloured = bool(bank.layers["coloured"].any())
        folds = bank.tables["fold"]
        self.chart = Chart(self.table, folds, T)
        self.anisotropic = bool((folds < ISOTROPIC).any())
        self.values = T.Float(bank.arrays["values"])
        self.still = bank.still
        self.poses = T.Float(bank.arrays["light" if self.still else "poses"])
        self.cells, self.density = T.Half(bank.arrays["cells"]), T.Half(bank.arrays["density"])
        self.sums, self.running = T.Float(bank.arrays["sums"]), T.Float(bank.arrays["running"])
        self.colour = T.Float(bank.arrays["colour"]) if self.coloured else None
        self.angle_steps = int(bank.layers["drawn_angles"].max() - 1).bit_length()
        self.block_steps = int(bank.layers["drawn_radii"].max() // 4 - 1).bit_length()
        # Until `values` is changed they are read by cells; draws have tables of their own, whatever becomes of it.
        self.original = True

    def _by_pair(self, numbers, count):
        return 0 if count == 1 else Numbers({"table": numbers}, self.types)

    def _pick(self, numbers, pair):
        return numbers if isinstance(numbers, int) else numbers("table", pair)

    def parameters(self):
        """Names of the attributes that can be changed: values of all layers, one after the other, 1/sr."""
        return ["values"]

    def _blend(self, array, nodes, at, stride):
        """Σ weight · array[at + node · stride]."""
        return sum(w * dr.gather(self.types.Float, array, node * stride + at) for node, w in nodes)

    # Layers.

    def _placed(self, layer, seen):
        """A layer's plane at one incidence: q = stretch (cosines - centre), or stretch slope; and the total there."""
        T, L = self.types, self.layer
        if self.still:
            cx, cy, xx, xy, yy = (T.Float(L(name, layer)) for name in PLANE)
            at = L("light_at", layer) // 2
            rows = [(dr.gather(T.Two, self.poses, node + at), w) for node, w in seen.fine]
            factor, total = (sum(w * row[k] for row, w in rows) for k in (0, 1))
        else:
            halves, at = [], L("poses_at", layer) // 4
            for half in (0, 1):
                rows = [(dr.gather(T.Four, self.poses, node * 2 + (at + half)), w) for node, w in seen.fine]
                halves.append([sum(w * row[k] for row, w in rows) for k in range(4)])
            (cx, cy, xx, xy), (yy, factor, total, _) = halves
        det = dr.fma(xx, yy, -(xy * xy))
        sound = (xx > 0.0) & (yy > 0.0) & (xx + yy < 1e5) & (det > 1e-6 * xx * yy)
        xx, xy, yy, det = (dr.select(sound, a, b) for a, b in ((xx, 1.0), (xy, 0.0), (yy, 1.0), (det, 1.0)))
        slopes = L("slopes", layer)
        f = L("factor", layer)
        x, y = seen.x * f + cx, seen.y * f + cy
        length = dr.sqrt(dr.fma(x, x, y * y))
        kept = dr.select(length > 0.995, 0.995 / dr.maximum(length, 0.995), 1.0)
        off = select(slopes, T.Bool(True), T.Bool(False)) | ~dr.isfinite(length)
        x, y = (dr.select(off, 0.0, c * kept) for c in (x, y))
        return SimpleNamespace(x=x, y=y, xx=xx, xy=xy, yy=yy, det=det, factor=factor, total=total, slopes=slopes)

    def _unstretched(self, p, x, y):
        return (p.yy * x - p.xy * y) / p.det, (p.xx * y - p.xy * x) / p.det

    def _place(self, p, seen, x, y, z):
        a, b = select(p.slopes, (seen.x + x) / (seen.z + z), x - p.x), select(p.slopes, (seen.y + y) / (seen.z + z), y - p.y)
        return dr.fma(p.xx, a, p.xy * b), dr.fma(p.xy, a, p.yy * b)

    def _direction(self, p, seen, qx, qy):
        """x and y, turned, of the scattered direction at a place; on the rim where that is beyond it."""
        vx, vy = self._unstretched(p, qx, qy)
        twice = 2.0 * (seen.x * vx + seen.y * vy + seen.z) / (vx * vx + vy * vy + 1.0)
        x = select(p.slopes, vx * twice - seen.x, p.x + vx)
        y = select(p.slopes, vy * twice - seen.y, p.y + vy)
        inside = 1.0 / dr.maximum(dr.sqrt(dr.fma(x, x, y * y)), 1.0)
        return x * inside, y * inside

    def _area(self, p, seen, x, y, z):
        """Area of the plane per projected solid angle."""
        length = dr.sqrt(dr.maximum(2.0 + 2.0 * (seen.x * x + seen.y * y + seen.z * z), 1e-12))
        cosine = (seen.z + z) / length
        under = dr.maximum(z, 1e-9) * 2.0 * length * cosine * cosine * cosine
        return p.det * select(p.slopes, 1.0 / under, self.types.Float(1.0))

    def _reach(self, p, seen, ex, ey):
        """How far it is from the peak to the horizon along a unit vector."""
        dx, dy = self._unstretched(p, ex, ey)
        b = select(p.slopes, (dx * seen.x + dy * seen.y) / seen.z, -(dx * p.x + dy * p.y))
        c = select(p.slopes, self.types.Float(1.0), dr.maximum(1.0 - p.x * p.x - p.y * p.y, 1e-6))
        squared = dr.fma(dx, dx, dy * dy)
        root = dr.sqrt(dr.fma(b, b, squared * c))
        return dr.select(b >= 0.0, (b + root) / squared, c / dr.select(b >= 0.0, 1.0, root - b))

    def _scale(self, layer, distance):
        return dr.log(1.0 + distance / self.layer("core", layer))

    def _cell(self, angle, t, angles, radii):
        """Numbers of the cell by angle and distance, and the place in it."""
        T = self.types
        as_float = lambda n: n if isinstance(n, int) else T.Float(n)
        a, r = angle * as_float(angles), t * as_float(radii)
        i, k = (dr.minimum(T.UInt32(dr.maximum(c, 0.0)), n - 1) for c, n in ((a, angles), (r, radii)))
        return i, k, a - T.Float(i), r - T.Float(k)

    def _gathered(self, array, cell):
        T = self.types
        return [T.Float(c) for c in dr.gather(T.FourHalves, array, cell)]

    def _corners(self, array, cell, fa, ft):
        """One node's four neighbours that lie side by side, blended."""
        l0, l1, h0, h1 = self._gathered(array, cell)
        low, high = dr.fma(ft, l1 - l0, l0), dr.fma(ft, h1 - h0, h0)
        return dr.fma(fa, high - low, low)

    def _four(self, array, at, radii, fa, ft, stride=1):
        """One node's four neighbours, blended."""
        (l0, l1), (h0, h1) = (
            [dr.gather(self.types.Float, array, at + (row + k) * stride) for k in (0, 1)] for row in (0, radii + 1)
        )
        low, high = dr.fma(ft, l1 - l0, l0), dr.fma(ft, h1 - h0, h0)
        return dr.fma(fa, high - low, low)

    def _values(self, layer, seen, angle, scaled):
        """Y, and X and Z where something has colour, of a layer but for its factor."""
        L = self.layer
        t = dr.minimum(scaled * L("over_far", layer), 1.0)
        angles, radii = L("angles", layer), L("radii", layer)
        i, k, fa, ft = self._cell(angle, t, angles, radii)
        if self.original:
            first = i * radii + k + L("cells_at", layer) // 4
            unit, size = L("value_unit", layer), angles * radii
            own = [w * unit * self._corners(self.cells, node * size + first, fa, ft) for node, w in seen.nodes]
        else:
            first, size = i * (radii + 1) + k + L("values_at", layer), (angles + 1) * (radii + 1)
            own = [w * self._four(self.values, node * size + first, radii, fa, ft) for node, w in seen.nodes]
        y = sum(own)
        if not self.coloured:
            return (y,)
        angles, radii = L("colour_angles", layer), L("colour_radii", layer)
        i, k, fa, ft = self._cell(angle, t, angles, radii)
        first, at, size = i * (radii + 1) + k, L("colour_at", layer), (angles + 1) * (radii + 1)
        tint = lambda node, c: self._four(self.colour, (node * size + first) * 2 + (at + c), radii, fa, ft, 2)
        x, z = (sum(v * tint(node, c) for v, (node, _) in zip(own, seen.nodes)) for c in (0, 1))
        return y, x, z

    def _dense(self, layer, p, seen, qx, qy, angle, scaled):
        """The density over a layer's plane."""
        L = self.layer
        core = L("core", layer)
        length2 = dr.fma(qx, qx, qy * qy)
        length = dr.sqrt(length2)
        some = length > 0.0
        safe = dr.select(some, length, 1.0)
        ex, ey = dr.select(some, qx / safe, 1.0), dr.select(some, qy / safe, 0.0)
        whole = self._scale(layer, self._reach(p, seen, ex, ey))
        v = dr.clip(scaled / whole, _MIDDLE / whole, 1.0)
        sum_ = dr.abs(ex) + dr.abs(ey)
        rho = dr.maximum(length, _MIDDLE * core)
        angles, radii = L("drawn_angles", layer), L("drawn_radii", layer)
        i, k, fa, ft = self._cell(angle, v, angles, radii)
        first = i * radii + k + L("density_at", layer) // 4
        stored = sum(w * self._corners(self.density, node * (angles * radii) + first, fa, ft) for node, w in seen.nodes)
        return L("drawn_unit", layer) * stored / (rho * (rho + core) * whole * sum_ * sum_)

    def _mass(self, layer, p, seen):
        """The integral of a layer's density over the hemisphere, times its factor."""
        angles = self.layer("drawn_angles", layer)
        run = self._blend(self.running, seen.nodes, self.layer("running_at", layer) + angles, angles + 1)
        return p.factor * run * self.layer("mass_unit", layer)

    def _mix(self, table, pair, wi, wo, values, density):
        """f (as `_values`), and what draws are in proportion to: of all layers."""
        T = self.types
        seen, plane = self._seen(table, pair, wi)
        x = dr.fma(seen.turn[0], wo.x, seen.turn[1] * wo.y)
        y = dr.fma(seen.turn[2], wo.x, seen.turn[3] * wo.y)
        z = dr.abs(wo.z)
        first, count, span = (self.table(n, table) for n in ("first", "layers", "span"))
        f, drawn, mass = [T.Float(0.0)] * (3 if self.coloured else 1), T.Float(0.0), T.Float(0.0)
        total = None
        for n in range(self.most_layers):
            there = n < count
            layer = first + n if isinstance(there, bool) else first + dr.select(there, T.UInt32(n), 0)
            p = self._placed(layer, seen) if n else plane
            factor = p.factor if isinstance(there, bool) else dr.select(there, p.factor, 0.0)
            total = p.total if total is None else total
            qx, qy = self._place(p, seen, x, y, z)
            sum_ = dr.abs(qx) + dr.abs(qy)
            part = dr.select(sum_ > 0.0, dr.abs(qy) / dr.select(sum_ > 0.0, sum_, 1.0), 0.0)
            half = dr.select(qx >= 0.0, part, 2.0 - part)
            folded = select(span < 4.0, half, dr.select(qy >= 0.0, half, 4.0 - half))
            angle = folded / span
            scaled = self._scale(layer, dr.sqrt(dr.fma(qx, qx, qy * qy)))
            if values:
                f = [dr.fma(factor, own, so_far) for own, so_far in zip(self._values(layer, seen, angle, scaled), f)]
            if density:
                p.factor = factor
                own = self._dense(layer, p, seen, qx, qy, angle, scaled)
                drawn = dr.fma(factor * own, self._area(p, seen, x, y, z), drawn)
                mass += self._mass(layer, p, seen)
        if density:
            drawn = dr.select(mass > 0.0, drawn / dr.select(mass > 0.0, mass, 1.0) * total, 0.0)
        return f, drawn

    def _seen(self, table, pair, wi):
        """What `table` sees of an incident direction, and its first layer's plane.

        Totals take both tables of a side in any case: one is chosen of what these see, instead of asking a third time.
        """
        if not self.shared:
            seen = self.chart.see(table, wi)
            return seen, self._placed(self.table("first", table), seen)
        back, number = ~(wi.z > 0.0), self.types.UInt32
        found = []
        for behind, before in ((3, 0), (2, 1)):
            own = self._pick(self._own, dr.select(back, number(behind), number(before)))
            seen = self.chart.see(own, wi)
            found.append((seen, self._placed(self.table("first", own), seen)))
        (seen, plane), (other, crossed) = found
        transmitted = (pair == 1) | (pair == 2)
        return _either(transmitted, other, seen), _either(transmitted, crossed, plane)

    # The queries.

    def value_and_drawn(self, pair, wi, wo, active):
        """f as stored, 1/sr: (X, Y, Z), X and Z None where nothing has colour; and what `draw` draws in proportion to."""
        own, draws = self._pick(self._own, pair), self._pick(self._draws, pair)
        if self.swapped is None:
            f, drawn = self._mix(own, pair, wi, wo, True, True)
        else:
            swapped = dr.gather(self.types.Bool, self.swapped, pair)
            f, _ = self._mix(own, pair, dr.select(swapped, wo, wi), dr.select(swapped, wi, wo), True, False)
            _, drawn = self._mix(draws, pair, wi, wo, False, True)
            if self.even is not None:
                even = dr.gather(self.types.Bool, self.even, pair)
                drawn = dr.select(even, self.table("most", own) * dr.inv_pi, drawn)
        f = [dr.select(active, c, 0.0) for c in f]
        return ((f[1], f[0], f[2]) if self.coloured else (None, f[0], None)), dr.select(active, dr.detach(drawn), 0.0)

    def total(self, pair, wi, active):
        """∫ drawn |cos θo| dωo; draws need nothing else to begin."""
        T, table = self.types, self._pick(self._draws, pair)
        total = self._placed(self.table("first", table), self.chart.see(table, wi)).total
        if self.even is not None:
            even = dr.gather(T.Bool, self.even, pair)
            total = dr.select(even, self.table("most", self._pick(self._own, pair)), total)
        return dr.select(active, total, 0.0), T.UInt32(0)

    def draw(self, pair, wi, begin, u, active):
        """A point (x, y) of the disk with density `drawn` / `total`; its value is not told."""
        T, L = self.types, self.layer
        table = self._pick(self._draws, pair)
        seen, p = self._seen(table, pair, wi)
        layer, ux, uy = self._chosen(table, seen, u)
        if self.most_layers > 1:
            p = self._placed(layer, seen)
        span, angles = self.table("span", table), L("drawn_angles", layer)
        halved, other = span < 4.0, ux >= 0.5
        turn = select(halved, dr.select(other, 2.0 - 2.0 * ux, 2.0 * ux), ux)
        running = lambda node, column: dr.gather(T.Float, self.running, node * (angles + 1) + (L("running_at", layer) + column))
        node, whole = self._drawn_from(seen, running, angles, u.spare)
        target = turn * whole
        low, high = T.UInt32(0), T.UInt32(angles)
        for _ in range(self.angle_steps):
            middle = (low + high) >> 1
            ahead = (middle > low) & (running(node, middle) <= target)
            low, high = dr.select(ahead, middle, low), dr.select(ahead | (middle <= low), high, middle)
        radii = L("drawn_radii", layer)
        last = radii // 4
        sums_at, density_at = L("sums_at", layer), L("density_at", layer)
        column = node * (angles + 1) + low
        sums = lambda side, block: dr.gather(T.Float, self.sums, (column + side) * (last + 1) + (sums_at + block))
        tau = _along(sums(0, last), sums(1, last), target - running(node, low))
        between = lambda block: dr.lerp(sums(0, block), sums(1, block), tau)
        target = uy * between(last)
        block, end = T.UInt32(0), T.UInt32(last)
        for _ in range(self.block_steps):
            middle = (block + end) >> 1
            ahead = (middle > block) & (between(middle) <= target)
            block, end = dr.select(ahead, middle, block), dr.select(ahead | (middle <= block), end, middle)
        rest = target - between(block)
        knots, cell = [], (node * angles + low) * radii + 4 * block + density_at // 4
        for k in (0, 2, 3):
            l0, l1, h0, h1 = self._gathered(self.density, cell + k)
            knots += [dr.lerp(l0, h0, tau), dr.lerp(l1, h1, tau)]
        del knots[4]
        place, found, before = T.Float(0.0), T.Bool(False), knots[0]
        for step in range(4):
            after = knots[step + 1]
            mass = 0.5 * (before + after)
            here = ~found & ((rest < mass) | (step == 3))
            place = dr.select(here, T.Float(4 * block + step) + _along(before, after, rest), place)
            found |= here
            rest, before = dr.select(found, rest, rest - mass), after
        as_float = lambda n: float(n) if isinstance(n, int) else T.Float(n)
        angle = (T.Float(low) + tau) * (span / as_float(angles))
        angle = dr.select(other & select(halved, T.Bool(True), T.Bool(False)), 4.0 - angle, angle)
        ex = 1.0 - dr.select(angle > 2.0, 4.0 - angle, angle)
        ey = dr.select(angle > 2.0, -1.0, 1.0) * (1.0 - dr.abs(ex))
        norm = dr.rsqrt(dr.fma(ex, ex, ey * ey))
        ex, ey = ex * norm, ey * norm
        whole = self._scale(layer, self._reach(p, seen, ex, ey))
        rho = L("core", layer) * (dr.exp(place / as_float(radii) * whole) - 1.0)
        x, y = self._direction(p, seen, ex * rho, ey * rho)
        x, y = dr.fma(seen.turn[0], x, seen.turn[2] * y), dr.fma(seen.turn[1], x, seen.turn[3] * y)
        if self.even is not None:
            even, (a, b) = dr.gather(T.Bool, self.even, pair), square_to_disk(u.x, u.y)
            x, y = dr.select(even, a, x), dr.select(even, b, y)
        return x, y, None

    def _drawn_from(self, seen, running, angles, u):
        """The node whose table a draw is made by, chosen by weight and mass with one number, and its mass."""
        masses = [(node, running(node, angles), w) for node, w in seen.nodes]
        left = u * sum(w * mass for _, mass, w in masses)
        chosen, whole, _ = masses[0]
        begin = self.types.Float(0.0)
        for node, mass, w in masses:
            here = (left >= begin) & (w * mass > 0.0)
            chosen, whole = dr.select(here, node, chosen), dr.select(here, mass, whole)
            begin += w * mass
        return chosen, whole

    def _chosen(self, table, seen, u):
        """The layer that a draw falls in, and two numbers for the place there."""
        T, first, count = self.types, self.table("first", table), self.table("layers", table)
        if self.most_layers == 1:
            return first, u.x, u.y
        masses = []
        for n in range(self.most_layers):
            there = n < count
            layer = first + n if isinstance(there, bool) else first + dr.select(there, T.UInt32(n), 0)
            mass = self._mass(layer, self._placed(layer, seen), seen)
            masses.append(mass if isinstance(there, bool) else dr.select(there, mass, 0.0))
        left = u.x * sum(masses)
        chosen, x, found = T.UInt32(0), T.Float(0.0), T.Bool(False)
        for n, mass in enumerate(masses):
            here = ~found & (mass > 0.0)
            chosen = dr.select(here, n, chosen)
            x = dr.select(here, dr.clip(left / dr.select(mass > 0.0, mass, 1.0), 0.0, _LAST), x)
            found |= here & (left < mass)
            left -= mass
        return chosen + first, x, u.y


def _either(condition, yes, no):
    """What is chosen lane by lane of two values, lists or namespaces that are alike; literals stay where both are the same."""
    if isinstance(yes, SimpleNamespace):
        return SimpleNamespace(**{name: _either(condition, a, getattr(no, name)) for name, a in vars(yes).items()})
    if isinstance(yes, (list, tuple)):
        return type(yes)(_either(condition, a, b) for a, b in zip(yes, no))
    if isinstance(yes, bool):
        return yes if isinstance(no, bool) and yes == no else dr.select(condition, type(condition)(yes), type(condition)(no))
    return dr.select(condition, yes, no)


def _along(left, right, mass):
    """Where in [0, 1] a density that goes from `left` to `right` has the integral `mass`."""
    root = left + dr.sqrt(dr.maximum(left * left + 2.0 * (right - left) * mass, 0.0))
    return dr.select(root > 0.0, dr.clip(2.0 * mass / dr.select(root > 0.0, root, 1.0), 0.0, 1.0), 0.5)
