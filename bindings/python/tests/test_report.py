"""A page is whole, self-contained and escaped, and says the library's numbers."""

import base64
import json
import os
import re
import subprocess
import sys
from html.parser import HTMLParser

import bsdfkit
import numpy as np
import pytest

pytest.importorskip("matplotlib")
report = bsdfkit.report

EMPTY = {"meta", "img", "br"}
EVIL = '<script>alert(1)</script> & "glass" $x^2$'


class Page(HTMLParser):
    """Elements that are opened are closed in order; what would be fetched or run is noted."""

    def __init__(self, text):
        super().__init__()
        self.open, self.seen, self.links, self.words = [], [], [], []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attributes):
        self.seen.append(tag)
        self.links += [v for k, v in attributes if k in ("src", "href", "srcset", "action", "poster")]
        assert not any(k.startswith("on") for k, _ in attributes)
        if tag not in EMPTY:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.words.append(data)

    @property
    def text(self):
        return " ".join("".join(self.words).split())


def read(text):
    """The page, which holds all it needs and runs nothing."""
    page = Page(text)
    assert not {"script", "iframe", "object", "link", "form"} & set(page.seen)
    assert page.links and all(link.startswith("data:image/") for link in page.links)
    for link in page.links:
        head, data = link.split(",", 1)
        content = base64.b64decode(data, validate=True)
        assert content[:4] == b"\x89PNG" if "png" in head else b"<svg" in content[:2000]
    assert "url(" not in text and "@import" not in text
    return page


def command(tmp_path, said):
    """A program that stands for `bsdf` and says this of every file."""
    path = tmp_path / "bsdf"
    path.write_text(f"#!{sys.executable}\nprint({json.dumps(said)!r})\n")
    path.chmod(0o755)
    return str(path)


def test_a_page_of_a_bsdf(tree, golden, tmp_path, monkeypatch):
    monkeypatch.setenv("BSDFKIT_COMMAND", "")
    monkeypatch.setenv("PATH", "")
    file, out = golden("xml/t4_rf_rb_tf_tb.xml"), tmp_path / "a.html"
    text = report(file, out)
    assert out.read_text() == text
    page = read(text)
    for heading in ("Verdict", "Components", "Energy", "Reciprocity", "Peaks", "Pictures", "Commands", "Terms"):
        assert heading in re.findall(r"<h2>(.*?)</h2>", text)
    wi = bsdfkit.direction(45, 90)
    for way in (bsdfkit.Components.REFLECTION, bsdfkit.Components.TRANSMISSION):
        assert f"{tree.directional_hemispherical(wi, components=way):.4f}" in page.text
    assert f"{100 * tree.reciprocity_defect('front', 'front'):.1f} %" in page.text
    peak = tree.peaks(list(bsdfkit.direction(30, 0)), "front")[0]
    assert f"{peak['f']:.3g}" in page.text
    assert "the command bsdf was not found" in page.text
    assert f"bsdf check {file}" in page.text
    # The same file makes the same page.
    assert report(file) == text


def test_names_from_strangers_are_text(tree, tmp_path, monkeypatch):
    said = {
        "file": "a",
        "verdict": "bad",
        "faults": ["<img src=x onerror=alert(1)>"],
        "remarks": ["<b>bold</b>"],
        "energy": [
            {
                "component": "<i>front</i>",
                "largest": 1.5,
                "theta_degrees": 2,
                "phi_degrees": 0,
                "of_the_part_seen": False,
            }
        ],
        "reciprocity": [{"component": "front", "defect": 0.25}],
    }
    monkeypatch.setenv("BSDFKIT_COMMAND", command(tmp_path, said))
    file = tmp_path / "<b>&name.xml"
    evil = tree.tabulate(
        "klems-quarter", name=EVIL, manufacturer="<svg onload=alert(1)>", properties={"DeviceType": "<u>"}
    )
    evil.save(file)
    text = report(file)
    page = read(text)
    for words in (EVIL, "<svg onload=alert(1)>", "<u>", "<b>&name.xml", *said["faults"], *said["remarks"]):
        assert words in page.text, words
    assert "✗ faults" in page.text and "1.5000 of the light" in page.text and "differ by 25.0 %" in page.text
    assert "<i>front</i>" in page.text
    assert text.count("<title>") == 1 and not re.search(r"<(script|svg|u|b|i)[ >]", text)


