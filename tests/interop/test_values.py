"""Radiance's library loads our XML and answers the same values as we do."""

import math
import random

import pytest

import radiance

# Radiance multiplies looked-up values by a position-dependent factor of up to 3e-4 to break ties.
TOLERANCE = 4e-4
PAIRS = 4000


def direction(generator, front):
    """θ and φ in degrees, uniform in projected solid angle up to 85 degrees."""
    sine = math.sqrt(generator.random()) * math.sin(math.radians(85.0))
    theta = math.degrees(math.asin(sine))
    return (theta if front else 180.0 - theta), generator.uniform(0.0, 360.0)


def pairs():
    """Incident and scattered directions on all four pairs of sides; one in four near the mirror direction or
    the straight line through, where values are steep."""
    generator = random.Random(20141)
    rows = []
    for k in range(PAIRS):
        front, transmitted = k % 2 == 0, k % 4 >= 2
        theta_i, phi_i = direction(generator, front)
        theta_o, phi_o = direction(generator, front != transmitted)
        if k % 16 < 4:
            theta_o = 180.0 - theta_i if transmitted else theta_i
            theta_o = min(max(theta_o + generator.gauss(0.0, 2.0), 0.0), 180.0)
            if (theta_o < 90.0) != (front != transmitted):
                continue
            phi_o = (phi_i + 180.0 + generator.gauss(0.0, 4.0)) % 360.0
        rows.append(tuple(round(x, 6) for x in (theta_i, phi_i, theta_o, phi_o)))
    return rows


@pytest.mark.parametrize("kind", ["tree", "klems"])
def test_values_agree(bsdf, files, kind):
    path = getattr(files, kind)
    rows = pairs()
    text = "".join(" ".join(map(str, row)) + "\n" for row in rows)
    ours = [float(line) for line in bsdf("eval", path, stdin=text).split()]
    assert len(ours) == len(rows)
    theirs = radiance.library("eval", path, rows)
    assert sum(v > 1e-3 for v in theirs) > len(rows) // 8, "hardly anything scatters"

    wrong = [
        (row, a, b)
        for row, a, b in zip(rows, ours, theirs)
        if not abs(a - b) <= TOLERANCE * abs(b) + 1e-7
    ]
    # Radiance's 32-bit coordinates may put a direction on the other side of a cell's wall.
    assert len(wrong) <= len(rows) // 1000, f"{len(wrong)} of {len(rows)} differ, first {wrong[:5]}"


def test_no_value_is_negative_or_odd(bsdf, files):
    text = "".join(" ".join(map(str, row)) + "\n" for row in pairs())
    for path in files.representations():
        values = [float(line) for line in bsdf("eval", path, stdin=text).split()]
        assert all(math.isfinite(v) and v >= 0.0 for v in values), path.name


def test_hemispherical_totals_agree_between_representations(files):
    """The tree and the matrix come from one interpolant: their totals differ by the cells' coarseness only."""
    rows = [(0.0, 20.0), (30.0, 20.0), (60.0, 20.0)]
    totals = [radiance.library("hemispherical", path, rows) for path in files.representations()]
    for row, tree, klems in zip(rows, *totals):
        assert 0.02 < tree < 1.02 and abs(tree - klems) < 0.1 * tree, f"{row}: {tree}, {klems}"


SKY = """void glow sky
0
0
4 1 1 1 0
sky source dome
0
0
4 0 0 1 360
void BSDF glass
6 0 {name} 0 1 0 .
0
0
glass polygon pane
0
0
12 -9 -9 0 9 -9 0 9 9 0 -9 9 0
"""


def test_for_radiance_the_sky_shines_through_isotropic_glass_from_both_sides(bsdf, rad, glass_xml):
    """Of a lone isotropic tree Radiance samples one way alone: findings/radiance-isotropic-tree-is-dark-from-behind.sh."""
    folder = glass_xml.parent
    bsdf("fit", folder / "measurements", "--for", "radiance", "--max-leaves", "8000", "-o", folder / "radiance.xml")
    octree = rad.octree(folder, "sky", SKY.format(name="radiance.xml"))
    tilt = math.tan(math.radians(20.0))

    def seen(z):
        ray = f"{tilt} 0 {z} {-tilt} 0 {-z}\n".encode() * 400
        options = "-h -ov -ab 1 -ad 1024 -lr 4 -st 0 -ss 16 -dj 0".split()
        rows = rad.run(folder, "rtrace", *options, octree, stdin=ray).decode().splitlines()
        return sum(float(row.split()[1]) for row in rows) / len(rows)

    totals = bsdf("hemispherical", "--stdin", folder / "radiance.xml", stdin="20 0\n160 0\n")
    ours = [float(row.split()[1]) for row in totals.splitlines()]
    assert seen(1) == pytest.approx(ours[0], rel=0.03) and seen(-1) == pytest.approx(ours[1], rel=0.03)
    assert ours[1] == pytest.approx(ours[0], rel=0.03) and ours[0] > 0.1
