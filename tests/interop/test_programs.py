"""Radiance's programs accept our files and render with them."""

import math

import pytest

import radiance

# A uniform surrounding of radiance 1: what a surface shows is its directional-hemispherical value.
FURNACE = """
void glow surrounding
0
0
4 1 1 1 0
surrounding source everywhere
0
0
4 0 0 1 360
"""

# A sun of half a degree and a dim surrounding.
SUN = """
void light bright
0
0
3 1e5 1e5 1e5
bright source sun
0
0
4 {sun} 0.53
void glow dim
0
0
4 .2 .2 .2 0
dim source everywhere
0
0
4 0 0 1 360
"""

# Up is +Y; no thickness, so that light passes through.
MATERIAL = """
void BSDF specimen
6 0 {xml} 0 1 0 .
0
0
"""

SPHERE = """
specimen sphere ball
0
0
4 0 0 0 1
"""

# Its front, +Z, is the room; the camera stands there.
WINDOW = """
specimen polygon pane
0
0
12 -1 -1 0  1 -1 0  1 1 0  -1 1 0
"""

SAMPLING = ["-ab", "1", "-ad", "256", "-as", "0", "-aa", "0", "-lr", "4", "-st", "0", "-ss", "16"]


@pytest.mark.parametrize("kind", ["tree", "klems"])
def test_check_bsdf_accepts(rad, files, kind):
    path = getattr(files, kind)
    report = rad.run(path.parent, "checkBSDF", path.name).decode()
    expected = {
        "klems": ["Klems_Full"],
        "tree": ["Anisotropic_Tensor_Tree", "Isotropic_Tensor_Tree"],
    }[kind]
    assert any(name in report for name in expected), report
    assert "nan" not in report.lower() and "inf " not in report.lower(), report


@pytest.mark.parametrize("kind", ["tree", "klems"])
def test_pkg_bsdf_makes_a_pane(bsdf, rad, files, kind):
    """It wants a width and a height: placeholders, or what was given."""
    path = getattr(files, kind)
    sized = path.with_name(f"sized_{kind}.xml")
    bsdf("convert", path, "--to", {"tree": "tensor-tree", "klems": "klems-full"}[kind], "-o", sized, "--width", "1.2", "--height", "0.8")
    for xml, width, height in ((path, 1, 1), (sized, 1.2, 0.8)):
        rad.run(path.parent, "pkgBSDF", xml.name)
        scene = xml.with_suffix(".rad").read_text()
        corners = [float(word) for word in scene.split("polygon")[1].split()[4:]]
        assert max(corners[::3]) == pytest.approx(width / 2) and max(corners[1::3]) == pytest.approx(height / 2)
        rad.octree(path.parent, f"packed_{kind}", scene)


@pytest.mark.parametrize("kind", ["tree", "klems"])
@pytest.mark.parametrize("shape", ["sphere", "window"])
def test_rpict_renders(rad, files, kind, shape):
    path = getattr(files, kind)
    # The sun stands behind the camera for what reflects and behind the pane for what transmits.
    sun = "0.3 0.4 -1" if files.transmits else "0.3 0.4 1"
    geometry = {"sphere": SPHERE, "window": WINDOW}[shape]
    scene = SUN.format(sun=sun) + MATERIAL.format(xml=path.name) + geometry
    octree = rad.octree(path.parent, f"{kind}_{shape}", scene)
    view = ["-vtv", "-vp", "0", "0", "5", "-vd", "0", "0", "-1", "-vu", "0", "1", "0", "-vh", "30", "-vv", "30"]
    picture = rad.picture(path.parent, octree, 48, "-ps", "1", *view, *SAMPLING)
    values = [v for row in picture for v in row]
    assert all(math.isfinite(v) and v >= 0.0 for v in values)
    middle = [v for row in picture[14:34] for v in row[14:34]]
    lit = sum(v > 1e-3 for v in middle)
    assert lit > len(middle) * 0.9, f"{lit} of {len(middle)} pixels of the {shape} are not black"
    spread = max(middle) - min(middle)
    assert shape == "window" or spread > 0.05 * max(middle), "a sphere in the sun has a light and a dark side"


@pytest.mark.parametrize("kind", ["tree", "klems"])
def test_rtrace_sees_the_hemispherical_total(rad, files, kind):
    """In a furnace of radiance 1 a pane shows what it reflects and transmits in all."""
    path = getattr(files, kind)
    scene = FURNACE + MATERIAL.format(xml=path.name) + WINDOW
    octree = rad.octree(path.parent, f"{kind}_furnace", scene)
    for theta in (0.0, 40.0):
        sine, cosine = math.sin(math.radians(theta)), math.cos(math.radians(theta))
        ray = f"{4 * sine} 0 {4 * cosine} {-sine} 0 {-cosine}\n"
        rays = (ray * 64).encode()
        text = rad.run(path.parent, "rtrace", "-h", "-fa", "-ov", *SAMPLING, octree, stdin=rays).decode()
        values = [float(word) for word in text.split()]
        assert len(values) == 3 * 64 and all(map(math.isfinite, values)), text[:200]
        expected = radiance.library("hemispherical", path, [(theta, 0.0)])[0]
        found = sum(values) / len(values)
        assert abs(found / expected - 1.0) < 0.05, f"{kind} at {theta} degrees: {found}, expected {expected}"
