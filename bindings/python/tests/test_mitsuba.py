"""The plugin for Mitsuba answers as the library does, and draws what it says."""

import os
import warnings
from glob import glob

import bsdfkit
import numpy as np
import pytest

if "DRJIT_LIBLLVM_PATH" not in os.environ:
    found = glob("/usr/lib/*/libLLVM.so.19.1")
    if found:
        os.environ["DRJIT_LIBLLVM_PATH"] = found[0]

if "CI" not in os.environ:
    pytest.importorskip("mitsuba", reason="no mitsuba: the plugin was not tried")
import drjit as dr  # noqa: E402
import mitsuba as mi  # noqa: E402
import bsdfkit.mitsuba  # noqa: E402

# Random trees of both ranks, with all four pairs of sides and with one transmission that also answers reversed; matrices of
# equal, unequal and unusual bases; colour; Lambertian parts alone.
FILES = [
    "t3_rf_rb_tf_tb",
    "t4_rf_rb_tf_tb",
    "t3_tf",
    "t4_tf",
    "kq_sample",
    "custom_basis",
    "mixed_basis",
    "color_tree_0.3333_0.3333",
    "color_mtx_0.3333_0.3333",
    "diffuse_pure",
]
VARIANTS = ["scalar_rgb", "scalar_spectral", "llvm_ad_rgb", "llvm_ad_spectral", "llvm_ad_mono"]
JIT = ["llvm_ad_rgb", "llvm_ad_spectral"]
LUMINANCE = np.array([0.21263901, 0.71516868, 0.07219232])


def variant(name):
    """Sets a variant; where there is no LLVM 19 the test is skipped, in CI an error unless it says that there is none."""
    best, why = bsdfkit.mitsuba.best_variant()
    if name.startswith("llvm") and best.startswith("scalar"):
        if "CI" in os.environ and "BSDFKIT_WITHOUT_LLVM" not in os.environ:
            pytest.fail(why)
        pytest.skip(why)
    mi.set_variant(name)
    return name.startswith("scalar")


def opened(path):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", bsdfkit.FileWarning)
        return bsdfkit.open(path)


def loaded(path):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", bsdfkit.FileWarning)
        return mi.load_dict({"type": "bsdfkit", "filename": str(path)})


@pytest.fixture(scope="module")
def xml(golden):
    return lambda name: golden(f"xml/{name}.xml")


def interaction(wi, wavelength=550.0):
    si = dr.zeros(mi.SurfaceInteraction3f)
    si.wi = mi.Vector3f(*wi.T) if wi.ndim > 1 else mi.Vector3f(*map(float, wi))
    if mi.is_spectral:
        si.wavelengths = [wavelength] * 4
    return si


def luminance(spectra):
    """Luminance of spectra of grey data, shape (channels, ...)."""
    return np.tensordot(LUMINANCE, spectra, 1) if mi.is_rgb else spectra[0]


def asked(plugin, scalar, wi, wo):
    """f |cos θo| and pdf of all pairs."""
    ctx = mi.BSDFContext()
    if not scalar:
        value, pdf = plugin.eval_pdf(ctx, interaction(wi), mi.Vector3f(*wo.T))
        return luminance(np.array(value)), np.array(pdf) + np.zeros(len(wi))
    values, densities = [], []
    for a, b in zip(wi, wo):
        value, pdf = plugin.eval_pdf(ctx, interaction(a), mi.Vector3f(*map(float, b)))
        values.append(luminance(np.array(value)))
        densities.append(pdf)
    return np.array(values), np.array(densities)


