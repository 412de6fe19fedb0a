"""Render forms as arrays that all pairs of sides share, made ready for gathers. Needs numpy alone.

`bindings/c/include/bsdfkit_device_render.h` says how they are read; names are alike.
"""

import numpy as np

FOLDS = ["none", "mirror-x", "mirror-y", "quadrants", "half-turn", "isotropic", "isotropic-mirrored"]
ISOTROPIC = FOLDS.index("isotropic")
# Cosines of incidence below count as this.
LOWEST = 0.01
MOST2 = 1.0 - LOWEST * LOWEST
# What places a layer's plane, in the order of poses.
PLANE = ["c_x", "c_y", "xx", "xy", "yy"]
# Ratios of colour are stored over this.
COLOUR_UNIT = 1.0 / 64.0


def out(sine2, z, grazing):
    """How far out an incidence is but for a factor; arrays of numpy or numbers."""
    return np.sqrt(sine2 / (1.0 + z)) / (1.0 + grazing * z)


def corners(part):
    """The values at the four corners of each cell, of (nodes, angles + 1, radii + 1)."""
    low, high = part[:, :-1], part[:, 1:]
    return np.stack([low[..., :-1], low[..., 1:], high[..., :-1], high[..., 1:]], -1)


class Bank:
    """The tables of several components, and their reverses, one array of each kind.

    Attributes:
        tables, layers: Numbers by name, one a table or a layer; layers of a table follow one another.
        arrays: By name: "poses" has eight words a layer and fine node (c_x, c_y, xx, xy, yy, factor, total, 0), "values" are in 1/sr,
            "colour" has X/Y and Z/Y; "cells" has values as stored and "density" densities, half floats, the four corners of each cell side
            by side (this angle and the next, each at this distance and the next); "light" has (factor, total); others are as stored.
        still: Whether no layer is moved or stretched from one incidence to another, so that `layers` has all of their planes.
    """

    def __init__(self):
        self.tables, self.layers, self.arrays = {}, {}, {}
        self._parts, self._lengths = {}, {}
        self.count = self.layer_count = 0
        self.still = True

    def add(self, said, arrays, prefix="render"):
        """Appends a table that a container describes by `said`; returns its number."""
        fold, n = FOLDS.index(said["fold"]), said["intervals"]
        isotropic = fold >= ISOTROPIC
        low_x = -1 if FOLDS[fold] in ("none", "mirror-y", "half-turn") else 0
        low_y = 0 if isotropic else -1 if FOLDS[fold] in ("none", "mirror-x") else 0
        cells_x, cells_y = (1 - low_x) * n, (1 - low_y) * n
        nodes = (cells_x + 1) * (1 if isotropic else cells_y + 1)
        grazing = said["grazing"]
        self._put(self.tables, {
            "fold": fold,
            "intervals": n,
            "low_x": float(low_x),
            "low_y": float(low_y),
            "cells_x": cells_x,
            "cells_y": cells_y,
            "grazing": grazing,
            "over_out": 1.0 / out(MOST2, LOWEST, grazing),
            "span": 2.0 if FOLDS[fold] == "isotropic-mirrored" else 4.0,
            "first": self.layer_count,
            "layers": len(said["layers"]),
            "most": said["largest_total"],
        })
        incidences = arrays[f"{prefix}.incidences"]
        for k, shape in enumerate(said["layers"]):
            own = {a: arrays.get(f"{prefix}.layer.{k}.{a}") for a in ("values", "colour", "density", "sums", "running")}
            self._layer(shape, own, nodes, incidences, 1 + 6 * k)
        self.count += 1
        return self.count - 1

    def _layer(self, shape, own, nodes, incidences, first):
        grey = not shape["colour_angles"] or not shape["angles"]
        # What a layer lacks is one cell of a constant.
        stored = np.zeros((nodes, 2, 2), np.float16)
        colour = np.ones((nodes, 2, 2, 2), np.float32)
        if shape["angles"]:
            stored = own["values"]
        values = stored.astype(np.float32) * np.float32(shape["value_unit"])
        if not grey:
            colour = own["colour"].astype(np.float32) * np.float32(COLOUR_UNIT)
        poses = np.zeros((len(incidences), 8), np.float32)
        poses[:, :6] = incidences[:, first : first + 6]
        poses[:, 6] = incidences[:, 0]
        self.still &= bool((poses[:, :5] == poses[0, :5]).all())
        at = {name: self._append(name, part) for name, part in (
            ("poses", poses), ("light", poses[:, 5:7]), ("values", values), ("cells", corners(stored)), ("colour", colour),
            ("density", corners(own["density"])), ("sums", own["sums"]), ("running", own["running"]),
        )}
        frame = shape["frame"]
        cells = shape["drawn_angles"] * shape["drawn_radii"]
        self._put(self.layers, {
            "slopes": frame["kind"] == "slopes",
            "factor": frame["factor"],
            "angles": shape["angles"] or 1,
            "radii": shape["radii"] if shape["angles"] else 1,
            **dict(zip(PLANE, poses[0, :5].tolist())),
            "value_unit": shape["value_unit"],
            "core": shape["core"],
            "over_far": 1.0 / max(np.log1p(shape["far"] / shape["core"]), 1e-12),
            "colour_angles": 1 if grey else shape["colour_angles"],
            "colour_radii": 1 if grey else shape["colour_radii"],
            "drawn_angles": shape["drawn_angles"],
            "drawn_radii": shape["drawn_radii"],
            "drawn_unit": shape["drawn_unit"],
            "mass_unit": 4.0 * shape["drawn_unit"] / cells,
            "coloured": not grey,
            **{f"{name}_at": place for name, place in at.items()},
        })
        self.layer_count += 1

    def _append(self, name, part):
        at = self._lengths.get(name, 0)
        self._parts.setdefault(name, []).append(part.ravel())
        self._lengths[name] = at + part.size
        return at

    @staticmethod
    def _put(columns, row):
        for name, value in row.items():
            columns.setdefault(name, []).append(value)

    def finish(self):
        """Joins all arrays."""
        half = ("cells", "density")
        kind = lambda name: np.float16 if name in half else np.float32
        self.arrays = {name: np.concatenate(parts).astype(kind(name)) for name, parts in self._parts.items()}
        self.tables = {name: np.array(column) for name, column in self.tables.items()}
        self.layers = {name: np.array(column) for name, column in self.layers.items()}
        return self
