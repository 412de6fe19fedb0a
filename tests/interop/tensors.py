"""RGL's tables evaluated slowly, in double precision, from the arrays as `mi.tensor_io` reads them. [DJ18]"""

import numpy as np

# Linear RGB of sRGB's primaries to XYZ in which white has X = Y = Z.
RGB_TO_XYZ = np.array([[0.412453, 0.35758, 0.180423], [0.212671, 0.71516, 0.072169], [0.019334, 0.119193, 0.950227]])
WHITE = np.array([0.950456, 1.0, 1.088754])


def cell(x, nodes):
    x = min(max(x, 0.0), 1.0) * (nodes - 1)
    k = min(int(x), nodes - 2)
    return k, x - k


def bilinear(table, point):
    (i, x), (j, y) = cell(point[0], table.shape[-1]), cell(point[1], table.shape[-2])
    low = (1 - x) * table[..., j, i] + x * table[..., j, i + 1]
    high = (1 - x) * table[..., j + 1, i] + x * table[..., j + 1, i + 1]
    return (1 - y) * low + y * high


def invert(density, point):
    """Shares of the density below `point`: along the row through it, and of all rows."""
    def integral(values, x):
        k, t = cell(x, len(values))
        means = 0.5 * (values[1:] + values[:-1])
        part = t * (values[k] + 0.5 * t * (values[k + 1] - values[k]))
        return means[:k].sum() + part, means.sum()

    j, y = cell(point[1], density.shape[0])
    row = (1 - y) * density[j] + y * density[j + 1]
    below, all_ = integral(row, point[0])
    rows = (0.5 * (density[:, 1:] + density[:, :-1])).sum(axis=1)
    below_y, all_y = integral(rows, point[1])
    return below / all_, below_y / all_y


class Tables:
    """One file; `xyz(wi, wo)` is f in 1/sr."""

    def __init__(self, arrays):
        get = {name: np.array(a, dtype=np.float64) for name, a in arrays.items() if name != "description"}
        self.theta, self.phi = get["theta_i"], get["phi_i"]
        self.ndf, self.sigma, self.rgb = get["ndf"], get["sigma"], get["rgb"]
        means = get["vndf"]
        means = 0.25 * (means[..., 1:, 1:] + means[..., 1:, :-1] + means[..., :-1, 1:] + means[..., :-1, :-1])
        self.vndf = get["vndf"] / means.mean(axis=(-1, -2), keepdims=True)

    @staticmethod
    def weights(nodes, x):
        after = int(np.searchsorted(nodes, x, side="right"))
        if after in (0, len(nodes)):
            return [(max(after - 1, 0), 1.0)]
        t = (x - nodes[after - 1]) / (nodes[after] - nodes[after - 1])
        return [(after - 1, 1 - t), (after, t)]

    def xyz(self, wi, wo):
        theta_i, phi_i = np.arctan2(np.hypot(wi[0], wi[1]), wi[2]), np.arctan2(wi[1], wi[0])
        m = (wi + wo) / np.linalg.norm(wi + wo)
        origin = phi_i if len(self.phi) == 1 else 0.0
        y = (np.arctan2(m[1], m[0]) - origin + np.pi) / (2 * np.pi)
        point = np.sqrt(2 * np.arctan2(np.hypot(m[0], m[1]), m[2]) / np.pi), y - np.floor(y)
        slices = [(a * b, p, t) for p, a in self.weights(self.phi, phi_i) for t, b in self.weights(self.theta, theta_i)]
        density = sum(w * self.vndf[p, t] for w, p, t in slices)
        values = sum(w * bilinear(self.rgb[p, t], invert(density, point)) for w, p, t in slices)
        at_wi = np.sqrt(2 * theta_i / np.pi), (phi_i + np.pi) / (2 * np.pi)
        factor = bilinear(self.ndf, point) / (4 * bilinear(self.sigma, at_wi))
        return RGB_TO_XYZ @ values * factor / wo[2] / WHITE
