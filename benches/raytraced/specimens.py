"""Micro-geometry: one cell of each specimen, repeated without end along X and Y.

A cell is [0, period_x) x [0, period_y), between `bottom` and `top`. Shapes reach a margin beyond it, so that a ray that is
wrapped from one side to the other finds the same surface there. Triangles have their outside where their normal is.
"""

from dataclasses import dataclass

import numpy as np

from bsdfkit.geometry._specimen import Specimen as Cell
from renderer import mi

MARGIN = 0.25


@dataclass
class Specimen(Cell):
    """A cell with a name; `side` is "reflection" or "transmission", `symmetry` tells which azimuths."""

    name: str
    side: str
    symmetry: str

    @property
    def ups(self):
        """Which light is measured, as `measure` takes it."""
        return (self.side == "reflection",)


def mesh(name, vertices, faces, bsdf):
    """Triangles with flat normals."""
    properties = mi.Properties()
    properties["bsdf"] = mi.load_dict(bsdf)
    m = mi.Mesh(name, len(vertices), len(faces), props=properties)
    p = mi.traverse(m)
    p["vertex_positions"] = mi.Float(np.ascontiguousarray(vertices, np.float32).ravel())
    p["faces"] = mi.UInt32(np.ascontiguousarray(faces, np.uint32).ravel())
    p.update()
    return m


def specimen(name, side, symmetry, shapes, period, bottom, top):
    scene = mi.load_dict({"type": "scene", **{f"shape_{k}": s for k, s in enumerate(shapes)}})
    return Specimen(scene, period, float(bottom), float(top), name, side, symmetry)


def grid_faces(rows, columns):
    """Two triangles a square of vertices numbered row by row; normals are columns' direction x rows' direction."""
    k = np.arange((rows - 1) * (columns - 1))
    a = k // (columns - 1) * columns + k % (columns - 1)
    b, c, d = a + 1, a + columns, a + columns + 1
    return np.concatenate([np.stack([a, b, d], 1), np.stack([a, d, c], 1)])


def extruded(name, profile, bsdf, flip=False):
    """The polyline `profile` of (x, z), drawn along Y beyond the cell; outside is left of the way along it."""
    x, z = np.asarray(profile, float).T
    ends = np.array([-MARGIN, 1.0 + MARGIN])
    vertices = np.stack([np.tile(x, 2), np.repeat(ends, len(x)), np.tile(z, 2)], 1)
    faces = grid_faces(2, len(x))
    return mesh(name, vertices, faces[:, ::-1] if flip else faces, bsdf)


def repeated(profile, period=1.0):
    """`profile` over one period, three times side by side."""
    profile = np.asarray(profile, float)
    shifted = [profile + [k * period, 0.0] for k in (-1, 0, 1)]
    return np.concatenate([shifted[0], *(s[1:] for s in shifted[1:])])


def metal(alpha):
    """Aluminium, rough."""
    return {"type": "roughconductor", "distribution": "ggx", "alpha": alpha, "eta": 1.1, "k": 6.8}


def glass(alpha):
    return {"type": "roughdielectric", "distribution": "ggx", "alpha": alpha, "int_ior": 1.5, "ext_ior": 1.0}


def matte(reflectance):
    value = {"type": "uniform", "value": reflectance}
    return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": value}}


def painted(alpha, reflectance, gloss):
    """`gloss` of rough metal, the rest diffuse; both sides."""
    parts = {"a": matte(reflectance)["bsdf"], "b": metal(alpha)}
    return {"type": "twosided", "bsdf": {"type": "blendbsdf", "weight": gloss, **parts}}


def lambertian_plane(reflectance=0.5):
    shapes = [extruded("plane", [(-1.0, 0.0), (2.0, 0.0)], matte(reflectance))]
    return specimen("lambertian-plane", "reflection", "quadrilateral", shapes, (1.0, 1.0), -0.1, 0.1)


