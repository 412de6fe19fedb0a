"""A room with a window of prismatic film, a sphere of brushed metal and a drape of fabric, for Mitsuba and for Radiance.

Axes of the room: x into it from the window, z up; metres. Files of materials are the same for both programs; up is +Z for
all of them, so that a sphere's x runs round its axis and a drape's along its folds' way.
"""

import numpy as np

WIDTH, DEPTH, HEIGHT = 3.0, 3.0, 2.4
#: The film's pane is in the wall x = 0.
PANE = dict(y=(0.7, 2.3), z=(0.7, 2.0))
SPHERE = dict(centre=(1.5, 1.3, 0.45), radius=0.45)
WALLS, FLOOR = 0.5, 0.25
#: A wide sun, as through haze, so that path tracing finds what the film sends into a narrow beam: unit vector towards it, diameter
#: in degrees, radiance; and an even sky.
SUN, SUN_DEGREES, SUN_RADIANCE, SKY_RADIANCE = np.array([-0.75, -0.2, 0.63]), 16.0, 20.0, 3.0
SUN = SUN / np.linalg.norm(SUN)
#: From a corner by the far wall; degrees.
EYE, LOOK_AT, FIELD = (2.75, 0.25, 1.5), (0.95, 2.1, 0.95), 80.0


def drape(columns=96):
    """The folds' outline from above, in front of the wall y = DEPTH: points (x, y), and the length along it.

    With up +Z and the normal to the room, the material's x runs along it.
    """
    x = np.linspace(1.4, 2.8, columns + 1)
    y = DEPTH - 0.18 + 0.08 * np.sin(2 * np.pi * (x - 1.4) / 0.28)
    along = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))])
    return x, y, along


DRAPE_HEIGHT = (0.1, 2.1)


def quads():
    """Walls, floor and ceiling with their normals into the room; the window's wall has a hole."""
    w, d, h = WIDTH, DEPTH, HEIGHT
    (y0, y1), (z0, z1) = PANE["y"], PANE["z"]
    window = [[(0, a, c), (0, b, c), (0, b, e), (0, a, e)] for a, b, c, e in (
        (0, d, 0, z0), (0, d, z1, h), (0, y0, z0, z1), (y1, d, z0, z1))]
    return {
        "floor": ([[(0, 0, 0), (w, 0, 0), (w, d, 0), (0, d, 0)]], FLOOR),
        "ceiling": ([[(0, 0, h), (0, d, h), (w, d, h), (w, 0, h)]], WALLS),
        "back": ([[(0, d, 0), (w, d, 0), (w, d, h), (0, d, h)]], WALLS),
        "front": ([[(0, 0, 0), (0, 0, h), (w, 0, h), (w, 0, 0)]], WALLS),
        "far": ([[(w, 0, 0), (w, 0, h), (w, d, h), (w, d, 0)]], WALLS),
        "window_wall": (window, WALLS),
    }


def pane():
    """Corners of the pane, its normal into the room."""
    (y0, y1), (z0, z1) = PANE["y"], PANE["z"]
    return [(0, y0, z0), (0, y1, z0), (0, y1, z1), (0, y0, z1)]
