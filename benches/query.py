"""Queries: this library beside the reference one, same files, same directions, one thread, one run.

    make bench-query          or: python benches/query.py [FOLDER]

Needs pyradiance (PyPI), whose shared object holds the reference library, numpy, a C compiler and cargo.
The reference is called from a loop in C (query/reference.c); what the loop itself costs is measured,
subtracted and printed. Files: a glossy rank-4 tree of 2^6 cells a dimension, the same tree as a lone transmission that
is asked from its other side, a rank-3 tree of 2^8, the first material as a Klems Full matrix
(crates/bsdf/examples/bench_query.rs makes them), and a matrix of tests/golden whose values are integers of few
digits: the shortest file of its kind, and the reference's quickest. A ratio's target stands beside it.
"""

import ctypes
import glob
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pyradiance

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
INTEGERS = ROOT / "tests/golden/xml/kf_out_tf.xml"
RUNS = 5


class Allocated(ctypes.Structure):
    """glibc's struct mallinfo2."""

    _fields_ = [(name, ctypes.c_size_t) for name in
                ("arena", "ordblks", "smblks", "hblks", "hblkhd", "usmblks", "fsmblks", "uordblks", "fordblks", "keepcost")]


def allocated():
    """KB in use: what is resident says little in a process whose freed memory the library takes up again."""
    call = ctypes.CDLL(None).mallinfo2
    call.restype = Allocated
    figures = call()
    return (figures.uordblks + figures.hblkhd) // 1024


def mapped(path):
    """KB of a file that are resident in mappings of it."""
    held, resident = False, 0
    for line in Path("/proc/self/smaps").read_text().splitlines():
        if not line.split(None, 1)[0].endswith(":"):
            held = line.endswith(str(path))
        elif held and line.startswith("Rss:"):
            resident += int(line.split()[1])
    return resident


def pointer(array):
    return array.ctypes.data_as(ctypes.c_void_p)


def load_loops(folder):
    target = folder / "reference.so"
    compiler = os.environ.get("CC", "cc")
    source = HERE / "query/reference.c"
    subprocess.run([compiler, "-O3", "-shared", "-fPIC", "-o", target, source], check=True)
    loops = ctypes.CDLL(str(target))
    for name in ("time_eval", "time_sample", "time_hemi", "time_nothing"):
        getattr(loops, name).restype = ctypes.c_double
    return loops


class Reference:
    """One file in the reference library."""

    def __init__(self, path):
        package = Path(pyradiance.__file__).parent
        self.library = ctypes.CDLL(glob.glob(str(package / "bsdf*.so"))[0])
        self.path = str(path).encode()
        # Larger than its structure of names, sizes and four Lambertian parts.
        self.data = ctypes.create_string_buffer(1 << 16)

    def open(self):
        self.library.SDclearBSDF(self.data, self.path)
        start = time.process_time()
        status = self.library.SDloadFile(self.data, self.path)
        taken = time.process_time() - start
        if status:
            raise RuntimeError(f"{self.path.decode()}: reference library status {status}")
        return taken

    def free(self):
        self.library.SDfreeBSDF(self.data)

    def function(self, name):
        return ctypes.cast(getattr(self.library, name), ctypes.c_void_p)


def measure_reference(path, pairs, u, loops, many):
    """Name -> nanoseconds a result; `open` in nanoseconds, `resident` in KB allocated. `many`: incidences are costly."""
    reference = Reference(path)
    taken = {}
    n = len(u)
    out = np.ones(n)
    before = allocated()
    begin, opened = time.perf_counter(), []
    # As often as ours is opened: fifteen times, and for 0.2 s.
    while len(opened) < 15 or time.perf_counter() - begin < 0.2:
        if opened:
            reference.free()
        opened.append(reference.open())
    taken["open"] = 1e9 * min(opened)
    call = {
        "eval": lambda n, stride: loops.time_eval(
            reference.function("SDevalBSDF"), reference.data, pointer(pairs),
            ctypes.c_size_t(n), ctypes.c_size_t(stride), pointer(out)),
        "sample": lambda n, stride: loops.time_sample(
            reference.function("SDsampBSDF"), reference.data, pointer(pairs),
            ctypes.c_size_t(n), ctypes.c_size_t(stride), pointer(u), pointer(out)),
        "hemi": lambda n, stride: loops.time_hemi(
            reference.function("SDdirectHemi"), reference.data, pointer(pairs),
            ctypes.c_size_t(n), ctypes.c_size_t(stride), pointer(out)),
    }
    empty = min(loops.time_nothing(pointer(pairs), ctypes.c_size_t(n), pointer(out)) for _ in range(RUNS)) / n
    print(f"# loop and call by themselves: {1e9 * empty:.2f} ns, subtracted")

    def best(name, n, stride, runs):
        """Of so many runs, or of half a second, as ours."""
        begin, times = time.perf_counter(), []
        while len(times) < runs or time.perf_counter() - begin < 0.5:
            times.append(call[name](n, stride))
        return 1e9 * (min(times) / n - empty)

    taken["eval"] = best("eval", n, 1, RUNS)
    taken["eval, one wi"] = best("eval", n, 0, RUNS)
    taken["sample, one wi"] = best("sample", n, 0, RUNS)
    # Every incidence met once, so that its tables are made, then timed.
    warm = 50_000 if many else n
    call["sample"](warm, 1)
    few = 10_000 if many else n
    taken["sample"] = best("sample", few, 1, 2)
    taken["hemi"] = best("hemi", few, 1, 2)
    taken["resident"] = allocated() - before
    return taken


