"""How much light is scattered: directional-hemispherical reflectance and transmittance."""

import numpy as np

from .. import Components, direction
from .._errors import ArgumentError
from . import _style
from ._subject import SIDES, other


def draw(figure, subjects, *, azimuths=None, step_degrees=None):
    """Directional-hemispherical reflectance and transmittance over the incident angle, a panel for each side that is
    lit.

    Lines of a BSDF; dots of a measurement, hollow where the total rests on less than nine tenths of the hemisphere.

    Args:
        azimuths: Incident azimuths in degrees; None: 0, and 90 where it makes a difference.
        step_degrees: Between incident angles; None: 2 of an interpolant, which takes long and is smooth, and 0.25 of
            what is stored, where the steps between patches and leaves are seen.
    """
    if step_degrees is not None:
        _style.expect_between("step_degrees", step_degrees, 0.1, 90)
    lit = [side for side in SIDES if any(i == side for s in subjects for i, _ in s.pairs())]
    if not lit:
        raise ArgumentError("nothing to draw: nothing is scattered")
    figure = _style.figure(figure, 0.6 + 4.4 * len(lit), 3.7)
    axes = figure.subplots(1, len(lit), squeeze=False, sharey=True)[0]
    handles = {}
    # A curve has the same colour on both sides: the legend names it once.
    order = {}
    for ax, side in zip(axes, lit):
        for subject in subjects:
            ways = [other(side) != s for i, s in subject.pairs() if i == side]
            for reflected in sorted(set(ways), reverse=True):
                scattered = side if reflected else other(side)
                name = "reflectance" if reflected else "transmittance"
                k = order.setdefault((id(subject), name), len(order))
                colour = _style.LINES[k % len(_style.LINES)]
                _series(ax, subject, side, scattered, name, azimuths, step_degrees, colour, len(subjects) > 1)
        ax.axhline(1.0, color=_style.HAIR, lw=0.8, zorder=0)
        ax.set_xlim(0, 90)
        ax.set_xticks(range(0, 91, 15), [f"{t}°" for t in range(0, 91, 15)])
        ax.set_ylim(0, max(1.05, ax.get_ylim()[1]))
        ax.grid(True, axis="y", alpha=0.6)
        ax.set_xlabel(f"incident angle θᵢ from the {side} normal")
        handles.update({h.get_label(): h for h in ax.get_lines() + ax.collections if not h.get_label().startswith("_")})
    axes[0].set_ylabel("directional-hemispherical value")
    if len(subjects) == 1:
        figure.suptitle(subjects[0].label, size=9.5)
    _style.legend(figure, list(handles.values()), list(handles))
    return figure


def _series(ax, subject, side, scattered, name, azimuths, step, colour, name_subject):
    prefix = f"{subject.label}, {name}" if name_subject else name
    if subject.is_measured:
        for m in (m for m in subject.what if (m.incident, m.scattered) == (side, scattered)):
            theta, value, told = totals_of(m)
            for hollow in (False, True):
                these = told != hollow
                if np.any(these):
                    face = "none" if hollow else colour
                    label = f"{prefix}, {'of the part seen' if hollow else 'measured'}"
                    ax.plot(
                        theta[these],
                        value[these],
                        "o",
                        ms=4,
                        mfc=face,
                        mec=colour,
                        label=label,
                        zorder=3,
                        clip_on=False,
                    )
        return
    step = step or (2.0 if subject.is_interpolant else 0.25)
    theta = np.arange(0.0, 90.0 + 1e-9, step)
    theta[-1] = min(theta[-1], 89.9)
    way = Components.REFLECTION if scattered == side else Components.TRANSMISSION
    curve = lambda phi: subject.what.directional_hemispherical(  # noqa: E731
        direction(theta if side == "front" else 180.0 - theta, phi), components=way
    )
    drawn = [(phi, curve(phi)) for phi in (azimuths if azimuths is not None else (0.0, 90.0))]
    if azimuths is None and np.allclose(drawn[0][1], drawn[1][1], atol=0.005):
        drawn = drawn[:1]
    for n, (phi, values) in enumerate(drawn):
        label = prefix if len(drawn) == 1 and azimuths is None else f"{prefix}, φᵢ = {phi:g}°"
        ax.plot(theta, values, color=colour, ls=_style.DASHES[n % len(_style.DASHES)], label=label)


def totals_of(measurement):
    """(theta from the normal of its side, total, whether enough was seen) of every incidence."""
    quality = measurement.quality()
    y = measurement.luminance_channel
    theta, value, told = [], [], []
    for i in quality["incidences"]:
        total = i["hemispherical"][y]
        total = i["hemispherical_at_least"][y] if total is None else total
        theta.append(min(i["theta_degrees"], 180.0 - i["theta_degrees"]))
        value.append(np.nan if total is None else total)
        told.append(not i["extrapolated"])
    return np.array(theta), np.array(value, dtype=float), np.array(told)
