"""What bands are seen as, beside colour-science: the CIE's tables and CIEDE2000 by another hand."""

import warnings

import numpy as np
import pytest

import radiance

with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # it misses packages that only draw
    import colour

WAVELENGTHS = np.arange(400.0, 701.0, 10.0)
FINE = np.arange(380.0, 781.0)


def direction(theta, phi):
    theta, phi = np.radians(theta), np.radians(phi)
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1)


def paint(wi, wo):
    """The formula of `pearl-paint`, written once more."""
    half = wi + wo
    half /= np.linalg.norm(half, axis=-1, keepdims=True)
    a = 0.18
    slope = (half[:, 0] / a) ** 2 + (half[:, 1] / a) ** 2 + half[:, 2] ** 2

    def hidden(w):
        return 0.5 * (np.sqrt(1 + a * a * (w[:, 0] ** 2 + w[:, 1] ** 2) / w[:, 2] ** 2) - 1)

    flakes = 1 / (np.pi * a * a * slope**2) / (1 + hidden(wi) + hidden(wo)) / (4 * wi[:, 2] * wo[:, 2])
    cosine = np.sqrt(1 - (1 - (wi * half).sum(-1) ** 2) / 2.2**2)
    mirrored = 0.05 + 0.5 * np.sin(2 * np.pi * 2.2 * 140 * cosine[:, None] / WAVELENGTHS) ** 2
    ground = 0.04 + 0.3 / (1 + np.exp((580 - WAVELENGTHS) / 15))
    return flakes[:, None] * mirrored + ground / np.pi


def tristimulus(spectra, illuminant):
    """X, Y, Z of spectra that are linear between bands, and of white."""
    light = colour.SDS_ILLUMINANTS[illuminant]
    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    light = np.interp(FINE, light.wavelengths, light.values)
    seen = np.stack([np.interp(FINE, observer.wavelengths, v) for v in observer.values.T], 1)
    weights = light[:, None] * seen / (light * seen[:, 1]).sum()
    fine = np.stack([np.interp(FINE, WAVELENGTHS, s) for s in spectra])
    return fine @ weights, weights.sum(0)


@pytest.fixture(scope="session")
def fitted(bsdf, tmp_path_factory):
    folder = tmp_path_factory.mktemp("spectra")
    instrument = ["--sweeps", "36", "--points-per-sweep", "120", "--spiral-points", "2000"]
    bsdf("simulate", "pearl-paint", "-o", folder / "measured", *instrument)
    file = folder / "paint.safetensors"
    bsdf("fit", folder / "measured", "-o", file)
    return file


@pytest.mark.parametrize("theta", [30.0, 37.5])
@pytest.mark.parametrize("illuminant", ["D65", "A"])
def test_colours_are_those_of_31_bands(bsdf, fitted, theta, illuminant):
    k = np.arange(400)
    theta_o, phi_o = 78 * np.sqrt((k + 0.5) / 400), k * 137.508
    rows = "".join(f"{theta} 10 {a:.9f} {b:.9f}\n" for a, b in zip(theta_o, phi_o))

    def asked(*arguments):
        lines = bsdf("eval", fitted, *arguments, stdin=rows).splitlines()
        return np.array([[float(x) for x in line.split()] for line in lines])

    bands = asked("--bands")
    seen = asked("--channels", "--view", f"xyz-{illuminant.lower()}")
    # The same bands by another hand; our tables have every fifth nanometre, theirs each.
    by_theirs, white = tristimulus(bands, illuminant)
    assert np.abs(seen - by_theirs).max() < 1e-3 * by_theirs.max()

    truth = paint(np.repeat(direction(theta, 10)[None], 400, 0), direction(theta_o, phi_o))
    assert np.abs(bands - truth).sum() < 0.015 * truth.sum()
    expected, _ = tristimulus(truth, illuminant)
    # Reflectance factors; what mirrors more than white is compared at white's luminance.
    scale = np.pi / np.maximum(np.pi * expected[:, 1:2], 1)
    lab = [colour.XYZ_to_Lab(v * scale, white[:2] / white.sum()) for v in (seen, expected)]
    difference = colour.difference.delta_E_CIE2000(*lab)
    assert difference.mean() < 0.5, difference.mean()


