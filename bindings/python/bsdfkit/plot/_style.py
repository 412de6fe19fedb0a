"""How all pictures look: type, colours, sizes, and how they are written."""

import math
import numbers
import os
import tempfile
from pathlib import Path

from .._errors import ArgumentError, IoError

try:
    import matplotlib
    from matplotlib.colors import LogNorm, Normalize, SymLogNorm
    from matplotlib.figure import Figure
    from matplotlib.ticker import MaxNLocator, NullFormatter
except ImportError:
    raise ImportError(
        "pictures: expected the package matplotlib, found none: pip install 'bsdfkit[plot]'"
    ) from None

import numpy as np

INK = "#1a1a1a"
FAINT = "#6b6b6b"
HAIR = "#b8b8b8"
PAPER = "#ffffff"
UNKNOWN = "#e8e8e8"

#: Lines that the colour-blind tell apart. [Okabe and Ito 2008]
LINES = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000"]
#: And that a printer in black tells apart.
DASHES = ["-", (0, (5, 1.5)), (0, (1.5, 1.2)), (0, (6, 1.5, 1.5, 1.5)), (0, (8, 2)), (0, (3, 1)), "-."]

#: Values: lightness rises evenly, for every eye and in grey.
VALUES = "viridis"
#: Errors and shares, told from values at a glance.
ERRORS = "cividis"
#: Differences: orange to purple, white is none.
DIFFERENCES = "PuOr_r"

RC = {
    # matplotlib brings it along; a reader of SVG without it shows another one without serifs.
    "font.family": ["sans-serif"],
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 9.0,
    "mathtext.fontset": "dejavusans",
    "axes.titlesize": 9.5,
    "axes.titleweight": "regular",
    "axes.labelsize": 9.0,
    "axes.edgecolor": FAINT,
    "axes.labelcolor": INK,
    "axes.titlecolor": INK,
    "axes.linewidth": 0.7,
    "axes.grid": False,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "grid.color": HAIR,
    "grid.linewidth": 0.5,
    "xtick.color": FAINT,
    "ytick.color": FAINT,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "legend.frameon": False,
    "legend.fontsize": 8.0,
    "lines.linewidth": 1.4,
    "figure.facecolor": PAPER,
    "figure.dpi": 150,
    "savefig.dpi": 150,
    "text.color": INK,
    "text.usetex": False,
    # Names of materials hold dollars, too; what is mathematics here is written in Unicode.
    "text.parse_math": False,
    "svg.fonttype": "none",
    "svg.hashsalt": "bsdfkit",
}

FORMATS = ("png", "svg")


def style():
    """The context in which pictures are drawn and written."""
    return matplotlib.rc_context(RC)


def figure(given, width, height, layout="compressed"):
    """The figure to draw on: the caller's, or a new one of that size in inches.

    It is none of pyplot's, so that nothing has to be closed.
    """
    if given is not None:
        return given
    return Figure(figsize=(width, height), layout=layout)


def expect_between(name, value, least, most):
    """Raises:
    ArgumentError: ``value`` is no number between both.
    """
    if not (isinstance(value, numbers.Real) and least <= value <= most):
        raise ArgumentError(f"{name}: expected {least:g} to {most:g}, found {value!r}")


def values_scale(values, decades, linear=False):
    """One scale for several arrays of values: what is not finite is passed over.

    The top is what a ten-thousandth of the brightest array exceeds. A logarithmic scale begins at what a fiftieth of
    the darkest does not reach, but at most ``decades`` below the top.
    """
    expect_between("decades", decades, 0.1, 30)
    low, high = np.inf, 0.0
    for array in values:
        known = np.asarray(array)[np.isfinite(array)]
        if known.size:
            least, most = np.quantile(known, [0.02, 0.9999])
            low, high = min(low, least), max(high, most)
    if not high > 0:
        raise ArgumentError("nothing to draw: no light is scattered to that side from that direction")
    if linear:
        return Normalize(0.0, high)
    return LogNorm(min(max(low, high / 10.0**decades), 0.5 * high), high, clip=True)


def difference_scale(difference, decades=2.0):
    """Symmetric about 0: linear up to ``decades`` below the largest difference, logarithmic beyond."""
    most = np.nanmax(np.abs(difference), initial=0.0)
    most = most if most > 0 else 1.0
    return SymLogNorm(most / 10.0**decades, linscale=0.5, vmin=-most, vmax=most, base=10)


def decades_between(low, high):
    """Powers of ten within a range."""
    return [10.0**k for k in range(math.ceil(math.log10(low) - 1e-9), math.floor(math.log10(high) + 1e-9) + 1)]


