"""Where the light of one incident direction goes: false colours over the hemisphere of scattered directions."""

import numpy as np

from .. import angles
from . import _style
from ._disk import Disk, degrees, dots, legend_of_light, unit
from ._subject import finite, name_of, nearest_points, quantity, scattered_side, side_of


def draw(
    figure,
    subjects,
    *,
    incident=(30, 0),
    way=None,
    projection="equal-area",
    decades=4.0,
    linear=False,
    cosine=False,
    pixels=420,
):
    """False colours over the hemisphere of scattered directions, one panel a subject, all of one scale.

    Of a measurement the points of the nearest incidence, or of its image under the symmetry, are dots.

    Args:
        incident: (theta, phi) in degrees, away from the surface.
        way: "reflection" or "transmission"; None: reflection where there is any.
        projection: "equal-area" (solid angles), "angle" (radius is the polar angle) or "cosines" (direction
            cosines: projected solid angles).
        decades: Most decades of the scale.
        linear: Linear colours from 0 instead of logarithmic ones.
        cosine: f · cos θₒ (cosine-corrected) instead of f.
        pixels: Along a side of a panel.
    """
    disk, wi = Disk(projection), unit(incident)
    side = side_of(wi)
    scattered = scattered_side(subjects, side, way)
    panels = [_panel(s, wi, side, scattered, disk, pixels, cosine) for s in subjects]
    values = [values for _, values, _ in panels]
    norm = _style.values_scale(values, decades, linear)
    figure = _style.figure(figure, 0.6 + 3.5 * len(subjects), 4.25)
    axes = figure.subplots(1, len(subjects), squeeze=False)[0]
    for ax, (title, shown, points) in zip(axes, panels):
        disk.axes(ax, title=title, side=scattered)
        if points is None:
            image = disk.image(ax, shown, norm=norm, cmap=_style.VALUES)
            disk.mark_light(ax, wi, transmission=side != scattered)
        else:
            own, wo = points
            image = dots(ax, disk, wo, shown, norm, _style.VALUES)
            disk.mark_light(ax, own, transmission=side != scattered)
    _style.colorbar(figure, image, list(axes), quantity(side, scattered, cosine))
    figure.suptitle(f"{name_of(side, scattered)}, light from {degrees(*incident)}", size=9.5)
    legend_of_light(figure, transmission=side != scattered, loc="outside lower center")
    return figure


def _panel(subject, wi, side, scattered, disk, pixels, cosine):
    """(title, values, None) of pixels, or (title, values, (wi, wo)) of points."""
    if subject.is_measured:
        measurement = subject.measurement(side, scattered)
        own, wo, f = nearest_points(measurement, wi)
        theta, phi = (round(float(a), 1) for a in angles(own))
        title = f"{subject.label}, {degrees(theta, phi)}"
        return title, finite(f) * (np.abs(wo[..., 2]) if cosine else 1.0), (own, wo)
    wo = disk.pixels(pixels, scattered)
    return subject.label, finite(subject.f(wi, wo)) * (np.abs(wo[..., 2]) if cosine else 1.0), None
