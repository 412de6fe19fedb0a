"""One film through four programs: who says how much light passes, and how far that is from the truth.

    pip install -r requirements.txt, and bsdfkit[mitsuba] with LLVM 19
    BSDF=target/release/bsdf python benches/programs/four_programs.py build/film

The film (turning_film.py) has two sides and turns light upward. It is measured, fitted and written as a tensor tree and as a
Klems matrix; Radiance, Mitsuba, EnergyPlus and WINDOW's engine are asked for the visible transmittance of sunlight from the
20 places where EnergyPlus's sun stands, of an even sky, and of an even hemisphere. The last lines are largest differences.
"""

import argparse
import json
import subprocess
import sys
import time
from pathlib import Path

import bsdfkit
import by_mitsuba
import by_radiance
import energyplus
import numpy as np
import turning_film as film
from klems import Klems
from places import bsdf, from_sun, travel

SUNS = 20
#: Values of the tree of each pair of sides.
LEAVES = 800_000


def files(folder):
    """Measures, fits, writes what is not there yet."""
    folder.mkdir(parents=True, exist_ok=True)
    table, fitted = folder / "film.csv", folder / "film.safetensors"
    tree, klems, objects = folder / "film_tree.xml", folder / "film_window.xml", folder / "film.epJSON"
    if not fitted.exists():
        table.write_text(film.table())
        bsdf("fit", table, "-o", fitted)
    if not klems.exists():
        bsdf("convert", fitted, "--for", "window", "-o", klems)
    if not objects.exists():
        bsdf("export", "energyplus", klems, "-o", objects)
    if not tree.exists():
        bsdf("convert", fitted, "--max-leaves", LEAVES, "-o", tree)
    return fitted, tree, klems, objects


def suns_of_energyplus(folder, objects):
    """Incident directions of SUNS suns, evenly picked by their angle of incidence (to 85 degrees, as the film is measured),
    and the beam's transmittances."""
    run = folder / "energyplus"
    if run.exists():
        subprocess.run(["rm", "-r", run], check=True)
    rows = np.array(energyplus.run(json.loads(objects.read_text()), "film", run))
    wi = from_sun(rows[:, 0], rows[:, 1])
    order = np.argsort(wi[:, 2])
    order = order[-wi[order, 2] > np.cos(np.radians(85.0))]
    picked = order[np.linspace(0, len(order) - 1, SUNS).round().astype(int)]
    return wi[picked], rows[picked, 2]


def kept(folder, name, ask):
    """What a program answered, asked once: a run that was broken off goes on where it was."""
    path = folder / f"answer_{name}.npz"
    if not path.exists():
        start = time.monotonic()
        answer = ask()
        np.savez(path, *(answer if isinstance(answer, tuple) else (answer,)))
        print(f"{name}: {time.monotonic() - start:.0f} s", file=sys.stderr, flush=True)
    with np.load(path) as found:
        arrays = [found[key] for key in sorted(found.files)]
    return arrays[0] if len(arrays) == 1 else arrays


def even(values, wi):
    """Means over a sky (incident directions from above) and over the hemisphere, of equal projected solid angles."""
    return np.array([values[wi[:, 1] > 0].mean(), values.mean()])


def by_ours(path, suns, n):
    """Of a file, and of n² incidences for sky and hemisphere."""
    opened, grid = bsdfkit.open(path), film.hemisphere(n, False)
    total = lambda wi: opened.directional_hemispherical(wi, components=bsdfkit.Components.TRANSMISSION)
    return np.concatenate([total(suns), even(total(grid), grid)])


def by_window(path, suns):
    """WINDOW has no sky."""
    theta, phi = travel(suns)
    rows = "".join(f"{t} {p}\n" for t, p in zip(theta, phi))
    script = Path(by_mitsuba.__file__).with_name("by_window.py")
    done = subprocess.run([sys.executable, script, path], input=rows, capture_output=True, text=True, timeout=3600)
    if done.returncode:
        sys.exit(done.stderr)
    found = list(map(float, done.stdout.split()))
    return np.array([*found[:-1], np.nan, found[-1]])


