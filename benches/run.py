"""What a fit costs: Radiance's programs beside ours, same specimens, same machine, one after the other.

    make bench                              every material
    python benches/run.py fabric            only those named

Both sides read the same Mountain files and write an interpolant, a tensor tree and a full Klems matrix.
Seconds and peak memory are the operating system's accounting of each process. Radiance's converters run
with the options printed: not its best accuracy, but what ends in minutes.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import pyradiance

RADIANCE = Path(pyradiance.__file__).resolve().parent
BSDF = os.environ.get("BSDF", "target/release/bsdf")
MATERIALS = ["brushed-metal", "rotated-metal", "fabric", "prism-film", "fritted-glass", "rough-dielectric"]
ENVIRONMENT = dict(
    os.environ,
    RAYPATH=f".{os.pathsep}{RADIANCE / 'lib'}",
    PATH=f"{RADIANCE / 'bin'}{os.pathsep}{os.environ['PATH']}",
)


def measured(command, folder, output, limit):
    """Runs a command: (verdict, wall s, processor s, peak MB)."""
    with open(folder / output, "wb") as out, open(folder / "errors.txt", "wb") as errors:
        start = time.monotonic()
        child = subprocess.Popen(list(map(str, command)), cwd=folder, env=ENVIRONMENT, stdout=out, stderr=errors)
        alarm = threading.Timer(limit, child.kill)
        alarm.start()
        _, status, usage = os.wait4(child.pid, 0)
        wall = time.monotonic() - start
        alarm.cancel()
    child.returncode = os.waitstatus_to_exitcode(status)
    verdict = "" if child.returncode == 0 else "cut off" if wall >= limit else f"status {child.returncode}"
    return verdict, wall, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024.0


def commands(folder, points, threads):
    """(label, command, file that standard output goes to, file whose size counts)."""
    ours = [BSDF, "fit", folder / "measurements", "-o", "ours.safetensors", "-o", "ours.xml"]
    ours += ["--to", "klems-full", "-o", "ours_klems.xml", "--threads", threads]
    yield "bsdf fit (all three)", ours, "ours.txt", "ours.xml"
    yield f"pabopto2bsdf -n {threads}", ["pabopto2bsdf", "-n", threads, *points], "peer.sir", "peer.sir"
    yield "bsdf2ttree -g 5 -n 16", ["bsdf2ttree", "-g", 5, "-n", 16, "peer.sir"], "peer.xml", "peer.xml"
    yield "bsdf2klems -n 64", ["bsdf2klems", "-n", 64, "peer.sir"], "peer_klems.xml", "peer_klems.xml"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("materials", nargs="*", default=MATERIALS)
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    parser.add_argument("--limit", type=float, default=1200.0, help="seconds after which a program is cut off")
    arguments = parser.parse_args()
    print(f"{'material':17} {'program':24} {'wall s':>8} {'cpu s':>8} {'peak MB':>8} {'file MB':>8}")
    failed = False
    for material in arguments.materials:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            subprocess.run([BSDF, "simulate", material, "-o", folder / "measurements"], check=True, capture_output=True)
            points = sorted((folder / "measurements").glob("*.txt"))
            for label, command, output, counted in commands(folder, points, arguments.threads):
                verdict, wall, cpu, peak = measured(command, folder, output, arguments.limit)
                path = folder / counted
                size = path.stat().st_size / 1e6 if path.exists() else 0.0
                print(f"{material:17} {label:24} {wall:8.1f} {cpu:8.1f} {peak:8.0f} {size:8.2f} {verdict}", flush=True)
                if verdict and label.startswith("bsdf fit"):
                    print((folder / "errors.txt").read_text(errors="replace")[-500:])
                    failed = True
                if verdict and label.startswith("pabopto2bsdf"):
                    break
    sys.exit(failed)


if __name__ == "__main__":
    main()
