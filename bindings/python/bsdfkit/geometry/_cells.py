"""Cells of the hemisphere and the blocks that they are gathered in. Needs numpy alone.

Cells are those of the concentric square (Shirley and Chiu 1997): CELLS x CELLS of equal projected solid angle, about two
degrees wide. Where there is little light, 2 x 2 or 4 x 4 of them make one block, so that each holds enough rays.
"""

import numpy as np

CELLS = 96
#: Rays above which a block is divided: each quarter then has about 5 % of noise, all light together 2 to 3 %.
RAYS = 1600


def direction(theta, phi):
    theta, phi = np.radians(theta), np.radians(phi)
    return np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])


def angles(w):
    """(theta, phi) in degrees."""
    theta = np.degrees(np.arctan2(np.hypot(w[..., 0], w[..., 1]), w[..., 2]))
    return theta, np.degrees(np.arctan2(w[..., 1], w[..., 0])) % 360.0


def to_hemisphere(a, b, sign=1.0):
    """Directions of points of the square, 0 to 1 along either side."""
    a, b = 2 * np.asarray(a) - 1, 2 * np.asarray(b) - 1
    wide = np.abs(a) > np.abs(b)
    r = np.where(wide, a, b)
    with np.errstate(divide="ignore", invalid="ignore"):
        phi = np.where(wide, np.pi / 4 * (b / a), np.pi / 2 - np.pi / 4 * (a / b))
    phi = np.where(r == 0, 0.0, phi)
    x, y = r * np.cos(phi), r * np.sin(phi)
    return np.stack([x, y, sign * np.sqrt(np.maximum(0.0, 1 - x * x - y * y))], -1)


def blocks(rays):
    """The number of each cell's block, and each block's (row, column, size) in cells, from rays by cell."""
    rays = np.asarray(rays, float).reshape(CELLS, CELLS)
    gathered = lambda size: rays.reshape(CELLS // size, size, CELLS // size, size).sum((1, 3))
    spread = lambda part, size: np.repeat(np.repeat(part, size, 0), size, 1)
    size = np.full((CELLS, CELLS), 4)
    size[spread(gathered(4) > RAYS, 4)] = 2
    size[(size == 2) & spread(gathered(2) > RAYS, 2)] = 1
    row, column = np.indices((CELLS, CELLS))
    first = row // size * size * CELLS + column // size * size
    corners, number = np.unique(first.ravel(), return_inverse=True)
    return number, np.stack([corners // CELLS, corners % CELLS, size.ravel()[corners]], 1)


def means(number, values):
    """Means of cells' values by block; all cells are of one projected solid angle."""
    return np.bincount(number, values) / np.bincount(number)


def centres(parts, sign):
    """The direction in the middle of each block."""
    middle = (parts[:, :2] + 0.5 * parts[:, 2:]) / CELLS
    return to_hemisphere(middle[:, 0], middle[:, 1], sign)
