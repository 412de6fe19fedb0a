"""A venetian blind straight to a Klems matrix: ours beside Radiance's generate_bsdf, with the noise of both, and times.

    python benches/geometry_klems.py [--rays 4000]       needs bsdfkit[mitsuba], LLVM 19 and pyradiance

Crowned slats, 1.15 periods wide, 35 degrees from the normal, Lambertian of reflectance 0.6. Both send as many rays from each of
145 patches of each side; each is run twice. L1 is that of transmission from outside, mean over incident patches: between two
runs of one program it is √2 times its noise, between the programs it should be no more than the root of the mean square of both.
"""

import argparse
import tempfile
import time
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import bsdfkit
import numpy as np
import pyradiance
from bsdfkit.geometry._klems import OMEGA

REFLECTANCE, WIDTH, LEAN, CROWN = 0.6, 1.15, np.radians(35.0), 0.06
#: Slats on either side of the one in the middle, and their length, for Radiance, which has no end of them otherwise.
NEIGHBOURS, LENGTH = 12, 60.0


def profile(points=17):
    """(x, z) across one slat, the periods along X."""
    s = np.linspace(-WIDTH / 2, WIDTH / 2, points)
    crown = CROWN * (1 - (2 * s / WIDTH) ** 2)
    return s * np.sin(LEAN) - crown * np.cos(LEAN), s * np.cos(LEAN) + crown * np.sin(LEAN)


def obj():
    x, z = profile()
    lines = [f"v {a} {y} {c}" for a, c in zip(x, z) for y in (0, 1)]
    lines += [f"f {2 * k + 1} {2 * k + 3} {2 * k + 4} {2 * k + 2}" for k in range(len(x) - 1)]
    return "\n".join(lines) + "\n"


def radiance():
    """The blind behind the plane z = 0, and the box of one period in its middle."""
    x, z = profile()
    text, top = [f"void plastic paint\n0\n0\n5 {REFLECTANCE} {REFLECTANCE} {REFLECTANCE} 0 0\n"], z.max()
    for slat in range(-NEIGHBOURS, NEIGHBOURS + 1):
        for k in range(len(x) - 1):
            (a, c), (b, d) = ((x[n] + slat, z[n] - top) for n in (k, k + 1))
            l = LENGTH / 2
            text.append(f"paint polygon s{slat + NEIGHBOURS}_{k}\n0\n0\n12 {a} {-l} {c} {b} {-l} {d} {b} {l} {d} {a} {l} {c}\n")
    box = pyradiance.genbsdf.SamplingBox(-0.5, 0.5, -0.5, 0.5, z.min() - top, 0.0)
    return "".join(text).encode(), box


def ours(folder, rays, seed):
    path = bsdfkit.geometry_klems(folder / "slats.obj", REFLECTANCE, folder / "slats.xml", period=(1, 1), rays=rays, seed=seed)
    root = ElementTree.parse(path).getroot()
    space = "{http://windows.lbl.gov}"
    for block in root.iter(f"{space}WavelengthDataBlock"):
        if block.find(f"{space}WavelengthDataDirection").text == "Transmission Front":
            values = np.array(block.find(f"{space}ScatteringData").text.replace(",", " ").split(), float)
            return values.reshape(145, 145) * OMEGA[:, None]


def theirs(rays):
    scene, box = radiance()
    # One path a ray, as ours.
    options = ["-ab", "8", "-ad", "1", "-as", "0", "-lw", "1e-6"]
    result = pyradiance.generate_bsdf(scene, dim=box, nsamp=rays, params=options, nproc=1)
    rows = [line.split() for line in result.front.transmittance.decode().splitlines() if line.strip()]
    return np.array([row for row in rows if len(row) == 145], float)


def l1(a, b):
    return (np.abs(a - b).sum(0) / (0.5 * (a + b)).sum(0)).mean()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rays", type=int, default=4000)
    rays = parser.parse_args().rays
    runs, seconds = {"ours": [], "generate_bsdf": []}, {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "slats.obj").write_text(obj())
        ours(folder, 1, 0)  # compiles
        for who, make in (("ours", lambda k: ours(folder, rays, k)), ("generate_bsdf", lambda k: theirs(rays))):
            start = time.monotonic()
            runs[who] = [make(k) for k in (1, 2)]
            seconds[who] = (time.monotonic() - start) / 2
    for who, (a, b) in runs.items():
        print(f"{who:14} {seconds[who]:7.1f} s a run, transmittance at normal incidence {a[:, 0].sum():.4f}, L1 of two runs {l1(a, b):.4f}")
    pairs = [(a, b) for a in runs["ours"] for b in runs["generate_bsdf"]]
    between = np.mean([l1(a, b) for a, b in pairs])
    expected = np.sqrt(np.mean([l1(*pair) ** 2 for pair in runs.values()]))
    print(f"between them   L1 {between:.4f}; noise alone would be {expected:.4f}")
    totals = [np.mean(pair, 0).sum(0) for pair in runs.values()]
    print(f"totals of patches differ by {np.abs(totals[0] / totals[1] - 1).mean():.4f} in the mean, at most {np.abs(totals[0] - totals[1]).max():.4f}")


if __name__ == "__main__":
    main()