def saw_tooth_metal(alpha=0.1):
    """Aluminium, pressed into teeth along Y: a face of 25 degrees, one of 65."""
    rise = 1.0 / (1.0 / np.tan(np.radians(25.0)) + 1.0 / np.tan(np.radians(65.0)))
    tip = rise / np.tan(np.radians(25.0))
    profile = repeated([(0.0, 0.0), (tip, rise), (1.0, 0.0)])
    shapes = [extruded("teeth", profile, metal(alpha))]
    return specimen("saw-tooth-metal", "reflection", "bilateral", shapes, (1.0, 1.0), -0.01, rise + 0.01)


def prismatic_film(alpha=0.08, front=0.03):
    """Acrylic, nearly smooth in front; behind, rough prisms along Y of 35 and 50 degrees with a flat tenth between."""
    a, b = np.tan(np.radians([35.0, 50.0]))
    depth = 0.9 / (1.0 / a + 1.0 / b)
    back = repeated([(0.0, 0.0), (depth / a, -depth), (0.9, 0.0), (1.0, 0.0)])
    shapes = [
        extruded("front", [(-1.0, 0.3), (2.0, 0.3)], glass(front) if front else {"type": "dielectric"}),
        extruded("back", back, glass(alpha) if alpha else {"type": "dielectric"}, flip=True),
    ]
    return specimen("prismatic-film", "transmission", "bilateral", shapes, (1.0, 1.0), -depth - 0.01, 0.31)


def slats(bsdf=None):
    """A venetian blind: slats along Y, 1.15 periods wide, leaning by 35 degrees, slightly crowned; gloss over paint."""
    s = np.linspace(-0.575, 0.575, 17)
    crown = 0.06 * (1.0 - (s / 0.575) ** 2)
    sin, cos = np.sin(np.radians(35.0)), np.cos(np.radians(35.0))
    # the slats stand upright in a stack along X, turned by 35 degrees from lying across it
    x, z = s * sin - crown * cos, s * cos + crown * sin
    paint = bsdf or painted(0.15, 0.6, 0.4)
    shapes = [extruded(f"slat_{k}", np.stack([x + k + 0.5, z], 1), paint) for k in range(-2, 3)]
    return specimen("slats", "transmission", "bilateral", shapes, (1.0, 1.0), z.min() - 0.01, z.max() + 0.01)


def tube(name, along, at, start, wide, thick, height, bsdf):
    """A flat thread along axis `along` (0 X, 1 Y), beside it at `at`, waving with the sign `start`: half axes and wave."""
    s, a = np.linspace(-MARGIN, 1.0 + MARGIN, 145), np.linspace(0.0, 2.0 * np.pi, 97)
    wave, slope = start * height * np.cos(2 * np.pi * s), -start * height * 2 * np.pi * np.sin(2 * np.pi * s)
    length = np.hypot(1.0, slope)
    # rings across the thread's own way
    out, side = np.cos(a), np.sin(a)
    way = s[:, None] - thick * out * (slope / length)[:, None]
    z = wave[:, None] + thick * out * (1.0 / length)[:, None]
    aside = np.broadcast_to(at + wide * side, z.shape)
    vertices = np.stack([way, aside, z] if along == 0 else [aside, way, z], -1).reshape(-1, 3)
    faces = grid_faces(len(s), len(a))
    return mesh(name, vertices, faces if along == 0 else faces[:, ::-1], bsdf)


def woven_threads():
    """Plain weave of flat threads: glossy warp along Y, dull weft along X, gaps between."""
    shapes = []
    for k in (-1, 0, 1, 2):
        at, start = 0.5 * k + 0.25, 1.0 if k % 2 == 0 else -1.0
        # where a warp thread is up, the weft thread that it crosses is down
        shapes.append(shifted_tube(f"warp_{k}", 1, at, start, painted(0.2, 0.35, 0.55)))
        shapes.append(shifted_tube(f"weft_{k}", 0, at, -start, painted(0.35, 0.5, 0.15)))
    return specimen("woven-threads", "reflection", "quadrilateral", shapes, (1.0, 1.0), -0.16, 0.16)