def measure_ours(program, verb, path, directions):
    taken = {}
    environment = dict(os.environ, RAYON_NUM_THREADS="1") if verb == "run" else os.environ
    output = subprocess.run([program, verb, path, directions], env=environment, check=True, capture_output=True)
    for line in output.stdout.splitlines():
        figure = json.loads(line)
        taken[figure["name"]] = next(figure[unit] for unit in ("ns", "count") if unit in figure)
    return taken


class Ours:
    """The C library, for what it holds: its speed is measured in a process of its own."""

    def __init__(self, shared_object, path, pairs, u):
        os.environ["RAYON_NUM_THREADS"] = "1"
        self.library = ctypes.CDLL(str(shared_object))
        self.library.bsdfkit_open.restype = ctypes.c_void_p
        # A first round, so that what the process holds once and for all is not counted.
        self.resident(path, pairs, u)
        del os.environ["RAYON_NUM_THREADS"]

    def resident(self, path, pairs, u):
        """KB held after every query: allocated, and of the file if it is mapped."""
        wi, wo = np.ascontiguousarray(pairs[:, :3]), np.ascontiguousarray(pairs[:, 3:])
        n, everything = ctypes.c_size_t(len(u)), ctypes.c_uint32(2**32 - 1)
        # A sample takes six doubles.
        out = np.zeros((len(u), 6))
        before = allocated()
        bsdf = ctypes.c_void_p(self.library.bsdfkit_open(str(path).encode(), None))
        calls = (
            self.library.bsdfkit_eval_many(bsdf, pointer(wi), n, pointer(wo), n, pointer(out), n, None),
            self.library.bsdfkit_hemispherical_many(bsdf, pointer(wi), n, everything, pointer(out), n, None),
            self.library.bsdfkit_sample_1_many(bsdf, pointer(wi), n, pointer(u), n, everything, pointer(out), n, None),
        )
        if any(calls):
            raise RuntimeError(f"{path}: queries failed: {calls}")
        held = allocated() - before + mapped(path)
        self.library.bsdfkit_close(bsdf)
        return held


# Label, figure of the reference, figure of ours, least ratio for the rank-4 tree and for the matrix.
ROWS = [
    ("eval", "eval", "eval_many", (8, 8)),
    ("eval, single calls", "eval", "eval", None),
    ("eval, one wi", "eval, one wi", "eval_many, one wi", None),
    ("eval, smooth lookup", "eval", "eval_many, smooth", None),
    ("sample, random wi", "sample", "sample_many", (100, 10)),
    ("sample, two u", "sample", "sample2_many", None),
    ("sample, single calls", "sample", "sample", None),
    ("sample, one wi", "sample, one wi", "sample_many, one wi", None),
    ("sample, smooth lookup", "sample", "sample_many, smooth", None),
    ("hemispherical, random wi", "hemi", "directional_hemispherical_many", (100, 100)),
    ("pdf (reference: none)", None, "pdf_many", None),
    ("open XML", "open", "open", (8, 8)),
]
CONTAINER_RATIO, CONTAINER_NS = 100, 5e6


def verdict(reached, target):
    return f"{target:>10}  {'' if reached else 'MISSED'}"


