"""Makes the pictures of docs/guide/pictures.md: `python docs/figures/pictures.py`, some minutes.

Needs the package with its extra `plot`. Virtual materials, measured coarsely, so that steps and residuals are seen.
"""

import tempfile
from pathlib import Path

import bsdfkit
import bsdfkit.plot

HERE = Path(__file__).resolve().parent
#: Pixels an inch: each file stays below 200 kB.
DPI = 90


def draw(subjects, kind, **options):
    bsdfkit.plot.draw(subjects, kind, output=HERE / f"plot-{kind}.png", dpi=DPI, **options)


def measured_and_fitted(material, folder):
    bsdfkit.simulate(material, folder, sweeps=24, points_per_sweep=120, relative_noise=0.01)
    return bsdfkit.read(folder), bsdfkit.fit(folder)


def main():
    with tempfile.TemporaryDirectory() as temporary:
        points, metal = measured_and_fitted("brushed-metal", Path(temporary) / "metal")
        tree = metal.tabulate(max_leaves=100_000)
        klems = metal.tabulate("klems-full")
        labels = ["measured", "interpolant", "tensor tree", "Klems matrix"]
        draw([points, metal, tree, klems], "hemisphere", incident=(45, 30), labels=labels, pixels=300)
        draw(metal, "slice", incident=[(0, 0), (30, 0), (60, 0)])
        draw([metal, tree], "lobe", incident=(30, 20), labels=labels[1:3])
        draw(klems, "patches", incident=(30, 0))
        draw(tree, "leaves", incident=(30, 0))
        draw([metal, klems, points], "hemispherical", labels=["interpolant", "Klems matrix", "measurement"])
        draw([metal, tree], "compare", incident=(30, 0), labels=labels[1:3])
        draw([metal, points], "points", incident=(30, 0))
        _, film = measured_and_fitted("grating-film", Path(temporary) / "film")
        draw(film, "mesh")


if __name__ == "__main__":
    main()
