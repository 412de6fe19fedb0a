"""Measured points over the function that was made of them, and what is left between both."""

import numpy as np

from .. import angles
from .._errors import ArgumentError
from . import _style
from ._disk import Disk, degrees, dots, legend_of_light, unit
from ._subject import finite, name_of, nearest_points, quantity, scattered_side, side_of
from .slice import NEAR_DEGREES, _in_plane


#: Points of more than this touch one another where they are dense.
MOST_RIMMED = 4000


def draw(figure, subjects, *, incident=(30, 0), way=None, projection="equal-area", decades=4.0, pixels=360):
    """A measured incidence over an interpolant: its points on the hemisphere, their residuals, and both in the plane
    of incidence.

    Args:
        incident: (theta, phi) in degrees: the nearest measured incidence, or its image under the symmetry, is drawn.
        way: "reflection" or "transmission"; None: reflection where there is any.
        projection: As of "hemisphere".
        decades: Most decades of the scale.
        pixels: Along a side of the false colours.
    """
    measured = [s for s in subjects if s.is_measured]
    fitted = [s for s in subjects if not s.is_measured]
    if len(measured) != 1 or len(fitted) != 1:
        raise ArgumentError(
            f"points: expected one measurement and one interpolant or BSDF, found {len(measured)} and {len(fitted)}"
        )
    (measured,), (fitted,) = measured, fitted
    disk, wi = Disk(projection), unit(incident)
    side = side_of(wi)
    scattered = scattered_side([measured], side, way)
    wi, wo, f = nearest_points(measured.measurement(side, scattered), wi)
    model = fitted.f(wi, wo)

    grid = disk.pixels(pixels, scattered)
    values = finite(fitted.f(wi, grid))
    norm = _style.values_scale([values, finite(f)], decades)
    residual = f - model
    difference = _style.difference_scale(np.quantile(np.abs(residual[np.isfinite(residual)]), [0.0, 0.999]))

    figure = _style.figure(figure, 8.6, 6.6, layout="constrained")
    upper, lower = figure.subfigures(2, 1, height_ratios=[1.35, 1.0])
    left, right = upper.subplots(1, 2)
    disk.axes(left, title="measured points over the interpolant", side=scattered)
    image = disk.image(left, values, norm=norm, cmap=_style.VALUES)
    over = dots(left, disk, wo, finite(f), norm, _style.VALUES)
    # Rims tell points from what lies below them; where points touch they would hide both.
    over.set_edgecolor("white")
    over.set_linewidth(0.15 if len(f) <= MOST_RIMMED else 0.0)
    _style.colorbar(upper, image, left, quantity(side, scattered))
    disk.axes(right, title="residual: measured − interpolant", side=scattered)
    drawn = dots(right, disk, wo, residual, difference, _style.DIFFERENCES)
    _style.colorbar(upper, drawn, right, "residual (1/sr)")
    for ax in (left, right):
        disk.mark_light(ax, wi, transmission=side != scattered)

    legend_of_light(upper, transmission=side != scattered, loc="outside lower center")

    theta, phi = (round(float(a), 1) for a in angles(wi))
    _in_plane_of_incidence(lower, fitted, wi, phi, wo, f, residual, side, scattered, norm)
    figure.suptitle(
        f"{measured.label}: {name_of(side, scattered)}, light from {degrees(theta, phi)}, {len(f)} points", size=9.5
    )
    return figure


def _in_plane_of_incidence(figure, fitted, wi, phi, wo, f, residual, side, scattered, norm):
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=[2.2, 1])
    alphas = np.radians(np.arange(-89.75, 90.0, 0.25))
    up = 1.0 if scattered == "front" else -1.0
    line = _in_plane(phi, alphas) * [1, 1, up]
    curve = finite(fitted.f(wi, line))
    turned = np.radians(phi)
    across = -wo[:, 0] * np.sin(turned) + wo[:, 1] * np.cos(turned)
    along = -(wo[:, 0] * np.cos(turned) + wo[:, 1] * np.sin(turned))
    near = np.abs(np.degrees(np.arcsin(np.clip(across, -1, 1)))) <= NEAR_DEGREES
    at = np.degrees(np.arctan2(along, np.abs(wo[:, 2])))[near]
    above.plot(
        at,
        np.where(f[near] > 0, f[near], np.nan),
        ".",
        ms=3,
        color=_style.LINES[1],
        mec="none",
        label=f"measured within {NEAR_DEGREES:g}° of the plane",
    )
    above.plot(np.degrees(alphas), curve, color=_style.LINES[0], label=fitted.label)
    above.set_yscale("log")
    above.set_ylim(max(norm.vmin * 0.5, np.nanmin(curve[curve > 0], initial=norm.vmax) * 0.5), norm.vmax * 2)
    from matplotlib.ticker import FuncFormatter, NullFormatter

    above.yaxis.set_major_formatter(FuncFormatter(lambda v, _: _style.number(v)))
    above.yaxis.set_minor_formatter(NullFormatter())
    above.set_ylabel(quantity(side, scattered))
    above.legend(loc="upper left")
    below.axhline(0.0, color=_style.HAIR, lw=0.8)
    below.plot(at, residual[near], ".", ms=3, color=_style.LINES[1], mec="none")
    below.set_ylabel("residual (1/sr)")
    below.yaxis.set_major_formatter(FuncFormatter(lambda v, _: _style.number(round(v, 12))))
    below.set_xlim(-90, 90)
    below.set_xticks(range(-90, 91, 30), [f"{abs(t)}°" for t in range(-90, 91, 30)])
    below.set_xlabel(
        "θₒ in the plane of incidence: left of the normal where light comes from, right where a mirror sends it"
    )
    for ax in (above, below):
        ax.grid(True, alpha=0.6)
