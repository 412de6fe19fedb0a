"""The light of incident directions in one plane through the normal, in polar coordinates."""

import numpy as np

from .. import angles
from .._errors import ArgumentError
from . import _style
from ._disk import degrees, text, unit
from ._subject import finite, nearest_points, quantity, side_of

#: Points this near to the plane are drawn in it.
NEAR_DEGREES = 2.0


def draw(
    figure,
    subjects,
    *,
    incident=((30, 0),),
    plane=None,
    decades=4.0,
    linear=False,
    cosine=False,
    step_degrees=0.25,
):
    """Polar curves of f in a plane through the normal, reflection above and transmission below.

    Angles count from the normal of the side: to the right where a mirror sends light, to the left where it comes
    from. Measured points within 2 degrees of the plane are dots.

    Args:
        incident: (theta, phi) in degrees, or a list of them: a curve each.
        plane: Azimuth of the plane in degrees; None: the plane of incidence of each.
        decades: Decades from the rim to the middle.
        linear: The radius is f, from 0, instead of its logarithm.
        cosine: f · cos θₒ (cosine-corrected) instead of f.
        step_degrees: Between the directions of a curve.
    """
    incident = _several(incident)
    _style.expect_between("decades", decades, 0.1, 30)
    _style.expect_between("step_degrees", step_degrees, 0.01, 30)
    alphas = np.radians(np.arange(-180.0, 180.0 + 0.5 * step_degrees, step_degrees))
    curves = []
    for subject in subjects:
        for pair in incident:
            curves += _curves(subject, pair, plane, alphas, cosine, len(subjects) > 1, len(incident) > 1)
    known = [c["f"] for c in curves]
    top = max((np.nanmax(f, initial=0.0) for f in known), default=0.0)
    if not top > 0:
        raise ArgumentError("nothing to draw: no light is scattered in that plane")
    radius = _radius(top, decades, linear)
    whole = any(np.any(np.isfinite(c["f"]) & (np.abs(c["alpha"]) > 0.5 * np.pi + 1e-9)) for c in curves)
    figure = _style.figure(figure, 5.6, 6.2 if whole else 3.9)
    ax = figure.subplots()
    _axes(ax, whole, top, decades, linear)
    for k, curve in enumerate(curves):
        colour = _style.LINES[k % len(_style.LINES)]
        r = radius(curve["f"])
        places = r * np.sin(curve["alpha"]), r * np.cos(curve["alpha"])
        if curve["dots"]:
            ax.plot(*places, ".", ms=2.5, color=colour, label=curve["label"], rasterized=True, mec="none", zorder=4)
        else:
            ax.plot(*places, color=colour, ls=_style.DASHES[k % len(_style.DASHES)], label=curve["label"], zorder=4)
    for k, pair in enumerate(incident):
        _light(ax, pair, plane, _style.LINES[k % len(_style.LINES)] if len(subjects) == 1 else _style.INK)
    side = side_of(unit(incident[0]))
    name = "BRDF above, BTDF below (1/sr)" if whole else quantity(side, side)
    name = name.replace(" (1/sr)", " · cos θₒ (1/sr)") if cosine else name
    # A legend of several incidences of one file does not name it.
    ax.set_title(f"{subjects[0].label}: {name}" if len(subjects) == 1 and len(incident) > 1 else name, pad=8)
    where = f"plane of azimuth {plane:g}°" if plane is not None else "plane of incidence"
    handles, labels = ax.get_legend_handles_labels()
    _style.legend(figure, handles, labels, title=where, title_fontsize=8)
    return figure


def _several(incident):
    """A list of pairs of angles, of one or of many."""
    pairs = list(incident)
    if len(pairs) == 2 and not any(np.iterable(p) for p in pairs):
        pairs = [tuple(pairs)]
    for pair in pairs:
        unit(pair)
    if not pairs:
        raise ArgumentError("incident: expected at least one direction, found none")
    return [tuple(float(a) for a in pair) for pair in pairs]


def _in_plane(azimuth, alphas):
    """Directions at angles from the front normal, in the plane of an azimuth; positive ones are away from it."""
    turned = np.radians(azimuth)
    sin = np.sin(alphas)
    return np.stack([-sin * np.cos(turned), -sin * np.sin(turned), np.cos(alphas)], axis=-1)


