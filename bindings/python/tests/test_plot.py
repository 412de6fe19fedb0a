"""What pictures show is what the library says: values, places and shares, read back from what was drawn."""

import subprocess
import sys
from pathlib import Path

import bsdfkit
import numpy as np
import pytest

pytest.importorskip("matplotlib")
from matplotlib.collections import PathCollection, PolyCollection  # noqa: E402
from mpl_toolkits.mplot3d.art3d import Poly3DCollection  # noqa: E402

import bsdfkit.plot  # noqa: E402
from bsdfkit.plot import _style  # noqa: E402


@pytest.fixture(scope="module")
def klems(tree):
    return tree.tabulate("klems-full", progress=False)


@pytest.fixture(scope="module")
def measured(measurements):
    return bsdfkit.read(measurements)


def panels(figure):
    """Axes with a picture or a title in them, without bars of colours."""
    return [ax for ax in figure.axes if ax.get_label() != "<colorbar>"]


def collection(ax, kind):
    (found,) = [c for c in ax.collections if isinstance(c, kind)]
    return found


def polygons(ax):
    """(places, values) of the cells drawn."""
    cells = collection(ax, PolyCollection)
    return np.stack([p.vertices[:-1] for p in cells.get_paths()]), np.asarray(cells.get_array())


def areas(places):
    x, y = places[..., 0], places[..., 1]
    return 0.5 * np.abs(np.sum(x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1), axis=1))


@pytest.mark.parametrize("projection", ["equal-area", "angle", "cosines"])
@pytest.mark.parametrize("way", ["reflection", "transmission"])
def test_pixels_are_values_in_their_directions(tree, projection, way):
    figure = tree.plot("hemisphere", incident=(40, 70), way=way, projection=projection, pixels=64)
    (image,) = panels(figure)[0].images
    shown = image.get_array()
    polar = {
        "equal-area": lambda r: 2 * np.arcsin(r / np.sqrt(2)),
        "angle": lambda r: r * np.pi / 2,
        "cosines": np.arcsin,
    }[projection]
    checked = 0
    for row in range(3, 64, 9):
        for column in range(2, 64, 7):
            x, y = (column + 0.5) / 32 - 1, (row + 0.5) / 32 - 1
            r = np.hypot(x, y)
            if r >= 1:
                assert shown.mask[row, column]
                continue
            theta = np.degrees(polar(r))
            wo = bsdfkit.direction(theta if way == "reflection" else 180 - theta, np.degrees(np.arctan2(y, x)))
            expected = tree.eval(bsdfkit.direction(40, 70), wo)
            if shown.mask[row, column]:
                assert expected == 0
            # On a border between leaves either is right.
            checked += shown[row, column] == pytest.approx(expected, rel=1e-9)
    assert checked > 30


def test_a_slice_is_f_in_its_plane(tree):
    figure = tree.plot("slice", incident=[(20, 30), (60, 30)], decades=6, step_degrees=1)
    ax = panels(figure)[0]
    for k, theta in enumerate((20, 60)):
        line = next(x for x in ax.lines if x.get_label().startswith(f"θᵢ = {theta}°"))
        x, y = line.get_data()
        known = np.isfinite(x)
        r, alpha = np.hypot(x, y)[known], np.arctan2(x, y)[known]
        # Away from the light, at its azimuth and half a turn on.
        wo = np.stack([-np.sin(alpha) * np.cos(np.pi / 6), -np.sin(alpha) * np.sin(np.pi / 6), np.cos(alpha)], axis=-1)
        f = tree.eval(bsdfkit.direction(theta, 30), wo)
        top = max(tree.eval(bsdfkit.direction(t, 30), wo[n]) for t in (20, 60) for n in range(len(wo)))
        seen = (r > 0.02) & (np.abs(np.abs(alpha) - np.pi / 2) > 1e-6)
        near = np.isclose(top * 10 ** (6 * (r - 1)), f, rtol=1e-6)
        assert seen.sum() > 60 and near[seen].mean() > 0.95