def test_a_page_of_a_measurement(measurements):
    page = read(report(measurements))
    (m,) = bsdfkit.read(measurements)
    quality = m.quality()
    assert f"{quality['points']:,} points" in page.text and "isotropic" in page.text
    for i in quality["incidences"]:
        assert f"{i['hemispherical'][0]:.4f}" in page.text
        assert "none" in page.text if not i["holes"] else f"{i['holes'][0]['radius_degrees']:.1f}°" in page.text


def test_a_page_of_one_incidence_shows_it_once(measurements, tmp_path, monkeypatch):
    fault = "what the command says twice"
    said = {"verdict": "bad", "faults": [f"front transmission: {fault}"], "remarks": [fault, "another"]}
    monkeypatch.setenv("BSDFKIT_COMMAND", command(tmp_path, said))
    file = sorted(measurements.glob("*.txt"))[0]
    page = read(report(file))
    words = "Measured points, seen from the front"
    assert page.text.count(words) == 1
    assert read(report(measurements)).text.count(words) == 2
    assert page.text.count(fault) == 1 and "another" in page.text
    # Nothing is made of one incidence.
    assert "--kind mesh" in page.text and "bsdf fit" not in page.text


def test_the_commands_of_a_page_draw(golden, tmp_path):
    for name, lit in (("xml/dir_rb.xml", "150,0"), ("xml/t4_tf.xml", "30,0")):
        commands = re.search(r"<pre><code>(.*?)</code></pre>", report(golden(name)), re.S)[1]
        plots = [line.split()[2:] for line in commands.splitlines() if line.startswith("bsdf plot ")]
        assert len(plots) == 2 and all(lit in words for words in plots)
        for words in plots:
            ran = subprocess.run(
                [sys.executable, "-m", "bsdfkit.plot", *words], capture_output=True, text=True, cwd=tmp_path
            )
            assert ran.returncode == 0, ran.stderr


def test_a_page_of_an_interpolant_says_how_far_to_trust_it(interpolant, measurements, tmp_path):
    file = tmp_path / "fit.safetensors"
    interpolant.save(file)
    alone, beside = read(report(file)), read(report(file, measured=measurements))
    fitted = bsdfkit.open(file).fitted("front", "back")
    assert f"L1 {fitted['fit_l1'].mean():.4f} in the mean" in alone.text
    assert f"L1 {fitted['expected_l1']:.3f}; not to be trusted above" in alone.text
    assert "Incidences left out" not in alone.text and "Incidences left out" in beside.text
    (validation,) = bsdfkit.open(file).validate(measurements, progress=False)
    inside = ~np.array(validation.extrapolated)
    assert f"{validation.l1[inside].mean():.4f}" in beside.text
    assert len(beside.links) == len(alone.links) + 1


def test_bad_input_leaves_no_page(golden, measurements, tmp_path):
    out = tmp_path / "a.html"
    rubbish = tmp_path / "rubbish.xml"
    rubbish.write_bytes(os.urandom(64))
    for path, options, error in [
        (tmp_path / "missing.xml", {}, bsdfkit.IoError),
        (rubbish, {}, bsdfkit.FormatError),
        (golden("xml/t4_tf.xml"), {"measured": measurements}, bsdfkit.ArgumentError),
    ]:
        with pytest.raises(error):
            report(path, out, **options)
    with pytest.raises(bsdfkit.IoError, match="no"):
        report(golden("xml/t4_tf.xml"), tmp_path / "no" / "a.html")
    assert list(tmp_path.iterdir()) == [rubbish]


def test_the_command_line(golden, tmp_path):
    run = lambda *words: subprocess.run(
        [sys.executable, "-m", "bsdfkit._report", *map(str, words)], capture_output=True, text=True
    )  # noqa: E731
    out = tmp_path / "a.html"
    ran = run(golden("xml/t4_tf.xml"), "-o", out, "--title", "A & B")
    assert (ran.returncode, ran.stdout.strip()) == (0, str(out)), ran.stderr
    assert "<h1>A &amp; B</h1>" in out.read_text()
    ran = run(tmp_path / "missing.xml", "-o", out)
    assert ran.returncode == 3 and "missing.xml" in ran.stderr and "Traceback" not in ran.stderr
