"""What `bsdf check` says of a file is what the program does with it, and its corrected copy is read."""

import importlib.util
import json
import math
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import radiance

HERE = Path(__file__).resolve().parent
needs_window = pytest.mark.skipif(
    importlib.util.find_spec("pywincalc") is None and "CI" not in os.environ,
    reason="pywincalc has no wheel for this Python: WINDOW's engine was not tried",
)

ROWS = [(20.0, 30.0), (50.0, 200.0), (160.0, 0.0), (130.0, 70.0)]
DIRECTIONS = ["Transmission Front", "Transmission Back", "Reflection Front", "Reflection Back"]


@pytest.fixture(scope="module")
def command():
    """Our command with any exit status: (status, what it prints)."""
    bsdf = shutil.which(os.environ.get("BSDF", HERE.parents[1] / "target" / "release" / "bsdf"))

    def run(*arguments):
        done = subprocess.run([bsdf, *map(str, arguments)], capture_output=True, text=True, timeout=600)
        return done.returncode, done.stdout

    return run


@pytest.fixture(scope="module")
def good(bsdf, tmp_path_factory):
    """A file that every program reads: .5 goes straight on, .1 is scattered evenly, .2 is reflected."""
    folder = tmp_path_factory.mktemp("check")
    bare, path = folder / "bare.xml", folder / "good.xml"
    bare.write_text(document())
    bsdf("convert", bare, "--for", "window", "-o", path, "--thickness", "0.003", "--name", "Shade", "--manufacturer", "Acme")
    return path.read_text()


def solid_angles():
    """Projected solid angles of Klems Full."""
    rings = [1, 8, 16, 20, 24, 24, 24, 16, 12]
    bounds = [math.radians(b) for b in (0, 5, 15, 25, 35, 45, 55, 65, 75, 90)]
    share = [math.cos(lower) ** 2 - math.cos(upper) ** 2 for lower, upper in zip(bounds, bounds[1:])]
    return [math.pi * ring / n for n, ring in zip(rings, share) for _ in range(n)]


def document():
    """Klems Full by its name alone, the visible band in four directions."""
    omega = solid_angles()

    def block(direction, through, diffuse):
        def value(row, column):
            return diffuse / math.pi + (through / omega[row] if row == column else 0.0)

        lines = ("".join(f"{value(r, c):.6g}," for c in range(145)) for r in range(145))
        basis = "".join(f"<{e}AngleBasis>LBNL/Klems Full</{e}AngleBasis>" for e in ("Column", "Row"))
        return (
            "<WavelengthData><LayerNumber>System</LayerNumber><Wavelength unit='Integral'>Visible</Wavelength>"
            f"<WavelengthDataBlock><WavelengthDataDirection>{direction}</WavelengthDataDirection>{basis}"
            "<ScatteringDataType>BTDF</ScatteringDataType><ScatteringData>\n" + "\n".join(lines)
            + "</ScatteringData></WavelengthDataBlock></WavelengthData>\n"
        )

    shares = {"T": (0.5, 0.1), "R": (0.05, 0.15)}
    return (
        "<WindowElement><WindowElementType>System</WindowElementType><FileType>BSDF</FileType><Optical><Layer>"
        "<Material><Name>Shade</Name></Material><DataDefinition>\n<IncidentDataStructure>Columns</IncidentDataStructure>\n"
        "</DataDefinition>\n" + "".join(block(d, *shares[d[0]]) for d in DIRECTIONS)
        + "</Layer></Optical></WindowElement>"
    )


def without_band(text, band):
    return re.sub(rf"<WavelengthData>(?:(?!</WavelengthData>).)*>{band}<.*?</WavelengthData>\n?", "", text, flags=re.S)


def changed_block(text, band, direction, change):
    """The text with `change` made to one block's numbers."""
    def data(match):
        whole = match.group(0)
        if f">{band}<" not in whole or f">{direction}<" not in whole:
            return whole
        return re.sub(r"(<ScatteringData>)(.*?)(</ScatteringData>)", lambda m: m[1] + change(m[2]) + m[3], whole, flags=re.S)

    return re.sub(r"<WavelengthData>.*?</WavelengthData>", data, text, flags=re.S)


def padded(text):
    return text.replace(">Visible<", ">\n Visible\n<")


def duplicate(text):
    first = re.search(r"<WavelengthData>.*?</WavelengthData>\n", text, re.S)[0]
    other = re.sub(r"[0-9.e-]+,", "0.01,", first.split("<ScatteringData>")[1])
    return text.replace(first, first.split("<ScatteringData>")[0] + "<ScatteringData>" + other + first, 1)


def zeros(numbers):
    return re.sub(r"[0-9.e-]+,", "0,", numbers)


