"""What a fit costs: processor seconds and memory against incidences, points, lobes and leaves over a decade each.

    python benches/cost_model.py --bsdf target/release/bsdf [--quick] [-o docs/figures/cost-model.png]

One specimen, anisotropic and glossy, measured at ever more incidences, with ever more points, with ever more and narrower peaks, and cut
into ever more leaves; all else stays at its middle value. Prints a table in Markdown, the exponents of power laws through the upper halves
of the curves, and what they make of 10,000 materials of a laboratory on 100 workers. Times are user and system seconds of one thread, so
that other work on the machine changes little of them.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

# Where the curves cross.
INCIDENCES, POINTS, PEAKS, LEAVES = 24, 2000, 2, 20_000
MOST_POINTS = 50_000
GOLDEN = 137.507764

# A material of a laboratory: both sides reflected and transmitted, 100 incidences each, 50,000 points, a tree of each.
LABORATORY = {"components": 4, "incidences": 100, "points": 50_000, "leaves": 300_000}
MATERIALS, WORKERS = 10_000, 100


def direction(theta, phi):
    theta, phi = np.radians(theta), np.radians(phi)
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1)


def spiral(count, limit):
    """Directions evenly by projected solid angle: θ and φ in degrees."""
    k = np.arange(count) + 0.5
    return np.degrees(np.arcsin(np.sqrt(k / count) * np.sin(np.radians(limit)))), GOLDEN * k % 360


def measure(path, incidences, points, peaks):
    """A table of f: a floor and `peaks` peaks about the specular direction, each off it and narrower than the one before."""
    theta, phi = spiral(points, 85)
    wo = direction(theta, phi)
    with open(path, "w") as out:
        out.write("theta_i,phi_i,theta_o,phi_o,value\n")
        for theta_i, phi_i in zip(*spiral(incidences, 70), strict=True):
            specular = direction(theta_i, phi_i + 180)[:2]
            f = np.full(points, 0.03)
            for k in range(peaks):
                width = 0.35 * 0.8**k
                off = 0.25 * k / peaks * np.array([np.cos(2.4 * k), np.sin(2.4 * k)])
                apart = wo[:, :2] - specular - off
                apart[:, 1] *= 1.5
                f += 0.2 / peaks / width**2 * np.exp(-(apart**2).sum(-1) / width**2)
            rows = np.stack([np.full(points, theta_i), np.full(points, phi_i), theta, phi, f], -1)
            np.savetxt(out, rows, fmt="%.4f,%.4f,%.4f,%.4f,%.6e")


def spent(line):
    """Processor seconds, largest memory in MB and standard output of a process."""
    process = subprocess.Popen([str(word) for word in line], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    said = process.stdout.read()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        sys.exit(f"{line}: status {process.returncode}")
    unit = 1 if sys.platform == "darwin" else 1024
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss * unit / 1e6, said


def curves(bsdf, folder, quick):
    """Of each quantity: (value, lobes, seconds, MB) along it."""
    def fit(incidences=INCIDENCES, points=POINTS, peaks=PEAKS):
        measured, fitted = folder / "m.csv", folder / "m.safetensors"
        measure(measured, incidences, points, peaks)
        line = [bsdf, "fit", measured, "--symmetry", "none", "--threads", 1, "--json", "-o", fitted]
        seconds, megabytes, said = spent(line)
        return json.loads(said)["components"][0]["lobes"], seconds, megabytes

    def leaves(count):
        line = [bsdf, "convert", folder / "m.safetensors", "-o", folder / "m.xml", "--max-leaves", count]
        return 0, *spent(line)[:2]

    steps = np.array([0.33, 1.0, 3.3]) if quick else np.array([0.316, 0.562, 1.0, 1.78, 3.16])
    along = {
        "incidences": [(n, *fit(incidences=n)) for n in np.rint(INCIDENCES * steps).astype(int)],
        "points an incidence": [(n, *fit(points=n)) for n in np.rint(MOST_POINTS * steps / steps[-1]).astype(int)],
        "lobes": [(n, *fit(peaks=n)) for n in ((1, 3, 10) if quick else (1, 2, 3, 6, 10))],
    }
    # By the lobes that came of it.
    along["lobes"] = sorted((lobes, *rest[1:]) for _, *rest in along["lobes"] for lobes in [rest[0]])
    along["lobes"] = [(n, n, s, m) for n, s, m in along["lobes"]]
    fit()
    along["leaves"] = [(n, *leaves(n)) for n in np.rint(LEAVES * steps).astype(int)]
    return along


def law(points, column):
    """The exponent through the last half of a curve."""
    x = np.log([p[0] for p in points][-3:])
    y = np.log([p[column] for p in points][-3:])
    return float(np.polyfit(x, y, 1)[0]) if np.ptp(x) > 0 else 0.0


def extrapolated(along):
    """Seconds and MB of a laboratory's material: its points were measured, its incidences and leaves follow their laws."""
    points, tree = along["points an incidence"][-1], along["leaves"][-1]
    components, incidences = LABORATORY["components"], LABORATORY["incidences"] / INCIDENCES
    leaves = LABORATORY["leaves"] / tree[0]

    def grown(column):
        fit = points[column] * incidences ** max(law(along["incidences"], column), 0)
        return fit, tree[column] * leaves ** max(law(along["leaves"], column), 0)

    return components * sum(grown(2)), max(components * grown(3)[0], grown(3)[1])


def draw(along, path):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from matplotlib.ticker import NullFormatter

    figure, axes = plt.subplots(2, len(along), figsize=(11, 5), sharey="row", layout="constrained")
    for column, (name, points) in enumerate(along.items()):
        x = [p[0] for p in points]
        for row, (what, label) in enumerate([(2, "CPU seconds"), (3, "memory, MB")]):
            a = axes[row, column]
            a.loglog(x, [p[what] for p in points], "o-", color="#1f6fb4", markersize=4)
            for axis in (a.xaxis, a.yaxis):
                axis.set_minor_formatter(NullFormatter())
            a.grid(True, which="both", alpha=0.25, linewidth=0.5)
            power = round(law(points, what), 1) + 0.0
            a.text(0.95, 0.06, f"$\\propto x^{{{power}}}$", transform=a.transAxes, ha="right")
            if row:
                a.set_xlabel(name)
            if column == 0:
                a.set_ylabel(label)
    figure.savefig(path, dpi=110)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bsdf", required=True)
    parser.add_argument("--quick", action="store_true", help="three points a curve")
    parser.add_argument("-o", "--output", help="picture to draw")
    wanted = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        along = curves(Path(wanted.bsdf).absolute(), Path(folder), wanted.quick)
    print("| along | from | to | CPU s | MB | CPU grows as | memory as |\n|---|---:|---:|---:|---:|---:|---:|")
    for name, points in along.items():
        first, last = points[0], points[-1]
        print(f"| {name} | {first[0]} | {last[0]} | {first[2]:.2f} to {last[2]:.2f} | {first[3]:.0f} to {last[3]:.0f} "
              f"| x^{law(points, 2):.2f} | x^{law(points, 3):.2f} |")
    seconds, megabytes = extrapolated(along)
    hours = seconds * MATERIALS / WORKERS / 3600
    print(f"\nA material of {LABORATORY}: {seconds:.0f} CPU s, {megabytes / 1000:.1f} GB; "
          f"{MATERIALS} of them on {WORKERS} workers of one thread: {hours:.0f} hours")
    if wanted.output:
        draw(along, wanted.output)


main()
