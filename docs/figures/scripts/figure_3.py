"""Between measured incidences: linear, Radiance's interpolant, ours, and the truth [WKB14, figure 3].

    BSDF=target/release/bsdf python docs/figures/scripts/figure_3.py build/figures       writes docs/figures/between.png

Rows: f on a scale of one and a half decades, and what is too much (red) or too little (blue) against the truth. L1 is the integral of
|f - truth| |cos θo| over that of the truth. Linear is the barycentric blend of the three nearest measured incidences,
each with its values by our fit, which is within 0.1 % there.
"""

import sys
from pathlib import Path

import matplotlib
import numpy as np

import specimen

matplotlib.use("agg")
from matplotlib import colors  # noqa: E402
from matplotlib import pyplot as plt  # noqa: E402

MATERIAL = "fabric"
#: In the middle of the triangle of these measured incidences.
CORNERS = [(30.0, 30.0), (45.0, 30.0), (45.0, 60.0)]
PIXELS = 160


def main(folder):
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    corners = np.array([specimen.direction(*corner) for corner in CORNERS])
    middle = corners.mean(0) / np.linalg.norm(corners.mean(0))
    theta, phi = np.degrees(np.arccos(middle[2])), np.degrees(np.arctan2(middle[1], middle[0]))
    wo, inside = specimen.disk(PIXELS)
    ours, theirs = specimen.fitted(folder, MATERIAL), specimen.by_radiance(folder, MATERIAL)
    at = lambda source, incidence: specimen.values(source, *incidence, wo[inside])
    truth = at(["--material", MATERIAL], (theta, phi))
    shown = {
        "linear": np.mean([at([ours], corner) for corner in CORNERS], axis=0),
        "Radiance's interpolant": at([theirs], (theta, phi)),
        "ours": at([ours], (theta, phi)),
        "truth": truth,
    }
    figure, axes = plt.subplots(2, 4, figsize=(11, 5.8), dpi=110)
    most = truth.max()
    for column, (name, values) in enumerate(shown.items()):
        l1 = np.abs(values - truth).sum() / truth.sum()
        picture, off = (np.full((PIXELS, PIXELS), np.nan) for _ in range(2))
        picture[inside], off[inside] = values, (values - truth) / most
        axes[0, column].imshow(picture, norm=colors.LogNorm(most / 30, most, clip=True), cmap="magma")
        axes[0, column].set_title(name if name == "truth" else f"{name}: L1 {l1:.3f}", fontsize=10)
        if name != "truth":
            axes[1, column].imshow(off, vmin=-0.5, vmax=0.5, cmap="RdBu_r")
            print(f"{name:24} L1 {l1:.4f}, peak {values.max() / most:.3f} of the truth's, energy {values.sum() / truth.sum():.4f}")
    axes[1, 3].text(0.5, 0.5, f"{MATERIAL} at ({theta:.1f}°, {phi:.1f}°),\nbetween three measured incidences.\n\n"
                    "Below: difference from the truth,\n± half of its peak.", ha="center", va="center", fontsize=9)
    for axis in axes.ravel():
        axis.axis("off")
    figure.tight_layout()
    figure.savefig(specimen.FIGURES / "between.png", bbox_inches="tight")


if __name__ == "__main__":
    main(sys.argv[1])
