"""Ray-traced micro-geometry: what is known without tracing comes out, and files say it."""

import os
from glob import glob

import bsdfkit
import numpy as np
import pytest

if "DRJIT_LIBLLVM_PATH" not in os.environ:
    found = glob("/usr/lib/*/libLLVM.so.19.1")
    if found:
        os.environ["DRJIT_LIBLLVM_PATH"] = found[0]

if "CI" not in os.environ:
    pytest.importorskip("mitsuba", reason="no mitsuba: micro-geometry was not traced")
import bsdfkit.mitsuba  # noqa: E402
import mitsuba as mi  # noqa: E402

SQUARE = "v 0 0 {z}\nv {x} 0 {z}\nv {x} {y} {z}\nv 0 {y} {z}\nf 1 2 3 4\n"


@pytest.fixture(autouse=True)
def llvm():
    best, why = bsdfkit.mitsuba.best_variant()
    if best.startswith("scalar"):
        if "CI" in os.environ and "BSDFKIT_WITHOUT_LLVM" not in os.environ:
            pytest.fail(why)
        pytest.skip(why)


@pytest.fixture
def plane(tmp_path):
    path = tmp_path / "plane.obj"
    path.write_text(SQUARE.format(x=2, y=1, z=0))
    return path


@pytest.fixture(scope="module")
def slats(tmp_path_factory):
    """Flat slats along Y, 1.2 periods wide, 40 degrees from the normal."""
    x, z = 0.6 * np.sin(np.radians(40)), 0.6 * np.cos(np.radians(40))
    path = tmp_path_factory.mktemp("slats") / "slats.obj"
    path.write_text(f"v {-x} 0 {-z}\nv {x} 0 {z}\nv {x} 1 {z}\nv {-x} 1 {-z}\nf 1 2 3 4\n")
    return path


def rows(path):
    return np.loadtxt(path, delimiter=",", skiprows=1)


def test_a_lambertian_plane_is_reflectance_over_pi(plane, tmp_path):
    heard = []
    traced = bsdfkit.simulate_geometry(
        plane,
        0.5,
        tmp_path / "out",
        incident="both",
        thetas=(0, 40),
        azimuths=(0, 90),
        held_out=[(20, 45)],
        progress=lambda done, total: heard.append((done, total)),
    )
    assert heard == [(k, 8) for k in range(1, 9)]
    assert len(traced.files) == 6 and np.allclose(traced.energy, 0.5, atol=1e-4)
    assert 0.001 < traced.noise < 0.03
    for path in traced.files:
        found = rows(path)
        front = path.name.startswith("front")
        # The side that light comes from, and nothing behind.
        assert ((found[:, 0] < 90) == front).all() and ((found[:, 2] < 90) == front).all()
        off = found[:, 4] * np.pi / 0.5 - 1
        assert abs(off.mean()) < 2e-3 and off.std() < 0.06
    held_out = np.load(traced.held_out)
    assert held_out["incidences"].tolist() == [[20, 45], [160, 45]]
    means = held_out["values"].mean(2) * np.pi
    assert np.allclose(means, [[0.5, 0.0], [0.0, 0.5]], atol=1e-3)
    # Nothing of it is beside the measurements.
    fitted = bsdfkit.fit(tmp_path / "out" / "measured", progress=False)
    wi = bsdfkit.direction([20, 160], [45, 45])
    assert np.allclose(fitted.directional_hemispherical(wi), 0.5, rtol=0.01)


def test_each_side_has_its_material_and_the_front_is_above(plane, tmp_path):
    under = tmp_path / "under.obj"
    under.write_text(SQUARE.format(x=2, y=1, z=-0.1))
    path = bsdfkit.geometry_klems([plane, under], [0.8, 0.2], tmp_path / "two.xml", rays=400)
    found = bsdfkit.open(path).directional_hemispherical(bsdfkit.direction([0, 50, 130, 180], [0, 200, 30, 0]))
    assert np.allclose(found, [0.8, 0.8, 0.2, 0.2], rtol=2e-3)


def test_lossless_slats_return_all_light(slats, tmp_path):
    path = bsdfkit.geometry_klems(slats, 1.0, tmp_path / "white.xml", period=(1, 1), rays=1000)
    wi = bsdfkit.direction([0, 30, 62, 120, 150], [0, 0, 180, 90, 10])
    assert np.allclose(bsdfkit.open(path).directional_hemispherical(wi), 1.0, atol=4e-3)


