"""The light of one incident direction as a surface in space."""

import matplotlib
import numpy as np
from matplotlib.cm import ScalarMappable

from .. import direction
from . import _style
from ._disk import degrees, unit
from ._subject import finite, name_of, quantity, side_of


def draw(
    figure,
    subjects,
    *,
    incident=(30, 0),
    decades=3.0,
    linear=False,
    cosine=False,
    steps=(100, 240),
    elevation=22.0,
    azimuth=None,
):
    """Surfaces whose distance from the specimen is f, one panel a subject, reflection and transmission.

    Args:
        incident: (theta, phi) in degrees, away from the surface.
        decades: Decades from the outermost point to the specimen.
        linear: The distance is f instead of its logarithm.
        cosine: f · cos θₒ (cosine-corrected) instead of f.
        steps: Of the polar angle and of the azimuth, a hemisphere.
        elevation: Of the eye above the specimen, degrees.
        azimuth: Of the eye, degrees; None: beside the plane of incidence.
    """
    wi = unit(incident)
    for count in steps:
        _style.expect_between("steps", count, 4, 720)
    side = side_of(wi)
    shells = [_shells(s, wi, steps, cosine) for s in subjects]
    norm = _style.values_scale([f for subject in shells for _, f in subject], decades, linear)
    top = norm.vmax
    several = len({s for subject in subjects for i, s in subject.pairs() if i == side}) > 1
    figure = _style.figure(figure, 0.8 + 4.3 * len(subjects), 4.9 if several else 4.1)
    up = [w[0, 0, 2] > 0 for subject in shells for w, _ in subject] + [wi[2] > 0]
    axes = [
        figure.add_subplot(1, len(subjects), k + 1, projection="3d", computed_zorder=False)
        for k in range(len(subjects))
    ]
    reach = (0.0 if all(up) else -1.0, 1.0 if any(up) else 0.0)
    for ax, subject, surfaces in zip(axes, subjects, shells):
        _scene(ax, subject.label, wi, elevation, incident[1] - 62.0 if azimuth is None else azimuth, reach)
        for w, f in surfaces:
            shown = np.where(np.isfinite(f), f, 0.0)
            r = shown / top if linear else np.clip(np.log10(np.maximum(shown, 1e-300) / top) / decades + 1.0, 0.0, None)
            r = np.minimum(r, 1.15)
            colours = matplotlib.colormaps[_style.VALUES](norm(np.maximum(shown, norm.vmin if not linear else 0.0)))
            ax.plot_surface(
                *(r[..., None] * w).transpose(2, 0, 1),
                facecolors=colours,
                rcount=steps[0] + 1,
                ccount=steps[1] + 1,
                linewidth=0,
                edgecolor="none",
                antialiased=False,
                shade=True,
                rasterized=True,
                zorder=2,
            )
    sides = {name_of(side, s) for subject in subjects for i, s in subject.pairs() if i == side}
    label = (
        ("BSDF · cos θₒ (1/sr)" if cosine else "BSDF (1/sr)")
        if several
        else quantity(side, next(s for subject in subjects for i, s in subject.pairs() if i == side), cosine)
    )
    _style.colorbar(figure, ScalarMappable(norm, _style.VALUES), axes, label, shrink=0.7)
    kind = "distance from the specimen: " + ("f" if linear else f"log f over {decades:g} decades")
    figure.suptitle(f"{' and '.join(sorted(sides))}, light from {degrees(*incident)}\n{kind}", size=9.5)
    return figure


def _shells(subject, wi, steps, cosine):
    """(directions, f) of each side that light goes to."""
    found = []
    for incident, scattered in subject.pairs():
        if incident != side_of(wi):
            continue
        theta = np.linspace(0.0, 89.9, steps[0] + 1)[:, None]
        w = direction(theta if scattered == "front" else 180.0 - theta, np.linspace(0.0, 360.0, steps[1] + 1))
        found.append((w, finite(subject.f(wi, w)) * (np.abs(w[..., 2]) if cosine else 1.0)))
    return found


def _scene(ax, title, wi, elevation, azimuth, reach):
    """The specimen, its axes, and the light."""
    ax.set_axis_off()
    low, high = reach
    ax.set_box_aspect((2, 2, high - low), zoom=1.3)
    ax.set_xlim(-1, 1)
    ax.set_ylim(-1, 1)
    ax.set_zlim(low, high)
    ax.view_init(elevation, azimuth)
    ax.set_title(_style.clipped(title), y=1.0)
    turn = np.linspace(0, 2 * np.pi, 121)
    for r in (0.5, 1.0):
        ax.plot(r * np.cos(turn), r * np.sin(turn), 0 * turn, color=_style.HAIR, lw=0.7, zorder=1)
    for phi in range(0, 360, 90):
        c, s = np.cos(np.radians(phi)), np.sin(np.radians(phi))
        ax.plot([0, c], [0, s], [0, 0], color=_style.HAIR, lw=0.6, zorder=1)
        ax.text(1.12 * c, 1.12 * s, 0, f"{phi}°", size=7, color=_style.FAINT, ha="center", va="center")
    ax.plot([0, 0], [0, 0], reach, color=_style.HAIR, lw=0.6, zorder=1)
    x, y, z = 1.15 * wi
    ax.plot([x, 0], [y, 0], [z, 0], color=_style.LINES[1], lw=1.8, zorder=4)
    ax.plot([x], [y], [z], "o", color=_style.LINES[1], ms=5, zorder=4)
    ax.text(1.1 * x, 1.1 * y, 1.1 * z, "light", size=8, color=_style.LINES[1], ha="center")