def test_hemispherical_curves_are_the_totals(tree, measured, interpolant):
    figure = tree.plot("hemispherical", azimuths=[25.0], step_degrees=15)
    for ax, side in zip(panels(figure), ("front", "back")):
        drawn = [line for line in ax.lines if not line.get_label().startswith("_")]
        assert len(drawn) == 2
        for line, way in zip(drawn, (bsdfkit.Components.REFLECTION, bsdfkit.Components.TRANSMISSION)):
            theta = line.get_xdata()
            wi = bsdfkit.direction(theta if side == "front" else 180 - theta, 25.0)
            np.testing.assert_allclose(line.get_ydata(), tree.directional_hemispherical(wi, components=way))
    figure = bsdfkit.plot.draw([interpolant, measured], "hemispherical")
    ax = panels(figure)[0]
    dots = [line for line in ax.lines if line.get_marker() == "o"]
    shown = sorted(y for line in dots for y in line.get_ydata())
    quality = measured[0].quality()["incidences"]
    assert shown == sorted(i["hemispherical"][0] for i in quality)


def test_a_curve_has_the_colour_of_the_legend_on_both_sides(interpolant, measured):
    # Measured from the front alone: what comes after has no other place among the curves of the back.
    klems = interpolant.tabulate("klems-full", progress=False)
    figure = bsdfkit.plot.draw([interpolant, measured, klems], "hemispherical")
    (legend,) = figure.legends
    named = {text.get_text(): line.get_markeredgecolor() for text, line in zip(legend.get_texts(), legend.get_lines())}
    front, back = panels(figure)
    assert any(line.get_marker() == "o" for line in front.lines) and len(set(named.values())) == len(named) == 3
    drawn = [line for ax in (front, back) for line in ax.lines if not line.get_label().startswith("_")]
    assert len(drawn) == 5
    for line in drawn:
        assert line.get_markeredgecolor() == named[line.get_label()], line.get_label()


@pytest.mark.parametrize("incident", [(0, 0), (35, 110), (150, 20)])
@pytest.mark.parametrize("way", ["reflection", "transmission"])
def test_patches_and_leaves_hold_all_the_light(tree, klems, incident, way):
    """Areas in direction cosines are projected solid angles: areas times values sum to the total."""
    wi = bsdfkit.direction(*incident)
    components = bsdfkit.Components[way.upper()]
    for bsdf, kind, tolerance in ((klems, "patches", 0.01), (tree, "leaves", 0.005)):
        figure = bsdf.plot(kind, incident=incident, way=way, projection="cosines")
        places, values = polygons(panels(figure)[0])
        area = areas(places)
        assert area.sum() == pytest.approx(np.pi, rel=tolerance)
        total = bsdf.directional_hemispherical(wi, components=components)
        assert np.sum(area * values) == pytest.approx(total, rel=2 * tolerance)
    assert len(polygons(panels(klems.plot("patches", incident=incident, way=way))[0])[1]) == 145


def test_cells_are_where_their_value_is(tree, klems):
    for bsdf in (tree, klems):
        wi = bsdfkit.direction(50, 200)
        middles, outlines, _ = bsdf.cells(list(wi), "back")
        inside = 0.98 * outlines[:, ::4, :2] + 0.02 * middles[:, None, :2]
        wo = np.concatenate([inside, -np.sqrt(1 - np.sum(inside**2, axis=-1, keepdims=True))], axis=-1)
        expected = np.broadcast_to(bsdf.eval(wi, middles)[:, None], wo.shape[:2])
        # A chord cuts off a little of a bent border.
        assert np.isclose(bsdf.eval(wi, wo), expected).mean() > 0.97


def test_a_transmission_stored_one_way_shows_its_leaves_from_the_other(golden):
    one_way = bsdfkit.open(golden("xml/t4_tf.xml"))
    stored = {(c.incident, c.scattered) for c in one_way.components}
    ((incident, scattered),) = stored
    theta = 160 if scattered == "back" else 20
    figure = one_way.plot("leaves", incident=(theta, 40), way="transmission", projection="cosines")
    places, values = polygons(panels(figure)[0])
    total = one_way.directional_hemispherical(bsdfkit.direction(theta, 40))
    assert np.sum(areas(places) * values) == pytest.approx(total, rel=0.01)


