"""Trees of one rank as arrays that all pairs of sides share, made ready for gathers.

Slots keep the container's form (a leaf is the bits of its value, a branch 2³¹ + its number), renumbered so that all trees
lie in one array. What samples are drawn from are the container's slices, renumbered alike: the cell of the known direction
has a slice, a slice a region, a region the means of its four quadrants and their regions.
"""

from dataclasses import dataclass

import numpy as np

from .._flat import BRANCH

# Levels that one look-up skips: 4096 cells a tree.
TOP = {3: 4, 4: 3}
# Finest cells of the known direction in a table, a power of two along a side; what is finer is found by descent.
KNOWN = {3: 12, 4: 9}
# Cells along a side from which the other way of a lone isotropic transmission is drawn, at most.
GRID = 6
# Share of such draws that is spread evenly, so that no light is out of reach. A guess.
EVEN = 0.1
BITS = 16

_QUAD, _RECORD = np.uint32(1 << 30), np.uint32(2 << 30)
_MARKS = np.uint32(3 << 30)


def spread(b):
    """Bits 0, 1, 2, … of 16 → 0, 2, 4, …; arrays of numpy or Dr.Jit."""
    b = (b | (b << 8)) & 0x00FF00FF
    b = (b | (b << 4)) & 0x0F0F0F0F
    b = (b | (b << 2)) & 0x33333333
    return (b | (b << 1)) & 0x55555555


@dataclass
class Cells:
    """What is drawn from at one pair of sides: numbers into the arrays of `Draws`."""

    table: int
    # +1: the cell of the known direction is that of its (x, y); -1: of its direction of travel.
    sign: float


class Draws:
    """Slices of several trees, one array of each kind."""

    def __init__(self, rank):
        self.parts = 2 if rank == 3 else 4
        self.rank = rank
        # The first is the slice of nothing.
        self.mean, self.link = [np.zeros(1, np.float32)], [np.zeros(1, np.uint32)]
        self.index, self.tables = [], []
        self.records, self.links, self.quads = [], [], []
        self.slices = 1
        self.groups = self.record_count = self.quad_count = 0
        self.table_size = 1 << (KNOWN[rank] * (1 if rank == 3 else 2))

    def add(self, index, slices, records, means_of_quad):
        """Appends the arrays of a container; `means_of_quad` gives the four slots of numbered quads."""
        quads = np.concatenate([slices[:, 1], records[:, 4:].ravel()])
        quads = np.unique(quads[(quads & _MARKS) == _QUAD]) & ~_MARKS

        def region(link):
            """Links of the container → 1 + number of a region, records counted from 0, quads from 2³⁰; 0 for none."""
            at = (link & ~_MARKS).astype(np.int64)
            quad = (link & _MARKS) == _QUAD
            quad_at = np.searchsorted(quads, at) + self.quad_count
            found = np.where(quad, quad_at + (1 << 30), at + self.record_count) + 1
            return np.where(link == 0, 0, found).astype(np.uint32)

        branch = (index & BRANCH) != 0
        renumbered = np.where(branch, index + np.uint32(self.groups), index + np.uint32(self.slices))
        self.tables.append(self._table(renumbered, self.groups))
        self.index.append(renumbered[:-1])
        self.mean.append(slices[:, 0].copy().view(np.float32))
        self.link.append(region(slices[:, 1]))
        self.records.append(np.ascontiguousarray(records[:, :4]).view(np.float32))
        self.links.append(region(records[:, 4:]))
        self.quads.append(means_of_quad(quads).view(np.float32))
        self.groups += (len(index) - 1) // self.parts
        self.slices += len(slices)
        self.record_count += len(records)
        self.quad_count += len(quads)
        return len(self.tables) - 1

    def _table(self, index, first):
        """The slices (or groups, where those are finer) of the finest cells of the table, as `cell` numbers them."""
        levels, own = KNOWN[self.rank], index[:-1]
        cell = np.arange(self.table_size, dtype=np.uint32)
        at = np.full(self.table_size, index[-1], np.uint32)
        bits = 1 if self.rank == 3 else 2
        for level in range(levels):
            branch = (at & BRANCH) != 0
            part = (cell >> np.uint32(bits * (levels - 1 - level))) & np.uint32(self.parts - 1)
            below = (at ^ BRANCH).astype(np.int64) - first
            at = np.where(branch, own[np.where(branch, below * self.parts + part, 0)] if len(own) else at, at)
        return at

    def finish(self):
        """All arrays joined: regions are numbered records first, then quads."""

        def joined(arrays, dtype, shape=(0,)):
            return np.concatenate([np.zeros(shape, dtype), *arrays]).astype(dtype)

        records = np.uint32(self.record_count)

        def numbered(links):
            quad = links > (1 << 30)
            return np.where(quad, links - np.uint32(1 << 30) + records, links).astype(np.uint32)

        links = numbered(joined(self.links, np.uint32, (0, 4)))
        means = joined(self.records, np.float32, (0, 4)).view(np.uint32)
        regions = [np.concatenate([means, links], axis=1).ravel(), *(q.view(np.uint32).ravel() for q in self.quads)]
        return {
            "mean": joined(self.mean, np.float32),
            "link": numbered(joined(self.link, np.uint32)),
            "index": joined(self.index, np.uint32),
            "table": joined(self.tables, np.uint32),
            # Records: four means, four links; then quads: four means.
            "regions": joined(regions, np.uint32),
            "records": int(records),
        }


