"""The hemisphere laid out flat, seen from the front: +X right, +Y up, the normal in the middle."""

import numpy as np

from .. import direction
from .._errors import ArgumentError
from ._style import FAINT, HAIR, INK, UNKNOWN, clipped, expect_between

PROJECTIONS = {
    "equal-area": "equal areas are equal solid angles",
    "angle": "the radius is the polar angle",
    "cosines": "direction cosines: equal areas are equal projected solid angles",
}

_RADII = {
    "equal-area": lambda z: np.sqrt(np.clip(1.0 - z, 0.0, None)),
    "angle": lambda z: np.arccos(np.clip(z, -1.0, 1.0)) / (0.5 * np.pi),
    "cosines": lambda z: np.sqrt(np.clip(1.0 - z * z, 0.0, None)),
}
_COSINES = {
    "equal-area": lambda r: 1.0 - r * r,
    "angle": lambda r: np.cos(0.5 * np.pi * r),
    "cosines": lambda r: np.sqrt(np.clip(1.0 - r * r, 0.0, None)),
}


class Disk:
    """A projection of a hemisphere onto the unit disk.

    Args:
        projection: A name in `PROJECTIONS`.
    """

    def __init__(self, projection="equal-area"):
        if projection not in PROJECTIONS:
            raise ArgumentError(f"projection: expected one of {', '.join(PROJECTIONS)}, found {projection!r}")
        self.projection = projection

    def place(self, w):
        """Directions of either side, shape (..., 3) → places, shape (..., 2)."""
        w = np.asarray(w, dtype=float)
        xy = w[..., :2]
        sin = np.linalg.norm(xy, axis=-1, keepdims=True)
        radius = _RADII[self.projection](np.abs(w[..., 2:]))
        # The normal itself is in the middle; NaN stays NaN.
        return xy / np.where(sin == 0, 1.0, sin) * radius

    def radius(self, theta_degrees):
        """The circle of a polar angle from the normal of its side."""
        return float(_RADII[self.projection](np.cos(np.radians(theta_degrees))))

    def pixels(self, count, side):
        """Directions at the middles of count × count pixels, the first row lowest; NaN outside the disk."""
        expect_between("pixels", count, 8, 4096)
        at = (np.arange(count) + 0.5) / count * 2.0 - 1.0
        x, y = np.meshgrid(at, at)
        radius = np.hypot(x, y)
        inside = radius < 1.0
        z = _COSINES[self.projection](np.where(inside, radius, 0.0))
        sin = np.sqrt(np.clip(1.0 - z * z, 0.0, None))
        scale = np.where(radius > 0, sin / np.where(radius > 0, radius, 1.0), 0.0)
        w = np.stack([x * scale, y * scale, z if side == "front" else -z], axis=-1)
        w[~inside] = np.nan
        return w

    def axes(self, ax, *, title=None, side="front", rings=True):
        """Empty axes of a hemisphere: rim and azimuths; circles of polar angles and spokes, unless what is drawn has
        borders of its own.
        """
        ax.set_aspect("equal")
        ax.set_xlim(-1.13, 1.13)
        ax.set_ylim(-1.13, 1.13)
        ax.set_axis_off()
        turn = np.linspace(0.0, 2.0 * np.pi, 361)
        circle = np.cos(turn), np.sin(turn)
        ax.fill(*circle, color=UNKNOWN, zorder=0, lw=0)
        ax.plot(*circle, color=FAINT, lw=0.9, zorder=4, solid_joinstyle="round")
        for theta in (30, 60) if rings else ():
            r = self.radius(theta)
            ax.plot(r * circle[0], r * circle[1], color=HAIR, lw=0.5, alpha=0.65, zorder=3)
            # Between two spokes, where they are least in the way.
            shown = theta if side == "front" else 180 - theta
            text(ax, r * np.cos(np.radians(67.5)), r * np.sin(np.radians(67.5)), f"{shown}°", size=6.5)
        for phi in range(0, 360, 45):
            c, s = np.cos(np.radians(phi)), np.sin(np.radians(phi))
            if rings:
                ax.plot([0.0, c], [0.0, s], color=HAIR, lw=0.4, alpha=0.45, zorder=3)
            if phi % 90 == 0:
                text(ax, 1.085 * c, 1.085 * s, f"{phi}°", size=7, halo=False)
        if title:
            ax.set_title(clipped(title), pad=4)

    def image(self, ax, values, *, norm, cmap):
        """Values at `pixels` as colours, cut off at the rim."""
        from matplotlib.patches import Circle

        shown = ax.imshow(
            np.ma.masked_invalid(values),
            extent=(-1, 1, -1, 1),
            origin="lower",
            norm=norm,
            cmap=cmap,
            interpolation="nearest",
            zorder=1,
        )
        shown.set_clip_path(Circle((0, 0), 1.0, transform=ax.transData))
        # imshow sets limits of its own.
        ax.set_xlim(-1.13, 1.13)
        ax.set_ylim(-1.13, 1.13)
        return shown

    def mark_light(self, ax, wi, *, transmission):
        """A ring where light comes from and a cross where a mirror or no surface at all would send it."""
        x, y = self.place(wi)
        for colour, width in ((INK, 2.6), ("white", 1.3)):
            ax.plot([x], [y], "o", mfc="none", mec=colour, mew=width, ms=8, zorder=6)
            ax.plot([-x], [-y], "x", color=colour, mew=width, ms=6, zorder=6)


