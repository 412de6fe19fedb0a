"""Selections of components, and what a sample consists of."""

import enum
from typing import NamedTuple

from . import _bsdfkit

Components = enum.IntFlag("Components", _bsdfkit.COMPONENT_BITS, module="bsdfkit")
Components.__doc__ = """Which parts of a BSDF a query concerns.

{REFLECTION, TRANSMISSION} by {LAMBERTIAN, NON_LAMBERTIAN} by {FRONT, BACK}, the side of the incident
direction. ``&`` selects what both sides of it select (``REFLECTION & LAMBERTIAN``); ``|`` unites bit
by bit (``REFLECTION | TRANSMISSION`` is both).
"""

Part = enum.IntEnum("Part", _bsdfkit.PART_NUMBERS, module="bsdfkit")
Part.__doc__ = "Names of the negative numbers in ``Sample.part``; others number ``Bsdf.components``."


class Sample(NamedTuple):
    """Drawn directions.

    Attributes:
        wo: Scattered directions, shape (..., 3).
        weight: f |cos θo| / pdf, dimensionless, shape (...): the same for every u.
        pdf: Density over solid angle, 1/sr, shape (...).
        part: The part drawn from, shape (...): an index of ``Bsdf.components`` or a ``Part``.
    """

    wo: "object"
    weight: "object"
    pdf: "object"
    part: "object"
