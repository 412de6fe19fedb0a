"""Where light is measured: scattered directions of one incidence, incident directions, and their mesh [WKB14, figure 2].

    BSDF=target/release/bsdf python docs/figures/scripts/figure_2.py build/figures       writes docs/figures/incidences.png
"""

import sys
from pathlib import Path

import matplotlib
import matplotlib.tri
import numpy as np

import specimen

matplotlib.use("agg")
from matplotlib import pyplot as plt  # noqa: E402

MATERIAL = "fabric"


def main(folder):
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    files = [specimen.points(p) for p in sorted(specimen.measured(folder, MATERIAL).glob("*.txt"))]
    incidences = np.array([specimen.direction(*at) for at, _ in files])
    shown, rows = next((at, rows) for at, rows in files if at == (45.0, 60.0))
    # The specimen is its own mirror image in the plane y = 0.
    images = incidences * [1, -1, 1]
    both = np.unique(np.round(np.concatenate([incidences, images]), 9), axis=0)
    # In stereographic projection circles stay circles: the plane's Delaunay triangles are the sphere's.
    flat = both[:, :2] / (1 + both[:, 2:])
    triangles = matplotlib.tri.Triangulation(*flat.T).triangles

    figure, axes = plt.subplots(1, 3, figsize=(10, 3.5), dpi=120)
    scattered = specimen.direction(rows[:, 0], rows[:, 1])
    axes[0].scatter(scattered[:, 0], scattered[:, 1], s=0.15, c="k", linewidths=0)
    axes[0].plot(*specimen.direction(*shown)[:2], "o", c="tab:red", ms=5)
    axes[0].set_title(f"{len(rows)} scattered directions\nof the incidence (45°, 60°)", fontsize=9)
    for axis in axes[1:]:
        axis.plot(images[:, 0], images[:, 1], "o", c="0.65", ms=4)
        axis.plot(incidences[:, 0], incidences[:, 1], "o", c="k", ms=4)
    axes[1].set_title(f"{len(incidences)} incident directions,\nand their mirror images", fontsize=9)
    axes[2].triplot(both[:, 0], both[:, 1], triangles, lw=0.7, c="tab:blue", zorder=0)
    axes[2].set_title(f"their mesh on the sphere:\n{len(triangles)} triangles", fontsize=9)
    for axis in axes:
        axis.add_patch(plt.Circle((0, 0), 1, fill=False, lw=0.8))
        axis.set(aspect="equal", xlim=(-1.03, 1.03), ylim=(-1.03, 1.03))
        axis.axis("off")
    figure.tight_layout()
    figure.savefig(specimen.FIGURES / "incidences.png", bbox_inches="tight")


if __name__ == "__main__":
    main(sys.argv[1])
