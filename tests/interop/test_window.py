"""LBNL's WINDOW engine reads our matrices and calculates with them as we do."""

import importlib.util
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import film
from klems import Klems

# Where CI is set a missing engine is an error, as its process then fails.
pytestmark = pytest.mark.skipif(
    importlib.util.find_spec("pywincalc") is None and "CI" not in os.environ,
    reason="pywincalc has no wheel for this Python: WINDOW's engine was not tried",
)

# Of transmittances and reflectances; the files hold five digits.
TOLERANCE = 1e-4

# WINDOW's name, the file's, and ours as (from the front, to the front): its front is our back.
DIRECTIONS = [
    ("front transmittance", "Transmission Front", (False, True)),
    ("back transmittance", "Transmission Back", (True, False)),
    ("front reflectance", "Reflection Front", (False, False)),
    ("back reflectance", "Reflection Back", (True, True)),
]


def engine(verb, path, *direction):
    """What WINDOW's engine says; see window.py."""
    script = Path(__file__).with_name("window.py")
    done = subprocess.run(
        [sys.executable, script, verb, path, *map(str, direction)], capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, f"{path.name}: status {done.returncode}: {done.stderr}"
    return json.loads(done.stdout)


def ours(bsdf, path, klems, sides):
    """Direct-direct and direct-hemispherical values of our command, one an incident bin."""
    from_front, to_front = sides
    incident, scattered = [], []
    for theta, phi in klems.centres():
        # Bins are numbered by the direction of travel; our vectors point away from the surface.
        incident.append((theta if from_front else 180.0 - theta, (phi + 180.0) % 360.0))
        scattered.append((theta if to_front else 180.0 - theta, phi))
    rows = "".join(f"{theta} {phi}\n" for theta, phi in incident)
    column = 0 if from_front == to_front else 1
    totals = [float(line.split()[column]) for line in bsdf("hemispherical", path, "--stdin", stdin=rows).splitlines()]
    rows = "".join(f"{a} {b} {c} {d}\n" for (a, b), (c, d) in zip(incident, scattered))
    values = [float(line) for line in bsdf("eval", path, stdin=rows).splitlines()]
    return [v * omega for v, omega in zip(values, klems.solid_angles())], totals


@pytest.mark.parametrize("name", ["film_xml", "glass_xml"])
def test_a_glazing_system_has_our_totals(bsdf, name, request):
    path = request.getfixturevalue(name)
    klems = Klems(path)
    theta, phi, bin_number = 20.0, 0.0, 9
    system = engine("system", path, theta, phi)
    omega = klems.solid_angles()
    assert len(omega) == 145 and system["u"] > 1.0
    most = 0.0
    for kind, _, sides in DIRECTIONS:
        matrix = system[kind]["matrix"]
        direct = [matrix[i][i] * omega[i] for i in range(145)]
        hemispherical = [sum(row[i] * w for row, w in zip(matrix, omega)) for i in range(145)]
        # The engine's own integrals say how its matrix is to be read.
        assert system[kind]["direct_direct"] == pytest.approx(direct[bin_number], abs=1e-6)
        assert system[kind]["direct_hemispherical"] == pytest.approx(hemispherical[bin_number], abs=1e-6)
        our_direct, our_hemispherical = ours(bsdf, path, klems, sides)
        assert direct == pytest.approx(our_direct, abs=TOLERANCE), kind
        assert hemispherical == pytest.approx(our_hemispherical, abs=TOLERANCE), kind
        most = max(most, *hemispherical)
    assert most > 0.1, "hardly anything scatters"


def test_the_film_is_the_film(film_xml):
    """The fitted matrix is that of the closed form: front and back are not exchanged on the way."""
    klems = Klems(film_xml)
    omega, centres = klems.solid_angles(), klems.centres()
    for _, direction, sides in DIRECTIONS:
        from_front, to_front = sides
        wi = (0.0, 0.0, 1.0 if from_front else -1.0)
        outgoing = [film.vector(theta if to_front else 180.0 - theta, phi) for theta, phi in centres]
        total = sum(film.value(wi, wo) * w for wo, w in zip(outgoing, omega))
        found = klems.hemispherical("Visible", direction)[0]
        assert found == pytest.approx(total, rel=0.05), direction


def test_every_matrix_that_we_write_is_read(bsdf, files, tmp_path):
    """From a fit and from a conversion, with nothing known of the material."""
    again = tmp_path / "again.xml"
    bsdf("convert", files.klems, "--to", "klems-full", "-o", again)
    for path in (files.klems, again):
        read, klems = engine("parse", path), Klems(path)
        blocks = [(kind, klems.blocks["Visible", d]) for kind, d, _ in DIRECTIONS if ("Visible", d) in klems.blocks]
        assert blocks and all(read["Visible"][kind] == values for kind, values in blocks)
        assert read["thickness"] > 0.0 and None not in read["emissivities"]
        [comment] = [line for line in path.read_text().splitlines() if "placeholders, not known" in line]
        assert "Manufacturer" in comment and "Thickness" in comment


def test_what_genbsdf_says_of_heat_is_taken(bsdf, film_xml, tmp_path):
    """Emissivities of 1, and no TIR: what is invented beside them is not refused."""
    black = ("--property", "EmissivityFront=1.0", "--property", "EmissivityBack=1.0")
    bsdf("convert", film_xml, "--for", "window", "-o", tmp_path / "black.xml", *black)
    assert engine("system", tmp_path / "black.xml", 20.0, 0.0)["u"] > 1.0


def test_placeholders_do_not_become_knowledge(bsdf, film_xml, tmp_path):
    text = film_xml.read_text()
    assert text.count("placeholders, not known") == 1 and text.count("Solar is not known") == 1
    again, named = tmp_path / "again.xml", tmp_path / "named.xml"
    bsdf("convert", film_xml, "--for", "window", "-o", again)
    assert again.read_text() == text
    labels = ("--name", "Film", "--manufacturer", "Us", "--thickness", "0.0002", "--property", "TIR=0")
    bsdf("convert", film_xml, "--for", "window", "-o", named, *labels)
    read = engine("parse", named)
    assert read["name"] == "Film" and read["thickness"] == 0.0002 and read["infrared transmittance"] == 0.0
    assert json.loads(bsdf("info", "--json", named))["name"] == "Film"
    assert json.loads(bsdf("info", "--json", film_xml))["name"] == ""


def test_the_example_prints_what_a_window_is_sold_by(film_xml):
    """U, SHGC and visible transmittance; the last is the matrix's own."""
    script = Path(__file__).resolve().parents[2] / "examples" / "python" / "window.py"
    done = subprocess.run([sys.executable, script, film_xml], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    lines = [line.split() for line in done.stdout.splitlines()]
    found = {words[0]: float(words[1]) for words in lines}
    assert 1.0 < found["U"] < 8.0
    assert 0.0 < found["SHGC"] < 1.0
    expected = Klems(film_xml).hemispherical("Visible", "Transmission Front")[0]
    assert found["Tvis"] == pytest.approx(expected, abs=1e-3)
    # What is kept heats: the solar heat gain is more than what passes, and less than all that does not come back.
    passes = Klems(film_xml).hemispherical("Solar", "Transmission Front")[0]
    back = Klems(film_xml).hemispherical("Solar", "Reflection Front")[0]
    assert passes < found["SHGC"] < 1.0 - back