def shares(text):
    """All blocks as shares of light."""

    def block(match):
        rows = zip(match[2].strip().splitlines(), solid_angles())
        scaled = ("".join(f"{float(v) * omega:.9g}," for v in row.split(",") if v) for row, omega in rows)
        return match[1] + "\n" + "\n".join(scaled) + match[3]

    text = text.replace(">BTDF<", ">Fractional Diffuse<")
    return re.sub(r"(<ScatteringData>)(.*?)(</ScatteringData>)", block, text, flags=re.S)


def with_band(text, band):
    """The text with the visible blocks once more, under another name."""
    blocks = without_band(text, "Solar").split("</DataDefinition>")[1].split("</Layer>")[0]
    return text.replace("</Layer>", blocks.replace(">Visible<", f">{band}<") + "</Layer>")


# code: (the program that it breaks, the fault put into a good file)
FAULTS = {
    "padded-label": ("radiance", padded),
    "padded-keyword": ("radiance", lambda t: t.replace(">Columns<", "> Columns <")),
    "cie-y": ("radiance", lambda t: t.replace(">Visible<", ">CIE-Y<")),
    "duplicate-block": ("radiance", duplicate),
    "fractional": ("radiance", shares),
    "dummy-loses-floor": ("radiance", lambda t: changed_block(t, "Visible", "Transmission Back", zeros)),
    "before-declaration": ("window", lambda t: "a stray line\n" + t),
    "no-description": ("window", lambda t: t.replace(">Shade<", "><")),
    "separators": ("window", lambda t: t.replace(",\n", "\n")),
    "rows": ("window", lambda t: t.replace(">Columns<", ">Rows<")),
    "no-solar": ("window", lambda t: without_band(t, "Solar")),
    "further-bands": ("window", lambda t: with_band(t, "NIR")),
    "dummy-transmission": ("window", lambda t: changed_block(t, "Visible", "Transmission Back", zeros)),
}

# Rows are transposed, and the good file is symmetric; of two blocks the last one, which is taken, is right.
SILENT = ["rows", "duplicate-block"]


def window(verb, path, *direction):
    """What WINDOW's engine says; None if it refuses the file or ends."""
    done = subprocess.run(
        [sys.executable, HERE / "window.py", verb, path, *map(str, direction)], capture_output=True, text=True, timeout=300
    )
    return json.loads(done.stdout) if done.returncode == 0 else None


def light(program, path):
    """What the program gets of the file's visible band."""
    if program == "radiance":
        try:
            return radiance.library("hemispherical", path, ROWS)
        except AssertionError:
            return None
    parsed = window("parse", path)
    if parsed is None:
        return None
    bands = ("Visible", "Solar")
    return [sum(map(sum, parsed[b][k])) if parsed[b][k] else 0.0 for b in bands for k in sorted(parsed[b])]


@pytest.mark.parametrize("code", FAULTS)
def test_the_copy_is_read_by_the_program_that_the_fault_breaks(code, good, command, tmp_path):
    program, fault = FAULTS[code]
    if program == "window" and importlib.util.find_spec("pywincalc") is None:
        pytest.skip("pywincalc is not here")
    sound, broken, mended, twice = (tmp_path / f"{name}.xml" for name in ("sound", "broken", "mended", "twice"))
    sound.write_text(good)
    broken.write_text(fault(good))
    status, told = command("check", broken, "--for", program, "--json")
    found = {f["code"]: f for f in json.loads(told)["findings"]}
    assert code in found, told
    assert found[code]["programs"][program]["how"] in ("refuses", "wrong")
    assert status in (1, 4)
    truth = light(program, sound)
    assert truth and max(truth) > 0.5
    if code not in SILENT:
        assert light(program, broken) != pytest.approx(truth, rel=1e-4), "the program reads it after all"
    status, told = command("check", broken, "--for", program, "--fix", "-o", mended)
    assert status == 0, told
    assert f"mended: {code}" in told
    # The engine's copy of Solar is the visible band's, as in the good file.
    assert light(program, mended) == pytest.approx(truth, rel=1e-3), told
    status, told = command("check", mended, "--for", program, "--fix", "-o", twice)
    assert status == 0 and "nothing to mend" in told
    assert twice.read_bytes() == mended.read_bytes()


def test_a_web_page_is_not_mended(command, tmp_path):
    page, copy = tmp_path / "page.xml", tmp_path / "copy.xml"
    page.write_text("<!DOCTYPE html><html><body></body></html>")
    status, _ = command("check", page, "--fix", "-o", copy)
    assert status == 4 and not copy.exists()


def test_half_of_73_directions_is_read_by_radiance(command, tmp_path):
    broken, mended = tmp_path / "half.xml", tmp_path / "mended.xml"
    shutil.copy(HERE.parents[0] / "golden" / "badxml" / "17_klems_half_73.xml", broken)
    assert light("radiance", broken) is None
    status, told = command("check", broken, "--for", "radiance", "--json")
    assert status == 1 and "half-73" in told
    assert command("check", broken, "--fix", "-o", mended)[0] == 0
    assert light("radiance", mended)[0] == pytest.approx(0.1 * math.pi, rel=1e-2)


