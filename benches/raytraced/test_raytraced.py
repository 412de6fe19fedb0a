"""What must hold before a ray-traced measurement is believed: python -m pytest benches/raytraced"""

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent))

import specimens  # noqa: E402
from cells import CELLS, angles, blocks, centres, direction, means, to_hemisphere  # noqa: E402
from bsdfkit.geometry._goniophotometer import batch, cell_of, measure  # noqa: E402
from renderer import mi  # noqa: E402

AREA = np.pi / CELLS**2
SLANTS = [(0, 0), (30, 20), (60, 135), (80, 250)]


def window(w):
    """The 5 x 5 cells around a direction."""
    number = int(np.array(cell_of(mi.Float(float(w[0])), mi.Float(float(w[1]))))[0])
    return np.array([number + CELLS * i + j for i in range(-2, 3) for j in range(-2, 3)])


def f_between(specimen, a, b, seeds, rays=1 << 18):
    """f from everywhere in the window around a to that around b, by projected solid angle, and its noise."""
    each = []
    for seed in seeds:
        rng = np.random.default_rng(seed)
        cell = rng.choice(window(a), rays)
        wi = to_hemisphere((cell // CELLS + rng.random(rays)) / CELLS, (cell % CELLS + rng.random(rays)) / CELLS)
        (up, _), _ = batch(specimen, wi, seed, beam_degrees=0.0, rays=rays)
        each.append(up[window(b)].sum() / (25 * AREA))
    return np.mean(each), np.std(each) / np.sqrt(len(each) - 1)


def test_cells_are_found_where_directions_are():
    k = np.arange(CELLS * CELLS)
    w = to_hemisphere((k // CELLS + 0.5) / CELLS, (k % CELLS + 0.5) / CELLS)
    assert (np.array(cell_of(mi.Float(w[:, 0]), mi.Float(w[:, 1]))) == k).all()


def test_blocks_cover_every_cell_once_and_keep_the_light():
    rng = np.random.default_rng(3)
    rays = rng.exponential(300.0, CELLS * CELLS) * (np.arange(CELLS * CELLS) % 97 < 20)
    number, parts = blocks(rays)
    assert (parts[:, 2] ** 2).sum() == CELLS * CELLS and (np.bincount(number) == parts[:, 2] ** 2).all()
    assert np.isclose((means(number, rays) * np.bincount(number)).sum(), rays.sum())
    single = parts[:, 2] == 1
    assert single.any() and (parts[:, 2] == 4).any()
    w = centres(parts, -1.0)
    at = np.array(cell_of(mi.Float(w[:, 0]), mi.Float(w[:, 1])))
    assert (number[at][single] == np.arange(len(parts))[single]).all()


@pytest.mark.parametrize("theta, phi", SLANTS)
def test_a_lambertian_plane_is_reflectance_over_pi(theta, phi):
    (up, down), lost = batch(specimens.lambertian_plane(), direction(theta, phi), 7)
    assert down.sum() == 0 and lost == 0 and abs(up.sum() - 0.5) < 1e-4
    f = up / AREA * np.pi / 0.5
    # 28 rays a cell: counts of Poisson
    assert abs(f.mean() - 1) < 1e-3 and abs(f.std() / (CELLS / np.sqrt(0.5 * (1 << 19))) - 0.71) < 0.05
    coarse = f.reshape(8, CELLS // 8, 8, CELLS // 8).mean((1, 3))
    assert np.abs(coarse - 1).max() < 0.05


@pytest.mark.parametrize("theta, phi", SLANTS)
def test_a_mirror_mirrors_and_a_pane_goes_straight_through(theta, phi):
    mirror = specimens.extruded("mirror", [(-1, 0), (2, 0)], {"type": "conductor", "material": "none"})
    specimen = specimens.specimen("mirror", "reflection", "none", [mirror], (1.0, 1.0), -0.1, 0.1)
    (up, _), _ = batch(specimen, direction(theta, phi), 1, beam_degrees=0.0)
    w = direction(theta, phi + 180)
    at = window(w)[12]
    number = np.argmax(up)
    # a direction on the border of two cells may fall into either
    assert abs(up.sum() - 1) < 1e-5 and up[number] > 0.45
    assert max(abs(number // CELLS - at // CELLS), abs(number % CELLS - at % CELLS)) <= 1
    film = specimens.extruded("front", [(-1, 0.1), (2, 0.1)], {"type": "dielectric"})
    back = specimens.extruded("back", [(-1, 0.0), (2, 0.0)], {"type": "dielectric"}, flip=True)
    pane = specimens.specimen("pane", "transmission", "none", [film, back], (1.0, 1.0), -0.1, 0.2)
    (up, down), lost = batch(pane, direction(theta, phi), 1, beam_degrees=0.0)
    assert abs(up.sum() + down.sum() - 1) < 1e-3 and lost < 1e-3
    assert abs(np.argmax(down) // CELLS - at // CELLS) <= 1 and abs(np.argmax(down) % CELLS - at % CELLS) <= 1
    assert abs(down.sum() - transmitted(theta)) < 3e-3


def transmitted(theta, n=1.5046):
    """Of a pane without absorption, all reflections inside it: mean of both polarisations (each ray is unpolarised)."""
    c = np.cos(np.radians(theta))
    t = np.sqrt(1 - (1 - c * c) / n**2)
    r = 0.5 * (((c - n * t) / (c + n * t)) ** 2 + ((n * c - t) / (n * c + t)) ** 2)
    return (1 - r) / (1 + r)


@pytest.mark.parametrize("theta, phi", SLANTS)
def test_lossless_specimens_return_all_light(theta, phi):
    smooth = specimens.prismatic_film(alpha=0, front=0)
    white = specimens.slats(specimens.matte(1.0))
    for specimen, most_lost in [(smooth, 0.02), (white, 0.002)]:
        (up, down), lost = batch(specimen, direction(theta, phi), 5)
        # light that prisms keep reflecting totally is cut off at the last event
        assert lost < most_lost, (specimen.name, lost)
        assert abs(up.sum() + down.sum() + lost - 1) < 3e-3, (specimen.name, up.sum(), down.sum(), lost)


def test_slats_hide_what_geometry_says():
    """Black slats: light passes where no slat stands in its way, by the shadow of one slat across the period."""
    black = specimens.slats(specimens.matte(0.0))
    s = np.linspace(-0.575, 0.575, 17)
    crown = 0.06 * (1.0 - (s / 0.575) ** 2)
    sin, cos = np.sin(np.radians(35.0)), np.cos(np.radians(35.0))
    x, z = s * sin - crown * cos, s * cos + crown * sin
    for theta, phi in SLANTS + [(50, 180), (35, 0)]:
        w = direction(theta, phi)
        shadow = x - z * w[0] / w[2]
        (_, down), _ = batch(black, w, 2, beam_degrees=0.0)
        assert abs(down.sum() - max(0.0, 1 - np.ptp(shadow))) < 3e-3, (theta, phi)


@pytest.mark.parametrize("name", ["slats", "bumps-of-two-lengths", "woven-threads", "saw-tooth-metal"])
def test_reflection_is_reciprocal_within_noise(name):
    specimen = specimens.ALL[name]()
    for a, b in [((30, 40), (55, 200)), ((10, 90), (60, 150)), ((70, 10), (25, 100))]:
        a, b = direction(*a), direction(*b)
        there, noise = f_between(specimen, a, b, range(6))
        back, more = f_between(specimen, b, a, range(6, 12))
        assert there > 0.01 and abs(there - back) < 5 * np.hypot(noise, more), (name, there, back, noise, more)


def test_the_same_seed_is_the_same_light_and_another_is_not():
    specimen = specimens.saw_tooth_metal()
    one, two, other = (batch(specimen, direction(20, 30), seed)[0][0] for seed in (1, 1, 2))
    assert np.abs(one - two).max() < 1e-6 and np.abs(one - other).max() > 1e-6


def test_the_noise_that_is_told_is_that_of_another_run():
    specimen = specimens.slats()
    runs = [measure(specimen, 40, 20, seed, specimen.ups)[0] for seed in (1, 2)]
    number, _ = blocks(runs[0].rays + runs[1].rays)
    size = np.bincount(number)
    a, b = (means(number, m.values) for m in runs)
    apart = (np.abs(a - b) * size).sum() / (a * size).sum()
    told = np.mean([m.noise for m in runs])
    # two runs differ by √2 times the noise of one; their blocks are finer
    assert told < apart < 2.5 * told


def test_angles_go_there_and_back():
    for theta, phi in [(10.0, 20.0), (80.0, 300.0), (150.0, 90.0)]:
        assert np.allclose(angles(direction(theta, phi)), (theta, phi))
