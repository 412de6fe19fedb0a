"""Mitsuba's `measured` reads what we write of RGL's form and answers as we do, and as the closed form."""

import json
import math
import random

import mitsuba as mi
import pytest

import metal

INCIDENT = [(5.0, 0.0), (20.0, 11.0), (33.0, 50.0), (45.0, 95.0), (57.0, 140.0), (66.0, 200.0)]
VARIANTS = [("scalar_rgb", "rgb"), ("scalar_spectral", "spec")]


@pytest.fixture(scope="module", params=["turned by 30 degrees", "isotropic"])
def written(request, bsdf, tmp_path_factory):
    """The interpolant, both files made of it, and the closed form."""
    folder = tmp_path_factory.mktemp("metal")
    isotropic = request.param == "isotropic"
    roughness, azimuths = ((0.3, 0.3), [0]) if isotropic else (metal.ROUGHNESS, range(0, 360, 60))
    (folder / "metal.csv").write_text(metal.table(roughness, azimuths))
    symmetry = "isotropic" if isotropic else "none"
    bsdf("fit", folder / "metal.csv", "--symmetry", symmetry, "-o", folder / "metal.safetensors")
    outputs = ("-o", folder / "metal_rgb.bsdf", "-o", folder / "metal_spec.bsdf")
    bsdf("convert", folder / "metal.safetensors", *outputs)
    return folder, lambda wi, wo: metal.value(wi, wo, roughness)


def directions(count):
    """Scattered directions spread evenly over the projected hemisphere."""
    generator = random.Random(1969)
    for _ in range(count):
        sine, phi = math.sqrt(generator.random()), generator.uniform(0.0, 360.0)
        yield math.degrees(math.asin(sine)), phi


def interaction(wi):
    si = mi.SurfaceInteraction3f()
    si.wi = wi
    if mi.is_spectral:
        si.wavelengths = [420.0, 500.0, 580.0, 700.0]
    return si


@pytest.mark.parametrize("variant, name", VARIANTS)
def test_values_agree(bsdf, written, variant, name):
    folder, truth = written
    mi.set_variant(variant)
    measured = mi.load_dict({"type": "measured", "filename": str(folder / f"metal_{name}.bsdf")})
    for theta, phi in INCIDENT:
        wi, places = metal.vector(theta, phi), list(directions(1500))
        rows = "".join(f"{theta} {phi} {a} {b}\n" for a, b in places)
        ours = [float(line) for line in bsdf("eval", folder / "metal.safetensors", stdin=rows).split()]
        theirs = []
        for place in places:
            wo = metal.vector(*place)
            f = measured.eval(mi.BSDFContext(), interaction(wi), wo)
            assert max(f) - min(f) <= 1e-4 * max(f), "grey"
            theirs.append(f[1] / wo[2])
        total = sum(ours)
        off = sum(abs(a - b) for a, b in zip(ours, theirs))
        assert off < 0.02 * total, f"{theta}, {phi}: L1 {off / total}"
        assert sum(theirs) == pytest.approx(total, rel=0.01)
        exact = [truth(wi, metal.vector(*place)) for place in places]
        assert sum(abs(a - b) for a, b in zip(exact, theirs)) < 0.03 * total


@pytest.mark.parametrize("variant, name", VARIANTS)
def test_samples_carry_the_light(bsdf, written, variant, name):
    """The mean weight of drawn directions is the directional-hemispherical reflectance, and weights hardly vary."""
    folder, _ = written
    mi.set_variant(variant)
    measured = mi.load_dict({"type": "measured", "filename": str(folder / f"metal_{name}.bsdf")})
    for theta, phi in INCIDENT[::2]:
        generator, weights = random.Random(theta), []
        for _ in range(3000):
            u = [generator.random() for _ in range(3)]
            _, weight = measured.sample(mi.BSDFContext(), interaction(metal.vector(theta, phi)), u[0], u[1:])
            weights.append(weight[1])
        line = bsdf("hemispherical", folder / "metal.safetensors", "--stdin", stdin=f"{theta} {phi}\n")
        total = float(line.split()[0])
        mean = sum(weights) / len(weights)
        assert mean == pytest.approx(total, rel=0.02)
        spread = math.sqrt(sum((w - mean) ** 2 for w in weights) / len(weights))
        assert spread < 0.25 * mean


def test_a_film_without_reflection_is_refused(bsdf, glass_xml, tmp_path):
    with pytest.raises(AssertionError, match="expected reflection of the front, found none"):
        bsdf("convert", glass_xml, "-o", tmp_path / "glass_rgb.bsdf")


def test_what_is_left_out_is_said(bsdf, film_xml, tmp_path):
    said = json.loads(bsdf("convert", film_xml, "--json", "-o", tmp_path / "film_rgb.bsdf"))["notes"]
    [note] = [line for line in said if line.startswith("left out")]
    for name in ("reflection of the back", "transmission from the front", "transmission from the back", "Solar"):
        assert name in note