def test_points_are_those_of_the_file_and_residuals_what_is_left(interpolant, measured):
    (m,) = measured
    k = 3
    theta, phi = bsdfkit.angles(m.wi[k])
    figure = bsdfkit.plot.draw([interpolant, m], "points", incident=(float(theta), float(phi)))
    wo, f = m.points(k)
    left, right = (ax for ax in panels(figure) if ax.collections)
    shown, residual = collection(left, PathCollection), collection(right, PathCollection)
    np.testing.assert_allclose(residual.get_array(), f - interpolant.eval(m.wi[k], wo), atol=1e-12)
    assert len(shown.get_offsets()) == len(f)
    # Equal areas: r² = 1 − cos θ.
    np.testing.assert_allclose(np.sum(shown.get_offsets() ** 2, axis=1), 1 - np.abs(wo[:, 2]), atol=1e-12)


def test_what_has_no_direction_has_no_place():
    from bsdfkit.plot._disk import Disk

    for projection in ("equal-area", "angle", "cosines"):
        places = Disk(projection).place([[np.nan, 0, 1], [0, 0, 1], [0, 0, -1], [0, -1, 0]])
        assert np.isnan(places[0]).any()
        np.testing.assert_allclose(places[1:], [[0, 0], [0, 0], [0, -1]], atol=1e-12)


def test_an_incidence_is_seen_through_the_symmetry(measured):
    (m,) = measured
    k = 2
    wi = m.wi[k]
    turn = np.array([[np.cos(2.0), -np.sin(2.0)], [np.sin(2.0), np.cos(2.0)]])
    there = np.append(turn @ wi[:2], wi[2])
    nearest, off, rows = m.nearest(list(there))
    assert nearest == k and off < 1e-6
    np.testing.assert_allclose(np.array(rows) @ wi[:2], there[:2], atol=1e-9)
    figure = m.plot("hemisphere", incident=tuple(float(a) for a in bsdfkit.angles(there)))
    dots = collection(panels(figure)[0], PathCollection)
    wo, f = m.points(k)
    np.testing.assert_allclose(dots.get_array().max(), f.max())
    places = (wo[:, :2] @ turn.T) / np.sqrt(1 + np.abs(wo[:, 2:]))
    # Measured directions are in single precision.
    np.testing.assert_allclose(dots.get_offsets(), places, atol=2e-5)


def test_the_mesh_has_the_incidences_and_their_peaks(interpolant, measured):
    (m,) = measured
    figure = interpolant.plot("mesh", projection="cosines")
    left, right = panels(figure)
    places = [np.column_stack(line.get_data()) for line in left.lines if line.get_marker() == "o"]
    assert any(p.shape == (len(m.wi), 2) and np.allclose(p, m.wi[:, :2]) for p in places)
    # Glass: its one peak is about where light goes straight through.
    centres, spread = interpolant.families(m.wi, "front", "back")
    assert np.degrees(np.arccos(-np.sum(centres[:, 0] * m.wi, axis=-1))).max() < 4
    assert (spread[:, 0, 0] > 0).all()
    drawn = next(line for line in right.lines if line.get_label() == "family 1")
    np.testing.assert_allclose(np.column_stack(drawn.get_data()), centres[:, 0, :2])
    assert panels(m.plot("mesh"))[0].get_title() == f"{len(m.wi)} measured incidences, isotropic symmetry"


def test_one_incidence_is_called_one(measurements, tmp_path):
    file = sorted(Path(measurements).glob("*.txt"))[0]
    (m,) = bsdfkit.read(file)
    assert panels(m.plot("mesh"))[0].get_title().startswith("1 measured incidence, ")


def test_a_difference_is_the_second_less_the_first(tree, klems):
    figure = bsdfkit.plot.draw([tree, klems], "compare", incident=(30, 0), pixels=48, labels=["a", "b"])
    first, second, difference = (ax.images[0].get_array() for ax in panels(figure))
    np.testing.assert_allclose(difference.filled(0), (second - first).filled(0))
    # Projected solid angles by the concentric squares of another grid.
    u = (np.arange(300) + 0.5) / 300
    theta, phi = np.degrees(np.arcsin(np.sqrt(u)))[:, None], np.arange(0.5, 360, 1.0)
    wi, wo = bsdfkit.direction(30, 0), bsdfkit.direction(theta, phi)
    f, g = tree.eval(wi, wo), klems.eval(wi, wo)
    l1 = float(panels(figure)[2].get_title().split("L1 = ")[1])
    assert l1 == pytest.approx(np.abs(f - g).sum() / f.sum(), rel=0.02)
    same = bsdfkit.plot.draw([tree, tree], "compare", pixels=32)
    assert panels(same)[2].get_title().endswith("L1 = 0")


