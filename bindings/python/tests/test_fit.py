"""Measurement to file and back, progress."""

import bsdfkit
import numpy as np
import pytest


def test_from_measurements_to_a_file_and_back(interpolant, tmp_path):
    (part,) = interpolant.components
    assert part.representation == "transport" and part.incidences >= 6
    assert "fritted" in interpolant.metadata.name

    wi = bsdfkit.direction(35, 10)
    theta = np.where(part.scattered == "back", 180 - np.arange(5, 60, 5), np.arange(5, 60, 5))
    wo = bsdfkit.direction(theta, 190)
    continuous = interpolant.eval(wi, wo)
    assert (continuous > 0).all()
    assert interpolant.eval(wi, wo[2]) == continuous[2]
    xyz = interpolant.eval(wi, wo, xyz=True)
    np.testing.assert_array_equal(xyz, np.repeat(continuous[:, None], 3, axis=1))
    assert np.isnan(interpolant.eval([np.nan, 0, 1], wo)).all()
    other_side = wo * [1, 1, -1]
    assert (interpolant.eval(wi, other_side) == 0).all()
    mixed = interpolant.eval(np.stack([wi, -wi, wi]), np.stack([wo[0], wo[0], wo[1]]))
    np.testing.assert_array_equal(mixed, [continuous[0], mixed[1], continuous[1]])

    interpolant.save(tmp_path / "i.safetensors")
    again = bsdfkit.open(tmp_path / "i.safetensors")
    assert isinstance(again, bsdfkit.Interpolant)
    np.testing.assert_allclose(again.eval(wi, wo), continuous, rtol=0.02)

    tree = interpolant.tabulate(max_error=0.02, max_depth=5, name="new name", thickness=0.004)
    assert tree.components[0].representation == "tree3"
    assert tree.components[0].leaves > 100
    # Quadrature of the continuous function, by hand.
    theta, phi = np.arange(0.25, 90, 0.5)[:, None], np.arange(0, 360, 2)
    w = bsdfkit.direction(180 - theta if part.scattered == "back" else theta, phi)
    cell = np.radians(0.5) * np.radians(2) * np.sin(np.radians(theta)) * np.abs(w[..., 2])
    integral = np.sum(interpolant.eval(wi, w) * cell)
    assert tree.directional_hemispherical(wi) == pytest.approx(integral, rel=0.03)

    tree.save(tmp_path / "t.xml", digits=9)
    tree.save(tmp_path / "t.safetensors")
    for name in ["t.xml", "t.safetensors"]:
        stored = bsdfkit.open(tmp_path / name)
        assert (stored.metadata.name, stored.metadata.thickness) == ("new name", 0.004)
        np.testing.assert_array_equal(stored.eval(wi, wo), tree.eval(wi, wo))
        read = bsdfkit.open(tmp_path / name, in_place=False)
        np.testing.assert_array_equal(read.eval(wi, wo), tree.eval(wi, wo))

    matrix = interpolant.tabulate("klems-quarter", progress=False)
    assert matrix.components[0].representation == "matrix"
    assert matrix.components[0].incidences == 41
    assert matrix.directional_hemispherical(wi) == pytest.approx(integral, rel=0.05)


def test_lists_of_files_and_a_given_symmetry(measurements):
    files = sorted(measurements.glob("*.txt"))
    fitted = bsdfkit.fit([str(f) for f in files], symmetry="isotropic", progress=False)
    assert fitted.components[0].incidences == len(files)


def test_progress_reaches_a_function_and_a_bar(measurements, tmp_path, capsys):
    heard = []
    bsdfkit.fit(measurements, progress=lambda done, total: heard.append((done, total)))
    assert heard and all(0 < done <= total for done, total in heard)
    pytest.importorskip("tqdm")
    bsdfkit.simulate(
        bsdfkit.materials()[0], tmp_path, sweeps=8, points_per_sweep=20, progress=True
    )
    assert bsdfkit.materials()[0] in capsys.readouterr().err


def test_an_exception_in_progress_stops_the_fit(measurements):
    def refuse(done, total):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        bsdfkit.fit(measurements, progress=refuse)


def test_xarray(tree, interpolant):
    pytest.importorskip("xarray")
    grid = tree.to_xarray(theta_i=[0, 40], theta_o=[10, 20, 170], phi_o=[0, 90], xyz=True)
    assert grid.dims == ("theta_i", "phi_i", "theta_o", "phi_o", "channel")
    assert grid.attrs["units"] == "sr-1" and grid.theta_i.attrs["units"] == "degree"
    value = tree.eval(bsdfkit.direction(40, 0), bsdfkit.direction(170, 90))
    assert grid.sel(theta_i=40, phi_i=0, theta_o=170, phi_o=90, channel="Y") == value
    assert interpolant.to_xarray(theta_i=[20]).shape == (1, 1, 37, 72)