@pytest.mark.parametrize("name", VARIANTS)
@pytest.mark.parametrize("file", FILES)
def test_values_are_the_librarys(xml, directions, name, file):
    scalar = variant(name)
    count = 200 if scalar else 50_000
    # What single precision can hold, so that both are asked for the same.
    wi, wo = (directions(count, seed).astype(np.float32) for seed in (3, 4))
    if file.startswith("color") and mi.is_rgb:
        # Near grey: cut at no channel.
        tolerance = 1e-3
    else:
        tolerance = 1e-4 if not file.startswith("color") else 2e-3
    library, plugin = opened(xml(file)), loaded(xml(file))
    value, pdf = asked(plugin, scalar, wi, wo)
    wi, wo = wi.astype(float), wo.astype(float)
    f = library.eval(wi, wo) * np.abs(wo[:, 2])
    assert f.max() > 0.01
    # Single precision puts some directions on the other side of a cell's wall.
    wrong = np.abs(value - f) > tolerance * f + 1e-6
    assert wrong.mean() <= 1e-3, (value[wrong][:5], f[wrong][:5])
    if file == "t3_tf" and not scalar:
        # Backward these are drawn from a table near f.
        pdf, wi, wo = (a[wi[:, 2] > 0.0] for a in (pdf, wi, wo))
    expected = library.pdf(wi, wo)
    wrong = np.abs(pdf - expected) > 1e-4 * expected + 1e-6
    assert wrong.mean() <= 1e-3, (pdf[wrong][:5], expected[wrong][:5])


def chi_square(path, wi, count):
    """Mitsuba's test of samples against their density, one of `count`: at once 1 % of the time by chance."""
    plugin, ctx = loaded(path), mi.BSDFContext()

    def draw(u):
        # Mitsuba's adapter drops what has no weight; a direction drawn from a table near f may have none.
        bs, _ = plugin.sample(ctx, interaction(np.array(wi)), u[0], mi.Point2f(u[1], u[2]))
        return bs.wo, dr.select(bs.pdf > 0.0, 1.0, 0.0)

    def density(wo):
        return plugin.pdf(ctx, interaction(np.array(wi)), wo)

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", bsdfkit.FileWarning)
        test = mi.chi2.ChiSquareTest(
            domain=mi.chi2.SphericalDomain(),
            sample_func=draw,
            pdf_func=density,
            sample_dim=3,
            sample_count=400_000,
            res=67,
            # Densities are constant in steps, which no rule of integration likes.
            ires=64,
        )
        assert test.run(significance_level=0.01, test_count=count), test.messages


@pytest.mark.parametrize("name", JIT)
@pytest.mark.parametrize("file", ["t3_rf_rb_tf_tb", "t4_rf_rb_tf_tb", "t3_tf", "t4_tf", "custom_basis", "mixed_basis"])
@pytest.mark.parametrize("angles", [(20.0, 33.0), (70.0, 200.0), (125.0, 80.0)])
def test_samples_have_the_density_that_is_told(xml, name, file, angles, tmp_path, monkeypatch):
    variant(name)
    # Where the test leaves its data when it fails.
    monkeypatch.chdir(tmp_path)
    chi_square(xml(file), [float(x) for x in bsdfkit.direction(*angles)], count=36)


