"""Queries of Klems matrices by gathers, for the llvm and cuda variants.

Convention: `crates/bsdf/src/matrix`: scattered directions are numbered as they are, incident ones by their direction of
travel; a matrix is row-major (incident, scattered).
"""

import drjit as dr
import numpy as np

_LAST = 1.0 - 2.0**-24


class Basis:
    """Rings of a hemisphere: `rings` has rows of (upper polar angle in degrees, number of azimuths)."""

    def __init__(self, rings):
        upper = np.radians(rings[:, 0])
        self.cosines = np.concatenate([[1.0], np.where(rings[:, 0] == 90.0, 0.0, np.cos(upper))])
        self.patches = rings[:, 1].astype(np.uint32)
        self.first = np.concatenate([[0], np.cumsum(self.patches)]).astype(np.uint32)
        self.count = int(self.first[-1])
        self.ring = np.repeat(np.arange(len(self.patches)), self.patches)
        squares = self.cosines**2
        self.solid = (np.pi * (squares[:-1] - squares[1:]) / self.patches)[self.ring]


class DeviceBasis:
    """The same for gathers."""

    def __init__(self, basis, types):
        self.types, self.basis = types, basis
        self.rings = len(basis.patches)
        self.patches, self.first = types.UInt32(basis.patches), types.UInt32(basis.first)
        sines = 1.0 - basis.cosines**2
        self.sines = types.Float(sines)

    def index(self, x, y, z):
        """The patch of a direction in basis form, and whether there is one."""
        T, cosines = self.types, self.basis.cosines
        ring = T.UInt32(0)
        for cosine in cosines[1:-1]:
            ring += dr.select(z <= float(cosine), T.UInt32(1), T.UInt32(0))
        inside = (z > float(cosines[-1])) | ((z == 0.0) & bool(cosines[-1] == 0.0))
        patches = dr.gather(T.UInt32, self.patches, ring)
        turns = dr.atan2(y, x) * (0.5 / dr.pi)
        turns = dr.select(turns < 0.0, turns + 1.0, turns)
        k = T.UInt32(dr.fma(turns, T.Float(patches), 0.5))
        k = dr.select(k >= patches, 0, k)
        return dr.gather(T.UInt32, self.first, ring) + k, inside

    def point(self, k, ring, u, v):
        """A point of the unit square → projection of a direction of patch k, in basis form."""
        T = self.types
        inner, outer = dr.gather(T.Float, self.sines, ring), dr.gather(T.Float, self.sines, ring + 1)
        number = T.Float(k - dr.gather(T.UInt32, self.first, ring)) - 0.5
        count = T.Float(dr.gather(T.UInt32, self.patches, ring))
        radius = dr.sqrt(dr.fma(u, outer - inner, inner))
        sin, cos = dr.sincos((number + v) / count * dr.two_pi)
        return radius * cos, radius * sin


def rings_of(answer):
    """Rings of the known and of the other direction."""
    names = ("matrix.incident_rings", "matrix.scattered_rings")
    known, other = (answer.stored.arrays[n] for n in (names[::-1] if answer.swapped else names))
    return known, other


