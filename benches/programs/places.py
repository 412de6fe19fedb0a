"""Files of the film, and how a south window of EnergyPlus's room lies in the film's frame."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
BSDF = os.environ.get("BSDF", str(ROOT / "target" / "release" / "bsdf"))
# Programs are run as the tests of interoperation run them.
sys.path.insert(0, str(ROOT / "tests" / "interop"))


def bsdf(*arguments):
    """Our command; a failure ends the bench with what it says."""
    done = subprocess.run([BSDF, *map(str, arguments)], capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"bsdf {' '.join(map(str, arguments))}: {done.stderr}")
    return done.stdout


def from_sun(altitude, azimuth):
    """The incident direction of a sun, degrees (azimuth from north, clockwise), on a window that faces south.

    +X is right as seen from the room, which is west; +Y is up; the room, +Z, is north.
    """
    altitude, azimuth = np.radians(altitude), np.radians(azimuth)
    east, north = np.cos(altitude) * np.sin(azimuth), np.cos(altitude) * np.cos(azimuth)
    return np.stack([-east, np.sin(altitude), north], -1)


def travel(wi):
    """θ and φ, degrees, by which WINDOW's bases number an incident direction: those of its way."""
    return np.degrees(np.arccos(np.abs(wi[..., 2]))), np.degrees(np.arctan2(-wi[..., 1], -wi[..., 0])) % 360.0
