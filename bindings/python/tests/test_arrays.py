"""Shapes, dtypes, NaN, selections, threads."""

from concurrent.futures import ThreadPoolExecutor

import bsdfkit
import numpy as np
import pytest
from bsdfkit import Components, Part
from bsdfkit._flat import flat

WI = bsdfkit.direction(30, 20)
WO = bsdfkit.direction(40, 160)


def test_directions_and_angles():
    np.testing.assert_allclose(bsdfkit.direction(90, 90), [0, 1, 0], atol=1e-16)
    w = bsdfkit.direction([[10.0], [170.0]], [0.0, 90.0, 270.0])
    assert w.shape == (2, 3, 3)
    theta, phi = bsdfkit.angles(w)
    np.testing.assert_allclose(theta, [[10] * 3, [170] * 3], atol=1e-12)
    np.testing.assert_allclose(phi, [[0, 90, 270]] * 2, atol=1e-12)
    assert isinstance(bsdfkit.angles(WI)[0], float)


def test_smooth_lookup(golden, tree, directions, tmp_path):
    path = golden("xml/t4_rf_rb_tf_tb.xml")
    smooth = bsdfkit.open(path, smooth=True)
    wi, wo = directions(200, 3), directions(200, 4)
    assert np.count_nonzero(smooth.eval(wi, wo) != tree.eval(wi, wo)) > 50
    drawn, weight, pdf, _ = smooth.sample(wi, (np.arange(200) + 0.5) / 200)
    np.testing.assert_array_equal(weight, smooth.directional_hemispherical(wi))
    np.testing.assert_array_equal(pdf, smooth.pdf(wi, drawn))
    smooth.save(tmp_path / "again.xml")
    again = bsdfkit.open(tmp_path / "again.xml")
    # What is written is what is stored, to the digits of XML.
    np.testing.assert_allclose(again.eval(wi, wo), tree.eval(wi, wo), rtol=1e-4)


@pytest.mark.parametrize("verb", ["eval", "pdf"])
def test_pairs_broadcast_and_equal_single_answers(tree, directions, verb):
    wi, wo = directions(5, 1), directions(4, 2)
    ask = getattr(tree, verb)
    table = ask(wi[:, None], wo)
    assert table.shape == (5, 4) and table.dtype == np.float64
    for i in range(5):
        for j in range(4):
            single = ask(wi[i], wo[j])
            assert isinstance(single, float) and single == table[i, j]
    assert np.count_nonzero(table) > 10
    assert ask(wi[:, None, None], wo[None, :, None]).shape == (5, 4, 1)
    assert ask(np.empty((0, 3)), wo[0]).shape == (0,)
    assert ask(np.empty((2, 0, 3)), wo[0]).shape == (2, 0)
    assert ask(wi, wo[:1]).shape == (5,)


def test_value_and_density_at_once(tree, directions):
    wi, wo = directions(20, 5), directions(30, 6)
    some = Components.TRANSMISSION
    value, pdf = tree.eval_pdf(wi[:, None], wo, components=some)
    np.testing.assert_array_equal(value, tree.eval(wi[:, None], wo, components=some))
    np.testing.assert_array_equal(pdf, tree.pdf(wi[:, None], wo, components=some))
    assert np.count_nonzero(value) > 50 and np.count_nonzero(pdf) > 50
    one = tree.eval_pdf(wi[3], wo[7], components=some)
    assert one == (value[3, 7], pdf[3, 7]) and all(isinstance(x, float) for x in one)
    assert np.isnan(tree.eval_pdf([np.nan, 0, 1], WO)).all()
    with pytest.raises(bsdfkit.ArgumentError):
        tree.eval_pdf(wi, wo)


