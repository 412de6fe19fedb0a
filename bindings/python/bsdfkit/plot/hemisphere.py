"""Where the light of one incident direction goes: false colours over the hemisphere of scattered directions."""

import numpy as np

from . import _style
from ._disk import Disk, degrees, legend_of_light, unit
from ._subject import finite, name_of, quantity, scattered_side, side_of


def draw(
    figure, subjects, *, incident=(30, 0), way=None, projection="equal-area", decades=4.0, linear=False,
    cosine=False, pixels=420,
):
    """False colours over the hemisphere of scattered directions, one panel a subject, all of one scale.

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
    wo = disk.pixels(pixels, scattered)
    weight = np.abs(wo[..., 2]) if cosine else 1.0
    values = [finite(s.f(wi, wo)) * weight for s in subjects]
    norm = _style.values_scale(values, decades, linear)
    figure = _style.figure(figure, 0.6 + 3.5 * len(subjects), 4.25)
    axes = figure.subplots(1, len(subjects), squeeze=False)[0]
    for ax, subject, shown in zip(axes, subjects, values):
        disk.axes(ax, title=subject.label, side=scattered)
        image = disk.image(ax, shown, norm=norm, cmap=_style.VALUES)
        disk.mark_light(ax, wi, transmission=side != scattered)
    _style.colorbar(figure, image, list(axes), quantity(side, scattered, cosine))
    figure.suptitle(f"{name_of(side, scattered)}, light from {degrees(*incident)}", size=9.5)
    legend_of_light(figure, transmission=side != scattered, loc="outside lower center")
    return figure
