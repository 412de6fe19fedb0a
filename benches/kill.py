"""Kills a fit at random moments, lets it go on, and compares what comes of it with what a fit that was never killed makes.

    python benches/kill.py --bsdf target/release/bsdf [--kills 50] [--material fabric]

Each of the kills ends one process (SIGKILL) at a random moment of what a whole fit takes; the same command is started again with the
same cache until it ends by itself. Fails unless every output is the same to the bit.
"""

import argparse
import random
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bsdf", default="bsdf")
    parser.add_argument("--kills", type=int, default=50)
    parser.add_argument("--material", default="fabric")
    parser.add_argument("--seed", type=int, default=1)
    wanted = parser.parse_args()
    chance = random.Random(wanted.seed)
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        small = ["--sweeps", "24", "--points-per-sweep", "120", "--spiral-points", "800"]
        subprocess.run(
            [wanted.bsdf, "simulate", wanted.material, "-o", folder / "m", *small], check=True, stdout=subprocess.DEVNULL
        )

        def command(cache, to):
            files = ["-o", to / "x.safetensors", "-o", to / "x.xml", "--max-leaves", "20000"]
            return [wanted.bsdf, "fit", folder / "m", *files, *(["--cache", cache] if cache else [])]

        whole = folder / "whole"
        whole.mkdir()
        began = time.monotonic()
        subprocess.run(command(None, whole), check=True, stdout=subprocess.DEVNULL)
        takes = time.monotonic() - began
        expected = {f.name: f.read_bytes() for f in whole.iterdir()}

        kills = same = rounds = 0
        while kills < wanted.kills:
            rounds += 1
            cache, to = folder / f"cache{rounds}", folder / f"out{rounds}"
            to.mkdir()
            while True:
                process = subprocess.Popen(command(cache, to), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
                try:
                    process.wait(timeout=chance.uniform(0.02, takes) if kills < wanted.kills else None)
                    break
                except subprocess.TimeoutExpired:
                    process.kill()
                    process.wait()
                    kills += 1
                for f in to.iterdir():
                    # Whole, or not there; files under way have names of their own.
                    if f.name in expected and f.read_bytes() != expected[f.name]:
                        sys.exit(f"{f.name}: half-written after a kill")
            found = {f.name: f.read_bytes() for f in to.iterdir() if f.name in expected}
            if process.returncode or found != expected:
                sys.exit(f"after {kills} kills: status {process.returncode}, other bits in {found.keys()}")
            same += 1
            print(f"{kills} kills, {same} fits that ended with the same bits", file=sys.stderr)
            shutil.rmtree(cache)
            shutil.rmtree(to)
        print(f"{kills} kills in {rounds} fits of {takes:.1f} s: all {same} ended with the same bits")


main()
