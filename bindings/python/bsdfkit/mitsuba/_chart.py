"""The chart of incident directions of render forms, in Dr.Jit: names are those of `bindings/c/include/bsdfkit_device_render.h`."""

from types import SimpleNamespace

import drjit as dr
import numpy as np

from ._bank import FOLDS, ISOTROPIC, LOWEST, MOST2
from ._numbers import any_of, select


class Chart:
    """Where incident directions are among the nodes of tables.

    Attributes:
        isotropic: Whether all tables are; None where some are.
    """

    def __init__(self, table, folds, types):
        self.types, self.table = types, table
        self.isotropic = bool((folds >= ISOTROPIC).all()) or (False if (folds < ISOTROPIC).all() else None)

    def see(self, table, wi):
        """An incident direction, turned to where its nodes are: x, y, z, the turn's rows, nodes and weights of both charts."""
        T, fold = self.types, self.table("fold", table)
        x, y, z = wi.x, wi.y, dr.abs(wi.z)
        length = dr.sqrt(dr.fma(x, x, y * y))
        low, radius = ~(z >= LOWEST), float(np.sqrt(MOST2))
        some = length > 0.0
        inverse = dr.select(some, 1.0 / dr.select(some, length, 1.0), 0.0)
        x = dr.select(low, dr.select(some, x * inverse * radius, radius), x)
        y = dr.select(low, y * inverse * radius, y)
        length, z = dr.select(low, radius, length), dr.select(low, LOWEST, z)
        some = length > 0.0
        one, zero = T.Float(1.0), T.Float(0.0)
        turn = (one, zero, zero, one)
        if self.isotropic is not True:
            left, down = dr.select(x < 0.0, T.Float(-1.0), one), dr.select(y < 0.0, T.Float(-1.0), one)
            is_ = lambda *names: any_of([fold == FOLDS.index(n) for n in names])
            across = select(is_("mirror-x", "quadrants"), left, select(is_("half-turn"), down, one))
            turn = (across, zero, zero, select(is_("mirror-y", "quadrants", "half-turn"), down, one))
        if self.isotropic is not False:
            safe = dr.select(some, length, 1.0)
            cos, sin = dr.select(some, x / safe, 1.0), dr.select(some, y / safe, 0.0)
            turned = (cos, sin, -sin, cos)
            turn = tuple(select(fold >= ISOTROPIC, a, b) for a, b in zip(turned, turn))
        x, y = dr.fma(turn[0], x, turn[1] * y), dr.fma(turn[2], x, turn[3] * y)
        sine2 = dr.fma(x, x, y * y)
        out = dr.sqrt(sine2 / (1.0 + z)) / (1.0 + self.table("grazing", table) * z)
        u = dr.clip(out * self.table("over_out", table), 0.0, 1.0)
        largest = dr.maximum(dr.abs(x), dr.abs(y))
        scale = dr.select(largest > 0.0, u / dr.select(largest > 0.0, largest, 1.0), 0.0)
        sx, sy = x * scale, y * scale
        if self.isotropic is not False:
            iso = fold >= ISOTROPIC
            sx, sy = select(iso, u, sx), select(iso, T.Float(0.0), sy)
        seen = SimpleNamespace(x=x, y=y, z=z, turn=turn)
        seen.nodes = self._around(table, sx, sy, 1)
        seen.fine = self._around(table, sx, sy, 2)
        return seen

    def _around(self, table, sx, sy, finer):
        """Nodes about a place of the square, and their weights, which sum to 1."""
        T, n = self.types, self.table("intervals", table)
        x = (sx - self.table("low_x", table)) * (n * finer if isinstance(n, int) else T.Float(n * finer))
        cells = self.table("cells_x", table) * finer
        i = dr.minimum(T.UInt32(dr.maximum(x, 0.0)), cells - 1)
        fx = dr.clip(x - T.Float(i), 0.0, 1.0)
        if self.isotropic is True:
            return [(i, 1.0 - fx), (i + 1, fx)]
        y = (sy - self.table("low_y", table)) * (n * finer if isinstance(n, int) else T.Float(n * finer))
        j = dr.minimum(T.UInt32(dr.maximum(y, 0.0)), self.table("cells_y", table) * finer - 1)
        fy = dr.clip(y - T.Float(j), 0.0, 1.0)
        # Cells are parted by the diagonal that points away from the middle.
        right = (i >= n * finer) | (self.table("low_x", table) >= 0.0)
        upper = (j >= n * finer) | (self.table("low_y", table) >= 0.0)
        main = ~(right ^ upper)
        near, far = dr.select(main, i, i + 1), dr.select(main, i + 1, i)
        across = dr.select(main, fx, 1.0 - fx)
        wide = across >= fy
        large, small = dr.maximum(across, fy), dr.minimum(across, fy)
        side = cells + 1
        row = j * side
        nodes = [row + near, dr.select(wide, row + far, row + side + near), row + side + far]
        weights = [1.0 - large, large - small, small]
        if self.isotropic is None:
            iso = self.table("fold", table) >= ISOTROPIC
            nodes = [select(iso, a, b) for a, b in zip((i, i + 1, i), nodes)]
            weights = [select(iso, a, b) for a, b in zip((1.0 - fx, fx, T.Float(0.0)), weights)]
        return list(zip(nodes, weights))
