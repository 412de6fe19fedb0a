"""Measurements of micro-geometry by a goniophotometer that is made of traced rays."""

import zlib
from pathlib import Path

import numpy as np

from .._errors import ArgumentError
from .._progress import reporter
from .._types import Traced
from ._cells import angles, blocks, centres, direction, means
from ._goniophotometer import measure
from ._specimen import specimen_of, tracer

#: As the instrument of `bsdfkit.simulate`.
GRAZING_LIMIT_DEGREES, RETRO_HOLE_DEGREES = 82.0, 4.0
#: Mean f below which a side has no light.
DARK = 1e-6


def simulate_geometry(mesh, material, folder, *, period, incident, thetas, azimuths, held_out, noise, seed, progress):
    """See `bsdfkit.simulate_geometry`."""
    if incident not in ("front", "back", "both"):
        raise ArgumentError(f'incident: expected "front", "back" or "both", found {incident!r}')
    if not 0.0 < noise < 1.0:
        raise ArgumentError(f"noise: expected a share above 0 and below 1, found {noise}")
    places = [(float(t), float(p)) for t in thetas for p in (azimuths if t else azimuths[:1])]
    aside = [(float(t), float(p)) for t, p in held_out]
    for theta, _ in places + aside:
        if not 0.0 <= theta < 90.0:
            raise ArgumentError(f"thetas: expected angles from the normal from 0 to below 90, found {theta}")
    if not places:
        raise ArgumentError("thetas, azimuths: expected incident directions, found none")
    folder = Path(folder)
    if folder.exists() and any(folder.iterdir()):
        raise ArgumentError(f"{folder}: expected a new or empty folder, found files in it")
    sides = ["front", "back"] if incident == "both" else [incident]
    total, files, noises, energies = len(sides) * (len(places) + len(aside)), [], [], []
    report = reporter(progress, "rays")
    try:
        with tracer():
            specimen = specimen_of(mesh, material, period)
            measured = folder / "measured"
            measured.mkdir(parents=True, exist_ok=True)
            done, kept = 0, []
            for side in sides:
                for number, (theta, phi) in enumerate(places + aside):
                    theta_i = theta if side == "front" else 180.0 - theta
                    sizes = {"seed": _seed(seed, side, theta, phi), "noise": noise}
                    pair = measure(specimen, theta_i, phi, **sizes)
                    if number < len(places):
                        path = measured / f"{side}_{theta:04.1f}_{phi:05.1f}.csv"
                        path.write_text(_table(theta_i, phi, pair))
                        files.append(path)
                        noises.append(pair[0].noise)
                        energies.append(pair[0].energy)
                    else:
                        kept.append(((theta_i, phi), pair))
                    done += 1
                    report.report(done, total)
    finally:
        report.close()
    path = _kept(folder / "held_out.npz", kept) if kept else None
    return Traced(files, path, float(np.mean(noises)), (float(min(energies)), float(max(energies))))


def _seed(seed, side, theta, phi):
    """The same for the same measurement, whatever else is measured."""
    return zlib.crc32(f"{seed} {side} {theta} {phi}".encode()) % 1_000_000


def _table(theta_i, phi_i, pair):
    """Rows of what the instrument sees, one a block of cells."""
    lines = ["theta_i,phi_i,theta_o,phi_o,value"]
    wi = direction(theta_i, phi_i)
    for up, part in zip((True, False), pair):
        if part.values.mean() < DARK:
            continue
        number, corners = blocks(part.rays)
        wo = centres(corners, 1.0 if up else -1.0)
        seen = np.abs(wo[:, 2]) >= np.cos(np.radians(GRAZING_LIMIT_DEGREES))
        seen &= wo @ wi < np.cos(np.radians(RETRO_HOLE_DEGREES))
        theta_o, phi_o = angles(wo)
        f = means(number, part.values)
        rows = zip(theta_o[seen], phi_o[seen], f[seen])
        lines += [f"{theta_i:g},{phi_i:g},{a:.4f},{b:.4f},{v:.6g}" for a, b, v in rows]
    return "\n".join(lines) + "\n"


def _kept(path, kept):
    """f by cell of the whole sphere, upward then downward, and the noise of each incidence."""
    np.savez_compressed(
        path,
        incidences=np.array([at for at, _ in kept]),
        values=np.array([[part.values for part in pair] for _, pair in kept], np.float32),
        rays=np.array([[part.rays for part in pair] for _, pair in kept], np.float32),
        noise=np.array([pair[0].noise for _, pair in kept]),
    )
    return path
