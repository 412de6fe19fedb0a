"""The command, as a function."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

from .._errors import Error
from ._command import command

__all__ = ["run"]


def run(
    manifest: str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    jobs: int | None = None,
    threads: int | None = None,
    cache: str | os.PathLike[str] | None = None,
    scheduler: str | None = None,
) -> list[dict[str, Any]]:
    """Fits every material of a manifest into the folder ``output``, and says what became of each.

    The same as ``bsdf batch MANIFEST -o DIR``, which it runs: what is done already is not done again, and materials that fail stop no
    other. ``scheduler`` is the address of a Dask scheduler; without it the fits are processes of this machine.

    Returns a dictionary a material, in the manifest's order: ``material``, ``status`` (``done``, ``failed`` or ``to do``), ``error``,
    ``files``, ``fit_error``, ``between``, ``energy``, ``seconds``, ``cpu_seconds``, ``peak_bytes`` and counts.

    Raises ``bsdfkit.Error`` where the manifest is wrong or the folder cannot be used.
    """
    words = [command(), "batch", str(manifest), "-o", str(output), "--json"]
    for name, value in {"jobs": jobs, "threads": threads, "cache": cache, "scheduler": scheduler}.items():
        if value is not None:
            words += [f"--{name}", str(value)]
    environment = {**os.environ, "BSDFKIT_PYTHON": sys.executable}
    ran = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment, check=False)
    if ran.returncode not in (0, 1) or not ran.stdout:
        raise Error(f"{Path(manifest)}: {ran.stderr.strip() or f'bsdf batch ended with status {ran.returncode}'}")
    lines: list[dict[str, Any]] = json.loads(ran.stdout)
    return lines
