"""Micro-geometry, ray traced by Mitsuba: a goniophotometer for meshes, and meshes straight to Klems matrices.

Needs `bsdfkit[mitsuba]` and LLVM 19; `bsdfkit.simulate_geometry` and `bsdfkit.geometry_klems` import it when they are called.
"""

from ._klems import geometry_klems
from ._simulate import simulate_geometry

__all__ = ["geometry_klems", "simulate_geometry"]