class Matrices:
    """Matrices over the same two bases, one for each of some pairs of sides; answers as `Trees`."""

    anisotropic = True

    def __init__(self, answers, types):
        self.types = types
        self.pairs = [a.pair for a in answers]
        self.coloured = any(a.stored.coloured for a in answers)
        known, other = rings_of(answers[0])
        self.known, self.other = DeviceBasis(Basis(known), types), DeviceBasis(Basis(other), types)
        rows, columns = self.known.basis.count, self.other.basis.count
        self.rows, self.columns = rows, columns
        solid = self.other.basis.solid
        channels = ("y", "x", "z") if self.coloured else ("y",)
        values, sign = np.zeros((len(channels), 4, rows, columns), np.float32), np.full(4, -1.0)
        ring_sums = np.zeros((4, rows, self.other.rings + 1))
        sums = np.zeros((4, rows, columns + 1))
        for a in answers:
            for c, channel in enumerate(channels):
                stored = a.stored.arrays[f"matrix.{channel}" if a.stored.coloured else "matrix.y"]
                values[c, a.pair] = stored.T if a.swapped else stored
            sign[a.pair] = 1.0 if a.swapped else -1.0
            masses = values[0, a.pair].astype(float) * solid
            sums[a.pair, :, 1:] = np.cumsum(masses, axis=1)
            ring_sums[a.pair] = sums[a.pair][:, self.other.basis.first]
        self.sign = types.Float(sign)
        self.names = ["values", "values_x", "values_z"][: len(channels)]
        for name, v in zip(self.names, values):
            setattr(self, name, types.Float(v.ravel()))
        self.sums, self.ring_sums = types.Float(sums.ravel()), types.Float(ring_sums.ravel())
        # Of the file, whatever becomes of `values`.
        self.drawn_values = types.Float(self.values)
        self.original = True

    def parameters(self):
        """Names of the attributes that can be changed: values by pair of sides, known and other direction, 1/sr."""
        return self.names

    def _known(self, pair, wi):
        sign = dr.gather(self.types.Float, self.sign, pair)
        k, inside = self.known.index(sign * wi.x, sign * wi.y, dr.abs(wi.z))
        return sign, pair * self.rows + k, inside

    def _entry(self, pair, wi, wo):
        sign, row, inside = self._known(pair, wi)
        o, reached = self.other.index(-sign * wo.x, -sign * wo.y, dr.abs(wo.z))
        return row * self.columns + o, inside & reached

    def value(self, pair, wi, wo, active):
        """f as stored, 1/sr: (X, Y, Z), X and Z None where nothing has colour."""
        entry, inside = self._entry(pair, wi, wo)
        found = [dr.gather(self.types.Float, getattr(self, n), entry, active & inside) for n in self.names]
        return (found[1], found[0], found[2]) if self.coloured else (None, found[0], None)

    def drawn(self, pair, wi, wo, active, y):
        """What `draw` draws in proportion to, 1/sr."""
        if not self.original:
            entry, inside = self._entry(pair, wi, wo)
            y = dr.gather(self.types.Float, self.drawn_values, entry, active & inside)
        return dr.select(active, dr.detach(y), 0.0)

    def value_and_drawn(self, pair, wi, wo, active):
        """f as stored, and what `draw` draws in proportion to."""
        found = self.value(pair, wi, wo, active)
        return found, self.drawn(pair, wi, wo, active, found[1])

    def total(self, pair, wi, active):
        """∫ drawn |cos θo| dωo, and the row that it is of."""
        _, row, inside = self._known(pair, wi)
        at = row * (self.columns + 1) + self.columns
        return dr.gather(self.types.Float, self.sums, at, active & inside), row

    def draw(self, pair, wi, row, u, active):
        """A point (x, y) of the disk with density `drawn` / `total`, a ring by one number, a patch by the other; and `drawn`."""
        T = self.types
        base = row * (self.other.rings + 1)
        ring, inside_ring = self._find(
            self.ring_sums, base, T.UInt32(0), T.UInt32(self.other.rings), self.other.rings, u.x, active
        )
        first = dr.gather(T.UInt32, self.other.first, ring, active)
        end = dr.gather(T.UInt32, self.other.first, ring + 1, active)
        most = int(self.other.basis.patches.max())
        k, inside_patch = self._find(self.sums, row * (self.columns + 1), first, end, most, u.y, active)
        sign = -dr.gather(T.Float, self.sign, pair, active)
        x, y = self.other.point(k, ring, inside_ring, inside_patch)
        return sign * x, sign * y, dr.gather(T.Float, self.drawn_values, row * self.columns + k, active)

    def _find(self, sums, base, first, end, most, u, active):
        """Of the intervals from `first` to `end` of running sums, the one that u falls in, and the place there."""
        T = self.types
        low, high = dr.gather(T.Float, sums, base + first, active), dr.gather(T.Float, sums, base + end, active)
        target = dr.fma(u, high - low, low)
        k, step = T.UInt32(first), 1 << max(0, (most - 1).bit_length() - 1)
        while step:
            ahead = k + step
            valid = active & (ahead < end)
            at = dr.gather(T.Float, sums, base + ahead, valid)
            k = dr.select(valid & (at <= target), ahead, k)
            step >>= 1
        low, high = dr.gather(T.Float, sums, base + k, active), dr.gather(T.Float, sums, base + k + 1, active)
        place = dr.select(high > low, (target - low) / (high - low), 0.5)
        return k, dr.clip(place, 0.0, _LAST)
