"""What is predicted where nothing was measured: Radiance's interpolant beside ours, on the same split of a specimen.

    python benches/left_out.py FOLDER           Mountain files of one pair of sides, one incidence each

Each file in turn is left out; both programs fit the others and predict its points. Points fall into 64 x 64
cells of equal projected solid angle; L1 is the sum of |measured - predicted| over that of measured, of the
means of cells; energy is predicted over measured. Radiance's SIR file is evaluated by `bsdf eval`, which agrees
with the reference (crates/represent/tests/sir.rs); with plans as stored, as Radiance reads them.
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pyradiance

RADIANCE = Path(pyradiance.__file__).resolve().parent
BSDF = Path(os.environ.get("BSDF", "target/release/bsdf")).resolve()
CELLS = 64


def read(path):
    """Rows theta_i phi_i theta_o phi_o in degrees, and the measured BSDF of each."""
    head, rows = {}, []
    for line in path.read_text().splitlines():
        if line.startswith("#"):
            key, _, rest = line[1:].strip().partition(" ")
            head[key.rstrip(":")] = rest.split()
        elif line.strip():
            rows.append([float(word) for word in line.split()[:3]])
    rows = np.array(rows)
    theta, phi = float(head["intheta"][0]), float(head["inphi"][0])
    turn = 90.0 - float(head.get("upphi", ["0"])[0])
    values = rows[:, 2]
    if head["format"][-1].upper() == "DSF":
        values = values / np.maximum(np.abs(np.cos(np.radians(rows[:, 0]))), 1e-3)
    n = len(rows)
    pairs = np.column_stack([np.full(n, theta), np.full(n, phi + turn), rows[:, 0], rows[:, 1] + turn])
    return pairs, values


def cells(pairs):
    """The number of the cell of each scattered direction in the square of equal areas. [Shirley and Chiu 1997]"""
    radius, phi = np.sin(np.radians(pairs[:, 2])), np.radians(pairs[:, 3])
    quarter = np.floor(phi / (np.pi / 2) + 0.5)
    # Along and across the nearest axis, turned back to it.
    along, across = radius, radius * (phi - quarter * np.pi / 2) / (np.pi / 4)
    cos, sin = np.round(np.cos(quarter * np.pi / 2)), np.round(np.sin(quarter * np.pi / 2))
    square = np.stack([along * cos - across * sin, along * sin + across * cos])
    index = np.clip(((square + 1) / 2 * CELLS).astype(int), 0, CELLS - 1)
    return index[0] * CELLS + index[1]


def compare(file, pairs, measured):
    """(L1, energy) of a file that `bsdf eval` reads."""
    text = "\n".join(" ".join(f"{a:.9g}" for a in row) for row in pairs)
    out = subprocess.run([BSDF, "eval", file], input=text, capture_output=True, text=True, check=True)
    predicted = np.array(out.stdout.split(), float)
    number = cells(pairs)
    count = np.bincount(number, minlength=CELLS**2)
    mean = [np.bincount(number, v, CELLS**2)[count > 0] / count[count > 0] for v in (measured, predicted)]
    return np.abs(mean[0] - mean[1]).sum() / mean[0].sum(), mean[1].sum() / mean[0].sum()


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    files = sorted(Path(sys.argv[1]).resolve().glob("*.txt"))
    if len(files) < 4:
        sys.exit(f"{sys.argv[1]}: expected at least 4 Mountain files (*.txt), found {len(files)}")
    print(f"{'left out':32} {'Radiance L1':>12} {'energy':>8} {'ours L1':>9} {'energy':>8} {'ratio':>7}")
    for left_out in files:
        others = [str(f) for f in files if f != left_out]
        pairs, measured = read(left_out)
        with tempfile.TemporaryDirectory() as name:
            theirs, ours = Path(name) / "theirs.sir", Path(name) / "ours.safetensors"
            with open(theirs, "wb") as out:
                command = [RADIANCE / "bin/pabopto2bsdf", "-n", str(os.cpu_count()), "-t", *others]
                subprocess.run(command, stdout=out, check=True, capture_output=False, stderr=subprocess.DEVNULL)
            subprocess.run([BSDF, "fit", *others, "-o", ours], check=True, capture_output=True)
            (a, ea), (b, eb) = compare(theirs, pairs, measured), compare(ours, pairs, measured)
            print(f"{left_out.name:32} {a:12.4f} {ea:8.3f} {b:9.4f} {eb:8.3f} {b / a:7.2f}", flush=True)


if __name__ == "__main__":
    main()
