"""Blocks that are 0 throughout: a transmission that is not known is the other direction reversed, as in Radiance."""

import pytest

import radiance

ROWS = [(0.0, 0.0), (20.0, 30.0), (50.0, 200.0), (160.0, 0.0), (130.0, 70.0)]

# By structure: values, zeros, bases. The least value is 0: with a dummy block beside it, Radiance does not take the
# Lambertian part, which is the least value, the other way.
ENCODINGS = {
    "Columns": (
        " ".join(f"{0.25 * (n % 41) / 41:.4f}," for n in range(41 * 41)),
        " ".join(["0.000,"] * 41 * 41),
        "<ColumnAngleBasis>LBNL/Klems Quarter</ColumnAngleBasis><RowAngleBasis>LBNL/Klems Quarter</RowAngleBasis>",
    ),
    "TensorTree4": (
        "{" + " ".join(f"{0.02 * n:.2f}" for n in range(16)) + "}",
        "{ 0 }",
        "<AngleBasis>LBNL/Shirley-Chiu</AngleBasis>",
    ),
}


def document(structure, blocks):
    _, _, basis = ENCODINGS[structure]
    text = "".join(
        "<WavelengthData><LayerNumber>System</LayerNumber><Wavelength unit='Integral'>Visible</Wavelength>"
        f"<WavelengthDataBlock><WavelengthDataDirection>{direction}</WavelengthDataDirection>{basis}"
        f"<ScatteringDataType>BTDF</ScatteringDataType><ScatteringData>{data}</ScatteringData>"
        "</WavelengthDataBlock></WavelengthData>"
        for direction, data in blocks
    )
    return (
        "<WindowElement><WindowElementType>System</WindowElementType><Optical><Layer><Material><Name>n</Name>"
        f"</Material><DataDefinition><IncidentDataStructure>{structure}</IncidentDataStructure></DataDefinition>"
        f"{text}</Layer></Optical></WindowElement>"
    )


@pytest.mark.parametrize("structure", ENCODINGS)
@pytest.mark.parametrize("real", ["Transmission Front", "Transmission Back"])
def test_the_other_direction_reversed_answers(bsdf, structure, real, tmp_path):
    values, zeros, _ = ENCODINGS[structure]
    [dummy] = {"Transmission Front", "Transmission Back"} - {real}
    path = tmp_path / "zero.xml"
    path.write_text(document(structure, [(real, values), (dummy, zeros), ("Reflection Back", zeros)]))
    rows = "".join(f"{theta} {phi}\n" for theta, phi in ROWS)
    ours = [tuple(map(float, line.split())) for line in bsdf("hemispherical", path, "--stdin", stdin=rows).splitlines()]
    theirs = radiance.library("hemispherical", path, ROWS)
    assert [r for r, _ in ours] == [0.0] * len(ROWS)
    assert [t for _, t in ours] == pytest.approx(theirs, rel=1e-3)
    assert sorted(theirs)[1] > 0.05
    assert "dummy block, ignored" in bsdf("check", path)
