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
    Measurement,
    Metadata,
    Validation,
    Viewer,
    __version__,
    angles,
    check,
    direction,
    fit,
    materials,
    open,
    read,
    simulate,
    view,
    view_weights,
    viewer_page,
)
from ._errors import ArgumentError, Error, FileWarning, FormatError, IoError, LimitError
from ._geometry import geometry_klems, simulate_geometry
from ._report import report
from ._types import Components, Finding, Part, Proposal, Sample, Specular, Traced

__all__ = [
    "ArgumentError",
    "Bsdf",
    "Component",
    "Components",
    "Error",
    "FileWarning",
    "Finding",
    "FormatError",
    "Interpolant",
    "IoError",
    "LimitError",
    "Measurement",
    "Metadata",
    "Part",
    "Proposal",
    "Sample",
    "Specular",
    "Traced",
    "Validation",
    "Viewer",
    "angles",
    "check",
    "direction",
    "fit",
    "geometry_klems",
    "materials",
    "open",
    "read",
    "report",
    "simulate",
    "simulate_geometry",
    "view",
    "view_weights",
    "viewer_page",
    "__version__",
]
