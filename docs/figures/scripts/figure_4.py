"""The Hilbert curve over the leaves of a tree: how one number walks through them [WKB14, figure 4].

    BSDF=target/release/bsdf python docs/figures/scripts/figure_4.py build/figures       writes docs/figures/hilbert.png

`sample` makes two numbers of one by the Hilbert curve, and the two a direction by the means of the tree's quadrants. So evenly
spaced numbers walk along the curve, drawn together where f is large: left in the square of scattered directions at one
incidence, with the leaves of that slice, right on the disk.
"""

import sys
from pathlib import Path

import matplotlib
import numpy as np

import bsdfkit
import specimen

matplotlib.use("agg")
from matplotlib import collections  # noqa: E402
from matplotlib import pyplot as plt  # noqa: E402

MATERIAL = "fabric"
INCIDENCE = (37.5, 45.0)
LEAVES = 60_000
FINE = 256
#: Of the curve that is drawn.
LEVEL = 5


def to_disk(s, t):
    """The square on the disk, +X at (1, 1/2) and +Y at (1/2, 1) (Shirley and Chiu)."""
    a, b = 2 * np.asarray(s) - 1, 2 * np.asarray(t) - 1
    wide = np.abs(a) > np.abs(b)
    r = np.where(wide, a, b)
    other = np.where(wide, b, a) / np.where(r == 0, 1, r) * np.pi / 4
    phi = np.where(wide, other, np.pi / 2 - other)
    return r * np.cos(phi), r * np.sin(phi)


def to_square(x, y):
    """The inverse."""
    r, phi = np.hypot(x, y), np.arctan2(y, x)
    quarter = np.round(phi / (np.pi / 2))
    along = r * (phi - quarter * np.pi / 2) * 4 / np.pi
    q = quarter.astype(int) % 4
    a = np.select([q == 0, q == 1, q == 2], [r, -along, -r], along)
    b = np.select([q == 0, q == 1, q == 2], [along, r, -along], -r)
    return (a + 1) / 2, (b + 1) / 2


def leaves(bsdf, wi):
    """Squares (s, t, width) in which f is one number: those of a quadtree over FINE² values."""
    at = (np.arange(FINE) + 0.5) / FINE
    s, t = np.meshgrid(at, at)
    x, y = to_disk(s, t)
    wo = np.stack([x, y, np.sqrt(np.maximum(0, 1 - x * x - y * y))], -1)
    values = bsdf.eval(wi, wo)
    found = []

    def divide(i, j, n):
        block = values[i : i + n, j : j + n]
        if n == 1 or np.ptp(block) <= 1e-6 * block.max():
            found.append((j / FINE, i / FINE, n / FINE))
            return
        half = n // 2
        for di in (0, half):
            for dj in (0, half):
                divide(i + di, j + dj, half)

    divide(0, 0, FINE)
    return np.array(found)


def main(folder):
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{MATERIAL}_small.xml"
    if not path.exists():
        specimen.bsdf("convert", specimen.fitted(folder, MATERIAL), "--max-leaves", LEAVES, "-o", path)
    bsdf, wi = bsdfkit.open(path), bsdfkit.direction(*INCIDENCE)
    squares = leaves(bsdf, wi)
    # The middles of the 4^5 pieces of the curve's fifth level.
    u = (np.arange(4**LEVEL) + 0.5) / 4**LEVEL
    drawn = bsdf.sample(wi, u, components=bsdfkit.Components.NON_LAMBERTIAN).wo
    path = np.stack(to_square(drawn[:, 0], drawn[:, 1]), -1)
    step = np.hypot(*np.diff(path, axis=0).T)
    shuffled = np.hypot(*np.diff(np.random.default_rng(1).permutation(path), axis=0).T)
    print(f"{len(squares)} leaves; from one number to the next the median step is {np.median(step):.4f} of the square's side,")
    print(f"of shuffled numbers {np.median(shuffled):.4f}; {np.mean(step > 0.25):.4f} of the steps are longer than a quarter")

    figure, axes = plt.subplots(1, 2, figsize=(10, 5), dpi=120)
    outline = np.array([[(a, b), (a + w, b), (a + w, b + w), (a, b + w)] for a, b, w in squares])
    axes[0].add_collection(collections.PolyCollection(outline, facecolor="none", edgecolor="0.75", lw=0.4))
    pieces = np.stack([path[:-1], path[1:]], 1)
    for axis, ends in ((axes[0], pieces), (axes[1], np.stack([drawn[:-1, :2], drawn[1:, :2]], 1))):
        axis.add_collection(collections.LineCollection(ends, cmap="viridis", array=np.linspace(0, 1, len(ends)), lw=0.8))
    axes[0].set(xlim=(0, 1), ylim=(0, 1), aspect="equal", title=f"{len(squares)} leaves, and the curve of samples on the square")
    edge = np.linspace(0, 1, 5)[:-1]
    round_ = np.concatenate([np.stack(to_disk(*((1 - edge[:, None, None]) * outline[None, :, k] + edge[:, None, None] * outline[None, :, (k + 1) % 4]).transpose(2, 0, 1)), -1) for k in range(4)])
    axes[1].add_collection(collections.PolyCollection(round_.transpose(1, 0, 2), facecolor="none", edgecolor="0.8", lw=0.4))
    axes[1].plot(*wi[:2], "o", c="tab:red")
    axes[1].set(xlim=(-1, 1), ylim=(-1, 1), aspect="equal", title="on the disk; the light comes from the red dot")
    for axis in axes:
        axis.set_xticks([])
        axis.set_yticks([])
        axis.title.set_fontsize(9)
    axes[1].axis("off")
    figure.tight_layout()
    figure.savefig(specimen.FIGURES / "hilbert.png", bbox_inches="tight")


if __name__ == "__main__":
    main(sys.argv[1])
