"""The light of incident directions in one plane through the normal, in polar coordinates."""

import numpy as np

from .. import angles, direction
from .._errors import ArgumentError
from . import _style
from ._disk import degrees, unit
from ._subject import finite, quantity, side_of

#: Points this near to the plane are drawn in it.
NEAR_DEGREES = 2.0


def draw(
    figure, subjects, *, incident=((30, 0),), plane=None, decades=4.0, linear=False, cosine=False, step_degrees=0.25,
):
    """Polar curves of f in a plane through the normal, reflection above and transmission below.

    Angles count from the normal of the side: to the right where a mirror sends light, to the left where it comes from. Measured points within 2
    degrees of the plane are dots.

    Args:
        incident: (theta, phi) in degrees, or a list of them: a curve each.
        plane: Azimuth of the plane in degrees; None: the plane of incidence of each.
        decades: Decades from the rim to the middle.
        linear: The radius is f, from 0, instead of its logarithm.
        cosine: f · cos θₒ (cosine-corrected) instead of f.
        step_degrees: Between the directions of a curve.
    """
    incident = _several(incident)
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
    figure = _style.figure(figure, 5.6, 5.4 if whole else 3.9)
    ax = figure.add_subplot(projection="polar")
    _axes(ax, whole, top, decades, linear)
    for k, curve in enumerate(curves):
        colour = _style.LINES[k % len(_style.LINES)]
        alpha, r = curve["alpha"], radius(curve["f"])
        if curve["dots"]:
            ax.plot(alpha, r, ".", ms=2.5, color=colour, label=curve["label"], rasterized=True, mec="none")
        else:
            ax.plot(alpha, r, color=colour, ls=_style.DASHES[k % len(_style.DASHES)], label=curve["label"])
    for k, pair in enumerate(incident):
        _light(ax, pair, plane, _style.LINES[k % len(_style.LINES)] if len(subjects) == 1 else _style.INK)
    sides = {side_of(unit(p)) for p in incident}
    side = "front" if "front" in sides else "back"
    name = "BRDF above, BTDF below" if whole else quantity(side, side, cosine)
    ax.set_title(f"{name}{' · cos θₒ' if whole and cosine else ''}{' (1/sr)' if whole else ''}", pad=8)
    where = f"plane of azimuth {plane:g}°" if plane is not None else "plane of incidence"
    handles, labels = ax.get_legend_handles_labels()
    figure.legend(
        handles, labels, loc="outside lower center", ncols=min(3, len(handles)), title=where, title_fontsize=8,
    )
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
        k, off, rows = measurement.nearest(wi)
        own, (wo, f) = measurement.wi[k], measurement.points(k)
        turn = np.array(rows)
        own = np.append(turn @ own[:2], own[2])
        wo = np.column_stack([wo[:, :2] @ turn.T, wo[:, 2]])
        theta, phi = angles(own)
        azimuth = np.radians(phi if plane is None else plane)
        across = wo[:, 0] * -np.sin(azimuth) + wo[:, 1] * np.cos(azimuth)
        along = -(wo[:, 0] * np.cos(azimuth) + wo[:, 1] * np.sin(azimuth))
        near = np.abs(np.degrees(np.arcsin(np.clip(across, -1, 1)))) <= NEAR_DEGREES
        f = finite(f) * (np.abs(wo[:, 2]) if cosine else 1.0)
        label = ", ".join([*words, f"measured at {degrees(round(theta, 1), round(phi, 1))}"])
        found.append({"alpha": np.arctan2(along, wo[:, 2])[near], "f": f[near], "dots": True, "label": label})
    return found


def _radius(top, decades, linear):
    if linear:
        return lambda f: f / top
    with_none = lambda f: np.log10(np.where(f > 0, f, np.nan) / top) / decades + 1.0  # noqa: E731
    return lambda f: np.clip(np.nan_to_num(with_none(f), nan=0.0), 0.0, None) + np.where(np.isnan(f), np.nan, 0.0)


def _axes(ax, whole, top, decades, linear):
    ax.set_theta_zero_location("N")
    ax.set_theta_direction(-1)
    if not whole:
        ax.set_thetamin(-90)
        ax.set_thetamax(90)
    ticks = np.arange(-90, 91, 30) if not whole else np.arange(-150, 181, 30)
    names = [f"{abs(t) if abs(t) <= 90 else abs(t)}°" for t in ticks]
    ax.set_xticks(np.radians(ticks), names)
    ax.set_ylim(0.0, 1.0)
    if linear:
        at = np.linspace(0.0, 1.0, 5)[1:]
        words = [_style.number(float(f"{a * top:.3g}")) for a in at]
    else:
        values = [v for v in _style.decades_between(top / 10.0**decades, top)]
        at = [np.log10(v / top) / decades + 1.0 for v in values]
        words = [_style.number(v) for v in values]
    keep = [(a, w) for a, w in zip(at, words) if a > 0.05]
    ax.set_yticks([a for a, _ in keep], [w for _, w in keep])
    ax.set_rlabel_position(-80 if not whole else -100)
    ax.tick_params(axis="y", labelsize=7)
    for label in ax.get_yticklabels():
        label.set_bbox({"facecolor": "white", "edgecolor": "none", "alpha": 0.7, "pad": 0.5})
    ax.grid(True)
    ax.spines["polar"].set_linewidth(0.7)


def _light(ax, pair, plane, colour):
    """An arrow along the incident light, where it is in the plane."""
    theta, phi = pair
    turned = 0.0 if plane is None else np.cos(np.radians(phi - plane))
    if plane is not None and abs(abs(turned) - 1.0) > 1e-6:
        return
    sense = -1.0 if plane is None or turned > 0 else 1.0
    at = sense * np.radians(theta)
    ax.annotate(
        "", xy=(at, 0.72), xytext=(at, 1.0),
        arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 1.6, "shrinkA": 0, "shrinkB": 0},
    )
