"""A stored BSDF as numpy arrays: what its compiled container holds, by pairs of sides.

`crates/bsdf/src/container` says what the arrays are.
"""

import json
from dataclasses import dataclass, field

import numpy as np

FRONT, BACK = 0, 1
SIDES = {"front": FRONT, "back": BACK}
BRANCH = np.uint32(1 << 31)

_TYPES = {"F16": np.float16, "F32": np.float32, "F64": np.float64, "U32": np.uint32}


def pair_of(incident, scattered):
    """The number of a pair of sides: 0 front reflection, 1 front transmission, 2 back transmission, 3 back reflection."""
    return 2 * incident + scattered


@dataclass
class Stored:
    """One stored component.

    Attributes:
        incident, scattered: Sides of the stored directions.
        arrays: Its arrays by the end of their names: "tree.y.slots", "matrix.y", ….
        floor: Constant part, XYZ, 1/sr.
        negligible: Whether the rest is too little to count.
        depth: Levels of branches of the tree of Y.
        render: What a render form says of its chart and layers; None of a tree or matrix. Its arrays are "render.incidences" and
            "render.layer.0.values", "….density", "….sums", "….running", …: `bsdfkit_device_render.h` says how they are read.
    """

    incident: int
    scattered: int
    arrays: dict
    floor: np.ndarray
    negligible: bool
    depth: int
    render: dict | None = None

    @property
    def is_tree(self):
        return "tree.y.slots" in self.arrays

    @property
    def rank(self):
        return {8: 3, 16: 4}[self.arrays["tree.y.slots"].shape[1]]

    @property
    def coloured(self):
        return "tree.u.slots" in self.arrays or "matrix.x" in self.arrays


@dataclass
class Answer:
    """The component that answers for a pair of sides; `swapped` where with both directions exchanged."""

    pair: int
    stored: Stored
    swapped: bool


@dataclass
class Flat:
    """All of a BSDF.

    Attributes:
        answers: What answers for each pair of sides, with its constant part; negligible ones left out.
        lambertian: XYZ of Lambertian parts that no answer contains by pair of sides, dimensionless, shape (4, 3).
    """

    answers: list = field(default_factory=list)
    lambertian: np.ndarray = field(default_factory=lambda: np.zeros((4, 3)))

    def of(self, pair):
        return [a for a in self.answers if a.pair == pair]


def _arrays(content):
    """Name → array of a safetensors file, and its metadata."""
    length = int.from_bytes(content[:8], "little")
    header = json.loads(content[8 : 8 + length])
    metadata = header.pop("__metadata__")
    arrays = {}
    for name, said in header.items():
        first, end = said["data_offsets"]
        data = content[8 + length + first : 8 + length + end]
        arrays[name] = np.frombuffer(data, _TYPES[said["dtype"]]).reshape(said["shape"])
    return arrays, json.loads(metadata["bsdfkit"])


def flat(bsdf):
    """The arrays of a `bsdfkit.Bsdf` of trees, matrices and render forms.

    Raises:
        ArgumentError: A component is none of these.
    """
    arrays, header = _arrays(bsdf._container())
    stored = []
    for n, said in enumerate(header["components"]):
        prefix = f"component.{n}."
        compiled = said["compiled"]
        stored.append(
            Stored(
                SIDES[said["incident"]],
                SIDES[said["scattered"]],
                {name[len(prefix) :]: a for name, a in arrays.items() if name.startswith(prefix)},
                np.array(compiled["floor"]),
                compiled["negligible"],
                (compiled["depths"] or [0])[0],
                said["representation"].get("render") if isinstance(said["representation"], dict) else None,
            )
        )
    found = Flat()
    rows = [(FRONT, FRONT), (BACK, BACK), (FRONT, BACK), (BACK, FRONT)]
    for row, (incident, scattered) in zip(arrays["lambertian"], rows):
        found.lambertian[pair_of(incident, scattered)] = row
    for incident in (FRONT, BACK):
        for scattered in (FRONT, BACK):
            own = [c for c in stored if (c.incident, c.scattered) == (incident, scattered)]
            # A transmission stored one way alone answers the other way reversed.
            swapped = not own and incident != scattered
            if swapped:
                own = [c for c in stored if (c.incident, c.scattered) == (scattered, incident)]
            pair = pair_of(incident, scattered)
            for c in own:
                if c.negligible:
                    found.lambertian[pair] += np.pi * c.floor
                else:
                    found.answers.append(Answer(pair, c, swapped))
    return found
