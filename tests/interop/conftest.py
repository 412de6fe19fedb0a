"""Files made by our command, for Radiance's programs to read.

The command is the environment variable BSDF, else target/release/bsdf. A missing command fails every
test: nothing here is skipped.
"""

import os
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

import pytest

import film
import radiance

ROOT = Path(__file__).resolve().parents[2]

# One specimen that reflects, without rotational symmetry (rank 4), and one that transmits, with it (rank 3).
MATERIALS = ["fabric", "fritted-glass"]


@pytest.fixture(scope="session")
def bsdf():
    """Runs our command and returns what it prints."""
    command = shutil.which(os.environ.get("BSDF", ROOT / "target" / "release" / "bsdf"))
    assert command, "the command bsdf is not built: run `make build`"

    def run(*arguments, stdin=None):
        arguments = [command, *map(str, arguments)]
        done = subprocess.run(arguments, input=stdin, capture_output=True, text=True, timeout=600)
        assert done.returncode == 0, f"{' '.join(arguments)}: status {done.returncode}\n{done.stderr}"
        return done.stdout

    return run


@dataclass
class Files:
    """What one fit wrote, all in one folder."""

    material: str
    tree: Path
    klems: Path

    def representations(self):
        return [self.tree, self.klems]

    @property
    def transmits(self):
        return self.material == "fritted-glass"


@pytest.fixture(scope="session", params=MATERIALS)
def files(request, bsdf, tmp_path_factory):
    """A virtual specimen measured, fitted and written as tree and as Klems matrix."""
    folder = tmp_path_factory.mktemp(request.param)
    tree, klems = folder / "tree.xml", folder / "klems.xml"
    bsdf("simulate", request.param, "-o", folder / "measurements")
    bsdf("fit", folder / "measurements", "-o", tree, "--to", "klems-full", "-o", klems)
    return Files(request.param, tree, klems)


@pytest.fixture(scope="session")
def rad():
    return radiance.Radiance()


@pytest.fixture(scope="session")
def film_xml(bsdf, tmp_path_factory):
    """A film with two sides, measured and fitted for WINDOW."""
    folder = tmp_path_factory.mktemp("film")
    (folder / "film.csv").write_text(film.table())
    bsdf("fit", folder / "film.csv", "--symmetry", "isotropic", "--for", "window", "-o", folder / "film.xml")
    return folder / "film.xml"


@pytest.fixture(scope="session")
def glass_xml(bsdf, tmp_path_factory):
    """A material that only transmits, of which one direction is measured."""
    folder = tmp_path_factory.mktemp("glass")
    bsdf("simulate", "fritted-glass", "-o", folder / "measurements")
    bsdf("fit", folder / "measurements", "--for", "window", "-o", folder / "glass.xml")
    return folder / "glass.xml"
