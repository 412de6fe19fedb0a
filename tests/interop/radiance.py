"""Radiance as the PyPI package pyradiance ships it: its programs, and its BSDF library in a process of its own."""

import os
import subprocess
import sys
from pathlib import Path

import pyradiance

HOME = Path(pyradiance.__file__).resolve().parent


class Radiance:
    """Runs Radiance's programs in a folder; local files are found there."""

    def __init__(self):
        # Without "." no file of the working folder is found; without lib no rayinit.cal.
        self.environment = dict(os.environ, RAYPATH=f".{os.pathsep}{HOME / 'lib'}")
        self.environment["PATH"] = f"{HOME / 'bin'}{os.pathsep}{os.environ['PATH']}"

    def run(self, folder, *arguments, stdin=b"", timeout=300):
        """Standard output as bytes; a failure or anything called an error is an assertion."""
        program = HOME / "bin" / arguments[0]
        done = subprocess.run(
            [program, *map(str, arguments[1:])],
            cwd=folder,
            env=self.environment,
            input=stdin,
            capture_output=True,
            timeout=timeout,
        )
        message = done.stderr.decode(errors="replace")
        assert done.returncode == 0, f"{arguments[0]}: status {done.returncode}: {message}"
        assert "error" not in message.lower(), f"{arguments[0]}: {message}"
        return done.stdout

    def octree(self, folder, name, scene):
        """Compiles a scene description; returns the octree's name."""
        (folder / f"{name}.rad").write_text(scene)
        (folder / f"{name}.oct").write_bytes(self.run(folder, "oconv", f"{name}.rad"))
        return f"{name}.oct"

    def picture(self, folder, octree, resolution, *options):
        """Renders with rpict; returns luminance, one row a line of the picture."""
        picture = self.run(folder, "rpict", "-x", resolution, "-y", resolution, *options, octree)
        text = self.run(folder, "pvalue", "-H", "-h", "-d", "-b", stdin=picture).split()
        assert len(text) == resolution * resolution
        values = list(map(float, text))
        return [values[row * resolution :][:resolution] for row in range(resolution)]


def pane(path):
    """The scene that pkgBSDF makes of a file; None if it refuses it."""
    try:
        return Radiance().run(path.parent, "pkgBSDF", "-s", path.name).decode()
    except AssertionError:
        return None


def library(verb, path, rows):
    """Answers of Radiance's library, one a row; see library.py."""
    done = subprocess.run(
        [sys.executable, Path(__file__).with_name("library.py"), verb, path],
        input="".join(" ".join(map(str, row)) + "\n" for row in rows),
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0, f"{path}: {done.stderr}"
    return [float(line) for line in done.stdout.split()]
