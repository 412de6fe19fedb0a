"""What is wrong with a file, and which program minds."""

from pathlib import Path

import bsdfkit
import pytest

GOLDEN = Path(__file__).resolve().parents[3] / "tests" / "golden" / "badxml"


def test_findings_have_a_place_and_programs():
    found = {f.code: f for f in bsdfkit.check(GOLDEN / "55_padded_wavelength.xml")}
    padded = found["padded-label"]
    assert padded.place.startswith("line ") and padded.place.endswith("Wavelength")
    assert "Visible" in padded.text
    how, text = padded.programs["radiance"]
    assert how == "wrong" and "black" in text
    assert "window" not in padded.programs
    assert padded.mended == "always" and padded.to_do


def test_only_what_matters_to_a_program():
    path = GOLDEN / "55_padded_wavelength.xml"
    window = {f.code for f in bsdfkit.check(path, program="window")}
    assert "padded-label" not in window and "no-solar" in window
    assert "no-solar" not in {f.code for f in bsdfkit.check(path, program="radiance")}


def test_what_cannot_be_read_is_a_finding(tmp_path):
    page = tmp_path / "shade.xml"
    page.write_text("<!DOCTYPE html><html></html>")
    [found] = bsdfkit.check(page)
    assert found.code == "web-page" and found.mended == "never"
    assert {f.code for f in bsdfkit.check(GOLDEN / "09_too_few_values.xml")} >= {"unreadable"}


def test_errors():
    with pytest.raises(bsdfkit.IoError):
        bsdfkit.check("no such file.xml")
    with pytest.raises(bsdfkit.ArgumentError, match="radiance"):
        bsdfkit.check(GOLDEN / "00_good_matrix.xml", program="blender")
