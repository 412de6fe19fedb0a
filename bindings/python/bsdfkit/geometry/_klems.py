"""Micro-geometry straight to a Klems matrix, as Radiance's genBSDF does: rays from everywhere in a patch, counted by patch."""

from pathlib import Path

import drjit as dr
import mitsuba as mi
import numpy as np

from .._errors import ArgumentError
from .._progress import reporter
from ._goniophotometer import escaped
from ._specimen import specimen_of, tracer

NAME = "LBNL/Klems Full"
#: Borders of rings, degrees, and patches in each.
BORDERS = np.array([0, 5, 15, 25, 35, 45, 55, 65, 75, 90])
PATCHES = np.array([1, 8, 16, 20, 24, 24, 24, 16, 12])
FIRST = np.concatenate([[0], np.cumsum(PATCHES)])
COUNT = int(FIRST[-1])
RING = np.repeat(np.arange(len(PATCHES)), PATCHES)
_SINES = np.sin(np.radians(BORDERS)) ** 2
#: Projected solid angle of each patch.
OMEGA = np.pi * np.diff(_SINES)[RING] / PATCHES[RING]
#: Rays a launch, at most.
LAUNCH = 1 << 20


def geometry_klems(mesh, material, path, *, period, rays, seed, progress):
    """See `bsdfkit.geometry_klems`."""
    if not rays >= 1:
        raise ArgumentError(f"rays: expected at least 1 an incident patch, found {rays}")
    path = Path(path)
    if path.suffix.lower() != ".xml":
        raise ArgumentError(f"{path}: expected a name ending in .xml")
    # Squares, as positions are stratified.
    each = int(np.ceil(np.sqrt(rays))) ** 2
    passes = -(-each * COUNT // LAUNCH)
    each = -(-each // passes)
    report, matrices = reporter(progress, "rays"), {}
    try:
        with tracer():
            specimen = specimen_of(mesh, material, period)
            for n, front in enumerate((True, False)):
                light = np.zeros((2, COUNT, COUNT))
                for k in range(passes):
                    light += _pass(specimen, front, each, seed * 1000 + n * 500 + k)
                    report.report(n * passes + k + 1, 2 * passes)
                for up, counted in zip((True, False), light):
                    matrices[front, up] = counted / (each * passes) / OMEGA[:, None]
    finally:
        report.close()
    part = path.with_name(path.name + ".part")
    part.write_text(_xml(path.stem, matrices))
    part.replace(path)
    return path


def _pass(specimen, front, each, seed):
    """Light by (up or down, scattered patch, incident patch) of `each` rays an incident patch."""
    rng = np.random.default_rng(seed)
    incident = rng.permutation(np.repeat(np.arange(COUNT), each))
    ring = RING[incident]
    u, v = rng.random((2, len(incident)))
    sine = np.sqrt(_SINES[ring] + (_SINES[ring + 1] - _SINES[ring]) * u)
    phi = 2 * np.pi * (incident - FIRST[ring] + v - 0.5) / PATCHES[ring]
    cosine = np.sqrt(1 - sine**2)
    # Patches of incident light are numbered by where it goes.
    wi = np.stack([-sine * np.cos(phi), -sine * np.sin(phi), cosine if front else -cosine], -1)
    d, weight, left = escaped(specimen, wi, seed, 0.0, len(incident))
    scattered = _patch_of(d)
    light = []
    for up in (True, False):
        counted = dr.zeros(mi.Float, COUNT * COUNT)
        dr.scatter_add(counted, weight, scattered * COUNT + mi.UInt32(incident.astype(np.uint32)), left & ((d.z > 0) == up))
        light.append(np.array(counted, float).reshape(COUNT, COUNT))
    return np.array(light)


def _patch_of(d):
    """The number of the patch of directions, by x and y alone."""
    sine2 = dr.minimum(d.x * d.x + d.y * d.y, 1.0)
    ring = mi.UInt32(0)
    for border in _SINES[1:-1].tolist():
        ring += dr.select(sine2 >= border, mi.UInt32(1), mi.UInt32(0))
    count = dr.gather(mi.Float, mi.Float(PATCHES.astype(np.float32)), ring)
    first = dr.gather(mi.UInt32, mi.UInt32(FIRST.astype(np.uint32)), ring)
    turns = dr.atan2(d.y, d.x) / (2 * dr.pi)
    number = dr.floor((turns - dr.floor(turns)) * count + 0.5)
    # No integer remainder: lanes beyond the last ray divide by 0.
    return first + mi.UInt32(dr.select(number >= count, 0.0, number))


def _xml(name, matrices):
    """A file of WINDOW's form. Its front is the exterior, z < 0."""
    rings = "".join(
        f"<AngleBasisBlock><Theta>{(0 if n == 0 else (low + high) / 2):g}</Theta><nPhis>{count}</nPhis><ThetaBounds>"
        f"<LowerTheta>{low}</LowerTheta><UpperTheta>{high}</UpperTheta></ThetaBounds></AngleBasisBlock>\n"
        for n, (low, high, count) in enumerate(zip(BORDERS[:-1], BORDERS[1:], PATCHES))
    )
    # Zeros are left out, as files with a dummy block are questioned; something must be there.
    lit = {pair: matrix for pair, matrix in matrices.items() if matrix.any()} or matrices
    blocks = []
    for (front, up), matrix in lit.items():
        kind, side = ("Reflection" if front == up else "Transmission"), ("Back" if front else "Front")
        rows = "\n".join(",".join(f"{v:.6g}" for v in row) for row in matrix)
        blocks.append(
            f"<WavelengthData>\n<LayerNumber>System</LayerNumber>\n<Wavelength unit=\"Integral\">Visible</Wavelength>\n"
            f"<WavelengthDataBlock>\n<WavelengthDataDirection>{kind} {side}</WavelengthDataDirection>\n"
            f"<ColumnAngleBasis>{NAME}</ColumnAngleBasis>\n<RowAngleBasis>{NAME}</RowAngleBasis>\n"
            f"<ScatteringDataType>{'BRDF' if front == up else 'BTDF'}</ScatteringDataType>\n"
            f"<ScatteringData>\n{rows}\n</ScatteringData>\n</WavelengthDataBlock>\n</WavelengthData>\n"
        )
    escaped_name = name.replace("&", "&amp;").replace("<", "&lt;")
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n<WindowElement xmlns="http://windows.lbl.gov">\n'
        "<WindowElementType>System</WindowElementType>\n<FileType>BSDF</FileType>\n<Optical>\n<Layer>\n"
        f"<Material>\n<Name>{escaped_name}</Name>\n<Manufacturer>ray tracing</Manufacturer>\n"
        "<DeviceType>Other</DeviceType>\n</Material>\n<DataDefinition>\n"
        "<IncidentDataStructure>Columns</IncidentDataStructure>\n"
        f"<AngleBasis>\n<AngleBasisName>{NAME}</AngleBasisName>\n{rings}</AngleBasis>\n</DataDefinition>\n"
        + "".join(blocks)
        + "</Layer>\n</Optical>\n</WindowElement>\n"
    )
