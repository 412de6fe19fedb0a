"""What is drawn: a name, and something that answers for pairs of sides."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from .. import Bsdf, Interpolant
from .._errors import ArgumentError

SIDES = ("front", "back")


@dataclass
class Subject:
    """A BSDF, an interpolant or a measurement with the words under its picture."""

    label: str
    what: Any

    @property
    def is_measured(self):
        return not isinstance(self.what, Bsdf)

    @property
    def is_interpolant(self):
        return isinstance(self.what, Interpolant)

    def pairs(self):
        """(incident, scattered) of all that is scattered."""
        if self.is_measured:
            return [(m.incident, m.scattered) for m in self.what]
        pairs = []
        stored = [(c.incident, c.scattered) for c in self.what.components]
        for n, incident in enumerate(SIDES):
            for m, scattered in enumerate(SIDES):
                own = (incident, scattered)
                # A transmission that is stored one way answers both ways.
                answered = own in stored or (incident != scattered and own[::-1] in stored)
                if answered or self.what.lambertian[n][m] > 0:
                    pairs.append(own)
        return pairs

    def measurement(self, incident, scattered):
        """What was measured of a pair of sides.

        Raises:
            ArgumentError: Nothing.
        """
        for m in self.what:
            if (m.incident, m.scattered) == (incident, scattered):
                return m
        raise ArgumentError(f"{self.label}: expected {name_of(incident, scattered)}, found none measured")

    def f(self, wi, wo):
        """f in 1/sr.

        Raises:
            ArgumentError: Measurements have no values between their points.
        """
        if self.is_measured:
            raise ArgumentError(
                f"{self.label}: expected a BSDF or an interpolant, found a measurement: `fit` makes one of it"
            )
        return self.what.eval(wi, wo)


def subjects_of(given, labels=None):
    """One subject, or a list of them, with words."""
    several = isinstance(given, (list, tuple)) and not _is_measurement(given)
    whats = list(given) if several else [given]
    labels = list(labels) if labels is not None else [None] * len(whats)
    if len(labels) != len(whats):
        raise ArgumentError(f"labels: expected {len(whats)}, found {len(labels)}")
    subjects = [_subject(what, label) for what, label in zip(whats, labels)]
    # Files of one specimen have one name: numbers tell them apart.
    names = [subject.label for subject in subjects]
    for k, subject in enumerate(subjects):
        if labels[k] is None and names[k] in names[:k]:
            subject.label = f"{names[k]} ({1 + names[:k].count(names[k])})"
    return subjects


def _is_measurement(given):
    from .. import Measurement

    return bool(given) and all(isinstance(g, Measurement) for g in given)


def _subject(what, label):
    from .. import Measurement

    if isinstance(what, Measurement):
        what = [what]
    if isinstance(what, (list, tuple)) and _is_measurement(what):
        name = next((m.name for m in what if m.name), "")
        return Subject(label or name or "measurement", list(what))
    if isinstance(what, Bsdf):
        return Subject(label or what.metadata.name or type(what).__name__.lower(), what)
    raise ArgumentError(f"expected a Bsdf, an Interpolant or a Measurement, found {type(what).__name__}")


def side_of(wi):
    return "front" if wi[2] > 0 else "back"


def scattered_side(subjects, incident, way=None):
    """The side that is drawn: reflection where there is any, unless asked for otherwise.

    Raises:
        ArgumentError: ``way`` is no word for it, or no subject scatters so.
    """
    if way not in (None, "reflection", "transmission"):
        raise ArgumentError(f'way: expected "reflection" or "transmission", found {way!r}')
    here = [scattered for s in subjects for i, scattered in s.pairs() if i == incident]
    ways = {"reflection": incident, "transmission": other(incident)}
    wanted = [ways[way]] if way else list(ways.values())
    for side in wanted:
        if side in here:
            return side
    found = sorted({name_of(*pair) for s in subjects for pair in s.pairs()})
    what = f"{way} of light" if way else "light"
    hint = ""
    if found and not here:
        hint = f" (theta {'above' if incident == 'front' else 'below'} 90: light from the {other(incident)})"
    raise ArgumentError(f"expected {what} from the {incident}, found {', '.join(found) or 'nothing'}{hint}")


def other(side):
    return "back" if side == "front" else "front"


def name_of(incident, scattered):
    """ "front reflection", "back transmission", …"""
    return f"{incident} {'reflection' if incident == scattered else 'transmission'}"


def quantity(incident, scattered, cosine=False):
    """The label of a scale, as ASTM E2387 has it."""
    name = "BRDF" if incident == scattered else "BTDF"
    return f"{name} · cos θₒ (1/sr)" if cosine else f"{name} (1/sr)"


def finite(values):
    """Values that can be drawn; what is not finite or below 0 is not."""
    values = np.asarray(values, dtype=float)
    return np.where(np.isfinite(values) & (values >= 0), values, np.nan)


def nearest_points(measurement, wi):
    """(wi, wo, f) of the incidence nearest to a direction, seen through the symmetry that brings it nearest."""
    k, _, rows = measurement.nearest(list(wi))
    own, (wo, f) = measurement.wi[k], measurement.points(k)
    turn = np.array(rows)
    return np.append(turn @ own[:2], own[2]), np.column_stack([wo[:, :2] @ turn.T, wo[:, 2]]), f
