"""Stored cells as coloured patches on the disk: what Klems matrices and tensor trees have in common."""

import numpy as np
from matplotlib.collections import PolyCollection

from .._errors import ArgumentError
from . import _style
from ._disk import Disk, degrees, legend_of_light, unit
from ._subject import name_of, quantity, scattered_side, side_of


def draw_cells(figure, subjects, incident, way, projection, decades, linear, *, form, number=None, line=0.3):
    """One panel a subject; `form` says which representations have cells of that kind, and what they are called."""
    disk, wi = Disk(projection), unit(incident)
    side = side_of(wi)
    scattered = scattered_side(subjects, side, way)
    cells = [_cells_of(s, wi, side, scattered, form) for s in subjects]
    norm = _style.values_scale([values for *_, values in cells], decades, linear)
    figure = _style.figure(figure, 0.6 + 4.1 * len(subjects), 4.9)
    axes = figure.subplots(1, len(subjects), squeeze=False)[0]
    for ax, subject, (middles, outlines, numbers, values) in zip(axes, subjects, cells):
        disk.axes(ax, title=f"{subject.label}: {len(values)} {form[1]}", side=scattered, rings=False)
        drawn = PolyCollection(
            disk.place(outlines),
            array=values,
            norm=norm,
            cmap=_style.VALUES,
            edgecolors="white",
            linewidths=line if len(values) < 3000 else 0.0,
            zorder=1,
        )
        # Leaves by the thousand would make a vector file of megabytes.
        drawn.set_rasterized(len(values) > 2000)
        ax.add_collection(drawn)
        if number is not None:
            number(ax, disk.place(middles), numbers, norm(values))
        disk.mark_light(ax, wi, transmission=side != scattered)
    _style.colorbar(figure, drawn, list(axes), quantity(side, scattered))
    figure.suptitle(f"{name_of(side, scattered)}, light from {degrees(*incident)}", size=9.5)
    legend_of_light(figure, transmission=side != scattered, loc="outside lower center")
    return figure


def _cells_of(subject, wi, side, scattered, form):
    forms, name = form
    if subject.is_measured:
        subject.f(wi, wi)
    pairs = [(side, scattered)] + ([(scattered, side)] if side != scattered else [])
    stored = [c.representation for c in subject.what.components if (c.incident, c.scattered) in pairs]
    if not any(r in forms for r in stored):
        found = f"the form {', '.join(stored)}" if stored else "no stored component"
        raise ArgumentError(
            (
                f"{subject.label}: expected {name} of the {name_of(side, scattered)}, found {found}: `tabulate` or "
                f"`bsdf convert` makes them"
            )
        )
    middles, outlines, numbers = subject.what.cells(list(wi), scattered)
    if not len(numbers):
        raise ArgumentError(f"{subject.label}: expected {name} for that incident direction, found none")
    return middles, outlines, numbers, np.asarray(subject.what.eval(wi, middles))