@pytest.mark.parametrize("name", VARIANTS)
@pytest.mark.parametrize("file", ["t3_rf_rb_tf_tb", "t4_tf", "t3_tf", "kq_sample", "mixed_basis"])
def test_means_of_samples_are_integrals(xml, name, file):
    """Of f |cos| times 1, x, y and z, by the library's quadrature over cells of equal projected solid angle."""
    scalar = variant(name)
    library, plugin = opened(xml(file)), loaded(xml(file))
    count, generator = (4000 if scalar else 400_000), np.random.default_rng(8)
    for theta, phi in ((35.0, 70.0), (140.0, 250.0)):
        wi = bsdfkit.direction(theta, phi)
        u1, u2 = generator.random(count), generator.random((2, count))
        ctx = mi.BSDFContext()
        if scalar:
            drawn = [plugin.sample(ctx, interaction(wi), a, mi.Point2f(b, c)) for a, b, c in zip(u1, *u2)]
            wo = np.array([np.array(bs.wo) for bs, _ in drawn]).T
            weight = np.array([luminance(np.array(w)) for _, w in drawn])
        else:
            u1 = mi.Float(u1.astype(np.float32))
            bs, w = plugin.sample(ctx, interaction(wi), u1, mi.Point2f(u2.astype(np.float32)))
            wo, weight = np.array(bs.wo), luminance(np.array(w))
        n = 400
        u, v = np.meshgrid((np.arange(n) + 0.5) / n, (np.arange(n) + 0.5) / n)
        r, phi = np.sqrt(u), 2.0 * np.pi * v
        cells = np.stack([r * np.cos(phi), r * np.sin(phi), np.sqrt(1.0 - u)], -1)
        expected, spread = np.zeros(4), np.zeros(4)
        for side in (1.0, -1.0):
            w = cells * [1.0, 1.0, side]
            f = library.eval(wi, w)
            expected += [np.pi * (f * g).mean() for g in (1.0, w[..., 0], w[..., 1], w[..., 2])]
        found = np.stack([weight, weight * wo[0], weight * wo[1], weight * wo[2]])
        spread = found.std(axis=1) / np.sqrt(count)
        off = np.abs(found.mean(axis=1) - expected)
        assert (off < 5.0 * spread + 2e-3 * expected[0]).all(), (found.mean(axis=1), expected)


@pytest.mark.parametrize("name", JIT)
def test_from_behind_the_normal_is_no_exception(xml, name):
    """There four cells of a lone isotropic transmission meet, each seen from a quarter: one alone had up to 17 % more light."""
    variant(name)
    library, plugin = opened(xml("t3_tf")), loaded(xml("t3_tf"))
    side = -1.0 if library.components[0].incident == "front" else 1.0
    n = 200_000
    r, phi = np.sqrt((np.arange(n) + 0.5) / n), np.arange(n) * 2.399963
    wo = np.stack([r * np.cos(phi), r * np.sin(phi), -side * np.sqrt(1.0 - r * r)])
    expected = float(library.directional_hemispherical(np.array([1e-5, 0.0, side])))
    for wi in ([0.0, 0.0, side], [-1e-17, 3e-17, side], [1e-9, 1e-9, side]):
        f = luminance(np.array(plugin.eval(mi.BSDFContext(), interaction(np.array(wi)), mi.Vector3f(*wo)))) / np.abs(wo[2])
        assert np.pi * f.mean() == pytest.approx(expected, rel=5e-3), wi
        u = np.random.default_rng(9).random((3, n)).astype(np.float32)
        _, weight = plugin.sample(mi.BSDFContext(), interaction(np.array(wi)), mi.Float(u[0]), mi.Point2f(u[1:]))
        assert luminance(np.array(weight)).mean() == pytest.approx(expected, rel=1e-2), wi


@pytest.mark.parametrize("file", ["xml/t3_tf.xml", "xml/t4_rf_rb_tf_tb.xml", "xml/mixed_basis.xml", "compiled/render_turned.safetensors"])
def test_samples_of_the_scalar_variant_have_the_librarys_density(golden, file, tmp_path, monkeypatch):
    """Drawn one at a time; Mitsuba's test itself wants arrays."""
    variant("scalar_rgb")
    monkeypatch.chdir(tmp_path)
    count, wi = 8_000, bsdfkit.direction(125.0, 80.0)
    plugin, ctx, si = loaded(golden(file)), mi.BSDFContext(), interaction(wi)
    u = np.random.default_rng(6).random((count, 3))
    wo = np.array([np.array(plugin.sample(ctx, si, a, mi.Point2f(b, c))[0].wo) for a, b, c in u]).T
    library = opened(golden(file))
    assert library.directional_hemispherical(wi) > 0.1
    variant("llvm_ad_rgb")
    test = mi.chi2.ChiSquareTest(
        domain=mi.chi2.SphericalDomain(),
        sample_func=lambda _: mi.Vector3f(wo.astype(np.float32)),
        pdf_func=lambda w: mi.Float(library.pdf(wi, np.array(w).T.astype(float)).astype(np.float32)),
        sample_dim=3,
        sample_count=count,
        res=21,
        ires=64,
    )
    assert test.run(significance_level=0.01, test_count=4), test.messages


