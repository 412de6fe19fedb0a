"""What the figures are made of: a virtual specimen, measured, fitted by us and by Radiance, in a folder that is kept."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pyradiance

ROOT = Path(__file__).resolve().parents[3]
FIGURES = ROOT / "docs" / "figures"
BSDF = os.environ.get("BSDF", str(ROOT / "target" / "release" / "bsdf"))
HOME = Path(pyradiance.__file__).resolve().parent
#: Fewer points than a laboratory's, about 20 000 an incidence.
INSTRUMENT = ["--sweeps", 24, "--points-per-sweep", 120]


def run(command, stdin=None, stdout=subprocess.PIPE):
    environment = dict(os.environ, RAYPATH=f".{os.pathsep}{HOME / 'lib'}")
    environment["PATH"] = f"{HOME / 'bin'}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(list(map(str, command)), input=stdin, stdout=stdout, stderr=subprocess.PIPE, env=environment)
    if done.returncode:
        sys.exit(f"{command[0]}: {done.stderr.decode(errors='replace')}")
    return done.stdout


def bsdf(*arguments, stdin=None):
    return run([BSDF, *arguments], stdin)


def measured(folder, material):
    """The folder of measurements."""
    path = folder / material
    if not path.exists():
        part = path.with_suffix(".part")
        shutil.rmtree(part, ignore_errors=True)
        bsdf("simulate", material, *INSTRUMENT, "-o", part)
        part.rename(path)
    return path


def fitted(folder, material):
    """Our interpolant."""
    path = folder / f"{material}.safetensors"
    if not path.exists():
        bsdf("fit", measured(folder, material), "-o", path)
    return path


def by_radiance(folder, material):
    """Radiance's interpolant of the same files."""
    path = folder / f"{material}.sir"
    if not path.exists():
        part = path.with_suffix(".part")
        with open(part, "wb") as out:
            run(["pabopto2bsdf", "-n", 1, *sorted(measured(folder, material).glob("*.txt"))], stdout=out)
        part.rename(path)
    return path


def values(source, theta, phi, wo):
    """f of a file, or of ["--material", NAME], at one incidence."""
    theta_o, phi_o = np.degrees(np.arccos(wo[:, 2])), np.degrees(np.arctan2(wo[:, 1], wo[:, 0])) % 360
    rows = "".join(f"{theta} {phi} {a:.6f} {b:.6f}\n" for a, b in zip(theta_o, phi_o))
    return np.array(bsdf("eval", *source, stdin=rows.encode()).split(), float)


def points(path):
    """Incidence (θ, φ) and rows (θ, φ, value) of a Mountain file."""
    at, rows = {}, []
    for line in path.read_text().splitlines():
        if line.startswith("#"):
            words = line[1:].split()
            if words[0] in ("intheta", "inphi"):
                at[words[0]] = float(words[1])
        elif line.strip():
            rows.append(line.split())
    return (at["intheta"], at["inphi"]), np.array(rows, float)


def direction(theta, phi):
    theta, phi = np.radians(theta), np.radians(phi)
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1)


def disk(n):
    """The square picture of the disk of directions: unit vectors (n, n, 3), +Y up, and which pixels are in it."""
    at = (np.arange(n) + 0.5) / n * 2 - 1
    x, y = np.meshgrid(at, -at)
    r2 = x * x + y * y
    return np.stack([x, y, np.sqrt(np.maximum(0, 1 - r2))], -1), r2 < 0.995