def test_the_lobe_is_as_far_as_f_is_large(tree):
    figure = tree.plot("lobe", incident=(30, 0), linear=True, steps=(30, 60))
    surfaces = [c for c in panels(figure)[0].collections if isinstance(c, Poly3DCollection)]
    assert len(surfaces) == 2
    for surface in surfaces:
        # matplotlib keeps them by faces from 3.11 on.
        faces = surface._faces if hasattr(surface, "_faces") else surface._vec[:3].T
        corners = np.reshape(np.asarray(faces), (-1, 3))
        r = np.linalg.norm(corners, axis=1)
        corners, r = corners[(r > 1e-6) & (r < 1.1)], r[(r > 1e-6) & (r < 1.1)]
        f = tree.eval(bsdfkit.direction(30, 0), corners / r[:, None])
        scale = np.median(r / f)
        # On a border between leaves either is right.
        assert len(r) > 1000 and np.isclose(r, scale * f, rtol=1e-6).mean() > 0.9


def test_colours_grow_lighter_for_every_eye():
    import matplotlib

    linear = lambda c: np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)  # noqa: E731
    # Who lacks the middle cones. [Viénot 1999]
    deuteranope = np.array([[0.29275, 0.70725, 0.0], [0.29275, 0.70725, 0.0], [-0.02234, 0.02234, 1.0]])
    for name in (_style.VALUES, _style.ERRORS):
        rgb = linear(matplotlib.colormaps[name](np.linspace(0, 1, 64))[:, :3])
        for seen in (rgb, rgb @ deuteranope.T):
            assert (np.diff(seen @ [0.2126, 0.7152, 0.0722]) > 0).all(), name


@pytest.mark.parametrize("low, high", [(0.051, 0.089), (0.011, 0.19), (0.07, 4.0), (0.02, 900.0), (3e-7, 2e-3)])
def test_a_scale_has_numbers_that_people_read(low, high):
    from matplotlib.colors import LogNorm
    from matplotlib.cm import ScalarMappable

    with _style.style():
        figure = _style.figure(None, 3, 3)
        ax = figure.subplots()
        bar = _style.colorbar(figure, ScalarMappable(LogNorm(low, high)), ax, "BRDF (1/sr)")
        figure.draw_without_rendering()
        words = [label.get_text() for label in bar.ax.yaxis.get_ticklabels(which="both")]
    words = [word for word in words if word]
    assert 3 <= len(words) <= 10
    assert not any("$" in word or "{" in word for word in words), words


def test_a_long_title_keeps_its_ends():
    assert _style.clipped("fabric 7") == "fabric 7"
    assert _style.clipped("a" * 30 + "b" * 30, 20) == "a" * 13 + "…" + "b" * 6


def test_files_have_their_form_and_real_type(tree, tmp_path):
    png, svg = tmp_path / "a.png", tmp_path / "a.svg"
    assert tree.plot(output=png) is not None
    tree.plot("slice", output=str(svg))
    assert png.read_bytes()[:4] == b"\x89PNG"
    text = svg.read_text()
    assert text.startswith("<?xml") and "<text" in text and "BRDF above" in text and "sans-serif" in text
    # The same picture is the same file.
    first = svg.read_bytes()
    tree.plot("slice", output=svg)
    assert svg.read_bytes() == first
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.png", "a.svg"]


def test_a_file_is_replaced_whole_or_not_at_all(tree, tmp_path, monkeypatch):
    from matplotlib.figure import Figure

    path = tmp_path / "a.png"
    path.write_text("before")

    def full(self, file, **_):
        file.write(b"half")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Figure, "savefig", full)
    with pytest.raises(bsdfkit.IoError, match="a.png: No space left"):
        tree.plot(output=path)
    assert path.read_text() == "before" and list(tmp_path.iterdir()) == [path]
    with pytest.raises(bsdfkit.IoError, match="missing"):
        tree.plot(output=tmp_path / "missing" / "a.png")


