"""The plugin's gathers from render forms answer as the library does, and draw what they say."""

import bsdfkit
import numpy as np
import pytest

from test_mitsuba import JIT, asked, chi_square, interaction, loaded, opened, shining, variant

import drjit as dr  # isort: skip
import mitsuba as mi  # isort: skip

#: Random tables of every fold with two layers; a transmission that also answers reversed; colour.
FORMS = ["render_isotropic", "render_turned", "t3_tf", "color_mtx_0.3333_0.3333"]


@pytest.fixture(scope="module")
def form(golden, tmp_path_factory):
    """The path of a render form, made of a tree or a matrix where there is none."""
    folder = tmp_path_factory.mktemp("forms")

    def path(name):
        if name.startswith("render"):
            return golden(f"compiled/{name}.safetensors")
        made = folder / f"{name}.safetensors"
        if not made.exists():
            opened(golden(f"xml/{name}.xml")).tabulate("render", progress=False).save(made)
        return made

    return path


@pytest.mark.parametrize("name", JIT)
@pytest.mark.parametrize("file", FORMS)
def test_values_and_densities_are_the_librarys(form, directions, name, file):
    variant(name)
    wi, wo = (directions(50_000, seed).astype(np.float32) for seed in (3, 4))
    library = opened(form(file))
    value, pdf = asked(loaded(form(file)), False, wi, wo)
    wi, wo = wi.astype(float), wo.astype(float)
    tolerance = 2e-3 if file.startswith("color") else 1e-3
    for found, expected in ((value, library.eval(wi, wo) * np.abs(wo[:, 2])), (pdf, library.pdf(wi, wo))):
        assert expected.max() > 0.1
        wrong = np.abs(found - expected) > tolerance * expected + 1e-5
        assert wrong.mean() <= 1e-4, (found[wrong][:5], expected[wrong][:5])


@pytest.mark.parametrize("name", JIT)
@pytest.mark.parametrize("file", FORMS[:3])
@pytest.mark.parametrize("angles", [(20.0, 33.0), (70.0, 200.0), (125.0, 80.0)])
def test_samples_have_the_density_that_is_told(form, name, file, angles, tmp_path, monkeypatch):
    variant(name)
    monkeypatch.chdir(tmp_path)
    wi = [float(x) for x in bsdfkit.direction(*angles)]
    if opened(form(file)).directional_hemispherical(wi) > 0.0:
        chi_square(form(file), wi, count=18)


@pytest.mark.parametrize("name", [*JIT, "scalar_rgb"])
@pytest.mark.parametrize("file", FORMS[2:])
@pytest.mark.parametrize("theta", [30.0, 130.0])
def test_furnace(form, name, file, theta):
    scalar = variant(name)
    eye, library = bsdfkit.direction(theta, 55.0), opened(form(file))
    n = 400
    u, v = np.meshgrid((np.arange(n) + 0.5) / n, (np.arange(n) + 0.5) / n)
    r, phi = np.sqrt(u), 2.0 * np.pi * v
    cells = np.stack([r * np.cos(phi), r * np.sin(phi), np.sqrt(1.0 - u)], -1)
    expected = sum(np.pi * library.eval(eye, cells * [1.0, 1.0, side]).mean() for side in (1.0, -1.0))
    samples, tolerance = (64, 0.03) if scalar else (4096, 0.01)
    assert shining(form(file), eye, samples) == pytest.approx(expected, rel=tolerance, abs=1e-4)


def test_gradients(form):
    """A value's derivative by all that is stored is that of a finite step."""
    variant("llvm_ad_rgb")
    plugin = loaded(form("render_turned"))
    parameters, ctx = mi.traverse(plugin), mi.BSDFContext()
    si, wo = interaction(bsdfkit.direction(30.0, 70.0)), mi.Vector3f(*map(float, bsdfkit.direction(40.0, 260.0)))
    before = float(plugin.eval(ctx, si, wo)[1][0])
    assert before > 0.0
    dr.enable_grad(parameters["values"])
    parameters.update()
    dr.backward(plugin.eval(ctx, si, wo)[1])
    gradient, values = dr.grad(parameters["values"]).numpy().copy(), dr.detach(parameters["values"]).numpy().copy()
    assert (gradient * values).sum() == pytest.approx(before, rel=1e-4)
    parameters["values"] = mi.Float(values * 1.5)
    parameters.update()
    assert float(plugin.eval(ctx, si, wo)[1][0]) == pytest.approx(1.5 * before, rel=1e-5)