class Forest:
    """The trees of one rank of a BSDF, and what samples of them are drawn from."""

    def __init__(self, rank):
        self.rank = rank
        self.children = 1 << rank
        self.slots, self.tops, self.places = [], [], []
        self.nodes = 0
        self.draws = Draws(rank)
        self.roots = {}

    def tree(self, stored, channel):
        """The number of a component's tree of Y, u or v: the place of its first cells in `top`."""
        key = (id(stored), channel)
        if key not in self.roots:
            slots = stored.arrays[f"tree.{channel}.slots"].ravel()
            root = stored.arrays[f"tree.{channel}.root"][0]
            branch = (slots & BRANCH) != 0
            self.slots.append(np.where(branch, slots + np.uint32(self.nodes), slots))
            shifted = root + np.uint32(self.nodes) if root & BRANCH else root
            first = self.nodes * self.children
            top, place = top_of(self.slots[-1], shifted, first, self.rank)
            self.tops.append(top)
            self.places.append(place)
            self.nodes += len(slots) // self.children
            self.roots[key] = len(self.tops) - 1
        return self.roots[key]

    def draw(self, answer):
        """What an answer draws from."""
        slots = answer.stored.arrays["tree.y.slots"]
        sense = "reverse" if answer.swapped else "forward"
        index, slices, records = (answer.stored.arrays[f"tree.y.{sense}.{a}"] for a in ("index", "slices", "records"))
        if answer.swapped:
            # Quadrants of the stored incident directions, which are numbered from the other end.
            def means(quads):
                node = slots[quads // 4]
                column = (quads % 4)[:, None] + np.array([12, 8, 4, 0])
                return np.take_along_axis(node, column, axis=1)
        else:
            def means(quads):
                return slots.reshape(-1, 4)[quads]
        return Cells(self.draws.add(index, slices, records, means), 1.0 if answer.swapped else -1.0)

    def draw_grid(self, values):
        """Draws from a regular grid, shape (known cells, n, n) with rows y: the first half of a tree of rank 3."""
        known = values.shape[0]
        levels = [values]
        while levels[-1].shape[1] > 1:
            v = levels[-1]
            levels.append(v.reshape(known, v.shape[1] // 2, 2, v.shape[2] // 2, 2).mean(axis=(2, 4)))
        # Records of the levels above the leaves, the finest first.
        records, links = [], None
        for fine in levels[:-1]:
            half = fine.shape[1] // 2
            def quads(a):
                return a.reshape(known, half, 2, half, 2).transpose(0, 1, 3, 2, 4).reshape(-1, 4)
            below = np.zeros((known * half * half, 4), np.uint32) if links is None else quads(links)
            first = sum(len(r) for r in records)
            means = np.ascontiguousarray(quads(fine).astype(np.float32)).view(np.uint32)
            records.append(np.concatenate([means, below], axis=1).astype(np.uint32))
            links = (np.arange(known * half * half, dtype=np.uint32) + np.uint32(first) | _RECORD).reshape(
                known, half, half
            )
        slices = np.zeros((known + 1, 3), np.uint32)
        slices[:known, 0] = levels[-1].reshape(-1).astype(np.float32).view(np.uint32)
        slices[:known, 1] = links.reshape(-1)
        # The known dimension's own tree, a heap; the upper half of its cells is never reached.
        groups = 2 * known - 1
        child = np.arange(1, 2 * groups + 1)
        index = np.where(child < groups, child + (1 << 31), np.minimum(child - groups, known))
        index = np.append(index, 1 << 31).astype(np.uint32)
        table = self.draws.add(index, slices, np.concatenate(records), lambda quads: np.zeros((0, 4), np.uint32))
        return Cells(table, -1.0)

    def finish(self):
        """All arrays."""
        slots = np.concatenate([np.zeros(0, np.uint32), *self.slots]).astype(np.uint32)
        return {
            "slots": slots,
            "top": np.concatenate(self.tops).astype(np.uint32),
            "place": np.concatenate(self.places).astype(np.uint32),
            **self.draws.finish(),
        }


def top_of(slots, root, first, rank):
    """Slots that the cells TOP levels below a root hold, and where they lie; `first` is the place of `slots[0]`.

    Cells are numbered incident part · 4^TOP + scattered part, each with its bits interleaved.
    """
    levels, children = TOP[rank], 1 << rank
    incident_bits = rank - 2
    cell = np.arange(1 << (rank * levels), dtype=np.uint32)
    scattered, incident = cell & np.uint32(4**levels - 1), cell >> np.uint32(2 * levels)
    slot = np.full(len(cell), root, np.uint32)
    place = np.zeros(len(cell), np.uint32)
    for level in range(levels):
        branch = (slot & BRANCH) != 0
        if not branch.any():
            break
        down = levels - 1 - level
        part = (scattered >> np.uint32(2 * down) & np.uint32(3)) | (
            (incident >> np.uint32(incident_bits * down) & np.uint32((1 << incident_bits) - 1)) << np.uint32(2)
        )
        at = (slot ^ BRANCH).astype(np.int64) * children + part
        place = np.where(branch, at, place).astype(np.uint32)
        slot = np.where(branch, slots[np.where(branch, at - first, 0)], slot)
    return slot, place