def test_light_is_mended_for_radiance(command, good, tmp_path):
    broken, mended = tmp_path / "broken.xml", tmp_path / "mended.xml"

    def much(numbers):
        return re.sub(r"[0-9.e-]+,", lambda m: f"{2.8 * float(m[0][:-1]):.9g},", numbers)

    broken.write_text(changed_block(good, "Visible", "Reflection Back", much))
    # .6 passes and 2.8 times .2 is reflected inside, our front.
    assert light("radiance", broken)[0] == pytest.approx(1.16, rel=1e-3)
    status, told = command("check", broken)
    assert status == 1 and "[energy]" in told
    status, told = command("check", broken, "--fix", "-o", mended)
    assert status == 0 and "mended: energy" in told
    assert light("radiance", mended) == pytest.approx([1.0, 1.0, 0.8, 0.8], rel=1e-3)


def test_exchanged_sides_are_put_right_for_radiance(command, good, tmp_path):
    broken, mended = tmp_path / "broken.xml", tmp_path / "mended.xml"

    def diffuse(share):
        return lambda numbers: re.sub(r"[0-9.e-]+,", f"{share / math.pi:.9g},", numbers)

    text = good
    # From the exterior .2 passes and .7 is reflected, from inside .7 and .2: Reflection Front and Back are exchanged.
    for direction, share in zip(DIRECTIONS, (0.2, 0.7, 0.2, 0.7)):
        text = changed_block(text, "Visible", direction, diffuse(share))
    broken.write_text(text)
    assert light("radiance", broken) == pytest.approx([1.4, 1.4, 0.4, 0.4], rel=1e-3)
    status, told = command("check", broken, "--for", "radiance")
    assert status == 1 and "[exchanged-sides]" in told
    status, told = command("check", broken, "--for", "radiance", "--fix", "-o", mended)
    assert status == 0 and "mended: exchanged-sides" in told
    assert light("radiance", mended) == pytest.approx([0.9] * 4, rel=1e-3)


def test_reciprocity_is_mended_where_it_is_asked_for(command, good, tmp_path):
    broken, mended = tmp_path / "broken.xml", tmp_path / "mended.xml"

    def one_way(numbers):
        # All light leaves toward some patches, from wherever it comes.
        rows = [row for row in numbers.strip().split("\n")]
        return "\n" + "\n".join(("0.2," if 20 <= k <= 40 else "0.001,") * 145 for k, _ in enumerate(rows))

    broken.write_text(changed_block(good, "Visible", "Reflection Back", one_way))
    status, told = command("check", broken, "--json")
    assert "not-reciprocal" in {f["code"] for f in json.loads(told)["findings"]}
    assert command("check", broken, "--fix", "--also", "not-reciprocal", "-o", mended)[0] == 0
    status, told = command("check", mended, "--json")
    assert "not-reciprocal" not in {f["code"] for f in json.loads(told)["findings"]}
    assert light("radiance", mended)[0] > 0.6


def test_pkgbsdf_makes_a_pane_of_the_copy(command, good, tmp_path):
    broken, mended = tmp_path / "broken.xml", tmp_path / "mended.xml"
    broken.write_text(re.sub(r"<(Width|Height) [^>]*>[^<]*</\1>\n?", "", good))
    assert radiance.pane(broken) is None
    status, told = command("check", broken, "--for", "radiance")
    # It renders all the same.
    assert status == 0 and "[no-size]" in told
    status, told = command("check", broken, "--for", "radiance", "--fix", "-o", mended)
    assert status == 0 and "mended: no-size" in told
    assert "polygon" in radiance.pane(mended)


@needs_window
def test_a_copy_for_window_makes_a_glazing_system(command, good, tmp_path):
    broken, mended = tmp_path / "radiance.xml", tmp_path / "mended.xml"
    text = without_band(good, "Solar").replace(",\n", "\n").replace(">Acme<", "><")
    broken.write_text("a stray line\n" + text)
    assert window("system", broken, 0, 0) is None
    status, told = command("check", broken, "--for", "window", "--fix", "-o", mended)
    assert status == 0, told
    system = window("system", mended, 0, 0)
    assert system["front transmittance"]["direct_hemispherical"] == pytest.approx(0.6, rel=1e-3)


@pytest.mark.skipif("BSDFKIT_DATA" not in os.environ, reason="BSDFKIT_DATA is not set: real files are not tried")
def test_verdicts_on_real_files_are_what_the_programs_do(command):
    tried = 0
    for path in sorted(Path(os.environ["BSDFKIT_DATA"]).glob("xml*/*.[xX][mM][lL]")):
        status, told = command("check", path, "--for", "radiance", "--json")
        read = light("radiance", path) is not None
        refused = any(f["programs"].get("radiance", {}).get("how") == "refuses" for f in json.loads(told)["findings"])
        assert read == (status != 4 and not refused), path.name
        tried += 1
    assert tried >= 30
