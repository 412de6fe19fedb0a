"""Two files side by side, and what is between them."""

import numpy as np

from .._errors import ArgumentError
from . import _style
from ._disk import Disk, degrees, legend_of_light, unit
from ._subject import finite, name_of, quantity, scattered_side, side_of


def draw(figure, subjects, *, incident=(30, 0), way=None, projection="equal-area", decades=4.0, pixels=420):
    """Two subjects in false colours of one scale, and the second less the first.

    The caption states L1 = Σ|f₂ − f₁| / Σ f₁ over projected solid angles: half of it is the share of the light in a
    wrong place.

    Args:
        incident: (theta, phi) in degrees, away from the surface.
        way: "reflection" or "transmission"; None: reflection where there is any.
        projection: As of "hemisphere".
        decades: Most decades of the scale.
        pixels: Along a side of a panel.
    """
    if len(subjects) != 2:
        raise ArgumentError(f"compare: expected two files, found {len(subjects)}")
    disk, wi = Disk(projection), unit(incident)
    side = side_of(wi)
    scattered = scattered_side(subjects, side, way)
    wo = disk.pixels(pixels, scattered)
    first, second = (finite(s.f(wi, wo)) for s in subjects)
    norm = _style.values_scale([first, second], decades)
    difference = second - first
    figure = _style.figure(figure, 11.4, 4.3)
    axes = figure.subplots(1, 3)
    for ax, subject, values in zip(axes, subjects, (first, second)):
        disk.axes(ax, title=subject.label, side=scattered)
        image = disk.image(ax, values, norm=norm, cmap=_style.VALUES)
        disk.mark_light(ax, wi, transmission=side != scattered)
    _style.colorbar(figure, image, list(axes[:2]), quantity(side, scattered))
    l1 = distance(*subjects, wi, scattered)
    disk.axes(axes[2], title=f"second − first: L1 = {l1:.3g}", side=scattered)
    drawn = disk.image(axes[2], difference, norm=_style.difference_scale(difference), cmap=_style.DIFFERENCES)
    _style.colorbar(figure, drawn, axes[2], "difference (1/sr)")
    figure.suptitle(f"{name_of(side, scattered)}, light from {degrees(*incident)}", size=9.5)
    legend_of_light(figure, transmission=side != scattered, loc="outside lower center")
    return figure


def distance(first, second, wi, scattered, pixels=512):
    """L1 = Σ|f₂ − f₁| / Σ f₁ over pixels of equal projected solid angle."""
    wo = Disk("cosines").pixels(pixels, scattered)
    wo = wo[np.isfinite(wo[..., 0])]
    f, g = finite(first.f(wi, wo)), finite(second.f(wi, wo))
    total = np.nansum(f)
    return float(np.nansum(np.abs(g - f)) / total) if total > 0 else float("nan")
