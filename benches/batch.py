"""Many virtual materials through Dask, a worker killed in the middle, beside the same by processes of one machine, one after the other.

    python benches/batch.py --bsdf target/release/bsdf [--materials 200] [--workers 2] [--keep DIR]

Prints whether all are there and the same to the byte, what a job costs beside its fit, and how much faster several workers are.
Needs the package bsdfkit with distributed in the interpreter that runs it (`pip install 'bsdfkit[dask]'`). A machine that does other
work meanwhile makes its times worthless; the processor seconds stand.
"""

import argparse
import contextlib
import json
import os
import re
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np


def direction(theta, phi):
    theta, phi = np.radians(theta), np.radians(phi)
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta) + 0 * phi], -1)


def laboratory(folder, materials, points):
    """Glossy isotropic specimens of four incidences, each another; the path of their manifest."""
    chance = np.random.default_rng(1)
    text = '[defaults]\noutputs = ["interpolant", "klems-full"]\nsymmetry = "isotropic"\n'
    theta = np.degrees(np.arcsin(np.sqrt((np.arange(points) + 0.5) / points) * np.sin(np.radians(85))))
    phi = 137.508 * np.arange(points) % 360
    wo = direction(theta, phi)
    for k in range(materials):
        floor, height, gloss = chance.uniform(0.01, 0.2), chance.uniform(0.1, 2), chance.uniform(5, 60)
        rows = ["theta_i,phi_i,theta_o,phi_o,value"]
        for theta_i in (0, 20, 40, 60):
            f = floor + height * np.exp(gloss * (wo @ direction(theta_i, 180.0) - 1))
            rows += [f"{theta_i},0,{t:.4f},{p:.4f},{v:.6e}" for t, p, v in zip(theta, phi, f, strict=True)]
        place = folder / f"{k}.csv"
        place.write_text("\n".join(rows) + "\n")
        text += f'[[material]]\nname = "m{k}"\nmeasurements = ["{k}.csv"]\n'
    manifest = folder / "all.toml"
    manifest.write_text(text)
    return manifest


def made(folder):
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.glob("*/*") if p.suffix in (".xml", ".safetensors")}


def start(main, words, environment, stderr=subprocess.DEVNULL):
    script = f"from distributed.cli.{main} import main; main()"
    return subprocess.Popen([sys.executable, "-c", script, *words], env=environment, stderr=stderr, text=True)


@contextlib.contextmanager
def cluster(workers, environment):
    """A scheduler on loopback; its address and the processes of its workers."""
    words = ["--host", "127.0.0.1", "--port", "0", "--no-dashboard"]
    scheduler = start("dask_scheduler", words, environment, subprocess.PIPE)
    processes = []
    try:
        address = next(found.group() for line in scheduler.stderr if (found := re.search(r"tcp://127\.0\.0\.1:\d+", line)))
        words = [address, "--nthreads", "1", "--no-nanny", "--no-dashboard", "--host", "127.0.0.1"]
        processes += [start("dask_worker", words, environment) for _ in range(workers)]
        time.sleep(8)  # until all are there: their start is not a job's cost
        yield address, processes
    finally:
        for process in [*processes, scheduler]:
            process.kill()
            process.wait()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bsdf", required=True)
    parser.add_argument("--materials", type=int, default=200)
    parser.add_argument("--points", type=int, default=300, help="an incidence")
    parser.add_argument("--workers", type=int, default=2)
    wanted = parser.parse_args()
    bsdf = str(Path(wanted.bsdf).absolute())
    environment = {**os.environ, "BSDFKIT_COMMAND": bsdf, "BSDFKIT_PYTHON": sys.executable}

    def batch(manifest, to, *words):
        before, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
        line = [bsdf, "batch", manifest, "-o", to, "--json", *words]
        ran = subprocess.run(line, env=environment, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=False)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        lines = json.loads(ran.stdout)
        if not all(one["status"] == "done" for one in lines):
            sys.exit(next(f"{one['material']}: {one['status']} {one['error']}" for one in lines if one["status"] != "done"))
        return lines, time.monotonic() - began, spent

    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        manifest = laboratory(folder, wanted.materials, wanted.points)
        count = wanted.materials
        serial, alone, spent = batch(manifest, folder / "serial", "--jobs", "1", "--threads", "1")
        fits = sum(one["cpu_seconds"] for one in serial)
        expected = made(folder / "serial")
        print(f"{count} materials of 4 x {wanted.points} points, {len(expected)} files")
        print(f"one process at a time: {alone:.1f} s, {1000 * alone / count:.0f} ms a job; "
              f"{1000 * (spent - fits) / count:.1f} ms of a processor a job beside its fit of {1000 * fits / count:.0f}")
        _, two, _ = batch(manifest, folder / "two", "--jobs", str(wanted.workers), "--threads", "1")
        print(f"{wanted.workers} processes at a time: {two:.1f} s, {alone / two:.2f} times as fast; "
              f"{'the same files' if made(folder / 'two') == expected else 'OTHER FILES'}")
        with cluster(wanted.workers, environment) as (address, _):
            lines, dask, _ = batch(manifest, folder / "dask", "--scheduler", address)
            fits = sum(one["cpu_seconds"] for one in lines)
            overhead = 1000 * (dask * wanted.workers - fits) / count
            print(f"Dask, {wanted.workers} workers: {dask:.1f} s, {alone / dask:.2f} times as fast, at most {overhead:.0f} ms a job "
                  f"beside its fit; {'the same files' if made(folder / 'dask') == expected else 'OTHER FILES'}")
        with cluster(wanted.workers + 1, environment) as (address, processes):
            to = folder / "killed"
            line = [bsdf, "batch", manifest, "-o", to, "--scheduler", address]
            running = subprocess.Popen(line, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            while running.poll() is None and len(list(to.glob("*/.batch.json"))) < count // 3:
                time.sleep(0.05)
            processes[0].kill()
            status = running.wait()
            same = made(to) == expected
            print(f"one of {wanted.workers + 1} workers killed after {count // 3} jobs: status {status}, "
                  f"{'complete, the same files' if same else 'OTHER FILES'}")
            sys.exit(0 if same and status == 0 else 1)


main()
