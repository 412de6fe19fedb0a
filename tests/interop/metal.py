"""Brushed metal in closed form, turned about its normal, and its measurement as a table. [War92], [GMD10]"""

import math

TURN = math.radians(30.0)
ROUGHNESS = (0.22, 0.45)
SPECULAR, DIFFUSE = 0.6, 0.1


def vector(theta, phi):
    sine = math.sin(math.radians(theta))
    return sine * math.cos(math.radians(phi)), sine * math.sin(math.radians(phi)), math.cos(math.radians(theta))


def value(wi, wo, roughness=ROUGHNESS):
    """f in 1/sr of unit vectors that both point away from the metal."""
    h = [a + b for a, b in zip(wi, wo)]
    cos, sin = math.cos(TURN), math.sin(TURN)
    x, y = cos * h[0] + sin * h[1], cos * h[1] - sin * h[0]
    slope2 = ((x / roughness[0]) ** 2 + (y / roughness[1]) ** 2) / h[2] ** 2
    scale = SPECULAR / (math.pi * roughness[0] * roughness[1])
    return scale * sum(c * c for c in h) / h[2] ** 4 * math.exp(-slope2) + DIFFUSE / math.pi


def table(roughness=ROUGHNESS, azimuths=range(0, 360, 60)):
    """The measurement as `bsdf fit` reads it."""
    lines = ["theta_i,phi_i,theta_o,phi_o,value"]
    for theta_i in (0, 25, 50, 70):
        for phi_i in azimuths if theta_i else [0]:
            wi = vector(theta_i, phi_i)
            for theta_o in range(0, 86, 5):
                for phi_o in range(0, 360, 10) if theta_o else [0]:
                    f = value(wi, vector(theta_o, phi_o), roughness)
                    lines.append(f"{theta_i},{phi_i},{theta_o},{phi_o},{f:.6g}")
    return "\n".join(lines) + "\n"
