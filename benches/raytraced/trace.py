"""Ray-traced specimens, measured: folders that `bsdf fit` reads, and incidences kept aside.

    python benches/raytraced/trace.py OUT [SPECIMEN ...]        every specimen without names

Writes OUT/SPECIMEN/measured/*.csv (theta_i, phi_i, theta_o, phi_o, value; one incidence each) and the same by cell in
measured.npz; held_out.npz and grazing.npz, every incidence traced twice; about.json and picture.png. OUT/hemispheres.png
holds all pictures side by side.
"""

import argparse
import json
import sys
import time
import zlib
from pathlib import Path

import numpy as np
from PIL import Image

sys.path.insert(0, str(Path(__file__).resolve().parent))

import specimens  # noqa: E402
from cells import CELLS, angles, blocks, centres, direction, means, to_hemisphere  # noqa: E402
from bsdfkit.geometry._goniophotometer import measure as measured_sides  # noqa: E402

THETAS = [0, 15, 30, 45, 60, 75]
AZIMUTHS = {"bilateral": range(0, 181, 30), "quadrilateral": range(0, 91, 30)}
#: In the middle of the cells of the measured grid.
HELD_OUT = {
    "bilateral": [(7.5, 15), (22.5, 45), (22.5, 135), (37.5, 105), (52.5, 15), (52.5, 165), (67.5, 75), (67.5, 135)],
    "quadrilateral": [(7.5, 45), (22.5, 15), (22.5, 75), (37.5, 45), (52.5, 15), (67.5, 45)],
}
GRAZING = {"bilateral": [(80, 0), (80, 105), (85, 165)], "quadrilateral": [(80, 15), (80, 90), (85, 45)]}
#: As the instrument of `bsdf simulate`.
GRAZING_LIMIT_DEGREES, RETRO_HOLE_DEGREES = 82.0, 4.0


def measure(specimen, theta, phi, seed):
    """The specimen's own side of one incidence."""
    (found,) = measured_sides(specimen, theta, phi, seed, specimen.ups)
    return found


def seed(name, theta, phi, repeat):
    """The same for the same measurement, whatever else is measured."""
    return zlib.crc32(f"{name} {theta} {phi} {repeat}".encode()) % 1_000_000


def table(path, specimen, theta, phi, measured):
    """One row a block that the instrument can see."""
    number, parts = blocks(measured.rays)
    wo = centres(parts, 1.0 if specimen.side == "reflection" else -1.0)
    seen = np.abs(wo[:, 2]) >= np.cos(np.radians(GRAZING_LIMIT_DEGREES))
    if specimen.side == "reflection":
        seen &= wo @ direction(theta, phi) < np.cos(np.radians(RETRO_HOLE_DEGREES))
    theta_o, phi_o = angles(wo)
    rows = zip(theta_o[seen], phi_o[seen], means(number, measured.values)[seen])
    lines = [f"{theta},{phi},{a:.4f},{b:.4f},{f:.6g}" for a, b, f in rows]
    path.write_text("\n".join(["theta_i,phi_i,theta_o,phi_o,value", *lines]) + "\n")
    return len(lines)


def kept(path, specimen, incidences, runs):
    """f by cell of every run of every incidence, and the rays of its runs together."""
    np.savez_compressed(
        path,
        incidences=np.array(incidences, float),
        values=np.array([[m.values for m in each] for each in runs], np.float32),
        rays=np.array([sum(m.rays for m in each) for each in runs], np.float32),
        side=specimen.side,
    )


def aside(path, specimen, incidences):
    """Incidences traced twice; their noise."""
    twice = [[measure(specimen, t, p, seed(specimen.name, t, p, k)) for k in (1, 2)] for t, p in incidences]
    kept(path, specimen, incidences, twice)
    return float(np.mean([m.noise for pair in twice for m in pair]))


def picture(path, specimen, theta, phi, measured, size=192):
    """The hemisphere from above (X to the right, Y up), four decades of f, dark to light."""
    at = (np.arange(size) + 0.5) / size * 2 - 1
    x, y = np.meshgrid(at, -at)
    cell = nearest_cell(x, y)
    number, _ = blocks(measured.rays)
    f = means(number, measured.values)[number][cell]
    shade = np.clip(1 + np.log10(np.maximum(f, 1e-9) / f.max()) / 4, 0, 1)
    shade[np.hypot(x, y) > 1] = 1.0
    wi = direction(theta, phi)
    shade[np.hypot(x - wi[0], y - wi[1]) < 0.02] = 1.0
    Image.fromarray((255 * shade).astype(np.uint8)).save(path)


def together(out):
    """The pictures of all specimens that there are, side by side."""
    found = [np.array(Image.open(p)) for p in sorted(out.glob("*/picture.png"))]
    Image.fromarray(np.concatenate(found, 1)).save(out / "hemispheres.png", optimize=True)


def nearest_cell(x, y):
    """Cells of points of the disk, by looking at every cell's middle: slow and plain."""
    k = np.arange(CELLS * CELLS)
    middles = to_hemisphere((k // CELLS + 0.5) / CELLS, (k % CELLS + 0.5) / CELLS)[:, :2]
    points = np.stack([x.ravel(), y.ravel()], 1)
    near = [np.argmin(((middles - p) ** 2).sum(1)) for p in points]
    return np.array(near).reshape(x.shape)


def run(name, out):
    start = time.monotonic()
    specimen = specimens.ALL[name]()
    folder = out / name
    (folder / "measured").mkdir(parents=True, exist_ok=True)
    incidences = [(t, p) for t in THETAS for p in ([0] if t == 0 else AZIMUTHS[specimen.symmetry])]
    runs, rows = [], 0
    for theta, phi in incidences:
        m = measure(specimen, theta, phi, seed(name, theta, phi, 0))
        rows += table(folder / "measured" / f"t{theta:04.1f}_p{phi:05.1f}.csv", specimen, theta, phi, m)
        runs.append([m])
        if (theta, phi) == (30, 60):
            picture(folder / "picture.png", specimen, theta, phi, m)
    kept(folder / "measured.npz", specimen, incidences, runs)
    held_out = aside(folder / "held_out.npz", specimen, HELD_OUT[specimen.symmetry])
    grazing = aside(folder / "grazing.npz", specimen, GRAZING[specimen.symmetry])
    energy = [m.energy for (m,) in runs]
    about = {
        "specimen": name,
        "side": specimen.side,
        "symmetry": specimen.symmetry,
        "rows": rows,
        "noise_measured": round(float(np.mean([m.noise for (m,) in runs])), 4),
        "noise_held_out": round(held_out, 4),
        "noise_grazing": round(grazing, 4),
        "energy_both_sides": [round(min(energy), 4), round(max(energy), 4)],
        "seconds": round(time.monotonic() - start, 1),
    }
    (folder / "about.json").write_text(json.dumps(about, indent=1) + "\n")
    print(json.dumps(about), flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=Path)
    parser.add_argument("specimen", nargs="*", default=list(specimens.ALL))
    arguments = parser.parse_args()
    for name in arguments.specimen:
        if name not in specimens.ALL:
            parser.error(f"specimen: expected one of {', '.join(specimens.ALL)}, found {name!r}")
    for name in arguments.specimen:
        run(name, arguments.out)
    together(arguments.out)


if __name__ == "__main__":
    main()
