"""A laboratory's whole set: four hemispheres of 101 incidences, 128 million points, 3.3 GB of text, as one fit.

    python benches/laboratory.py --bsdf target/release/bsdf [--against OTHER/bsdf] [--reader target/release/examples/read] [--keep DIR]

Makes the set with `bsdf simulate` (reflection and transmission, of the front and of a specimen mounted back to front), fits it, and prints
processor seconds, peak memory and what reading the text alone takes (`cargo build --release -p bsdfkit-measure --example read`). With
another build, both fit 13 million points (one hemisphere) in turn: what a point costs, as a ratio. The set stays in DIR where one is given.
"""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

ALL = ["--azimuth-step", "18", "--sweeps", "600", "--points-per-sweep", "500"]
PARTS = [
    ("reflection", "rotated-metal", []),
    ("reflection-back", "rotated-metal", ["--back-to-front", "--seed", "2"]),
    ("transmission", "square-diffuser", []),
    ("transmission-back", "square-diffuser", ["--back-to-front", "--seed", "2"]),
]
ONE = ["--sweeps", "200", "--points-per-sweep", "1000"]


def timed(*line):
    """Wall-clock and processor seconds, peak memory in MB of a command."""
    words = ["/usr/bin/time", "-f", "%e %U %S %M", *map(str, line)]
    ran = subprocess.run(words, capture_output=True, text=True, check=False)
    if ran.returncode != 0:
        sys.exit(ran.stderr)
    wall, user, system, kilobytes = map(float, ran.stderr.split()[-4:])
    return wall, user + system, kilobytes / 1000


def bytes_in(folders):
    return sum(path.stat().st_size for folder in folders for path in folder.iterdir())


def simulated(bsdf, folder, material, words):
    """A folder with the measurement, made unless it is there."""
    if not folder.exists():
        subprocess.run([bsdf, "simulate", material, *words, "-o", folder], check=True, stdout=subprocess.DEVNULL)
    return folder


def compared(bsdf, other, folder):
    one = simulated(bsdf, folder / "one", "rotated-metal", ONE)
    costs = {bsdf: [], other: []}
    for _ in range(2):
        for build in (other, bsdf):
            costs[build].append(timed(build, "fit", one, "-o", folder / "one.safetensors"))
    for build, runs in costs.items():
        told = "; ".join(f"{wall:.1f} s, processors {cpu:.1f} s, {memory:.0f} MB" for wall, cpu, memory in runs)
        print(f"13 million points, {build}: {told}")
    least = [[min(run[k] for run in costs[build]) for k in (1, 2)] for build in (bsdf, other)]
    print(f"ratio: processors {least[0][0] / least[1][0]:.3f}, memory {least[0][1] / least[1][1]:.3f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bsdf", required=True, type=Path)
    parser.add_argument("--against", type=Path)
    parser.add_argument("--reader", type=Path)
    parser.add_argument("--keep", type=Path)
    wanted = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = wanted.keep or Path(temporary)
        folder.mkdir(exist_ok=True)
        if wanted.against:
            compared(wanted.bsdf, wanted.against, folder)
        parts = [simulated(wanted.bsdf, folder / name, material, ALL + more) for name, material, more in PARTS]
        print(f"{sum(1 for part in parts for _ in part.iterdir())} files, {bytes_in(parts) / 1e9:.2f} GB of text")
        if wanted.reader:
            wall, cpu, memory = timed(wanted.reader, *parts)
            print(f"reading alone: {wall:.1f} s, processors {cpu:.1f} s, {memory:.0f} MB")
        wall, cpu, memory = timed(wanted.bsdf, "fit", *parts, "-o", folder / "all.safetensors")
        print(f"fit of all: {wall:.1f} s, processors {cpu:.1f} s, {memory:.0f} MB")


main()
