"""Files of others are read as others read them: RGL's tables as Mitsuba's `measured` does, and as their arrays say."""

import math
import os
import random
from pathlib import Path

import mitsuba as mi
import numpy as np
import pytest

import metal
import tensors

FILES = ["acrylic_felt_green_rgb", "cc_ibiza_sunset_rgb", "chm_mint_rgb", "satin_purple_rgb"]
PAIRS = 1000


@pytest.fixture(scope="module", params=["brushed metal, ours", *FILES])
def tables(request, bsdf, tmp_path_factory):
    """An anisotropic file that we wrote, and isotropic ones of RGL where there are real data."""
    if request.param in FILES:
        data = os.environ.get("BSDFKIT_DATA")
        if data is None:
            pytest.skip("BSDFKIT_DATA is not set")
        return Path(data) / "rgl_iso" / f"{request.param}.bsdf"
    folder = tmp_path_factory.mktemp("metal")
    (folder / "metal.csv").write_text(metal.table())
    bsdf("fit", folder / "metal.csv", "--symmetry", "none", "-o", folder / "metal.safetensors")
    bsdf("convert", folder / "metal.safetensors", "-o", folder / "metal_rgb.bsdf")
    return folder / "metal_rgb.bsdf"


def pairs():
    """Half of them all over the hemispheres, half about the mirror direction."""
    generator = random.Random(25176)
    for k in range(PAIRS):
        theta, phi = math.degrees(math.asin(math.sqrt(generator.random()))), generator.uniform(0.0, 360.0)
        if k % 2:
            place = math.degrees(math.asin(math.sqrt(generator.random()))), generator.uniform(0.0, 360.0)
        else:
            place = min(max(theta + generator.gauss(0, 5), 0.1), 85.0), phi + 180.0 + generator.gauss(0, 5)
        yield (theta, phi), place


@pytest.fixture(scope="module")
def answers(bsdf, tables):
    """What our command answers without a fit: (pairs, X Y Z)."""
    rows = "".join(f"{a!r} {b!r} {c!r} {d!r}\n" for (a, b), (c, d) in pairs())
    return np.array([line.split() for line in bsdf("eval", "--channels", tables, stdin=rows).splitlines()], dtype=float)


def test_values_are_what_the_arrays_say(tables, answers):
    mi.set_variant("scalar_rgb")
    slow = tensors.Tables(mi.tensor_io.read(str(tables)))
    exact = np.array([slow.xyz(np.array(metal.vector(*i)), np.array(metal.vector(*o))) for i, o in pairs()])
    exact = np.maximum(exact, 0.0)
    np.testing.assert_allclose(answers, exact, rtol=1e-6, atol=1e-9)
    assert answers.sum() == pytest.approx(exact.sum(), rel=1e-6)


def test_values_are_what_mitsuba_answers(tables, answers):
    """To its single precision: 1e-4 of a value on a steep flank, 1e-5 on the whole."""
    mi.set_variant("scalar_rgb")
    measured = mi.load_dict({"type": "measured", "filename": str(tables)})
    theirs = []
    for place in pairs():
        wi, wo = (metal.vector(*p) for p in place)
        si = mi.SurfaceInteraction3f()
        si.wi = wi
        theirs.append(np.array(measured.eval(mi.BSDFContext(), si, wo)) / wo[2])
    theirs = np.array(theirs) @ tensors.RGB_TO_XYZ.T / tensors.WHITE
    np.testing.assert_allclose(answers, theirs, rtol=3e-4, atol=1e-6)
    assert np.abs(answers - theirs).sum() < 1e-5 * theirs.sum()


def test_spectra_are_seen_in_daylight(bsdf, tables, answers):
    """The same material written as spectra has the same luminance; it is grey."""
    if tables.name != "metal_rgb.bsdf":
        pytest.skip("only of what we write is there a file of spectra")
    spectral = tables.with_name("metal_spec.bsdf")
    bsdf("convert", tables.with_name("metal.safetensors"), "-o", spectral)
    rows = "".join(f"{a!r} {b!r} {c!r} {d!r}\n" for (a, b), (c, d) in pairs())
    found = np.array(bsdf("eval", spectral, stdin=rows).split(), dtype=float)
    np.testing.assert_allclose(found, answers[:, 1], rtol=1e-3, atol=1e-6)


def test_a_fit_of_their_points_is_near_them(bsdf, tables, tmp_path):
    """What is fitted to the points of a file has the light that the file has."""
    if "felt" not in tables.name and "satin" not in tables.name:
        pytest.skip("too few points about a narrow peak, or none of its own")
    bsdf("fit", tables, "-o", tmp_path / "fit.safetensors")
    angles = "".join(f"{theta} 0\n" for theta in (0, 20, 40, 60))
    fitted, own = (
        [float(line.split()[0]) for line in bsdf("hemispherical", file, "--stdin", stdin=angles).splitlines()]
        for file in (tmp_path / "fit.safetensors", tables)
    )
    assert fitted == pytest.approx(own, rel=0.05)