def bin_means(klems):
    """The truth's means over incident bins: what a Klems matrix can say at best."""
    return np.array([film.transmittance(-in_bin(klems, k, 8), 80).mean() for k in range(klems.directions)])


def in_bin(klems, number, n):
    """Directions of travel in a bin, n² of equal projected solid angle."""
    first = 0
    for (lower, upper), (_, count) in zip(klems.bounds, klems.rings):
        if number < first + count:
            break
        first += count
    u, v = (g.ravel() for g in np.meshgrid((np.arange(n) + 0.5) / n, (np.arange(n) + 0.5) / n))
    low, high = np.sin(np.radians([lower, upper])) ** 2
    sine, phi = np.sqrt(low + (high - low) * u), 2 * np.pi * (number - first + v - 0.5) / count
    return np.stack([sine * np.cos(phi), sine * np.sin(phi), np.sqrt(1 - sine**2)], -1)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    folder = parser.parse_args().folder
    fitted, tree, klems, objects = files(folder)
    ask = lambda name, action: kept(folder, name, action)
    suns, beam = ask("energyplus", lambda: suns_of_energyplus(folder, objects))
    grid = film.hemisphere(40, False)
    truth = np.concatenate([film.transmittance(suns), even(film.transmittance(grid, 150), grid)])
    columns = {
        "interpolant": ask("interpolant", lambda: by_ours(fitted, suns, 40)),
        "our tree": ask("tree", lambda: by_ours(tree, suns, 300)),
        "our Klems": ask("klems", lambda: by_ours(klems, suns, 300)),
        "EnergyPlus": np.array([*beam, np.nan, np.nan]),
        "Mitsuba": ask("mitsuba", lambda: by_mitsuba.transmittances(tree, suns)),
    }
    for kind in ("BSDF", "aBSDF"):
        traced = by_radiance.Traced(folder, tree, kind)
        lit = ask(f"{kind}_suns", lambda: traced.suns(suns))
        columns[f"Radiance {kind}"] = np.concatenate([lit, ask(f"{kind}_skies", traced.skies)])
    columns["3-phase"], lit = ask("three_phase", lambda: by_radiance.three_phase(folder, klems, suns))
    columns["WINDOW"] = ask("window", lambda: by_window(klems, suns))
    theta, phi = travel(suns)
    bins, means = Klems(klems), bin_means(Klems(klems))
    omega = np.array(bins.solid_angles())
    of_bins = np.array([*means[[bins.bin(t, p)[0] for t, p in zip(theta, phi)]], np.nan, means @ omega / np.pi])
    best = {"our Klems": of_bins, "3-phase": lit @ means, "EnergyPlus": of_bins, "WINDOW": of_bins}
    print(f"{'theta':>6} {'phi':>6} {'truth':>8} " + " ".join(f"{name:>14}" for name in columns) + f" {'truth of bin':>14}")
    names = [f"{t:6.1f} {(p + 180) % 360:6.1f}" for t, p in zip(theta, phi)] + [f"{'sky':>13}", f"{'hemisphere':>13}"]
    for k, name in enumerate(names):
        print(f"{name} {truth[k]:8.4f} " + " ".join(f"{c[k]:14.4f}" for c in columns.values()) + f" {of_bins[k]:14.4f}")
    print("\nlargest difference from the truth, %; of programs that take the matrix also from its bins' own truth")
    for name, column in columns.items():
        off = 100 * (column / truth - 1)
        line = f"{name:15} suns {np.abs(off[:SUNS]).max():6.2f} sky {off[-2]:6.2f} hemisphere {off[-1]:6.2f}"
        if name in best:
            line += f"   suns from the truth of their bins {np.abs(100 * (column / best[name] - 1)[:SUNS]).max():6.2f}"
        print(line)


if __name__ == "__main__":
    main()
