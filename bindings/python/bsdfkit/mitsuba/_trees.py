"""Queries of trees by gathers, for the llvm and cuda variants: one loop for all pairs of sides."""

import drjit as dr
import numpy as np

from .._flat import BRANCH
from ._forest import BITS, GRID, EVEN, KNOWN, TOP, Forest, spread
from ._square import disk_to_square, square_to_disk

_BRANCH = int(BRANCH)
_LAST = 1.0 - 2.0**-24
# Of direction cosines: rounding of single precision about ½ is 3e-8, a cell 8e-6 at the least.
_ASIDE = 4e-6


class Trees:
    """The trees of one rank.

    Convention: `pair` numbers pairs of sides as `_flat.pair_of`. Directions point away from the surface. Every method
    answers 0 for pairs without a tree of this rank.
    """

    def __init__(self, answers, types, grid_of):
        self.types = types
        self.rank = answers[0].stored.rank
        self.anisotropic = self.rank == 4
        self.pairs = [a.pair for a in answers]
        self.coloured = any(a.stored.coloured for a in answers)
        self.deepest = max(a.stored.depth for a in answers)
        forest = Forest(self.rank)
        channels = ("y", "u", "v") if self.coloured else ("y",)
        # Tables by pair of sides; pairs without an answer have the tree and the slice of nothing.
        nothing = 1 << (self.rank * TOP[self.rank])
        trees = {c: np.full(4, -1) for c in channels}
        swapped = np.zeros(4, bool)
        table, sign = np.full(4, -1), np.full(4, -1.0)
        self.grids = {}
        for a in answers:
            for c in channels:
                if c == "y" or a.stored.coloured:
                    trees[c][a.pair] = forest.tree(a.stored, c)
            swapped[a.pair] = a.swapped
            if a.swapped and self.rank == 3:
                grid = grid_of(min(a.stored.depth, GRID))
                grid = (1.0 - EVEN) * grid + EVEN * grid.mean(axis=(1, 2), keepdims=True)
                cells = forest.draw_grid(grid)
                self.grids[a.pair] = grid.astype(np.float32)
            else:
                cells = forest.draw(a)
            table[a.pair], sign[a.pair] = cells.table, cells.sign
        arrays = forest.finish()
        number = types.UInt32
        self.root_count = len(forest.roots)
        # The last tree is that of nothing, the last table one of slices of nothing.
        self.top = number(np.append(arrays["top"], np.zeros(nothing, np.uint32)))
        self._place = np.append(arrays["place"], np.zeros(nothing, np.uint32))
        self._slots = arrays["slots"]
        self.slots = number(arrays["slots"]) if len(arrays["slots"]) else number([0])
        self.tree = {c: self._by_pair(np.where(t < 0, self.root_count, t).astype(np.uint32)) for c, t in trees.items()}
        self.has_chroma = self._by_pair(np.array([trees["u"][p] >= 0 for p in range(4)])) if self.coloured else False
        size = forest.draws.table_size
        self.table = number(np.append(arrays["table"], np.zeros(size, np.uint32)))
        count = len(forest.draws.tables)
        self.cells = self._by_pair(np.where(table < 0, count, table).astype(np.uint32))
        self.sign = self._by_pair(sign)
        self.swapped = self._by_pair(swapped)
        self.index = number(arrays["index"]) if len(arrays["index"]) else number([0])
        self.finer = bool((arrays["table"] & BRANCH).any())
        self.mean, self.link = types.Float(arrays["mean"]), number(arrays["link"])
        regions = arrays["regions"] if len(arrays["regions"]) else np.zeros(4, np.uint32)
        # The same words as means and as links.
        self.regions, self.links = types.Float(regions.view(np.float32)), number(regions)
        self.records = arrays["records"]
        # Made when asked for: values that can be changed and have gradients.
        self.values = self.place = None
        self.original = True
        self.grid = {p: types.Float(g.ravel()) for p, g in self.grids.items()}

    def _by_pair(self, values):
        """What `_pick` takes: one value where all pairs that are answered have the same, else an array."""
        own = {values[p].item() for p in self.pairs}
        if len(own) == 1 and len(self.pairs) == 4:
            return own.pop()
        kind = {"b": self.types.Bool, "u": self.types.UInt32, "f": self.types.Float}[values.dtype.kind]
        return kind(values)

    def _pick(self, values, pair):
        if isinstance(values, (bool, int, float)):
            return values
        return dr.gather(type(values), values, pair)

    def parameters(self):
        """Names of the attributes that can be changed, made now: values by the place of their slots, 1/sr (of u′ and v′: none)."""
        if self.values is None:
            leaves = np.where(self._slots & BRANCH, np.uint32(0), self._slots).view(np.float32)
            # Roots that are leaves have no slot: theirs come after.
            roots = np.zeros(self.root_count + 1, np.float32)
            place = self._place.reshape(self.root_count + 1, -1).copy()
            tops = self.top.numpy().reshape(place.shape)
            for k in range(self.root_count + 1):
                if place[k].max() == 0 and (tops[k] == tops[k][0]).all() and not tops[k][0] & BRANCH:
                    roots[k] = tops[k][:1].view(np.float32)[0]
                    place[k] = len(leaves) + k
            self.values = self.types.Float(np.concatenate([leaves, roots]))
            self.place = self.types.UInt32(place.ravel())
        return ["values"]

    # Where directions are.

    def _incidence(self, wi, sign=-1.0):
        """Finest cells (interleaved) of the known direction, and the projection that turns the other one."""
        T = self.types
        x, y = sign * wi.x, sign * wi.y
        if self.rank == 4:
            s, t = disk_to_square(x, y)
            return spread(self._quantise(s)) | (spread(self._quantise(t)) << 1), (x, y, 1.0)
        length = dr.sqrt(dr.fma(x, x, y * y))
        at = dr.clip(0.5 - 0.5 * length, 0.0, 0.5 - 0.5 / 65536)
        none = length <= 0.0
        x, length = dr.select(none, -1.0, x), dr.select(none, 1.0, length)
        return T.UInt32(dr.minimum(at * 65536.0, 65535.0)), (x, dr.select(none, 0.0, y), length)

    def _quantise(self, c):
        return self.types.UInt32(dr.minimum(c * 65536.0, 65535.0))

    def _scattered(self, frame, wo):
        if self.rank == 4:
            return disk_to_square(wo.x, wo.y)
        x, y, length = frame
        return disk_to_square(
            dr.fma(x, wo.x, y * wo.y) / length, dr.fma(x, wo.y, -(y * wo.x)) / length
        )

    def _part(self, incident, shift):
        """The incident part of a slot's number."""
        if self.rank == 4:
            return (incident >> (shift + shift)) & 3
        return (incident >> shift) & 1

    def _keys(self, pair, wi, wo):
        swapped = self._pick(self.swapped, pair)
        if isinstance(swapped, bool):
            a, b = (wo, self._off_normal(wi)) if swapped else (wi, wo)
        else:
            a, b = dr.select(swapped, wo, wi), dr.select(swapped, self._off_normal(wi), wo)
        incident, frame = self._incidence(a)
        s, t = self._scattered(frame, b)
        return incident, spread(self._quantise(s)) | (spread(self._quantise(t)) << 1)

    def _off_normal(self, w):
        """`w`, at the normal moved aside by what its place can tell: there four cells meet, one for each quarter of the
        directions from which it is seen, and one of them alone would be taken for all."""
        if self.rank == 4:
            return w
        length = dr.sqrt(dr.fma(w.x, w.x, w.y * w.y))
        scale = dr.select(length > 0.0, _ASIDE / length, 0.0)
        aside = self.types.Vector(dr.select(length > 0.0, scale * w.x, -_ASIDE), scale * w.y, w.z)
        return dr.select(length < _ASIDE, aside, w)

    def _leaf(self, channel, pair, incident, scattered, active):
        """The slot of the leaf that two finest cells are in, and its place where values are parameters."""
        T = self.types
        levels = TOP[self.rank]
        top = (incident >> ((32 if self.rank == 4 else 16) - (self.rank - 2) * levels)) << (2 * levels)
        top |= scattered >> (32 - 2 * levels)
        top += self._pick(self.tree[channel], pair) << (self.rank * levels)
        slot = dr.gather(T.UInt32, self.top, top, active)
        tracked = self.values is not None
        place = dr.gather(T.UInt32, self.place, top, active) if tracked else T.UInt32(0)

        def below(slot, place, shift):
            part = ((scattered >> (shift + shift)) & 3) | (self._part(incident, shift) << 2)
            at = (slot << self.rank) | part
            slot = dr.gather(T.UInt32, self.slots, at, (slot & _BRANCH) != 0)
            return slot, at if tracked else place, shift - 1

        if self.deepest > levels:
            slot, place, _ = dr.while_loop(
                state=(slot, place, T.UInt32(BITS - 1 - levels)),
                cond=lambda slot, place, shift: (slot & _BRANCH) != 0,
                body=below,
                labels=("slot", "place", "shift"),
                max_iterations=BITS,
            )
        return slot, place

    def _value(self, channel, pair, incident, scattered, active, original=False):
        T = self.types
        slot, place = self._leaf(channel, pair, incident, scattered, active)
        if self.values is not None and not original:
            return dr.gather(T.Float, self.values, place, active)
        return T.Float(dr.reinterpret_array(T.Single, slot))

    # The queries.

    def value(self, pair, wi, wo, active):
        """f as stored, 1/sr: (X, Y, Z), X and Z None where nothing has colour."""
        incident, scattered = self._keys(pair, wi, wo)
        y = dr.select(active, self._value("y", pair, incident, scattered, active), 0.0)
        if not self.coloured:
            return None, y, None
        active &= self._pick(self.has_chroma, pair)
        u = self._value("u", pair, incident, scattered, active)
        v = self._value("v", pair, incident, scattered, active)
        known = active & (v > 0.0)
        scale = y / dr.select(known, 4.0 * v, 1.0)
        x, z = 9.0 * u * scale, (12.0 - 3.0 * u - 20.0 * v) * scale
        return dr.select(known, x, y), y, dr.select(known, z, y)

    def drawn(self, pair, wi, wo, active, y):
        """What `draw` draws in proportion to, 1/sr: f as the file has it, `y` now."""
        if not self.original:
            incident, scattered = self._keys(pair, wi, wo)
            y = self._value("y", pair, incident, scattered, active, original=True)
        f = dr.detach(y)
        for p, grid in self.grid.items():
            incident, frame = self._incidence(wi)
            s, t = self._scattered(frame, wo)
            n = self.grids[p].shape[1]
            cell = self.types.UInt32(dr.minimum(t * n, n - 1)) * n + self.types.UInt32(dr.minimum(s * n, n - 1))
            cell += (incident >> (BITS + 1 - n.bit_length())) * (n * n)
            own = active & (pair == p)
            f = dr.select(own, dr.gather(self.types.Float, grid, cell, own), f)
        return dr.select(active, f, 0.0)

    def value_and_drawn(self, pair, wi, wo, active):
        """f as stored, and what `draw` draws in proportion to."""
        found = self.value(pair, wi, wo, active)
        return found, self.drawn(pair, wi, wo, active, found[1])

    def total(self, pair, wi, active):
        """∫ drawn |cos θo| dωo, and the slice that it is of."""
        T = self.types
        sign = self._pick(self.sign, pair)
        incident, _ = self._incidence(wi, sign)
        levels = KNOWN[self.rank]
        width = (self.rank - 2) * levels
        cell = incident >> ((32 if self.rank == 4 else 16) - width)
        cell += self._pick(self.cells, pair) << width
        at = dr.gather(T.UInt32, self.table, cell, active)
        if self.finer:
            parts = 1 << (self.rank - 2)

            def below(at, shift):
                part = self._part(incident, shift)
                place = (at & (_BRANCH - 1)) * parts + part
                return dr.gather(T.UInt32, self.index, place, (at & _BRANCH) != 0), shift - 1

            at, _ = dr.while_loop(
                state=(at, T.UInt32(BITS - 1 - levels)),
                cond=lambda at, shift: (at & _BRANCH) != 0,
                body=below,
                labels=("at", "shift"),
                max_iterations=BITS,
            )
        mean = dr.gather(T.Float, self.mean, at, active)
        return dr.select(active, dr.pi * mean, 0.0), at

    def draw(self, pair, wi, at, u, active):
        """A point (x, y) of the disk with density `drawn` / `total`, and `drawn` there; `at` is the slice."""
        T = self.types
        link = dr.gather(T.UInt32, self.link, at, active)
        mean = dr.gather(T.Float, self.mean, at, active)

        def below(link, x, y, width, u, v, mean):
            row = link - 1
            # Records of eight words come first, then quads of four.
            record = row < self.records
            place = dr.select(record, row * 2, row + self.records)
            m = dr.gather(T.Four, self.regions, place)
            lower, upper = m[0] + m[1], m[2] + m[3]
            w = v * (lower + upper)
            up = w >= lower
            v = dr.minimum(dr.select(up, w - lower, w) / dr.select(up, upper, lower), _LAST)
            left, right = dr.select(up, m[2], m[0]), dr.select(up, m[3], m[1])
            w = u * (left + right)
            on = w >= left
            mean = dr.select(on, right, left)
            u = dr.minimum(dr.select(on, w - left, w) / mean, _LAST)
            quadrant = dr.select(on, T.UInt32(5), T.UInt32(4)) + dr.select(up, T.UInt32(2), T.UInt32(0))
            link = dr.gather(T.UInt32, self.links, row * 8 + quadrant, record)
            width = 0.5 * width
            return link, dr.select(on, x + width, x), dr.select(up, y + width, y), width, u, v, mean

        _, x, y, width, u, v, mean = dr.while_loop(
            state=(link, T.Float(0.0), T.Float(0.0), T.Float(1.0), T.Float(u.x), T.Float(u.y), mean),
            cond=lambda link, x, y, width, u, v, mean: link != 0,
            body=below,
            labels=("link", "x", "y", "width", "u", "v", "mean"),
            max_iterations=BITS,
        )
        x, y = square_to_disk(dr.fma(u, width, x), dr.fma(v, width, y))
        if self.rank == 4:
            return x, y, mean
        # As `bsdfkit` turns it: the direction of travel is +X.
        _, (a, b, length) = self._incidence(wi)
        return (a * x - b * y) / length, (a * y + b * x) / length, mean
