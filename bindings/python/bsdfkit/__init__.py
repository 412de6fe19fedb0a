"""Measured BSDFs: fit, tabulate, query, save.

Directions are unit vectors that point away from the surface, in the frame +Z front normal, +Y up:
``wi`` incident (the known direction), ``wo`` scattered. Arrays of directions have the shape (..., 3);
leading axes broadcast. Values are f in 1/sr without cosine. Angles are in degrees.

    >>> import bsdfkit
    >>> bsdf = bsdfkit.open("fabric.xml")
    >>> f = bsdf.eval(bsdfkit.direction(30, 0), bsdfkit.direction(30, 180))
"""

from ._bsdfkit import (
    Bsdf,
    Component,
    Interpolant,
    Metadata,
    Validation,
    __version__,
    angles,
    direction,
    fit,
    materials,
    open,
    simulate,
)
from ._errors import ArgumentError, Error, FileWarning, FormatError, IoError, LimitError
from ._geometry import geometry_klems, simulate_geometry
from ._types import Components, Part, Proposal, Sample, Traced

__all__ = [
    "ArgumentError",
    "Bsdf",
    "Component",
    "Components",
    "Error",
    "FileWarning",
    "FormatError",
    "Interpolant",
    "IoError",
    "LimitError",
    "Metadata",
    "Part",
    "Proposal",
    "Sample",
    "Traced",
    "Validation",
    "angles",
    "direction",
    "fit",
    "geometry_klems",
    "materials",
    "open",
    "simulate",
    "simulate_geometry",
    "__version__",
]