@pytest.fixture(scope="session")
def three_bands(bsdf, tmp_path_factory):
    """A table of three wavelengths of the paint, as a lab writes one, fitted."""
    folder = tmp_path_factory.mktemp("bands")
    k = np.arange(3000)
    theta_o, phi_o = np.degrees(np.arcsin(0.985 * np.sqrt((k + 0.5) / 3000))), k * 137.508 % 360
    rows = ["theta_i,phi_i,theta_o,phi_o,450nm,550nm,650nm"]
    columns = [int(np.argmin(np.abs(WAVELENGTHS - w))) for w in (450, 550, 650)]
    for theta in [0, 15, 30, 45, 60, 75]:
        values = paint(np.repeat(direction(theta, 0)[None], 3000, 0), direction(theta_o, phi_o))[:, columns]
        rows += [f"{theta},0,{a:.4f},{b:.4f},{r:.6g},{g:.6g},{u:.6g}" for a, b, (r, g, u) in zip(theta_o, phi_o, values)]
    (folder / "paint.csv").write_text("\n".join(rows) + "\n")
    file = folder / "paint.safetensors"
    bsdf("fit", folder / "paint.csv", "-o", file)
    return file


def test_every_band_has_a_file_that_radiance_reads(bsdf, three_bands, tmp_path):
    bsdf("convert", three_bands, "--each-band", "--to", "klems-quarter", "-o", tmp_path / "paint.xml")
    names = [f"paint_{w}nm.xml" for w in (450, 550, 650)]
    assert sorted(p.name for p in tmp_path.iterdir()) == names
    incident = [(20.0, 30.0), (50.0, 200.0)]
    text = "".join(f"{a} {b}\n" for a, b in incident)
    k = np.arange(300)
    theta_o, phi_o = np.degrees(np.arcsin(0.98 * np.sqrt((k + 0.5) / 300))), k * 137.508 % 360
    rows = [(a, b, round(c, 6), round(d, 6)) for a, b in incident for c, d in zip(theta_o, phi_o)]
    pairs = "".join(" ".join(map(str, row)) + "\n" for row in rows)
    spectra = np.array([[float(x) for x in line.split()] for line in bsdf("eval", "--bands", three_bands, stdin=pairs).splitlines()])
    for name, band in zip(names, spectra.T):
        path = tmp_path / name
        ours = np.array([float(line) for line in bsdf("eval", path, stdin=pairs).split()])
        theirs = np.array(radiance.library("eval", path, rows))
        # As written, but for what Radiance adds to break ties, and coordinates beside a wall.
        assert (np.abs(ours - theirs) > 4e-4 * theirs + 1e-7).sum() <= 3, name
        # One channel: that band and no other, as its light is spread over cells.
        assert np.abs(theirs - band).sum() < 0.5 * band.sum(), name
        off = np.abs(theirs[:, None] - spectra).sum(0)
        assert off.argmin() == names.index(name), (name, off)
        alone = bsdf("hemispherical", three_bands, "--view", f"{name[6:9]}nm", "--stdin", stdin=text)
        table = bsdf("hemispherical", path, "--stdin", stdin=text)
        for a, b in zip(alone.split(), table.split()):
            assert abs(float(a) - float(b)) < 0.05 * float(a) + 1e-6, (name, a, b)
    # Bands differ, or one file would do.
    red, blue = [np.array(radiance.library("eval", tmp_path / names[n], rows)) for n in (2, 0)]
    assert np.abs(red - blue).sum() > 0.1 * blue.sum()


def test_each_band_is_for_forms_of_one_band_and_files_with_bands(bsdf, three_bands, tmp_path):
    for target, said in [("all.safetensors", "which keeps all"), ("paint_rgb.bsdf", "which keeps all")]:
        with pytest.raises(AssertionError, match=said):
            bsdf("convert", three_bands, "--each-band", "-o", tmp_path / target)
    bsdf("convert", three_bands, "--to", "klems-quarter", "-o", tmp_path / "seen.xml")
    with pytest.raises(AssertionError, match="found no bands"):
        bsdf("convert", tmp_path / "seen.xml", "--each-band", "-o", tmp_path / "again.xml")


def test_tables_keep_bands(bsdf, three_bands, tmp_path):
    """The render form answers what the interpolant does (trees: crates/fit/tests/spectral_tables.rs, with fewer samples)."""
    bsdf("compile", three_bands, "-o", tmp_path / "render.safetensors")
    k = np.arange(300)
    rows = "".join(f"35 10 {75 * np.sqrt((n + 0.5) / 300)} {n * 137.508}\n" for n in k)

    def bands(file):
        lines = bsdf("eval", "--bands", file, stdin=rows).splitlines()
        return np.array([[float(x) for x in line.split()] for line in lines])

    truth = bands(three_bands)
    found = bands(tmp_path / "render.safetensors")
    assert found.shape == (300, 3) and np.abs(found - truth).sum() < 0.03 * truth.sum()
    assert "3 bands, 450 to 650 nm" in bsdf("info", tmp_path / "render.safetensors")