def test_black_slats_pass_what_stands_in_nobodys_way(slats, tmp_path):
    """And azimuths are the right way round: these slats let light from one side through, and stop that from the other."""
    traced = bsdfkit.simulate_geometry(
        slats, 0.0, tmp_path / "black", period=(1, 1), thetas=(40,), azimuths=(0, 180), noise=0.5
    )
    x, z = 1.2 * np.sin(np.radians(40)), 1.2 * np.cos(np.radians(40))
    expected = [1 - abs(x - z * side * np.tan(np.radians(40))) for side in (1, -1)]
    assert expected[0] > 0.99 and expected[1] < 0
    # Through the lamp's two degrees some of it is shadowed.
    assert abs(traced.energy[1] - expected[0]) < 0.05 and traced.energy[0] < 1e-3
    through = rows(next(f for f in traced.files if f.name == "front_40.0_000.0.csv"))
    brightest = through[np.argmax(through[:, 4])]
    assert abs(brightest[2] - 140) < 2 and abs(brightest[3] - 180) < 3
    matrix = bsdfkit.open(bsdfkit.geometry_klems(slats, 0.0, tmp_path / "black.xml", period=(1, 1), rays=400))
    total = matrix.directional_hemispherical(bsdfkit.direction([40, 40, 140, 140], [0, 180, 180, 0]))
    # Means over patches ten degrees wide; from behind it is the other azimuth.
    assert (total[[0, 2]] > 0.8).all() and (total[[1, 3]] < 0.05).all()


def test_slats_are_reciprocal(slats, tmp_path):
    path = bsdfkit.geometry_klems(slats, 0.6, tmp_path / "slats.xml", period=(1, 1), rays=20_000)
    bsdf = bsdfkit.open(path)
    rng = np.random.default_rng(1)
    # Middles of patches, where the matrix has values of its own.
    a = bsdfkit.direction(rng.choice([10, 20, 30, 40, 50], 200), 0) * [1, 1, 1]
    b = bsdfkit.direction(180 - rng.choice([10, 20, 30, 40, 50], 200), 180)
    there, back = bsdf.eval(a, b), bsdf.eval(b, a)
    assert there.max() > 0.5
    assert np.abs(there - back).mean() < 0.05 * there.mean()


def test_a_bsdf_file_and_a_dictionary_are_materials(plane, golden, tmp_path):
    path = bsdfkit.geometry_klems(plane, golden("xml/diffuse_pure.xml"), tmp_path / "file.xml", rays=200)
    wi = bsdfkit.direction(20, 30)
    own = bsdfkit.open(golden("xml/diffuse_pure.xml"))
    both = [f.directional_hemispherical(wi, components=bsdfkit.Components.ALL) for f in (bsdfkit.open(path), own)]
    assert np.isclose(*both, rtol=0.02)
    mirror = {"type": "conductor", "material": "none"}
    path = bsdfkit.geometry_klems(plane, mirror, tmp_path / "mirror.xml", rays=200)
    assert np.isclose(bsdfkit.open(path).directional_hemispherical(wi), 1.0, rtol=1e-3)


def test_the_callers_variant_comes_back(plane, tmp_path):
    mi.set_variant("scalar_rgb")
    bsdfkit.geometry_klems(plane, 0.5, tmp_path / "plane.xml", rays=1)
    assert mi.variant() == "scalar_rgb"


@pytest.mark.parametrize(
    "change, message",
    [
        ({"material": 1.5}, "reflectance from 0 to 1, found 1.5"),
        ({"material": None}, "a reflectance, a BSDF's file or a dictionary"),
        ({"incident": "top"}, '"front", "back" or "both", found \'top\''),
        ({"noise": 0.0}, "above 0 and below 1"),
        ({"thetas": (95,)}, "found 95"),
        ({"thetas": ()}, "found none"),
        ({"period": (1, 0)}, "two lengths above 0"),
        ({"period": (0.001, 1)}, "at most 7 periods"),
        ({"mesh": "plane.stl"}, ".obj or .ply, found '.stl'"),
    ],
)
def test_nonsense_is_refused(plane, tmp_path, change, message):
    given = {"mesh": plane, "material": 0.5, "folder": tmp_path / "out", **change}
    with pytest.raises(bsdfkit.ArgumentError) as error:
        bsdfkit.simulate_geometry(**given)
    assert message in str(error.value)
    assert not list((tmp_path / "out").glob("**/*.csv"))


def test_missing_files_and_used_folders_are_told(plane, tmp_path):
    with pytest.raises(bsdfkit.IoError, match="nowhere.obj"):
        bsdfkit.simulate_geometry(tmp_path / "nowhere.obj", 0.5, tmp_path / "out")
    with pytest.raises(bsdfkit.ArgumentError, match="new or empty folder"):
        bsdfkit.simulate_geometry(plane, 0.5, tmp_path)
    with pytest.raises(bsdfkit.ArgumentError, match="ending in .xml"):
        bsdfkit.geometry_klems(plane, 0.5, tmp_path / "plane.txt")