def log_ticks(low, high):
    """Where a logarithmic scale is named: decades, or 1, 2, 5, or every digit, whichever are three at least."""
    ticks = []
    for digits in ((1,), (1, 2, 5), range(1, 10)):
        decades = decades_between(low / 10, high)
        ticks = [float(f"{d * m:.6g}") for d in decades for m in digits if low <= d * m <= high]
        if len(ticks) >= 3:
            return ticks
    # Less than three digits apart: even steps.
    return [float(f"{t:.6g}") for t in MaxNLocator(4).tick_values(low, high) if low <= t <= high]


def clipped(text, most=48):
    """A title that fits above a panel: of a long one the middle is left out."""
    text = str(text)
    if len(text) <= most:
        return text
    return f"{text[: most - most // 3 - 1]}…{text[-(most // 3) :]}"


#: Letters of a legend that fit on an inch, and what a line's sample takes of them.
LETTERS, SAMPLE = 16, 6


def legend(figure, handles, labels, **options):
    """Under the picture, in as many columns as fit."""
    longest = SAMPLE + max(map(len, labels))
    columns = max(1, min(len(handles), int(LETTERS * figure.bbox.width / figure.dpi) // longest))
    return figure.legend(handles, labels, loc="outside lower center", ncols=columns, **options)


_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def number(value):
    """A number of few digits as people write it: 0.02, 300, −1, 2·10⁻⁵."""
    if value == 0:
        return "0"
    sign, size = ("−" if value < 0 else ""), abs(value)
    power = math.floor(math.log10(size) + 1e-9)
    if -4 < power < 5:
        return sign + f"{size:.6g}"
    first = size / 10.0**power
    factor = "" if abs(first - 1) < 1e-6 else f"{first:.3g}·"
    return f"{sign}{factor}10{str(power).translate(_RAISED)}"


def colorbar(figure, image, axes, label, **where):
    """A bar whose numbers are written as here."""
    norm = image.norm
    extend = "max"
    if isinstance(norm, LogNorm):
        extend = "both"
    elif isinstance(norm, SymLogNorm):
        extend = "neither"
    bar = figure.colorbar(image, ax=axes, extend=extend, **{"shrink": 0.82, "pad": 0.02, "aspect": 24, **where})
    bar.set_label(label)
    if isinstance(norm, LogNorm):
        bar.set_ticks(ticks := log_ticks(norm.vmin, norm.vmax), labels=[number(t) for t in ticks])
        # Without, matplotlib names the steps between in formulas where a decade does not fit.
        bar.ax.yaxis.set_minor_formatter(NullFormatter())
    elif isinstance(norm, SymLogNorm):
        most = norm.vmax
        steps = [d for d in decades_between(norm.linthresh * 0.999, most)]
        ticks = [-t for t in steps[::-1]] + [0.0] + steps
        bar.set_ticks(ticks, labels=[number(t) for t in ticks])
        bar.ax.minorticks_off()
    return bar


def save(figure, path, dpi=None):
    """Writes PNG or SVG, as the name ends: an existing file is replaced whole or not at all.

    Args:
        figure: A matplotlib figure.
        path: Ends in .png or .svg.
        dpi: Pixels an inch, 150 by default.

    Raises:
        ArgumentError: Another suffix.
        IoError: The file cannot be written.
    """
    path = Path(path)
    kind = expect_format(path)
    metadata = {"Date": None, "Creator": "bsdfkit"} if kind == "svg" else {"Software": "bsdfkit"}

    def write(file):
        with style():
            figure.savefig(file, format=kind, metadata=metadata, dpi=dpi or RC["savefig.dpi"])

    replace(path, write)


def expect_format(path):
    """ "png" or "svg".

    Raises:
        ArgumentError: Another suffix.
    """
    kind = Path(path).suffix[1:].lower()
    if kind not in FORMATS:
        raise ArgumentError(f"{path}: expected a name ending in .png or .svg")
    return kind


def replace(path, write):
    """Calls ``write`` with a binary file that takes the place of ``path`` once it is whole.

    Raises:
        IoError: It cannot be written; what was there stays.
    """
    path, temporary = Path(path), None
    try:
        handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
        with os.fdopen(handle, "wb") as file:
            write(file)
        # mkstemp's file is its owner's alone.
        mask = os.umask(0)
        os.umask(mask)
        os.chmod(temporary, 0o666 & ~mask)
        os.replace(temporary, path)
        temporary = None
    except OSError as error:
        raise IoError(f"{path}: {error.strerror or error}") from None
    finally:
        if temporary is not None:
            os.unlink(temporary)
