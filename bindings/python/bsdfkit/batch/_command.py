"""Where the command is."""

from __future__ import annotations

import os
import shutil
import subprocess

COMMAND = "BSDFKIT_COMMAND"


def command() -> str:
    """The command ``bsdf``: what ``BSDFKIT_COMMAND`` names, else the one on the path.

    Raises ``FileNotFoundError``, saying what to do.
    """
    named = os.environ.get(COMMAND)
    found = shutil.which(named or "bsdf")
    if found is None:
        raise FileNotFoundError(
            f"expected the command bsdf, found {'none on the path' if not named else 'no program ' + named}: "
            f"`cargo install --path crates/cli` installs it, {COMMAND} names it"
        )
    return found


def version(path: str) -> str:
    """What the command at ``path`` calls itself."""
    told = subprocess.run([path, "--version"], capture_output=True, text=True, check=True, timeout=60)
    return told.stdout.split()[-1]
