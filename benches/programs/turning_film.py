"""A film with two sides in closed form: what four programs are asked about, and its measurement as a table.

Every pair of sides has a Lambertian part and a Gaussian on the disk of direction cosines (x, y):

    f(wi, wo) = ρ/π + mass / (2π σ²) exp(-|wi + wo - turn|² / 2σ²)

Transmission turns light upward (turn along +Y), so that a program which mixes up azimuths or sides is found out. f is the same
with wi and wo exchanged. The integral of f |cos θo| over a hemisphere is that of f over the disk.
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Part:
    """What is scattered from one side to one side."""

    lambertian: float
    mass: float
    sigma: float
    turn: float = 0.0


THROUGH = Part(lambertian=0.06, mass=0.6, sigma=0.28, turn=0.2)
#: By (from the front, to the front); the front, +Z, is the room.
PARTS = {
    (True, True): Part(lambertian=0.1, mass=0.08, sigma=0.25),
    (False, False): Part(lambertian=0.2, mass=0.05, sigma=0.3),
    (True, False): THROUGH,
    (False, True): THROUGH,
}
THETAS = [0, 15, 30, 45, 60, 75, 85]
#: The other half is the mirror image.
AZIMUTHS = range(-90, 91, 30)
#: Detector positions along either side of the square of equal projected solid angle.
POSITIONS = 26


def direction(theta, phi):
    """Unit vectors of degrees, shape (..., 3)."""
    theta, phi = np.radians(theta), np.radians(phi)
    return np.stack(np.broadcast_arrays(np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)), -1)


def disk(n):
    """The middles of n x n cells of equal area of the unit disk (Shirley and Chiu), shape (n², 2)."""
    at = (np.arange(n) + 0.5) / n * 2 - 1
    a, b = (g.ravel() for g in np.meshgrid(at, at))
    wide = np.abs(a) > np.abs(b)
    r = np.where(wide, a, b)
    other = np.where(wide, b, a) / np.where(r == 0, 1, r) * np.pi / 4
    phi = np.where(wide, other, np.pi / 2 - other)
    return np.stack([r * np.cos(phi), r * np.sin(phi)], -1)


def hemisphere(n, front):
    """Directions of the cells of `disk`, shape (n², 3)."""
    xy = disk(n)
    z = np.sqrt(np.maximum(0.0, 1.0 - (xy**2).sum(-1)))
    return np.column_stack([xy, z if front else -z])


def value(wi, wo):
    """f in 1/sr of unit vectors that point away from the film, all from one side to one side."""
    part = PARTS[bool(np.ravel(wi[..., 2])[0] > 0), bool(np.ravel(wo[..., 2])[0] > 0)]
    offset = wi[..., :2] + wo[..., :2] - np.array([0.0, part.turn])
    peak = part.mass / (2 * np.pi * part.sigma**2) * np.exp(-0.5 * (offset**2).sum(-1) / part.sigma**2)
    return part.lambertian / np.pi + peak


def transmittance(wi, n=400):
    """∫ f |cos θo| dωo of incident directions of one side, by n² equal cells of the disk: shape (..., 3) -> (...)."""
    wi = np.atleast_2d(wi)
    wo = hemisphere(n, wi[0, 2] < 0)
    return np.array([np.pi * value(w[None], wo).mean() for w in wi])


def table():
    """The measurement as `bsdf fit` reads it: nothing past 85 degrees."""
    lines = ["theta_i,phi_i,theta_o,phi_o,value"]
    for front_in in (True, False):
        for theta in THETAS:
            for phi in AZIMUTHS if theta else [0]:
                theta_i = theta if front_in else 180 - theta
                wi = direction(float(theta_i), float(phi))
                for front_out in (True, False):
                    wo = hemisphere(POSITIONS, front_out)
                    wo = wo[np.abs(wo[:, 2]) > np.cos(np.radians(85.0))]
                    theta_o = np.degrees(np.arccos(wo[:, 2]))
                    phi_o = np.degrees(np.arctan2(wo[:, 1], wo[:, 0])) % 360
                    rows = zip(theta_o, phi_o, value(wi[None], wo))
                    lines += [f"{theta_i},{phi % 360},{a:.4f},{b:.4f},{f:.6g}" for a, b, f in rows]
    return "\n".join(lines) + "\n"
