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


def test_an_interpolant_answers_every_verb(interpolant, tree):
    assert isinstance(interpolant, bsdfkit.Bsdf)
    wi = bsdfkit.direction([10, 50], 0)
    total = interpolant.directional_hemispherical(wi)
    u = (np.arange(4000) + 0.5) / 4000
    wo, weight, pdf, part = interpolant.sample(wi[:, None], u)
    assert weight.mean(axis=1) == pytest.approx(total, rel=0.01) and (part == 0).all()
    f = interpolant.eval(wi[:, None], wo)
    np.testing.assert_allclose(weight * pdf, f * np.abs(wo[..., 2]), rtol=1e-9)
    np.testing.assert_allclose(interpolant.pdf(wi[:, None], wo), pdf, rtol=1e-12)
    least, most = np.moveaxis(interpolant.projected_solid_angle(wi), -1, 0)
    assert (0 < least).all() and (least <= most).all() and (most < 0.01).all()
    # Glass, measured from one side, is the same from the other.
    across = bsdfkit.direction(160, 30)
    assert interpolant.eval(across, wi[0]) == interpolant.eval(wi[0], across) > 0
    selected = interpolant.directional_hemispherical(wi, components=bsdfkit.Components.REFLECTION)
    assert (selected == 0).all()


def test_validation_and_plan(interpolant, measurements, tmp_path):
    (validation,) = interpolant.validate(progress=False)
    n = interpolant.components[0].incidences
    assert validation.wi.shape == (n, 3) and validation.l1.shape == (n,)
    assert validation.scattered == "back" and "Validation" in repr(validation)
    inside = ~np.array(validation.extrapolated)
    assert inside.any() and (validation.l1[inside] < 0.3).all()
    expected = validation.expected(bsdfkit.direction([[5.0, 35.0]], 0))
    assert expected.shape == (1, 2) and (expected > 0).all() and (expected < 1).all()

    proposals = interpolant.plan(2, max_theta_degrees=60, progress=False)
    assert len(proposals) == 2 and proposals[0].mean_l1 >= proposals[1].mean_l1 > 0
    assert all(abs(np.linalg.norm(p.wi) - 1) < 1e-9 and p.wi[2] > 0.49 for p in proposals)

    interpolant.save(tmp_path / "i.safetensors")
    again = bsdfkit.open(tmp_path / "i.safetensors")
    with pytest.raises(bsdfkit.ArgumentError, match="paths"):
        again.validate()
    (same,) = again.validate(measurements, progress=False)
    np.testing.assert_allclose(same.l1, validation.l1, atol=2e-3)


def test_trees_of_a_size(interpolant):
    small = interpolant.tabulate(max_leaves=500, progress=False)
    assert small.components[0].leaves <= 500
    with pytest.raises(bsdfkit.ArgumentError, match="max_leaves"):
        interpolant.tabulate("klems-full", max_leaves=500)


def test_stored_forms_change_and_suit_a_program(interpolant, tmp_path):
    tree = interpolant.tabulate(max_leaves=2000, progress=False)
    matrix = tree.tabulate("klems-quarter", name="again")
    assert matrix.components[0].incidences == 41 and matrix.metadata.name == "again"
    wi = bsdfkit.direction([0, 40, 60], 0)
    np.testing.assert_allclose(
        matrix.directional_hemispherical(wi), tree.directional_hemispherical(wi), rtol=0.05
    )
    window = interpolant.tabulate(consumer="window", properties={"TIR": "0"}, progress=False)
    assert window.bands == ["Solar"] and len(window.components) == 4
    assert ("TIR", "0") in window.metadata.properties
    window.save(tmp_path / "w.xml")
    solar = bsdfkit.open(tmp_path / "w.xml").band("solar")
    np.testing.assert_allclose(
        solar.directional_hemispherical(wi), window.directional_hemispherical(wi), rtol=1e-4
    )
    with pytest.raises(bsdfkit.ArgumentError, match="klems-full"):
        interpolant.tabulate("tensor-tree", consumer="window")
    with pytest.raises(bsdfkit.ArgumentError, match="Solar"):
        window.band("NIR")


def test_a_fit_that_is_not_to_be_trusted_warns(tmp_path, caplog):
    rows = ["theta_i,phi_i,theta_o,phi_o,value"]
    rows += [f"{i},0,{o},180,0.3" for i in (0, 20, 40, 60) for o in range(-80, 81, 5)]
    (tmp_path / "plane.csv").write_text("\n".join(rows))
    with caplog.at_level("WARNING", logger="bsdfkit"):
        fitted = bsdfkit.fit(tmp_path / "plane.csv", progress=False)
    assert any("only one plane" in r.message for r in caplog.records)
    assert fitted.components[0].expected_error < 0.2
    (tmp_path / "one.csv").write_text("\n".join(rows[:1] + [f"{i},0,30,180,0.3" for i in range(4)]))
    with pytest.raises(bsdfkit.FormatError, match="one direction"):
        bsdfkit.fit(tmp_path / "one.csv", progress=False)


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


