"""Golden files, random directions, a small fitted material."""

import json
from pathlib import Path

import bsdfkit
import numpy as np
import pytest

GOLDEN = Path(__file__).resolve().parents[3] / "tests" / "golden"


@pytest.fixture(scope="session")
def golden():
    """Path of a golden file by its name."""
    return lambda name: GOLDEN / name


@pytest.fixture(scope="session")
def vectors():
    """Content of a golden JSON file by its name."""
    return lambda name: json.loads((GOLDEN / name).read_text())


@pytest.fixture(scope="session")
def directions():
    """Unit vectors over both hemispheres: shape (count, 3)."""

    def make(count, seed):
        w = np.random.default_rng(seed).normal(size=(count, 3))
        return w / np.linalg.norm(w, axis=-1, keepdims=True)

    return make


@pytest.fixture(scope="session")
def tree():
    return bsdfkit.open(GOLDEN / "xml" / "t4_rf_rb_tf_tb.xml")


@pytest.fixture(scope="session")
def measurements(tmp_path_factory):
    """A folder of few points of an isotropic material."""
    folder = tmp_path_factory.mktemp("measured") / "fritted"
    material = next(m for m in bsdfkit.materials() if "fritted" in m)
    files = bsdfkit.simulate(
        material, folder, sweeps=18, points_per_sweep=90, spiral_points=500, progress=False
    )
    assert all(f.parent == folder for f in files)
    return folder


@pytest.fixture(scope="session")
def interpolant(measurements):
    return bsdfkit.fit(measurements, progress=False)
