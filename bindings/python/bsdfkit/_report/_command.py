"""The command line `bsdf report PATH`."""

import argparse
from pathlib import Path

from ..plot._command import guarded


def parser():
    p = argparse.ArgumentParser(
        prog="bsdf report",
        description="Write one self-contained HTML page about a measurement, an interpolant or a BSDF.",
    )
    p.add_argument(
        "path", type=Path, metavar="PATH", help="a BSDF, an interpolant, or a file or folder of measurements"
    )
    p.add_argument("-o", "--output", type=Path, required=True, metavar="OUT.html", help="the page")
    p.add_argument(
        "--measured",
        type=Path,
        metavar="DIR",
        help="of an interpolant: the measurements it was fitted to; then residuals and incidences left out, too",
    )
    p.add_argument("--title", help="the title [the name that the file gives]")
    return p


def run(arguments):
    from . import report

    report(arguments.path, arguments.output, measured=arguments.measured, title=arguments.title)
    print(arguments.output)


def main(words=None):
    return guarded(run, parser().parse_args(words))