def test_spectra_are_kept_and_seen(tmp_path):
    bsdfkit.simulate("pearl-paint", tmp_path / "m", sweeps=16, points_per_sweep=60, spiral_points=300)
    paint = bsdfkit.fit(tmp_path / "m")
    assert paint.wavelengths == [400.0 + 10 * k for k in range(31)]
    wi = bsdfkit.direction(theta_degrees=30, phi_degrees=0)
    wo = bsdfkit.direction(theta_degrees=[20, 30, 50], phi_degrees=180)
    bands = paint.eval_bands(wi, wo)
    assert bands.shape == (3, 31) and (bands > 0).all()
    # One band by itself is what all bands say of it, in trees and matrices, too.
    red = paint.seen_as("620nm")
    np.testing.assert_allclose(red.eval(wi, wo), bands[:, 22], rtol=1e-5)
    assert paint.eval(wi, wo, xyz=True).shape == (3, 3)
    with pytest.raises(bsdfkit.ArgumentError, match="solar"):
        paint.seen_as("solar")
    with pytest.raises(bsdfkit.ArgumentError, match="view"):
        paint.seen_as("x-ray")
    # What is seen of bands is their weighted sum, here as there; totals likewise.
    for view in ["photopic", "melanopic-a", "550nm", "mean"]:
        weights = bsdfkit.view_weights(view, paint.wavelengths)
        assert weights.shape == (1, 31)
        seen = paint.seen_as(view)
        np.testing.assert_allclose((bands @ weights.T)[:, 0], seen.eval(wi, wo), rtol=1e-4)
        total = paint.directional_hemispherical_bands(wi) @ weights[0]
        np.testing.assert_allclose(total, seen.directional_hemispherical(wi), rtol=5e-3)
    for view in ["xyz-a", "colour"]:
        weights = bsdfkit.view_weights(view, paint.wavelengths)
        np.testing.assert_allclose(bands @ weights.T, paint.seen_as(view).eval(wi, wo, xyz=True), rtol=1e-4)
    grey = bsdfkit.view_weights("rgb", paint.wavelengths).sum(1)
    np.testing.assert_allclose(grey, 1, atol=0.02)  # bands end at 400 and 700 nm
    with pytest.raises(bsdfkit.ArgumentError, match="weights alone"):
        paint.seen_as("rgb")
    assert paint.directional_hemispherical_bands(wo).shape == (3, 31)
    assert (paint.directional_hemispherical_bands(wi, components=bsdfkit.Components.TRANSMISSION) == 0).all()


def test_the_render_form_keeps_bands(tmp_path):
    bsdfkit.simulate("pearl-paint", tmp_path / "m", sweeps=16, points_per_sweep=60, spiral_points=300)
    paint = bsdfkit.fit(tmp_path / "m")
    table = paint.tabulate("render")
    table.save(tmp_path / "paint_render.safetensors")
    table = bsdfkit.open(tmp_path / "paint_render.safetensors")
    assert table.wavelengths == paint.wavelengths
    wi = bsdfkit.direction(theta_degrees=35, phi_degrees=10)
    wo = bsdfkit.direction(theta_degrees=np.linspace(1, 75, 40), phi_degrees=np.arange(40) * 137.5)
    truth, found = paint.eval_bands(wi, wo), table.eval_bands(wi, wo)
    assert np.abs(found - truth).sum() < 0.03 * truth.sum()
    whole, kept = paint.directional_hemispherical_bands(wi), table.directional_hemispherical_bands(wi)
    np.testing.assert_allclose(kept, whole, rtol=0.02)
    # A view is all that a table of it has.
    assert paint.seen_as("620nm").tabulate("klems-quarter").wavelengths is None
    with pytest.raises(bsdfkit.ArgumentError, match="bands"):
        paint.tabulate("klems-quarter").eval_bands(wi, wo)


def test_bands_of_a_compiled_tree(golden):
    tree = bsdfkit.open(golden("compiled/spectral_tree.safetensors"))
    assert tree.wavelengths == [450, 550, 650]
    wi = bsdfkit.direction(40, 70)
    wo = bsdfkit.direction([50, 50], [255, 75])
    bands = tree.eval_bands(wi, wo)
    np.testing.assert_allclose(bands @ [0.25, 0.5, 0.25], tree.eval(wi, wo), rtol=1e-9)
    assert bands[0, 2] > 2 * bands[0, 0] and bands[1, 0] > 2 * bands[1, 2]
    total = tree.directional_hemispherical_bands(wi)
    np.testing.assert_allclose(total @ [0.25, 0.5, 0.25], tree.directional_hemispherical(wi), rtol=1e-6)
    assert np.isnan(tree.eval_bands([np.nan, 0, 1], wo)).all()