def _curves(subject, pair, plane, alphas, cosine, name_subject, name_light):
    wi = unit(pair)
    words = [subject.label] if name_subject or not name_light else []
    if subject.is_measured:
        return _dots(subject, wi, plane, cosine, words)
    azimuth = pair[1] if plane is None else plane
    wo = _in_plane(azimuth, alphas)
    f = finite(subject.f(wi, wo)) * (np.abs(wo[:, 2]) if cosine else 1.0)
    scattered = {s for i, s in subject.pairs() if i == side_of(wi)}
    for side, there in (("front", wo[:, 2] > 0), ("back", wo[:, 2] <= 0)):
        if side not in scattered:
            f[there] = np.nan
    # Exactly at the horizon nothing is scattered: the two sides are apart.
    f[np.abs(wo[:, 2]) < 1e-9] = np.nan
    if name_light or not name_subject:
        words.append(degrees(*pair))
    return [{"alpha": alphas, "f": f, "dots": False, "label": ", ".join(words)}]


def _dots(subject, wi, plane, cosine, words):
    found = []
    for measurement in subject.what:
        if measurement.incident != side_of(wi):
            continue
        own, wo, f = nearest_points(measurement, wi)
        theta, phi = (round(float(a), 1) for a in angles(own))
        azimuth = np.radians(phi if plane is None else plane)
        across = wo[:, 0] * -np.sin(azimuth) + wo[:, 1] * np.cos(azimuth)
        along = -(wo[:, 0] * np.cos(azimuth) + wo[:, 1] * np.sin(azimuth))
        near = np.abs(np.degrees(np.arcsin(np.clip(across, -1, 1)))) <= NEAR_DEGREES
        f = finite(f) * (np.abs(wo[:, 2]) if cosine else 1.0)
        label = ", ".join([*words, f"measured at {degrees(theta, phi)}"])
        found.append({"alpha": np.arctan2(along, wo[:, 2])[near], "f": f[near], "dots": True, "label": label})
    return found


def _radius(top, decades, linear):
    if linear:
        return lambda f: f / top
    with_none = lambda f: np.log10(np.where(f > 0, f, np.nan) / top) / decades + 1.0  # noqa: E731
    return lambda f: np.clip(np.nan_to_num(with_none(f), nan=0.0), 0.0, None) + np.where(np.isnan(f), np.nan, 0.0)


def _axes(ax, whole, top, decades, linear):
    """Rings of f and spokes of angles, a half or a whole circle."""
    ax.set_aspect("equal")
    ax.set_axis_off()
    ax.set_xlim(-1.16, 1.16)
    ax.set_ylim(-1.14 if whole else -0.13, 1.12)
    if linear:
        at = np.linspace(0.0, 1.0, 5)[1:]
        words = [_style.number(float(f"{a * top:.3g}")) for a in at]
    else:
        values = _style.decades_between(top / 10.0**decades, top)
        at = [np.log10(v / top) / decades + 1.0 for v in values]
        words = [_style.number(v) for v in values]
    turn = np.linspace(-np.pi if whole else -0.5 * np.pi, np.pi if whole else 0.5 * np.pi, 361)
    for r, word in [*((r, w) for r, w in zip(at, words) if 0.08 < r < 0.999), (1.0, None)]:
        rim = word is None
        ax.plot(
            r * np.sin(turn),
            r * np.cos(turn),
            color=_style.FAINT if rim else _style.HAIR,
            lw=0.8 if rim else 0.5,
            zorder=2,
        )
        if word:
            # Beside the base line of the side that light comes from.
            text(ax, -r, -0.05, word, size=7)
    for alpha in range(-90, 91, 30) if not whole else range(-150, 181, 30):
        sin, cos = np.sin(np.radians(alpha)), np.cos(np.radians(alpha))
        ax.plot(
            [0, sin],
            [0, cos],
            color=_style.FAINT if abs(alpha) == 90 else _style.HAIR,
            lw=0.7 if abs(alpha) == 90 else 0.5,
            zorder=2,
        )
        text(ax, 1.08 * sin, 1.06 * cos, f"{abs(alpha)}°", size=8, halo=False)


def _light(ax, pair, plane, colour):
    """An arrow along the incident light, where it is in the plane."""
    theta, phi = pair
    turned = 0.0 if plane is None else np.cos(np.radians(phi - plane))
    if plane is not None and abs(abs(turned) - 1.0) > 1e-6:
        return
    sense = -1.0 if plane is None or turned > 0 else 1.0
    at = sense * np.radians(theta)
    sin, cos = np.sin(at), np.cos(at)
    ax.annotate(
        "",
        xy=(0.74 * sin, 0.74 * cos),
        xytext=(sin, cos),
        zorder=5,
        arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 1.6, "shrinkA": 0, "shrinkB": 0},
    )