def test_bad_input_says_what_was_expected(tree, klems, interpolant, measured, golden):
    back = bsdfkit.open(golden("xml/dir_rb.xml"))
    wrong = [
        (tree, "portrait", {}, "kind: expected one of hemisphere"),
        (tree, "hemisphere", {"size": 3}, "hemisphere: expected options incident.* found size"),
        (tree, "hemisphere", {"incident": (200, 0)}, "theta 0 to 180"),
        (tree, "hemisphere", {"incident": "up"}, "incident: expected"),
        (tree, "hemisphere", {"projection": "mercator"}, "projection: expected one of equal-area"),
        (tree, "hemisphere", {"way": "both"}, 'way: expected "reflection"'),
        (tree, "hemisphere", {"output": "a.jpg"}, "ending in .png or .svg"),
        (
            interpolant,
            "hemisphere",
            {"way": "reflection"},
            "expected reflection of light from the front, found back transmission, front transmission$",
        ),
        (
            back,
            "hemisphere",
            {},
            r"light from the front, found back reflection \(theta above 90: light from the back\)",
        ),
        (tree, "patches", {}, "expected patches of the front reflection, found the form tree4"),
        (klems, "leaves", {}, "expected leaves"),
        (tree, "compare", {}, "expected two files"),
        (tree, "mesh", {}, "one interpolant or measurement"),
        (tree, "points", {}, "one measurement and one interpolant"),
        (measured, "lobe", {}, "found a measurement"),
        (tree, "slice", {"incident": []}, "at least one"),
        (tree, "slice", {"step_degrees": 0}, "step_degrees: expected 0.01 to 30, found 0"),
        (tree, "hemisphere", {"pixels": 10**9}, "pixels: expected 8 to 4096"),
        (tree, "hemisphere", {"decades": float("nan")}, "decades: expected"),
        (tree, "lobe", {"steps": (9, 10**6)}, "steps: expected"),
        ([tree, measured], "hemisphere", {"way": "reflection"}, "expected front reflection, found none measured"),
        (7, "hemisphere", {}, "expected a Bsdf"),
    ]
    for what, kind, options, words in wrong:
        with pytest.raises(bsdfkit.ArgumentError, match=words):
            bsdfkit.plot.draw(what, kind, **options)
    with pytest.raises(bsdfkit.ArgumentError, match="labels: expected 1, found 2"):
        bsdfkit.plot.draw(tree, labels=["a", "b"])


def plot_command(*words):
    return subprocess.run([sys.executable, "-m", "bsdfkit.plot", *map(str, words)], capture_output=True, text=True)


def test_the_command_line_draws_and_its_status_tells_what_is_wrong(golden, tmp_path):
    file, out = golden("xml/t4_rf_rb_tf_tb.xml"), tmp_path / "out.svg"
    ran = plot_command(file, f"again={file}", "--kind", "slice", "--incident", "30,0", "--incident", "60", "-o", out)
    assert (ran.returncode, ran.stdout.strip()) == (0, str(out)), ran.stderr
    assert "again, θᵢ = 60°" in out.read_text()
    rubbish = tmp_path / "rubbish.xml"
    rubbish.write_text("<Window")
    for words, status, message in [
        ([file, "--incident", "1,2", "--incident", "3,4", "-o", out], 2, "takes one, found 2"),
        ([tmp_path / "missing.xml", "-o", out], 3, "missing.xml"),
        ([rubbish, "-o", out], 4, "rubbish.xml"),
        ([file, "--kind", "portrait", "-o", out], 2, "invalid choice"),
        ([file, "--kind", "patches", "--elevation", "3", "-o", out], 2, "--kind patches: expected --incident"),
        ([file, "--incident", "north", "-o", out], 2, "THETA,PHI"),
    ]:
        ran = plot_command(*words)
        assert ran.returncode == status and message in ran.stderr, (words, ran.stderr)
        assert "Traceback" not in ran.stderr
    assert {p.name for p in tmp_path.iterdir()} == {"out.svg", "rubbish.xml"}


def test_without_matplotlib_it_says_what_to_install(golden):
    program = f"import sys; sys.modules['matplotlib'] = None; import bsdfkit; bsdfkit.open({str(golden('xml/t4_tf.xml'))!r}).plot()"
    ran = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert "pip install 'bsdfkit[plot]'" in ran.stderr
