"""What bands are seen as, beside colour-science: the CIE's tables and CIEDE2000 by another hand."""

import warnings

import numpy as np
import pytest

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
