"""Selections of components, and what samples, proposals and findings consist of."""

import enum
from typing import Any, NamedTuple

from . import _bsdfkit

_BITS = _bsdfkit.COMPONENT_BITS
_NUMBERS = _bsdfkit.PART_NUMBERS


class Components(enum.IntFlag):
    """Which parts of a BSDF a query concerns.

    {REFLECTION, TRANSMISSION} by {LAMBERTIAN, NON_LAMBERTIAN} by {FRONT, BACK}, the side of the
    incident direction. NON_LAMBERTIAN is SPECULAR (peaks of no width) and DIRECTIONAL_DIFFUSE. ``&`` selects what both of its sides select (``REFLECTION & LAMBERTIAN``);
    ``|`` unites bit by bit (``REFLECTION | TRANSMISSION`` is both).
    """

    REFLECTION = _BITS["REFLECTION"]
    TRANSMISSION = _BITS["TRANSMISSION"]
    NON_LAMBERTIAN = _BITS["NON_LAMBERTIAN"]
    LAMBERTIAN = _BITS["LAMBERTIAN"]
    SPECULAR = _BITS["SPECULAR"]
    DIRECTIONAL_DIFFUSE = _BITS["DIRECTIONAL_DIFFUSE"]
    FRONT = _BITS["FRONT"]
    BACK = _BITS["BACK"]
    ALL = _BITS["ALL"]
    NONE = _BITS["NONE"]


class Part(enum.IntEnum):
    """Names of the negative numbers in ``Sample.part``; others number ``Bsdf.components``.

    ``Part.SPECULAR - k`` is number k of ``Bsdf.specular``.
    """

    LAMBERTIAN_REFLECTION = _NUMBERS["LAMBERTIAN_REFLECTION"]
    LAMBERTIAN_TRANSMISSION = _NUMBERS["LAMBERTIAN_TRANSMISSION"]
    NOTHING = _NUMBERS["NOTHING"]
    SPECULAR = _NUMBERS["SPECULAR"]


class Sample(NamedTuple):
    """Drawn directions.

    Attributes:
        wo: Scattered directions, shape (..., 3).
        weight: f |cos θo| / pdf, dimensionless, shape (...): the same for every u, but of an
            ``Interpolant``.
        pdf: Density over solid angle, 1/sr, shape (...); of a peak of no width the probability of
            drawing it.
        part: The part drawn from, shape (...): an index of ``Bsdf.components`` or a ``Part``.
    """

    wo: Any
    weight: Any
    pdf: Any
    part: Any


class Specular(NamedTuple):
    """A family of peaks of no width: uo = A ui + g, u the direction cosines along X and Y.

    Attributes:
        incident: "front" or "back".
        scattered: "front" or "back".
        name: The law in words: "mirror", "straight through", "refracted, index 1.5", ….
        linear: A, by rows.
        offset: g.
        width_degrees: How wide an instrument saw it; 0 of an ideal one.
        residual: How well measured coefficients are foretold by the others, or None.
    """

    incident: str
    scattered: str
    name: str
    linear: Any
    offset: Any
    width_degrees: float
    residual: Any


class Proposal(NamedTuple):
    """An incident direction to measure next.

    Attributes:
        wi: Unit vector (x, y, z), away from the surface.
        expected_l1: L1 to expect there with what is measured and proposed so far.
        mean_l1: L1 of all incident light together once this one is measured, too.
        regions: Where to scan densely: (unit vector, radius in degrees).
    """

    wi: Any
    expected_l1: float
    mean_l1: float
    regions: Any


class Traced(NamedTuple):
    """What `simulate_geometry` wrote.

    Attributes:
        files: Measurements, one an incidence.
        held_out: The file of incidences kept aside, or None.
        noise: L1 between two halves of the rays, the mean over incidences.
        energy: The least and the largest share of light that left again.
    """

    files: Any
    held_out: Any
    noise: float
    energy: Any


class Finding(NamedTuple):
    """Something wrong with a file.

    Attributes:
        code: What kind of thing it is, as the guide lists them.
        place: Line and path of the element, or the side; empty for the whole file.
        text: What was found there, and what was expected.
        programs: Which programs it breaks: name to ("limited", "refuses" or "wrong", what happens).
        to_do: What to do.
        mended: Whether `bsdf check --fix` mends it: "always", "for" (with ``--for``), "asked" (with ``--also``), "never".
    """

    code: str
    place: str
    text: str
    programs: dict[str, tuple[str, str]]
    to_do: str
    mended: str
