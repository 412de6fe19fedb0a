"""The command line `bsdf plot FILE... --kind KIND`."""

import argparse
import os
import sys
import warnings
from pathlib import Path

import bsdfkit

STATUSES = [(bsdfkit.ArgumentError, 2), (bsdfkit.IoError, 3), (bsdfkit.FormatError, 4), (bsdfkit.LimitError, 5)]


def angles(text):
    """ "30,45" → (30.0, 45.0); "30" alone has phi = 0."""
    words = text.replace(",", " ").split()
    try:
        numbers = [float(word) for word in words]
    except ValueError:
        numbers = []
    if len(numbers) not in (1, 2):
        raise argparse.ArgumentTypeError(f"expected THETA,PHI in degrees, found {text!r}")
    return (*numbers, 0.0)[:2]


def captioned(text):
    """PATH or CAPTION=PATH."""
    if "=" in text and not Path(text).exists():
        caption, path = text.split("=", 1)
        return caption, Path(path)
    return None, Path(text)


#: How options of pictures are read from words, by name.
OPTIONS = {
    "incident": dict(
        type=angles,
        action="append",
        metavar="THETA,PHI",
        help="incident direction in degrees, away from the surface; may be repeated where a picture takes several [30,0]",
    ),
    "way": dict(choices=["reflection", "transmission"], help="which light is drawn [reflection where there is any]"),
    "projection": dict(choices=["equal-area", "angle", "cosines"], help="how the hemisphere is laid out [equal-area]"),
    "decades": dict(type=float, metavar="N", help="most decades of the scale"),
    "linear": dict(action="store_true", help="a linear scale from 0 instead of a logarithmic one"),
    "cosine": dict(action="store_true", help="f times the cosine of the scattered angle instead of f"),
    "plane": dict(type=float, metavar="PHI", help="azimuth of the plane of a slice [the plane of incidence]"),
    "azimuths": dict(
        type=float, action="append", metavar="PHI", help="incident azimuth of hemispherical curves; may be repeated"
    ),
    "numbers": dict(action="store_true", help="number the incidences of a mesh"),
    "no_numbers": dict(action="store_true", help="do not number the patches of a matrix"),
    "incident_side": dict(
        choices=["front", "back"], help="the side that is lit in a mesh [the first that was measured]"
    ),
    "elevation": dict(type=float, metavar="DEGREES", help="of the eye above a lobe's specimen [22]"),
    "azimuth": dict(type=float, metavar="DEGREES", help="of the eye about a lobe [beside the plane of incidence]"),
    "pixels": dict(type=int, metavar="N", help="pixels along a side of a panel"),
}

#: Options that a picture takes once.
SEVERAL = {"slice"}


def open_subject(path, smooth=False):
    """A BSDF, an interpolant, or the measurements of a file or folder."""
    try:
        return bsdfkit.open(path, smooth=smooth)
    except bsdfkit.ArgumentError as error:
        if "measurement" not in str(error):
            raise
        return bsdfkit.read(path)


def captions(files):
    """What files are called under their pictures: as short as tells them apart."""
    for name in (lambda path: path.stem, lambda path: path.name, str):
        names = [caption or name(path) for caption, path in files]
        if len(set(names)) == len(names):
            break
    return names


def parser():
    from . import KINDS

    kinds = "\n".join(f"  {name:<14} {words}" for name, words in KINDS.items())
    p = argparse.ArgumentParser(
        prog="bsdf plot",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        description=f"Draw files of a material as PNG or SVG.\n\nkinds:\n{kinds}",
    )
    p.add_argument(
        "files",
        nargs="+",
        type=captioned,
        metavar="FILE",
        help="BSDFs, interpolants or measurements, each as PATH or CAPTION=PATH",
    )
    p.add_argument(
        "--kind",
        choices=list(KINDS),
        default="hemisphere",
        metavar="KIND",
        help="what is drawn (see above) [hemisphere]",
    )
    p.add_argument("-o", "--output", type=Path, required=True, metavar="OUT", help="the picture, .png or .svg")
    p.add_argument("--dpi", type=float, metavar="N", help="pixels an inch [150]")
    p.add_argument("--smooth", action="store_true", help="read trees smoothly, not leaf by leaf as Radiance does")
    for name, words in OPTIONS.items():
        p.add_argument(f"--{name.replace('_', '-')}", default=None, **words)
    p.epilog = "options of each kind:\n" + "\n".join(f"  {kind:<14} {of_kind(kind)}" for kind in KINDS)
    return p


def of_kind(kind):
    """The options that a kind takes on the command line."""
    from . import options

    return " ".join(f"--{name.replace('_', '-')}" for name in options(kind) if name in OPTIONS)


def given_options(arguments):
    """The options that stand on the command line."""
    given = {name: getattr(arguments, name) for name in OPTIONS}
    given = {name: value for name, value in given.items() if value is not None and value is not False}
    if given.pop("no_numbers", False):
        given["numbers"] = False
    if "incident" in given and arguments.kind not in SEVERAL:
        if len(given["incident"]) > 1:
            raise bsdfkit.ArgumentError(
                f"incident: a picture of kind {arguments.kind} takes one, found {len(given['incident'])}"
            )
        given["incident"] = given["incident"][0]
    return given


def expect_options(kind, given):
    """That a kind takes the options that stand on the command line, in the words of the command line.

    Raises:
        ArgumentError: It does not.
    """
    from . import options

    unknown = [f"--{name.replace('_', '-')}" for name in given if name not in options(kind)]
    if unknown:
        raise bsdfkit.ArgumentError(
            f"--kind {kind}: expected {of_kind(kind) or 'no options'}, found {' '.join(unknown)}"
        )


def run(arguments):
    from . import draw, expect_format

    expect_format(arguments.output)
    given = given_options(arguments)
    expect_options(arguments.kind, given)
    subjects = [open_subject(path, arguments.smooth) for _, path in arguments.files]
    labels = captions(arguments.files)
    draw(subjects, arguments.kind, labels=labels, output=arguments.output, dpi=arguments.dpi, **given)
    print(arguments.output)


def guarded(job, *arguments):
    """Runs a command's job: an error of the library is one line and its status, as of the command `bsdf`."""
    warnings.showwarning = lambda message, *_, **__: print(f"warning: {message}", file=sys.stderr)
    try:
        job(*arguments)
    except bsdfkit.Error as error:
        print(f"bsdf: {error}", file=sys.stderr)
        return next(status for kind, status in STATUSES if isinstance(error, kind))
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except KeyboardInterrupt:
        return 130
    return 0


def main(words=None):
    return guarded(run, parser().parse_args(words))
