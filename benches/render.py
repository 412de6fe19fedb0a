"""The render form's speed: Radiance's tree, the interpolant and a closed form beside it, one core, one run.

    python benches/render.py [--old BENCH_PAIRS] INTERPOLANT.safetensors...

Needs pyradiance (PyPI), whose shared object holds Radiance's library, numpy, a C compiler and cargo; BSDF names the command,
else target/release/bsdf. Of each interpolant (`bsdf fit`) the command makes the render form and the default tree. All are asked at the
same pairs, uniform in projected solid angle: the render form by crates/bsdf/examples/bench_query.rs, in batches and call by call,
Radiance's library on the tree (benches/query.py), the interpolant by crates/fit/examples/bench_pairs.rs, an anisotropic GGX
in C (query/yardsticks.c). `--old`: that example built from another commit, in whose interpolant the second bar counts. The
floor: as many independent reads of cache lines, in as many bytes, as a value's tables take.
What is printed holds for a quiet machine only; ratios vary less than times. A ratio's target stands beside it.
"""

import argparse
import ctypes
import json
import os
import subprocess
import tempfile
from pathlib import Path

import numpy as np
import query
from query import HERE, ROOT, pointer, verdict

PAIRS = 1 << 18
# Radiance makes tables of an incidence when it is first sampled.
FEW = 20_000
RUNS = 15


def yardsticks(folder):
    target = folder / "yardsticks.so"
    source = HERE / "query/yardsticks.c"
    compiler = os.environ.get("CC", "cc")
    subprocess.run([compiler, "-O3", "-shared", "-fPIC", "-o", target, source, "-lm"], check=True)
    library = ctypes.CDLL(str(target))
    for name in ("time_ggx_eval", "time_ggx_sample", "time_lines"):
        getattr(library, name).restype = ctypes.c_double
    return library


def nanoseconds(run, results):
    return 1e9 * min(run() for _ in range(RUNS)) / results


def directions(random, count, side):
    radius, turn = np.sqrt(random.random(count)), 2 * np.pi * random.random(count)
    z = np.sqrt(1 - radius**2) * {"front": 1, "back": -1}[side]
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), z], axis=-1)


def closed_form(library, random):
    pairs = np.hstack([directions(random, PAIRS, "front") for _ in range(2)])
    u, out, count = random.random((PAIRS, 2)), np.zeros(PAIRS), ctypes.c_size_t(PAIRS)
    return (
        nanoseconds(lambda: library.time_ggx_eval(pointer(pairs), count, pointer(out)), PAIRS),
        nanoseconds(lambda: library.time_ggx_sample(pointer(pairs), count, pointer(u), pointer(out)), PAIRS),
    )


def lines_of(container):
    """Cache lines of tables of values that one value reads, and bytes of those tables."""
    content = container.read_bytes()
    length = int.from_bytes(content[:8], "little")
    header = json.loads(content[8 : 8 + length])
    tables = [a for name, a in header.items() if name.startswith("component.0.render.layer") and name.endswith(".values")]
    said = json.loads(header["__metadata__"]["bsdfkit"])["components"][0]["representation"]["render"]
    nodes = 2 if said["fold"].startswith("isotropic") else 3
    size = sum(a["data_offsets"][1] - a["data_offsets"][0] for a in tables)
    # Two rows of half floats a node: two neighbours share a line but one time in 32.
    return 2 * nodes * len(tables) * (1 + 1 / 32), size


def floor(library, random, lines, size):
    whole = max(round(lines), 1)
    places = random.integers(0, size, PAIRS * whole, dtype=np.uint32)
    table, out = np.ones(size, np.uint8), np.zeros(PAIRS)
    call = library.time_lines
    arguments = (pointer(table), pointer(places), ctypes.c_size_t(PAIRS), ctypes.c_size_t(whole), pointer(out))
    return nanoseconds(lambda: call(*arguments), PAIRS)


def sides(command, file):
    said = subprocess.run([command, "info", "--json", file], check=True, capture_output=True, text=True).stdout
    side, sense = json.loads(said.splitlines()[0])["components"][0]["component"].split()
    return side, side if sense == "reflection" else {"front": "back", "back": "front"}[side]


def interpolant(program, old, file):
    """ns a value today, and in the old build; None without it."""
    words = [program, *(["--against", old] if old else []), file]
    line = subprocess.run(words, check=True, capture_output=True, text=True).stdout.splitlines()[1].split()
    return (1e3 * float(line[2]), 1e3 * float(line[1])) if old else (1e3 * float(line[1]), None)


def row(label, other, own, target=None):
    if other is not None:
        print(f"  {label:44}{other:12.1f}{own:10.1f}{other / own:10.2f}" + ("" if target is None else verdict(other / own >= target, target)))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--old")
    parser.add_argument("files", nargs="+", type=Path)
    given = parser.parse_args()
    for what in (["bsdfkit", "--example", "bench_query"], ["bsdfkit-fit", "--example", "bench_pairs"]):
        subprocess.run(["cargo", "build", "--release", "--locked", "-p", *what], cwd=ROOT, check=True)
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release"
    command = os.environ.get("BSDF", target / "bsdf")
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        library, loops = yardsticks(folder), query.load_loops(folder)
        for file in given.files:
            random = np.random.default_rng(1)
            form, tree, asked = folder / "form.safetensors", folder / "tree.xml", folder / "directions.f64"
            subprocess.run([command, "compile", file, "-o", form], check=True, capture_output=True)
            subprocess.run([command, "convert", file, "--to", "tensor-tree", "-o", tree], check=True, capture_output=True)
            pairs = np.hstack([directions(random, PAIRS, side) for side in sides(command, file)])
            pairs.tofile(asked)
            ours = query.measure_ours(target / "examples/bench_query", "run", form, asked)
            theirs = query.measure_reference(tree, pairs[:FEW].copy(), random.random(FEW), loops, False)
            value, sample = closed_form(library, random)
            now, before = interpolant(target / "examples/bench_pairs", given.old, file)
            lines, size = lines_of(form)
            print(f"\n{file.stem}: {form.stat().st_size / 1e6:.1f} MB, tree {tree.stat().st_size / 1e6:.1f} MB")
            print(f"  {'':44}{'other ns':>12}{'ours ns':>10}{'ratio':>10}{'target':>10}")
            batch, single = ours["eval_many"], ours["eval"]
            row("values: Radiance's tree", theirs["eval"], batch, 8)
            row("values, call by call: Radiance's tree", theirs["eval"], single)
            row("values: the interpolant, today", now, batch)
            row("values: the interpolant, old build", before, batch, 150)
            row("values: GGX", value, batch, 0.3)
            row("values, call by call: GGX", value, single)
            row("values: the floor", floor(library, random, lines, size), batch)
            print(f"  {'':4}(floor: {lines:.1f} cache lines of {size / 1e6:.1f} MB)")
            row("samples: Radiance's tree", theirs["sample"], ours["sample_many"], 200)
            row("samples, two numbers: GGX", sample, ours["sample2_many"], 0.3)
            row("densities: GGX values", value, ours["pdf_many"])


if __name__ == "__main__":
    main()
