"""A real measurement, from the instrument's files to a picture in Radiance.

The data are not ours to publish: they are found through BSDFKIT_DATA.
"""

import math
import os
from pathlib import Path

import pytest

import radiance
from test_programs import MATERIAL, SAMPLING, SUN, WINDOW


@pytest.fixture(scope="module")
def diffuser(bsdf, tmp_path_factory):
    """EDS10, an engineered diffuser in transmission: 7 incidences of 31 000 points."""
    data = os.environ.get("BSDFKIT_DATA")
    if not data:
        pytest.skip("BSDFKIT_DATA is unset: the real measurement was not tried")
    xml = tmp_path_factory.mktemp("eds10") / "diffuser.xml"
    bsdf("fit", Path(data) / "eds10_mountain", "-o", xml)
    return xml


def test_the_diffuser_passes_most_light(diffuser):
    total = radiance.library("hemispherical", diffuser, [(0.0, 0.0), (180.0, 0.0)])
    assert 0.5 < max(total) < 1.02, total


def test_the_diffuser_renders(rad, diffuser):
    folder = diffuser.parent
    # The files are measured from one side only; Radiance uses one transmission for both.
    scene = SUN.format(sun="0.05 0.05 -1") + MATERIAL.format(xml=diffuser.name) + WINDOW
    octree = rad.octree(folder, "pane", scene)
    view = ["-vtv", "-vp", "0", "0", "5", "-vd", "0", "0", "-1", "-vu", "0", "1", "0", "-vh", "20", "-vv", "20"]
    picture = rad.picture(folder, octree, 32, "-ps", "1", *view, *SAMPLING)
    values = [v for row in picture for v in row]
    assert all(math.isfinite(v) and v >= 0.0 for v in values)
    assert min(v for row in picture[8:24] for v in row[8:24]) > 1e-3