#: Points of an incidence that are drawn, evenly through the file.
MOST_POINTS = 20_000


def dots(ax, disk, wo, values, norm, cmap, size=3.0):
    """Points on the disk in the colours of their values."""
    step = max(1, -(-len(values) // MOST_POINTS))
    # What is below 0 has no logarithm: noise is drawn as the darkest.
    shown = np.clip(values[::step], norm.vmin, None) if norm.vmin > 0 else values[::step]
    return ax.scatter(*disk.place(wo[::step]).T, c=shown, norm=norm, cmap=cmap, s=size, lw=0, zorder=2, rasterized=True)


def text(ax, x, y, words, *, size=7, halo=True, colour=INK):
    """Words that can be read on any colour."""
    from matplotlib.patheffects import withStroke

    effects = [withStroke(linewidth=1.8, foreground="white", alpha=0.75)] if halo else []
    ax.text(x, y, words, ha="center", va="center", size=size, color=colour, zorder=7, path_effects=effects)


def legend_of_light(figure_or_ax, *, transmission, **where):
    """What ring and cross are."""
    from matplotlib.lines import Line2D

    beyond = "straight through" if transmission else "mirror direction"
    ring = Line2D([], [], marker="o", ls="", mfc="none", mec=INK, mew=1.3, ms=7, label="light comes from here")
    cross = Line2D([], [], marker="x", ls="", color=INK, mew=1.3, ms=6, label=beyond)
    return figure_or_ax.legend(handles=[ring, cross], ncols=2, handletextpad=0.3, columnspacing=1.4, **where)


def degrees(theta, phi):
    """An incident direction in words."""
    return f"θᵢ = {theta:g}°, φᵢ = {phi:g}°"


def unit(angles, name="incident"):
    """(theta, phi) in degrees → unit vector.

    Raises:
        ArgumentError: Anything else.
    """
    try:
        theta, phi = (float(a) for a in angles)
    except (TypeError, ValueError):
        raise ArgumentError(f"{name}: expected (theta, phi) in degrees, found {angles!r}") from None
    if not (0.0 <= theta <= 180.0 and np.isfinite(phi)):
        raise ArgumentError(f"{name}: expected theta 0 to 180 and a finite phi, found ({theta:g}, {phi:g})")
    return direction(theta, phi)