def test_shapes_of_the_other_verbs(tree, directions):
    wi = directions(6, 3).reshape(2, 3, 3)
    assert tree.eval(wi, WO, xyz=True).shape == (2, 3, 3)
    assert tree.directional_hemispherical(wi).shape == (2, 3)
    assert isinstance(tree.directional_hemispherical(WI), float)
    assert tree.projected_solid_angle(wi).shape == (2, 3, 2)
    assert tree.projected_solid_angle(wi, WO).shape == (2, 3, 2)
    assert tree.projected_solid_angle(WI).shape == (2,)
    u = np.linspace(0.05, 0.95, 7)
    sample = tree.sample(wi[:, :, None], u)
    assert [field.shape for field in sample] == [(2, 3, 7, 3), (2, 3, 7), (2, 3, 7), (2, 3, 7)]
    assert np.issubdtype(sample.part.dtype, np.integer)
    one = tree.sample(wi[1, 2], u[3])
    assert one.wo.shape == (3,) and isinstance(one.weight, float)
    np.testing.assert_array_equal(one.wo, sample.wo[1, 2, 3])
    assert (one.pdf, one.part) == (sample.pdf[1, 2, 3], sample.part[1, 2, 3])
    two = tree.sample2(wi, np.full((2, 1, 2), 0.3))
    assert two.wo.shape == (2, 3, 3)


def test_any_memory_layout_gives_the_same(tree, directions):
    wi, wo = directions(50, 4), directions(50, 5)
    expected = tree.eval(wi, wo)
    unaligned = np.frombuffer(b"x" + wi.tobytes(), dtype=np.uint8)[1:].view(np.float64)
    for other in [
        np.asfortranarray(wi),
        np.repeat(wi, 2, axis=0)[::2],
        wi.tolist(),
        wi.astype(">f8"),
        unaligned.reshape(50, 3),
    ]:
        np.testing.assert_array_equal(tree.eval(other, wo), expected)
    np.testing.assert_array_equal(tree.eval(wi[::-1], wo[::-1]), expected[::-1])
    np.testing.assert_allclose(tree.eval(wi.astype(np.float32), wi), tree.eval(wi, wi), rtol=1)


def test_more_than_a_chunk_of_samples_and_colours(tree, directions):
    count = 70_000
    wi, wo = directions(count, 6), directions(count, 7)
    u = np.random.default_rng(8).random((count, 2))
    picks = [0, 65_535, 65_536, count - 1]
    one, two = tree.sample(wi, u[:, 0]), tree.sample2(WI, u)
    xyz, wide = tree.eval(wi, wo, xyz=True), tree.eval(wi[:, None], wo[None, :2])
    for k in picks:
        np.testing.assert_array_equal(one.wo[k], tree.sample(wi[k], u[k, 0]).wo)
        np.testing.assert_array_equal(two.wo[k], tree.sample2(WI, u[k]).wo)
        np.testing.assert_array_equal(xyz[k], tree.eval(wi[k], wo[k], xyz=True))
        assert wide[k, 1] == tree.eval(wi[k], wo[1])


def test_nan_and_darkness(tree, golden):
    nan = [np.nan, 0, 1]
    assert np.isnan(tree.eval(nan, WO)) and np.isnan(tree.eval(WI, nan))
    assert np.isnan(tree.eval(nan, WO, xyz=True)).all()
    assert np.isnan(tree.pdf(nan, WO)) and np.isnan(tree.directional_hemispherical(nan))
    assert np.isnan(tree.projected_solid_angle(nan)).all()
    for drawn in [tree.sample(nan, 0.5), tree.sample(WI, np.nan), tree.sample2(WI, [0, np.nan])]:
        assert np.isnan(drawn.wo).all() and np.isnan(drawn.weight) and np.isnan(drawn.pdf)
        assert drawn.part == Part.NOTHING
    black = tree.sample(WI, 0.5, components=Components.NONE)
    assert np.isnan(black.wo).all() and (black.weight, black.pdf) == (0, 0)
    assert black.part == Part.NOTHING