def shining(path, eye, samples=4096):
    """How a plate in uniform light of 1 from all around looks from a direction."""
    T = mi.ScalarTransform4f
    sensor = {
        "type": "orthographic",
        "to_world": T().look_at((2.0 * eye).tolist(), [0, 0, 0], [0, 0, 1]).scale(0.01),
        "film": {"type": "hdrfilm", "width": 8, "height": 8, "rfilter": {"type": "box"}},
    }
    around = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 2},
        "sensor": sensor,
        "light": {"type": "constant", "radiance": {"type": "uniform", "value": 1.0}},
    }
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", bsdfkit.FileWarning)
        plate = {"type": "rectangle", "bsdf": {"type": "bsdfkit", "filename": str(path)}}
        image = np.array(mi.render(mi.load_dict(around | {"plate": plate}), spp=samples))
    if mi.is_rgb:
        return image.mean()
    # Uniform light is not white: what it is without the plate is 1.
    return (image / np.array(mi.render(mi.load_dict(around), spp=samples)).mean(axis=(0, 1))).mean()


@pytest.mark.parametrize("name", JIT)
@pytest.mark.parametrize("file", ["t3_rf_rb_tf_tb", "t4_rf_rb_tf_tb", "t4_tf", "t3_tf", "mixed_basis"])
@pytest.mark.parametrize("theta", [30.0, 130.0])
def test_furnace(xml, name, file, theta):
    """A plate in uniform light shines with its directional-hemispherical value."""
    variant(name)
    eye = bsdfkit.direction(theta, 55.0)
    expected = opened(xml(file)).directional_hemispherical(eye)
    assert shining(xml(file), eye) == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize("file", ["t3_rf_rb_tf_tb", "t4_tf", "mixed_basis"])
def test_furnace_of_the_scalar_variant(xml, file):
    variant("scalar_rgb")
    eye = bsdfkit.direction(130.0, 55.0)
    expected = opened(xml(file)).directional_hemispherical(eye)
    assert shining(xml(file), eye, samples=64) == pytest.approx(expected, rel=0.03)


@pytest.mark.parametrize("name", ["scalar_rgb", "llvm_ad_rgb"])
def test_flags_and_components(xml, name):
    variant(name)
    F = mi.BSDFFlags
    plugin = loaded(xml("t4_rf_rb_tf_tb"))
    assert plugin.component_count() == 2
    for n, (kind, other) in enumerate(((F.GlossyReflection, F.GlossyTransmission), (F.GlossyTransmission, F.GlossyReflection))):
        flags = plugin.flags(n)
        assert mi.has_flag(flags, kind) and not mi.has_flag(flags, other)
        assert all(mi.has_flag(flags, f) for f in (F.FrontSide, F.BackSide, F.Anisotropic))
        assert mi.has_flag(plugin.flags(), kind)
    plugin = loaded(xml("t3_rf_rb_tf_tb"))
    assert not mi.has_flag(plugin.flags(), F.Anisotropic)
    plugin = loaded(xml("diffuse_pure"))
    assert plugin.component_count() == 1 and mi.has_flag(plugin.flags(), F.DiffuseReflection)
    assert "filename" in str(plugin)


