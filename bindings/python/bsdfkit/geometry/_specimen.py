"""A cell of micro-geometry, repeated without end along X and Y, as Mitsuba traces it."""

from contextlib import contextmanager
from dataclasses import dataclass
from os import PathLike, fspath
from pathlib import Path

import mitsuba as mi
import numpy as np

from .. import mitsuba as plugin
from .._errors import ArgumentError, IoError
from ._goniophotometer import MARGIN

#: Copies a mesh may reach beyond its cell on either side.
MOST_COPIES = 8
VARIANT = "llvm_ad_mono"


@dataclass
class Specimen:
    """What is traced: a scene, and the cell [0, x) × [0, y) of it between `bottom` and `top`."""

    scene: object
    period: tuple
    bottom: float
    top: float


@contextmanager
def tracer():
    """Mitsuba's variant for tracing; the caller's comes back.

    Raises:
        ArgumentError: no LLVM 19.
    """
    _, why = plugin.best_variant()
    if why:
        raise ArgumentError(f"ray tracing: {why}")
    before = mi.variant()
    mi.set_variant(VARIANT)
    try:
        yield
    finally:
        if before:
            mi.set_variant(before)


def specimen_of(meshes, materials, period):
    """The specimen of mesh files, each with its material; lengths are scaled so that the longer period is 1.

    Raises:
        ArgumentError, IoError.
    """
    if isinstance(meshes, (str, PathLike)):
        meshes, materials = [meshes], [materials]
    if len(meshes) != len(materials):
        raise ArgumentError(f"material: expected one for each of {len(meshes)} meshes, found {len(materials)}")
    parts = [_triangles(Path(fspath(path))) for path in meshes]
    corners = np.concatenate([v for v, _ in parts])
    low, high = corners.min(0), corners.max(0)
    period = np.array(high[:2] - low[:2] if period is None else period, float)
    if period.shape != (2,) or not (np.isfinite(period).all() and (period > 0).all()):
        raise ArgumentError(f"period: expected two lengths above 0, along X and Y, found {period.tolist()}")
    copies = np.ceil((high[:2] - low[:2]) / period).astype(int) + 1
    if (copies > MOST_COPIES).any():
        raise ArgumentError(f"period: expected a mesh of at most {MOST_COPIES - 1} periods, found {(high[:2] - low[:2]) / period}")
    scale = 1.0 / period.max()
    shapes = {}
    for number, ((vertices, faces), material) in enumerate(zip(parts, materials)):
        moved = (vertices - [low[0], low[1], 0.0]) * scale
        shapes[f"part_{number}"] = _repeated(f"part_{number}", moved, faces, period * scale, copies, _bsdf(material))
    scene = mi.load_dict({"type": "scene", **shapes})
    # Room for rays to begin in, also over a sheet without thickness.
    return Specimen(scene, tuple((period * scale).tolist()), float(low[2] * scale - 0.01), float(high[2] * scale + 0.01))


def _triangles(path):
    """Vertices (n, 3) and faces (m, 3) of a mesh file."""
    kind = path.suffix.lower().lstrip(".")
    if kind not in ("obj", "ply"):
        raise ArgumentError(f"{path}: expected a mesh, .obj or .ply, found {path.suffix!r}")
    if not path.is_file():
        raise IoError(f"{path}: no such file")
    try:
        mesh = mi.traverse(mi.load_dict({"type": kind, "filename": str(path)}))
    except RuntimeError as error:
        raise ArgumentError(f"{path}: Mitsuba does not read it: {error}") from None
    vertices = np.array(mesh["vertex_positions"], float).reshape(-1, 3)
    faces = np.array(mesh["faces"], np.int64).reshape(-1, 3)
    if not len(faces) or not np.isfinite(vertices).all():
        raise ArgumentError(f"{path}: expected triangles of finite coordinates, found {len(faces)} triangles")
    return vertices, faces


def _bsdf(material):
    """A Mitsuba BSDF of what the caller calls a material."""
    if isinstance(material, (int, float)):
        if not 0.0 <= material <= 1.0:
            raise ArgumentError(f"material: expected a reflectance from 0 to 1, found {material}")
        value = {"type": "uniform", "value": float(material)}
        return mi.load_dict({"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": value}})
    if isinstance(material, (str, PathLike)):
        return mi.load_dict({"type": "bsdfkit", "filename": fspath(material)})
    if isinstance(material, dict):
        return mi.load_dict(material)
    raise ArgumentError(f"material: expected a reflectance, a BSDF's file or a dictionary of Mitsuba, found {material!r}")


def _repeated(name, vertices, faces, period, copies, bsdf):
    """One mesh of all copies that reach into the cell and its margin, with flat normals."""
    corners = vertices[faces]
    found = []
    for i in range(-copies[0], copies[0] + 1):
        for j in range(-copies[1], copies[1] + 1):
            shifted = corners + [i * period[0], j * period[1], 0.0]
            low, high = shifted.min(1)[:, :2], shifted.max(1)[:, :2]
            near = ((high >= -2 * MARGIN * period) & (low <= (1 + 2 * MARGIN) * period)).all(1)
            found.append(shifted[near])
    corners = np.concatenate(found).astype(np.float32)
    properties = mi.Properties()
    properties["bsdf"] = bsdf
    properties["face_normals"] = True
    mesh = mi.Mesh(name, 3 * len(corners), len(corners), props=properties)
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = mi.Float(corners.ravel())
    parameters["faces"] = mi.UInt32(np.arange(3 * len(corners), dtype=np.uint32))
    parameters.update()
    return mesh