def shifted_tube(name, along, at, start, bsdf):
    """The wave's crests lie on the crossings, a quarter of the period from the cell's side."""
    m = tube(name, along, at, start, 0.2, 0.07, 0.075, bsdf)
    p = mi.traverse(m)
    v = np.array(p["vertex_positions"]).reshape(-1, 3)
    v[:, along] += 0.25
    # a whole period more, so that the cell is covered to both of its margins
    back = v.copy()
    back[:, along] -= 1.0
    faces = np.array(p["faces"]).reshape(-1, 3)
    keep_new = back[faces][:, :, along].max(1) <= 0.25 + 1e-6 - MARGIN
    p_all = np.concatenate([v, back])
    f_all = np.concatenate([faces, (faces + len(v))[keep_new]])
    return mesh(name, p_all, f_all, bsdf)


def bumps_of_two_lengths(cells=256):
    """Hammered metal: long bumps drawn out along X, short ones all over; even in x and y."""
    rng = np.random.default_rng(11)
    at = np.arange(-cells // 8, cells + cells // 8 + 1) / cells
    x, y = at[None, :], at[:, None]
    z = np.zeros((len(at), len(at)))

    def add(modes, slope_x, slope_y):
        part, dx, dy = np.zeros_like(z), 0.0, 0.0
        for kx, ky in modes:
            amplitude = rng.normal() / np.hypot(kx, ky)
            part += amplitude * np.cos(2 * np.pi * kx * x) * np.cos(2 * np.pi * ky * y)
            dx, dy = dx + (amplitude * kx) ** 2, dy + (amplitude * ky) ** 2
        scale = min(slope_x / np.sqrt(dx), slope_y / np.sqrt(dy)) / np.pi
        return scale * part

    z += add([(kx, ky) for kx in (0, 1, 2) for ky in (2, 3, 4, 5)], 0.2, 0.2)
    z += add([(kx, ky) for kx in range(7, 14) for ky in range(7, 14)], 0.08, 0.08)
    vertices = np.stack(np.broadcast_arrays(x, y, z), -1).reshape(-1, 3)
    shapes = [mesh("bumps", vertices, grid_faces(len(at), len(at)), metal(0.08))]
    return specimen(
        "bumps-of-two-lengths", "reflection", "quadrilateral", shapes, (1.0, 1.0), z.min() - 0.01, z.max() + 0.01
    )


def perforated_screen():
    """A painted plate, a fourth of the period thick, with round holes that take 36 % of it."""
    n, radius, half = 64, np.sqrt(0.36 / np.pi), 0.125
    a = 2 * np.pi * (np.arange(n + 1) + 0.5) / n
    hole = 0.5 + radius * np.stack([np.cos(a), np.sin(a)], 1)
    # the same azimuths on the square around it; its corners are added by their own triangles
    square = 0.5 + 0.5 * np.stack([np.cos(a), np.sin(a)], 1) / np.abs([np.cos(a), np.sin(a)]).max(0)[:, None]
    vertices, faces = [], []

    def sheet(points):
        base = sum(len(v) for v in vertices)
        vertices.append(points)
        faces.append(base + grid_faces(2, len(points) // 2))

    corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
    for dx in (-1, 0, 1):
        for dy in (-1, 0, 1):
            shift = np.array([dx, dy, 0.0])
            flat = lambda p, z: np.column_stack([p, np.full(len(p), z)]) + shift
            for z in (-half, half):
                sheet(np.concatenate([flat(hole, z), flat(square, z)]))
                for corner in corners:
                    near = np.argsort(np.hypot(*(square[:-1] - corner).T))[:2]
                    base = sum(len(v) for v in vertices)
                    vertices.append(flat(np.array([corner, *square[near]]), z))
                    faces.append(np.array([[base, base + 1, base + 2]]))
            sheet(np.concatenate([flat(hole, -half), flat(hole, half)]))
    shapes = [mesh("plate", np.concatenate(vertices), np.concatenate(faces), painted(0.2, 0.6, 0.3))]
    return specimen("perforated-screen", "transmission", "quadrilateral", shapes, (1.0, 1.0), -half - 0.01, half + 0.01)


ALL = {
    "bumps-of-two-lengths": bumps_of_two_lengths,
    "perforated-screen": perforated_screen,
    "prismatic-film": prismatic_film,
    "saw-tooth-metal": saw_tooth_metal,
    "slats": slats,
    "woven-threads": woven_threads,
}
