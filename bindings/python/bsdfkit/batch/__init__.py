"""Many materials: `bsdf batch` from Python, and its tasks for Dask.

``run`` starts the command. With a scheduler the command runs ``python -m bsdfkit.batch`` in its turn, which hands each material to a
worker as one task; a worker needs this package and the command ``bsdf`` of the same version.
"""

from ._run import run

__all__ = ["run"]