def report(title, theirs, ours, compiled, column):
    """`column`: 0 or 1, of the targets in ROWS; None where there are none."""
    print(f"\n{title}\n{'':28}{'reference ns':>14}{'ours ns':>12}{'ours M/s':>10}{'ratio':>9}{'target':>10}")

    def row(label, a, b, targets):
        target = "" if targets is None or column is None else verdict(a / b >= targets[column], targets[column])
        print(f"{label:28}{a:14.1f}{b:12.1f}{1e3 / b:10.2f}{a / b:9.1f}{target}")

    for label, reference, own, targets in ROWS:
        if own in ours:
            row(label, theirs.get(reference, float("nan")), ours[own], targets)
    row("open container", theirs["open"], compiled["open"], (CONTAINER_RATIO, CONTAINER_RATIO))
    if column is not None:
        milliseconds = f"{CONTAINER_NS / 1e6:.0f} ms"
        print(f"{'':28}{'':14}{compiled['open'] / 1e6:10.3f}ms{'':19}{verdict(compiled['open'] < CONTAINER_NS, milliseconds)}")
    more = max(ours["resident"], compiled["resident"]) > theirs["resident"]
    aim = "" if column is None else f"; target: at most the reference's {'MISSED' if more else ''}"
    print(f"KB held after all queries: reference {theirs['resident']}, ours from XML {ours['resident']}, "
          f"from the container {compiled['resident']}{aim}")


def report_floor(floor, ours):
    size = floor["bytes"] / 1e6
    print(f"floor: an eval touches {floor['lines']:.2f} cache lines: one of a table of the first levels, the others "
          f"of the tree's {size:.1f} MB. As many dependent lines of as many bytes, level by level, nothing computed:")
    for label, chase, own in (
        ("one after the other", "chase", "eval"),
        ("64 side by side", "chase, abreast", "eval_many"),
    ):
        a, b = floor[chase], ours[own]
        print(f"  {label:20} {a:6.1f} ns; {own:10} {b:6.1f} ns: {b / a:.1f} times the floor")


def report_threads(taken):
    print(f"threads on one handle, {os.cpu_count()} cores; M/s by the clock:")
    for verb in ("eval_many", "sample_many"):
        rates = [1e3 / taken[f"{verb}, {n} threads"] for n in (1, 2, 4)]
        print(f"  {verb:12}" + "".join(f"{n:4}: {rate:7.2f}" for n, rate in zip((1, 2, 4), rates))
              + f"   2 threads are {rates[1] / rates[0]:.2f} times as fast as 1")
    same = all(taken[f"same answers, {n} threads"] for n in (1, 2, 4))
    print(f"  answers {'equal bit for bit' if same else 'DIFFER'}")


def main():
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(tempfile.mkdtemp())
    for what in (["bsdfkit", "--example", "bench_query"], ["bsdfkit-c"]):
        subprocess.run(["cargo", "build", "--release", "--locked", "-p", *what], cwd=ROOT, check=True)
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    program = target / "release/examples/bench_query"
    folder.mkdir(parents=True, exist_ok=True)
    subprocess.run([program, "make", folder], check=True)
    integers = folder / "integers.xml"
    integers.write_bytes(INTEGERS.read_bytes())
    loops = load_loops(folder)
    directions = folder / "directions.f64"
    pairs = np.fromfile(directions).reshape(-1, 6)
    u = np.random.default_rng(2).random(len(pairs))
    library = Ours(target / "release/libbsdfkit.so", integers, pairs, u)
    through = folder / "through.f64"
    (pairs * [1, 1, 1, 1, 1, -1]).tofile(through)
    for path, directions, many, column in (
        (folder / "tree6.xml", directions, True, 0),
        (folder / "through6.xml", through, True, None),
        (folder / "tree3.xml", directions, False, None),
        (folder / "klems.xml", directions, False, 1),
        (integers, through, False, 1),
    ):
        pairs = np.fromfile(directions).reshape(-1, 6)
        theirs = measure_reference(path, pairs, u, loops, many)
        ours = measure_ours(program, "run", path, directions)
        container = path.with_suffix(".safetensors")
        compiled = measure_ours(program, "run", container, directions)
        for figures, file in ((ours, path), (compiled, container)):
            figures["resident"] = library.resident(file, pairs, u)
        report(f"{path.name}, {path.stat().st_size / 1e6:.1f} MB", theirs, ours, compiled, column)
        if column is None:
            continue
        if many:
            report_floor(measure_ours(program, "floor", container, directions), ours)
        report_threads(measure_ours(program, "threads", container, directions))


if __name__ == "__main__":
    main()