@pytest.mark.parametrize("name", ["scalar_rgb", "llvm_ad_rgb"])
def test_contexts_select(xml, name):
    variant(name)
    plugin = loaded(xml("t4_rf_rb_tf_tb"))
    wi, up, down = bsdfkit.direction(22.0, 33.0), bsdfkit.direction(43.0, 190.0), bsdfkit.direction(139.0, 190.0)
    library = opened(xml("t4_rf_rb_tf_tb"))
    everything = mi.BSDFContext()
    for n, (own, none) in enumerate(((up, down), (down, up))):
        ctx = mi.BSDFContext()
        ctx.component = n
        own, none = (mi.Vector3f(*map(float, w)) for w in (own, none))
        si = interaction(wi)
        assert np.allclose(plugin.eval(ctx, si, own), plugin.eval(everything, si, own))
        assert np.allclose(plugin.eval(ctx, si, none), 0.0)
        chosen = [bsdfkit.Components.REFLECTION, bsdfkit.Components.TRANSMISSION][n]
        w = np.array(own).reshape(-1)
        assert np.allclose(plugin.pdf(ctx, si, own), library.pdf(wi, w, components=chosen), rtol=1e-3)
        bs, weight = plugin.sample(ctx, si, 0.99, mi.Point2f(0.3, 0.6))
        assert np.all(np.array(bs.sampled_component) == n)
        total = library.directional_hemispherical(wi, components=chosen)
        assert np.allclose(weight, total, rtol=1e-4)
    ctx = mi.BSDFContext()
    ctx.type_mask = int(mi.BSDFFlags.GlossyTransmission)
    assert np.allclose(plugin.eval(ctx, interaction(wi), mi.Vector3f(*map(float, up))), 0.0)


@pytest.mark.parametrize("file", ["t3_tf", "t4_rf_rb_tf_tb", "mixed_basis", "diffuse_pure"])
def test_parameters_and_gradients(xml, file):
    """The derivative of a value by what is stored is that of a finite step; draws stay what they were."""
    variant("llvm_ad_rgb")
    plugin = loaded(xml(file))
    parameters = mi.traverse(plugin)
    # The brightest of some pairs.
    generator = np.random.default_rng(5)
    pairs = generator.normal(size=(500, 2, 3))
    pairs /= np.linalg.norm(pairs, axis=-1, keepdims=True)
    if file == "t3_tf":
        # Light that comes in as it is stored, and is drawn so.
        pairs[:, 0, 2] = np.abs(pairs[:, 0, 2])
    wi, wo = pairs[opened(xml(file)).eval(pairs[:, 0], pairs[:, 1]).argmax()]
    si, out = interaction(wi), mi.Vector3f(*map(float, wo))
    before = float(plugin.eval(mi.BSDFContext(), si, out)[0][0])
    keys = [k for k, _ in parameters if k == "lambertian" or k.endswith("values")]
    assert before > 0.0
    for key in keys:
        dr.enable_grad(parameters[key])
    parameters.update()
    dr.backward(dr.sum(plugin.eval(mi.BSDFContext(), si, out)))
    slope = 0.0
    for key in keys:
        # Copies: `numpy` shares memory that may end with the array.
        gradient, values = dr.grad(parameters[key]).numpy().copy(), dr.detach(parameters[key]).numpy().copy()
        slope += (gradient * values).sum()
        parameters[key] = mi.Float(values * 1.5)
    density = plugin.pdf(mi.BSDFContext(), si, out)
    parameters.update()
    after = float(plugin.eval(mi.BSDFContext(), si, out)[0][0])
    assert after == pytest.approx(1.5 * before, rel=1e-5)
    assert slope == pytest.approx(3.0 * before, rel=1e-4)
    assert np.allclose(plugin.pdf(mi.BSDFContext(), si, out), density)
    # The mean weight follows the values, although draws do not.
    generator = np.random.default_rng(1)
    u = mi.Float(generator.random(200_000).astype(np.float32))
    bs, weight = plugin.sample(mi.BSDFContext(), si, u, mi.Point2f(generator.random((2, 200_000)).astype(np.float32)))
    total = 1.5 * opened(xml(file)).directional_hemispherical(wi)
    assert np.array(weight)[0].mean() == pytest.approx(total, rel=0.01)


