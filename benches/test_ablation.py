"""What the bench is told to keep back, and where it looks: python -m pytest benches/test_ablation.py"""

import re
import sys
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

import ablation  # noqa: E402


def test_the_halves_are_those_that_were_written_down():
    text = (HERE / "held_back.md").read_text()
    virtual, traced = text.split("| ray-traced specimen |")
    for section, names in [(virtual, ablation.VIRTUAL), (traced, ablation.TRACED)]:
        for final, half in [(False, "looked at"), (True, "held back")]:
            written = re.findall(rf"^\| ([a-z-]+) \| {half} \|$", section, re.M)
            assert written == ablation.looked_at(names, final)


def test_nothing_held_back_is_run_without_final():
    words = ["ablation.py", "--traced", "nowhere"]
    for final in (False, True):
        sys.argv = words + ["--final"] * final
        names = {name for _, name, _ in ablation.specimens(ablation.parse())}
        for name in ["velvet", "retro-sheet", "traced/woven-threads"]:
            assert (name in names) == final
        for name in ["fabric", "louver", "traced/slats"]:
            assert (name in names) != final


def test_held_out_incidences_are_half_way_and_grazing_ones_beyond():
    grids = {
        "isotropic": [0.0],
        "quadrilateral": [0.0, 30.0, 60.0, 90.0],
        "none": [30.0 * k for k in range(12)],
    }
    for symmetry, phis in grids.items():
        measured = [(0.0, 0.0)] + [(t, p) for t in (15.0, 30.0, 45.0, 60.0, 75.0) for p in phis]
        sets = ablation.incident_sets(measured)
        assert set(sets["measured"]) <= set(measured)
        assert {t for t, _ in sets["held-out"]} == {7.5, 22.5, 37.5, 52.5, 67.5}
        if symmetry != "isotropic":
            assert all(p % 30.0 == 15.0 for _, p in sets["held-out"])
            assert len({p for _, p in sets["held-out"]}) > len(phis) // 2 - 1
        assert {t for t, _ in sets["grazing"]} == {80.0, 85.0}


def test_distances_and_what_is_no_number():
    truth = np.array([1.0, 3.0, 0.0])
    assert ablation.distance(truth, truth) == (0.0, 0.0, 0)
    l1, energy, bad = ablation.distance(truth, np.array([2.0, np.nan, -1.0]))
    assert (l1, energy, bad) == (5.0 / 4.0, -0.75, 2)
