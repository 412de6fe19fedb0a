"""Pictures of BSDFs, interpolants and measurements, on matplotlib (`pip install 'bsdfkit[plot]'`).

    >>> import bsdfkit
    >>> bsdf = bsdfkit.open("fabric.xml")
    >>> bsdf.plot("hemisphere", incident=(30, 0), output="fabric.png")

Each kind of picture is a file of its own, whose `draw` says what it takes. Values come from the library; nothing is
computed here but places on paper.
"""

import importlib
import inspect

from .._errors import ArgumentError
from ._style import expect_format, save, style
from ._subject import subjects_of

#: Kinds of pictures, and what each shows.
KINDS = {
    "hemisphere": "where the light of one incident direction goes, in false colours",
    "slice": "polar curves in a plane through the normal",
    "lobe": "the light of one incident direction as a surface in space",
    "hemispherical": "directional-hemispherical reflectance and transmittance",
    "patches": "the patches of a Klems matrix",
    "leaves": "the leaves of a tensor tree",
    "points": "measured points over an interpolant, with residuals",
    "mesh": "measured incidences, their mesh, and the families of peaks on it",
    "compare": "two files side by side, and their difference",
}

__all__ = ["KINDS", "draw", "options", "save"]


def _drawing(kind):
    if kind not in KINDS:
        raise ArgumentError(f"kind: expected one of {', '.join(KINDS)}, found {kind!r}")
    return importlib.import_module(f".{kind}", __name__).draw


def options(kind):
    """Names and usual values of what a kind of picture takes."""
    parameters = list(inspect.signature(_drawing(kind)).parameters.values())
    return {p.name: p.default for p in parameters if p.kind is p.KEYWORD_ONLY}


def draw(subjects, kind="hemisphere", *, labels=None, figure=None, output=None, dpi=None, **given):
    """Draws one picture.

    Args:
        subjects: A `Bsdf`, an `Interpolant`, a `Measurement` (or all of one specimen), or a list of them.
        kind: One of `KINDS`.
        labels: Words under each subject; None: the name that its file gives.
        figure: A matplotlib figure or subfigure to draw on; None: a new one.
        output: A file to write, too: .png or .svg; replaced whole or not at all.
        dpi: Pixels an inch of that file, 150 by default.
        given: What that kind takes; `options` lists it.

    Returns:
        The matplotlib figure.

    Raises:
        ArgumentError: There is nothing of that kind to draw of the subjects, or an option makes no sense.
        IoError: The file cannot be written.
    """
    drawing, known = _drawing(kind), options(kind)
    unknown = [name for name in given if name not in known]
    if unknown:
        raise ArgumentError(f"{kind}: expected options {', '.join(known)}, found {', '.join(unknown)}")
    if output is not None:
        expect_format(output)
    with style():
        drawn = drawing(figure, subjects_of(subjects, labels), **given)
    if output is not None:
        save(drawn, output, dpi)
    return drawn
