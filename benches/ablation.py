"""What a build of `bsdf` makes of everything it was and was not chosen by: one table, any number of builds in turn.

    python benches/ablation.py                                          the six, the looked-at half, what else is found
    python benches/ablation.py --against main=OTHER/bsdf                another build on the same measurements
    python benches/ablation.py --traced DIR --real DIR                  ray-traced specimens, real measurements
    python benches/ablation.py --final                                  the held-back half alone, when all is chosen

Virtual materials are measured by `bsdf simulate` of the first build and judged by `bsdf eval --material`, their closed form.
Ray-traced specimens come from benches/raytraced/trace.py; real ones (BSDFKIT_DATA) are left out one incidence at a time.

L1 is the sum of |predicted - true| over that of true, over directions of equal projected solid angle (real: means of the points
in 64 x 64 cells). measured: incidences that were fitted; held-out: half-way between them in both angles; grazing: at 80 and
85 degrees. noise: L1 of one of two traces from their mean, which is the truth. hemispherical: root mean square relative error of the
directional-hemispherical value, held-out. CPU and memory are the operating system's accounting of the one process `bsdf fit`,
or the sum and the largest where there are several. benches/held_back.md says what is not to be looked at.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent / "raytraced"))

from cells import CELLS, angles, blocks, direction, means, to_hemisphere  # noqa: E402

SIX = ["brushed-metal", "rotated-metal", "fabric", "prism-film", "fritted-glass", "rough-dielectric"]
VIRTUAL = [
    "clear-coat", "crossed-threads", "grating-film", "haze-and-beam", "louver", "narrow-metal", "perforated-screen",
    "retro-sheet", "splitting-peak", "square-diffuser", "three-facet-film", "velvet",
]  # fmt: skip
TRACED = ["bumps-of-two-lengths", "perforated-screen", "prismatic-film", "saw-tooth-metal", "slats", "woven-threads"]
REAL = [("EDS10", "eds10_mountain", "eds10_*"), ("garnet", "cornell_mountain", "garnet_*")]
REAL += [("steel", "rt300s_mountain", "NiTEsteel_*"), ("sensor", "rt300s_mountain", "IMX455_*")]
#: Directions at which the closed form is compared, along either side of the square.
GRID = 144


def looked_at(names, final):
    """The half of the names that may be printed: every second is held back, see held_back.md."""
    return sorted(names)[1::2] if final else sorted(names)[0::2]


#: Runs a command and prints its processor seconds and peak MB. A process begins with the peak of the one that started it,
#: and this one with its arrays has more than some fits: hence a small one between.
MEASURE = """
import os, resource, sys
resource.setrlimit(resource.RLIMIT_CPU, (7200, 7200))
silent = [(os.POSIX_SPAWN_OPEN, 1, os.devnull, os.O_WRONLY, 0)]
child = os.posix_spawn(sys.argv[1], sys.argv[1:], os.environ, file_actions=silent)
_, status, usage = os.wait4(child, 0)
print(usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024)
sys.exit(abs(os.waitstatus_to_exitcode(status)))
"""


class Build:
    """A command `bsdf` and what it costs."""

    def __init__(self, label, path):
        self.label, self.path = label, Path(path).resolve()

    def run(self, *words):
        """Processor seconds and peak MB of a command that must succeed."""
        command = [sys.executable, "-c", MEASURE, self.path, *map(str, words)]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            text = done.stderr[-500:]
            raise RuntimeError(f"{self.label}: bsdf {' '.join(map(str, words))}: status {done.returncode}: {text}")
        cpu, mb = map(float, done.stdout.split())
        return cpu, mb

    def eval(self, wi, wo, *what):
        """f at pairs of directions."""
        columns = np.column_stack([*angles(wi), *angles(wo)])
        text = "\n".join("%.6f %.6f %.6f %.6f" % tuple(row) for row in columns)
        done = subprocess.run([self.path, "eval", *map(str, what)], input=text, capture_output=True, text=True)
        values = np.array(done.stdout.split(), float)
        if done.returncode or len(values) != len(columns):
            raise RuntimeError(f"{self.label}: bsdf eval: {len(values)} of {len(columns)} values: {done.stderr[-500:]}")
        return values

    def fit(self, paths, folder, tree):
        """The interpolant of measurements: its file, and {cpu, mb}; with those of fit and tree together."""
        out = folder / "fit.safetensors"
        cpu, mb = self.run("fit", *paths, "-o", out)
        cost = {"cpu": cpu, "mb": mb}
        if tree:
            cost["tree_cpu"], cost["tree_mb"] = self.run("fit", *paths, "-o", out, "-o", folder / "fit.xml")
        return out, cost


def distance(truth, predicted):
    """(L1, relative error of the hemispherical value, values that are negative or not finite, which count as nothing)."""
    total = max(truth.sum(), 1e-12)
    bad = int((~(predicted >= 0) | np.isinf(predicted)).sum())
    predicted = np.where(np.isfinite(predicted), predicted, 0.0)
    return np.abs(predicted - truth).sum() / total, predicted.sum() / total - 1.0, bad


def summary(sets, cost):
    """One row of the table, from {set: [(L1, hemispherical error, bad)]}."""
    row = dict(cost)
    for name, found in sets.items():
        if found:
            l1 = [f[0] for f in found]
            row |= {name: float(np.mean(l1)), f"{name}_worst": float(np.max(l1))}
            row[f"{name}_hemispherical"] = float(np.sqrt(np.mean([f[1] ** 2 for f in found])))
            row["bad"] = row.get("bad", 0) + sum(f[2] for f in found)
    return row


# Virtual materials


def measured_angles(folder):
    """(theta, phi) of Mountain files, from their names."""
    return sorted(tuple(map(float, f.stem.split("_")[1:3])) for f in folder.glob("i_*.txt"))


def evenly(items, count):
    return [items[int(k)] for k in np.unique(np.linspace(0, len(items) - 1, min(count, len(items))).round())]


def incident_sets(measured):
    """Directions of each set, from the grid that was measured."""
    thetas = sorted({t for t, _ in measured})
    phis = sorted({p for t, p in measured if t > 0})
    if len(phis) == 1:
        # isotropic: any azimuth must do
        azimuths = [37.0]
    else:
        closed = phis + ([phis[0] + 360.0] if phis[-1] > 270.0 else [])
        azimuths = [(a + b) / 2 for a, b in zip(closed, closed[1:])]
    middles = [(a + b) / 2 for a, b in zip(thetas, thetas[1:])]
    # neighbouring middles get azimuths far apart
    held = [(t, azimuths[(k + j * max(1, len(azimuths) // 2)) % len(azimuths)])
            for j in range(min(2, len(azimuths))) for k, t in enumerate(middles)]  # fmt: skip
    some = evenly(sorted({*azimuths, *phis}), 3)
    grazing = [(t, p) for t in (80.0, 85.0) for p in some]
    return {"measured": evenly(measured, 8), "held-out": held, "grazing": grazing}


def virtual(builds, name, arguments):
    """Rows of a material, one a build."""
    first = builds[0]
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        points = folder / "measured"
        first.run("simulate", name, "-o", points, "--noise", arguments.noise)
        listed = json.loads(subprocess.run([first.path, "simulate", "--list", "--json"], capture_output=True).stdout)
        scattering = next(m["scattering"] for m in listed if m["name"] == name)
        sets = incident_sets(measured_angles(points))
        rng = np.random.default_rng(5)
        k = np.arange(GRID * GRID)
        at = np.stack([k // GRID, k % GRID]) + rng.random((2, GRID * GRID))
        wo = to_hemisphere(*at / GRID, 1.0 if scattering == "reflection" else -1.0)
        incident = [direction(*angle) for each in sets.values() for angle in each]
        pairs = np.repeat(incident, len(wo), 0), np.tile(wo, (len(incident), 1))
        truth = first.eval(*pairs, "--material", name).reshape(len(incident), -1)
        for build in builds:
            file, cost = build.fit([points], folder, arguments.tree)
            predicted = iter(zip(truth, build.eval(*pairs, file).reshape(len(incident), -1)))
            yield build, summary({s: [distance(*next(predicted)) for _ in each] for s, each in sets.items()}, cost)


# Ray-traced specimens


def traced(builds, folder, arguments):
    k = np.arange(CELLS * CELLS)
    for build in builds:
        with tempfile.TemporaryDirectory() as work:
            file, cost = build.fit([folder / "measured"], Path(work), arguments.tree)
            sets, noise = {}, []
            for name, kept in [("measured", "measured"), ("held-out", "held_out"), ("grazing", "grazing")]:
                with np.load(folder / f"{kept}.npz") as aside:
                    sign = 1.0 if str(aside["side"]) == "reflection" else -1.0
                    incidences, values, rays = aside["incidences"], aside["values"].astype(float), aside["rays"]
                wo = to_hemisphere((k // CELLS + 0.5) / CELLS, (k % CELLS + 0.5) / CELLS, sign)
                few = range(len(incidences)) if name != "measured" else evenly(range(len(incidences)), 8)
                sets[name] = []
                for i in few:
                    number, _ = blocks(rays[i])
                    weight = np.bincount(number)
                    wi = np.tile(direction(*incidences[i]), (len(wo), 1))
                    predicted = means(number, build.eval(wi, wo, file)) * weight
                    runs = [means(number, run) * weight for run in values[i]]
                    sets[name].append(distance(np.mean(runs, 0), predicted))
                    if name == "held-out":
                        noise.append(distance(np.mean(runs, 0), runs[0])[0])
            yield build, summary(sets, cost) | {"noise": float(np.mean(noise))}


# Real measurements


def read_mountain(path):
    """Incident direction, scattered directions and f of a Mountain file."""
    head, rows = {}, []
    for line in path.read_text(errors="replace").splitlines():
        if line.startswith("#"):
            key, _, rest = line[1:].strip().partition(" ")
            head[key.rstrip(":")] = rest.split()
        elif line.strip():
            rows.append([float(word) for word in line.split()[:3]])
    rows = np.array(rows)
    turn = 90.0 - float(head.get("upphi", ["0"])[0])
    theta, phi = float(head["intheta"][0]), float(head["inphi"][0]) + turn
    values = rows[:, 2]
    if head["format"][-1].upper() == "DSF":
        values = values / np.maximum(np.abs(np.cos(np.radians(rows[:, 0]))), 1e-3)
    return direction(theta, phi), np.stack(direction(rows[:, 0], rows[:, 1] + turn), -1), values


def square_cells(wo, cells=64):
    """The number of the cell of each direction."""
    radius, phi = np.hypot(wo[:, 0], wo[:, 1]), np.arctan2(wo[:, 1], wo[:, 0])
    quarter = np.floor(phi / (np.pi / 2) + 0.5)
    along, across = radius, radius * (phi - quarter * np.pi / 2) / (np.pi / 4)
    cos, sin = np.round(np.cos(quarter * np.pi / 2)), np.round(np.sin(quarter * np.pi / 2))
    square = np.stack([along * cos - across * sin, along * sin + across * cos])
    index = np.clip(((square + 1) / 2 * cells).astype(int), 0, cells - 1)
    return index[0] * cells + index[1]


def real(builds, files, arguments):
    def compare(build, fitted, path):
        wi, wo, values = read_mountain(path)
        predicted = build.eval(np.tile(wi, (len(wo), 1)), wo, fitted)
        _, number = np.unique(square_cells(wo), return_inverse=True)
        return distance(means(number, values), means(number, predicted))

    for build in builds:
        with tempfile.TemporaryDirectory() as work:
            fitted, cost = build.fit(files, Path(work), arguments.tree)
            sets = {"measured": [compare(build, fitted, path) for path in files], "held-out": []}
            for path in files:
                fitted, more = build.fit([f for f in files if f != path], Path(work), False)
                sets["held-out"].append(compare(build, fitted, path))
                cost = {k: max(v, more.get(k, v)) if "mb" in k else v + more.get(k, 0.0) for k, v in cost.items()}
            yield build, summary(sets, cost)


# The table

COLUMNS = [
    ("measured", "measured", "{:.4f}"), ("held-out", "held-out", "{:.4f}"), ("worst", "held-out_worst", "{:.3f}"),
    ("noise", "noise", "{:.3f}"), ("grazing", "grazing", "{:.3f}"), ("worst", "grazing_worst", "{:.3f}"),
    ("hemispherical", "held-out_hemispherical", "{:.4f}"), ("CPU s", "cpu", "{:.1f}"), ("peak MB", "mb", "{:.0f}"),
]  # fmt: skip
TREE = [("CPU s, tree", "tree_cpu", "{:.1f}"), ("peak MB, tree", "tree_mb", "{:.0f}")]


def line(cells):
    print("| " + " | ".join(cells) + " |", flush=True)


class Report:
    """Prints rows as they come, then geometric means by group and build, and builds over the first."""

    def __init__(self, builds, tree):
        self.builds, self.columns, self.rows = builds, COLUMNS + (TREE if tree else []), []
        line(["specimen", "build", *(c[0] for c in self.columns), "not finite or negative"])
        line(["---", "---", *("---:" for _ in self.columns), "---:"])

    def add(self, group, name, build, row):
        self.rows.append({"group": group, "specimen": name, "build": build.label, **row})
        self.show(name, build.label, row)

    def show(self, name, label, row):
        cells = [form.format(row[key]) if key in row else "" for _, key, form in self.columns]
        line([name, label, *cells, str(row.get("bad", ""))])

    def mean(self, group, build):
        rows = [r for r in self.rows if r["group"] == group and r["build"] == build.label]
        mean = lambda key: float(np.exp(np.mean([np.log(max(r[key], 1e-9)) for r in rows if key in r])))
        return {key: mean(key) for _, key, _ in self.columns if any(key in r for r in rows)}

    def finish(self):
        for group in dict.fromkeys(r["group"] for r in self.rows):
            base = self.mean(group, self.builds[0])
            for build in self.builds:
                mean = self.mean(group, build)
                self.show(f"**{group}**, geometric mean", build.label, mean)
                if build is not self.builds[0]:
                    self.show(f"{self.builds[0].label} over {build.label}", "", {k: base[k] / v for k, v in mean.items()})


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bsdf", default=os.environ.get("BSDF", "target/release/bsdf"), help="the build that is judged")
    parser.add_argument("--against", action="append", default=[], metavar="LABEL=PATH", help="another; may be repeated")
    parser.add_argument("--traced", type=Path, help="folder that benches/raytraced/trace.py wrote")
    parser.add_argument("--real", type=Path, default=os.environ.get("BSDFKIT_DATA"), help="real sets [BSDFKIT_DATA]")
    parser.add_argument("--only", nargs="+", metavar="NAME", help="these specimens: fabric, traced/slats, real/EDS10")
    parser.add_argument("--final", action="store_true", help="the held-back half, and nothing else")
    parser.add_argument("--noise", type=float, default=0.0, help="of virtual measurements, as a fraction")
    parser.add_argument("--tree", action="store_true", help="what fit and tree together cost, too")
    parser.add_argument("--json", type=Path, help="write all figures here")
    return parser.parse_args()


def specimens(arguments):
    """(group, name, function of the builds) of all that is to be run."""
    listed = [] if arguments.final else [("the six", n) for n in SIX]
    listed += [("virtual", n) for n in looked_at(VIRTUAL, arguments.final)]
    for group, name in listed:
        yield group, name, lambda builds, name=name: virtual(builds, name, arguments)
    for name in looked_at(TRACED, arguments.final) if arguments.traced else []:
        folder = arguments.traced / name
        yield "ray-traced", f"traced/{name}", lambda builds, folder=folder: traced(builds, folder, arguments)
    for name, folder, pattern in REAL if arguments.real and not arguments.final else []:
        files = sorted((Path(arguments.real) / folder).glob(pattern))
        if len(files) > 3:
            yield "real", f"real/{name}", lambda builds, files=files: real(builds, files, arguments)


def main():
    arguments = parse()
    others = [text.partition("=") for text in arguments.against]
    builds = [Build("this", arguments.bsdf), *(Build(label, path) for label, _, path in others)]
    chosen = list(specimens(arguments))
    names = [name for _, name, _ in chosen]
    unknown = [name for name in arguments.only or [] if name not in names]
    if unknown:
        sys.exit(f"--only: expected some of {', '.join(names)}, found {', '.join(unknown)} (held back: see --final)")
    report, failed = Report(builds, arguments.tree), []
    for group, name, rows in chosen:
        if arguments.only and name not in arguments.only:
            continue
        try:
            for build, row in rows(builds):
                report.add(group, name, build, row)
        except (RuntimeError, OSError) as error:
            failed.append(f"{name}: {error}")
    report.finish()
    for text in failed:
        print(text, file=sys.stderr)
    if arguments.json:
        arguments.json.write_text(json.dumps(report.rows, indent=1) + "\n")
    sys.exit(bool(failed))


if __name__ == "__main__":
    main()
