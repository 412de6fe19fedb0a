"""Every material in every form, in Radiance's programs and WINDOW's engine: not only read, but with our numbers.

`benches/programs/sweep.py` asks more programs, of more files, in minutes.
"""

import json
import math

import pytest

import film
import radiance
from klems import Klems
from test_programs import FURNACE
from test_window import DIRECTIONS, engine, pytestmark as needs_window

# Pairs of sides that were measured: (from the front, to the front).
MATERIALS = {
    "metal": [(True, True)],
    "glass, lit from the front": [(True, False)],
    "glass, lit from behind": [(False, True)],
    "film": [(True, True), (True, False), (False, True), (False, False)],
}
FORMS = {
    "tree": ["--for", "radiance", "--max-depth", "4", "--reciprocity", "off"],
    "full": ["--for", "window"],
    "half": ["--for", "energyplus", "--to", "klems-half"],
    "quarter": ["--to", "klems-quarter"],
}
# Two degrees and more from the borders of all bases; from both sides.
INCIDENT = [(theta, 2.0) for theta in (3.0, 22.0, 39.0, 52.0, 177.0, 158.0, 141.0, 128.0)]
# Of rtrace: its noise, and its jitter of the eye over the width of a patch, by which neighbours have a share.
TRACED = 0.05
PANE = "void {kind} specimen\n{arguments} 0 1 0 .\n0\n0\nspecimen polygon pane\n0\n0\n12 -99 -99 0 99 -99 0 99 99 0 -99 99 0\n"
KINDS = {"BSDF": "6 0 {xml}", "aBSDF": "5 {xml}"}
RAYS = 200


@pytest.fixture(scope="module", params=MATERIALS)
def written(request, bsdf, tmp_path_factory):
    """All forms of a material; a tree of rank 4 is made of its coarsest matrix."""
    folder = tmp_path_factory.mktemp("material")
    head, *rows = film.table().split()
    sides = MATERIALS[request.param]
    table = folder / "measured.csv"
    kept = [r for r in rows if tuple(float(r.split(",")[k]) < 90.0 for k in (0, 2)) in sides]
    table.write_text("\n".join([head, *kept]) + "\n")
    bsdf("fit", table, "--symmetry", "isotropic", "-o", folder / "fitted.safetensors")
    for name, how in FORMS.items():
        if (request.param, name) == ("film", "tree"):
            # Its four trees take half a minute; other tests have them.
            continue
        bsdf("convert", folder / "fitted.safetensors", *how, "-o", folder / f"{name}.xml")
    rank_four = ["--to", "tensor-tree", "--max-leaves", "20000", "-o", folder / "rank4.xml"]
    bsdf("convert", folder / "quarter.xml", *rank_four)
    return folder


def ours(bsdf, path):
    """Reflectance and transmittance together, by incident direction."""
    rows = "".join(f"{theta} {phi}\n" for theta, phi in INCIDENT)
    return [sum(map(float, line.split())) for line in bsdf("hemispherical", path, "--stdin", stdin=rows).splitlines()]


def seen(rad, path, kind, *options):
    """What a pane shows in a world of radiance 1, by incident direction."""
    scene = FURNACE + PANE.format(kind=kind, arguments=KINDS[kind].format(xml=path.name))
    octree = rad.octree(path.parent, f"{path.stem}_{kind}", scene)
    rays = []
    for theta, phi in INCIDENT:
        sine, cosine = math.sin(math.radians(theta)), math.cos(math.radians(theta))
        x, y = sine * math.cos(math.radians(phi)), sine * math.sin(math.radians(phi))
        rays += [f"{x} {y} {cosine} {-x} {-y} {-cosine}\n"] * RAYS
    options = ["-ab", "1", "-ad", "256", "-as", "0", "-aa", "0", "-lr", "6", "-lw", "1e-6", "-ss", "16", "-dj", "0", *options]
    text = rad.run(path.parent, "rtrace", "-h", "-fa", "-ov", *options, octree, stdin="".join(rays).encode())
    values = list(map(float, text.split()))[1::3]
    return [sum(values[k : k + RAYS]) / RAYS for k in range(0, len(values), RAYS)]


def test_radiance_has_our_totals(bsdf, rad, written):
    paths = sorted(written.glob("*.xml"))
    assert len(paths) >= 4
    for path in paths:
        expected = ours(bsdf, path)
        assert max(expected) > 0.2
        assert radiance.library("hemispherical", path, INCIDENT) == pytest.approx(expected, rel=1e-3, abs=1e-3), path.name
        assert seen(rad, path, "BSDF", "-st", "0") == pytest.approx(expected, rel=TRACED, abs=2e-3), path.name
        # No peak is told apart here, and what is weak turns diffuse: the light remains.
        assert seen(rad, path, "aBSDF") == pytest.approx(expected, rel=TRACED, abs=2e-3), path.name


@pytest.mark.parametrize("form", ["full", "half", "quarter"])
def test_dctimestep_passes_our_transmission(rad, written, form):
    """Each patch lit by itself from behind: a row of ones, weighted, sums what comes in."""
    path = written / f"{form}.xml"
    klems = Klems(path)
    angles = klems.solid_angles()
    n = len(angles)

    def matrix(name, rows, values):
        text = "".join(f"{v:.9g} {v:.9g} {v:.9g}\n" for v in values)
        (path.parent / name).write_text(f"#?RADIANCE\nNROWS={rows}\nNCOLS={n}\nNCOMP=3\nFORMAT=ascii\n\n{text}")

    scatters = [name for band, name in klems.blocks if band == "Visible" and any(map(any, klems.blocks[band, name]))]
    transmits = [name for name in scatters if name.startswith("Transmission")]
    if not transmits:
        # A metal passes nothing; dctimestep takes that for diffuse, and for 145 patches.
        assert scatters == ["Reflection Back"]
        return
    matrix("v.mtx", 1, angles)
    matrix("d.mtx", n, (float(i == k) for i in range(n) for k in range(n)))
    matrix("s.mtx", n, (1.0 / angles[i] if i == k else 0.0 for i in range(n) for k in range(n)))
    found = list(map(float, rad.run(path.parent, "dctimestep", "-h", "v.mtx", path.name, "d.mtx", "s.mtx").split()))[1::3]
    if "Transmission Front" in transmits:
        expected = klems.hemispherical("Visible", "Transmission Front")
    else:
        rows = klems.blocks["Visible", "Transmission Back"]
        expected = [sum(a * v for a, v in zip(angles, row)) for row in rows]
    assert max(expected) > 0.2
    assert found == pytest.approx(expected, rel=1e-3, abs=1e-4)


@needs_window
def test_window_reads_our_values(written):
    """What was not measured is 0, or the other direction reversed; the sun's band is there."""
    read, klems = engine("parse", written / "full.xml"), Klems(written / "full.xml")
    for band in ("Visible", "Solar"):
        for kind, direction, _ in DIRECTIONS:
            assert read[band][kind] == klems.blocks[band, direction], (band, kind)


def test_energyplus_is_told_what_passes(bsdf, written):
    """Of the exported objects the total at the normal is the matrix's; of a metal it is 0."""
    said = json.loads(bsdf("export", "energyplus", written / "fitted.safetensors", "--json", "-o", written / "window.epJSON"))
    expected = Klems(written / "full.xml").hemispherical("Solar", "Transmission Front")[0]
    assert said["solar_transmittance_normal"] == pytest.approx(expected, abs=1e-4)