def test_samples_agree_with_pdf_and_eval(tree):
    u = (np.arange(4000) + 0.5) / 4000
    wo, weight, pdf, part = tree.sample(WI, u)
    np.testing.assert_allclose(pdf, tree.pdf(WI, wo), rtol=1e-9)
    np.testing.assert_allclose(weight, tree.directional_hemispherical(WI), rtol=1e-12)
    estimate = tree.eval(WI, wo) * np.abs(wo[:, 2]) / pdf
    np.testing.assert_allclose(estimate, weight, rtol=1e-5)
    assert {tree.components[n].scattered for n in np.unique(part)} == {"front", "back"}


def test_values_of_selected_components_sum_up(tree):
    wo = np.stack([WI * [-1, -1, 1], WI * [-1, -1, -1]])
    alone = [tree.eval(WI, wo, components=c) for c in (Components.LAMBERTIAN, Components.NON_LAMBERTIAN)]
    assert np.allclose(alone[0] + alone[1], tree.eval(WI, wo), rtol=1e-6, atol=0)
    assert np.all(alone[0][0] == tree.lambertian[0, 0] / np.pi) and np.any(alone[1] > 0)
    reflected = tree.eval(WI, wo, components=Components.REFLECTION)
    assert np.all(reflected[0] == tree.eval(WI, wo[0], components=Components.ALL)) and np.all(reflected[1] == 0)
    with pytest.raises(bsdfkit.ArgumentError, match="components: expected without xyz"):
        tree.eval(WI, wo, xyz=True, components=Components.ALL)


def test_selected_components_sum_up(tree):
    total = tree.directional_hemispherical
    reflected = total(WI, components=Components.REFLECTION)
    transmitted = total(WI, components=Components.TRANSMISSION)
    assert reflected > 0.01 and transmitted > 0.01
    assert reflected + transmitted == pytest.approx(total(WI), rel=1e-12)
    assert total(WI, components=Components.REFLECTION & Components.FRONT) == reflected
    assert total(WI, components=Components.BACK) == 0
    assert total(WI, components=Components.FRONT & Components.BACK) == 0
    assert total(WI, components=Components.LAMBERTIAN) == tree.lambertian[0].sum()
    drawn = tree.sample(WI, [0.1, 0.9], components=Components.TRANSMISSION)
    assert (drawn.wo[:, 2] < 0).all()


def test_four_threads_on_one_handle(tree, directions):
    wi, wo = directions(20_000, 9), directions(20_000, 10)
    u = np.random.default_rng(11).random(20_000)

    def ask(_):
        fresh = tree.sample(wi, u)
        return np.concatenate([tree.eval(wi, wo), tree.pdf(wi, wo), fresh.wo.ravel()])

    expected = ask(0)
    with ThreadPoolExecutor(4) as pool:
        for answer in pool.map(ask, range(8)):
            np.testing.assert_array_equal(answer, expected)


def test_flat_arrays_of_a_render_form(golden):
    bsdf = bsdfkit.open(golden("compiled/render_turned.safetensors"))
    answers = flat(bsdf).answers
    assert [a.pair for a in answers if not a.swapped] == [0, 1, 2, 3]
    folds = {a.stored.render["fold"] for a in answers}
    assert folds == {"none", "mirror-x", "mirror-y", "quadrants"}
    none = next(a for a in answers if a.stored.render["fold"] == "none")
    incidences = none.stored.arrays["render.incidences"]
    side = 4 * none.stored.render["intervals"] + 1  # the finer chart has twice as many
    assert incidences.shape == (side * side, 1 + 6 * len(none.stored.render["layers"]))
    # The node in the middle is the normal: the first column is the total there.
    sign = 1.0 if none.stored.incident == 0 else -1.0
    total = bsdf.directional_hemispherical([0, 0, sign], components=selected(none))
    np.testing.assert_allclose(incidences[side * side // 2, 0], total, rtol=1e-6)
    assert none.stored.arrays["render.layer.0.values"].dtype == np.float16


def selected(answer):
    same = answer.stored.incident == answer.stored.scattered
    return Components.NON_LAMBERTIAN & (Components.REFLECTION if same else Components.TRANSMISSION)