@pytest.mark.parametrize("name", ["scalar_spectral", "llvm_ad_spectral"])
def test_spectra_have_the_colour(xml, name):
    """Under D65 the spectrum of a reflectance has its XYZ, scaled from equal energy to D65."""
    variant(name)
    from bsdfkit.mitsuba._colour import COUNT, FIRST, STEP, Colour

    colour = Colour()
    wavelengths = FIRST + STEP * np.arange(COUNT)
    d65 = np.array([float(np.ravel(np.array(mi.cie_d65(mi.Float(float(w)))))[0]) for w in wavelengths])
    bars = np.array([np.ravel(np.array(mi.cie1931_xyz(mi.Float(float(w))))) for w in wavelengths]).T
    for xyz in ([0.3, 0.3, 0.3], [0.32, 0.3, 0.27], [0.28, 0.3, 0.33]):
        found = []
        for w in wavelengths:
            spectrum = colour.spectrum(*(mi.Float(float(c)) for c in xyz), [mi.Float(float(w))] * 4)
            found.append(np.ravel(np.array(spectrum))[0])
        white, own = (bars * d65).sum(axis=1), (bars * d65 * found).sum(axis=1)
        assert np.allclose(own / white, xyz, rtol=2e-3), (own / white, xyz)
        assert min(found) > 0.0


def test_an_interpolant_lights_scenes(interpolant, tmp_path, caplog):
    path = tmp_path / "fritted.safetensors"
    interpolant.save(path)
    variant("scalar_rgb")
    wi, wo = bsdfkit.direction(20.0, 0.0), bsdfkit.direction(158.0, 182.0)
    out = mi.Vector3f(*map(float, wo))
    exact = loaded(path).eval(mi.BSDFContext(), interaction(wi), out)
    assert np.allclose(exact, interpolant.eval(wi, wo) * abs(wo[2]), rtol=1e-4)
    variant("llvm_ad_rgb")
    for properties, form in (({"form": "render"}, "render"), ({"max_error": 0.05}, "tree3")):
        plugin = mi.load_dict({"type": "bsdfkit", "filename": str(path)} | properties)
        assert "tabulated" in caplog.text and form in plugin.model.representations
        assert np.allclose(plugin.eval(mi.BSDFContext(), interaction(wi), out), exact, rtol=0.2)


def test_a_file_is_asked_for():
    variant("scalar_rgb")
    with pytest.raises(Exception, match="expected the property filename, found none"):
        mi.load_dict({"type": "bsdfkit"})


def test_rgl_files_need_no_plugin(xml, tmp_path):
    """Reflection of the front as tables of half vectors: totals of steps that are made smooth."""
    variant("scalar_rgb")
    library = opened(xml("color_mtx_0.3333_0.3333"))
    library.save(tmp_path / "matrix_rgb.bsdf")
    measured = mi.load_dict({"type": "measured", "filename": str(tmp_path / "matrix_rgb.bsdf")})
    generator = np.random.default_rng(3)
    for wi in (bsdfkit.direction(10.0, 20.0), bsdfkit.direction(50.0, 200.0)):
        sine, phi = np.sqrt(generator.random(3000)), 2.0 * np.pi * generator.random(3000)
        wo = np.stack([sine * np.cos(phi), sine * np.sin(phi), np.sqrt(1.0 - sine**2)], -1)
        f = [luminance(np.array(measured.eval(mi.BSDFContext(), interaction(wi), mi.Vector3f(*map(float, w))))) for w in wo]
        theirs = np.pi * np.mean(np.array(f) / wo[:, 2])
        assert theirs == pytest.approx(np.pi * library.eval(wi, wo).mean(), rel=0.02)
    with pytest.raises(bsdfkit.ArgumentError, match="_rgb.bsdf or _spec.bsdf"):
        library.save(tmp_path / "matrix.bsdf")
    with pytest.raises(bsdfkit.ArgumentError, match="expected reflection of the front, found none"):
        opened(xml("t4_tf")).save(tmp_path / "film_rgb.bsdf")
