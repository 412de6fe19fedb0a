"""A film with two sides, in closed form, and its measurement as a table.

Light is scattered about the mirror direction and about the direction straight through, on top of a Lambertian part;
the front, +Z, reflects otherwise than the back, and transmission is the same both ways.
"""

import math

# Polar angles of incidence and of the detector, and the detector's azimuths, in degrees.
INCIDENT = [0, 25, 50, 70]
SCATTERED = [0, 4, 8, 12, 16, 20, 25, 30, 35, 40, 45, 50, 55, 60, 65, 70, 75, 80, 85]
AZIMUTHS = range(0, 360, 10)
WIDTH = math.radians(14.0)

# Lambertian part and height of the peak, 1/sr, by (from the front, to the front).
PARTS = {(True, True): (0.03, 0.6), (False, False): (0.08, 0.2), (True, False): (0.05, 0.9), (False, True): (0.05, 0.9)}


def vector(theta, phi):
    sine = math.sin(math.radians(theta))
    return sine * math.cos(math.radians(phi)), sine * math.sin(math.radians(phi)), math.cos(math.radians(theta))


def value(wi, wo):
    """f in 1/sr of unit vectors that both point away from the film."""
    lambertian, peak = PARTS[wi[2] > 0, wo[2] > 0]
    # Both mirrored and straight light goes on to (-x, -y).
    cosine = -wi[0] * wo[0] - wi[1] * wo[1] + abs(wi[2] * wo[2])
    angle = math.acos(min(1.0, max(-1.0, cosine)))
    return lambertian + peak * math.exp(-0.5 * (angle / WIDTH) ** 2)


def table():
    """The measurement as `bsdf fit` reads it."""
    lines = ["theta_i,phi_i,theta_o,phi_o,value"]
    for front_in in (True, False):
        for front_out in (True, False):
            for incident in INCIDENT:
                theta_i = incident if front_in else 180 - incident
                for scattered in SCATTERED:
                    theta_o = scattered if front_out else 180 - scattered
                    for phi in AZIMUTHS if scattered else [0]:
                        f = value(vector(theta_i, 0), vector(theta_o, phi))
                        lines.append(f"{theta_i},0,{theta_o},{phi},{f:.6g}")
    return "\n".join(lines) + "\n"
