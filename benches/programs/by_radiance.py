"""Transmittance by Radiance: rays at a pane of `BSDF` or `aBSDF`, and the three-phase method with a Klems matrix.

The scene's axes are the film's: the room is z > 0, up is +Y. Suns are incident directions; of an even sky (the upper half)
and an even hemisphere the share that passes comes last.
"""

import numpy as np

import places  # noqa: F401  (where the module radiance lies)
import turning_film as film
from radiance import Radiance

PANE = """
void {kind} film
{arguments}
0
0
film polygon pane
0
0
12 -1e3 -1e3 0  1e3 -1e3 0  1e3 1e3 0  -1e3 1e3 0
"""
#: BSDF's first argument is its thickness.
ARGUMENTS = {"BSDF": "6 0 {} 0 1 0 .", "aBSDF": "5 {} 0 1 0 ."}
RADIANCE, SUN_DEGREES = 1e4, 0.53
#: Without -st 0 weak components turn diffuse; a low -lw keeps rays of little weight.
TRACED = ["-h", "-fa", "-ov", "-st", "0", "-aa", "0", "-lr", "6", "-lw", "1e-7", "-dj", "0"]

#: Wider suns for the three-phase method, so that the samples of a patch find them; and samples a patch.
WIDE_DEGREES, SAMPLES = 1.0, 6000
WINDOW = """#@rfluxmtx h=kf u=+Y
void glow window
0
0
4 1 1 1 0
window polygon opening
0
0
12 -1e3 -1e3 0  1e3 -1e3 0  1e3 1e3 0  -1e3 1e3 0
"""


def source(name, kind, radiance, towards, degrees):
    """A light far away: `light` is aimed at, `glow` found by chance."""
    last = " 0" if kind == "glow" else ""
    count = 4 if kind == "glow" else 3
    x, y, z = towards
    return (
        f"void {kind} {name}\n0\n0\n{count} {radiance} {radiance} {radiance}{last}\n"
        f"{name} source {name}_place\n0\n0\n4 {x} {y} {z} {degrees}\n"
    )


def cap(degrees):
    """Solid angle of a source."""
    return 2 * np.pi * (1 - np.cos(np.radians(degrees / 2)))


class Traced:
    """A pane that is looked at from n² directions of equal projected solid angle."""

    def __init__(self, folder, xml, kind, n=64):
        self.folder, self.radiance = folder, Radiance()
        self.pane = PANE.format(kind=kind, arguments=ARGUMENTS[kind].format(xml.name))
        self.rays = "\n".join(f"{x} {y} {z} {-x} {-y} {-z}" for x, y, z in film.hemisphere(n, True)).encode()

    def mean(self, lights, *options):
        """Mean radiance."""
        octree = self.radiance.octree(self.folder, "pane", lights + self.pane)
        text = self.radiance.run(self.folder, "rtrace", *options, *TRACED, octree, stdin=self.rays, timeout=3600)
        return np.array(text.split(), float)[1::3].mean()

    def suns(self, suns):
        """All in one run, each with a name of its own: a large tree is read once."""
        names = [f"sun{k}" for k in range(len(suns))]
        lights = "".join(source(name, "light", RADIANCE, wi, SUN_DEGREES) for name, wi in zip(names, suns))
        octree = self.radiance.octree(self.folder, "pane", lights + self.pane)
        modifiers = [word for name in names for word in ("-m", name)]
        options = [option for option in TRACED if option not in ("-ov",)]
        text = self.radiance.run(self.folder, "rcontrib", "-V+", "-ab", "0", *options, *modifiers, octree, stdin=self.rays, timeout=3600)
        shown = np.array(text.split(), float).reshape(-1, len(suns), 3)[:, :, 1].mean(0)
        return np.pi * shown / (RADIANCE * cap(SUN_DEGREES) * -np.array(suns)[:, 2])

    def skies(self):
        even = ["-ab", "1", "-ad", "64", "-as", "0", "-ss", "8"]
        # The room's own half of the upper dome would be reflected: a black wall stands behind the eyes.
        wall = "void plastic black\n0\n0\n5 0 0 0 0 0\nblack polygon wall\n0\n0\n12 -1e3 -1e3 9 1e3 -1e3 9 1e3 1e3 9 -1e3 1e3 9\n"
        sky = self.mean(source("sky", "glow", 1, (0, 1, 0), 180) + wall, *even)
        everything = self.mean(source("sky", "glow", 1, (0, 0, -1), 180), *even)
        return np.array([sky / 0.5, everything])


def matrix(text):
    """Green of a matrix with Radiance's header, shape (rows, columns)."""
    header, body = text.split(b"\n\n", 1)
    values = np.array(body.split(), float).reshape(-1, 3)[:, 1]
    [columns] = [int(line[6:]) for line in header.splitlines() if line.startswith(b"NCOLS=")]
    return values.reshape(-1, columns)


def three_phase(folder, xml, suns):
    """V T D s of suns, sky and hemisphere over what falls on the window by the same samples; and by which bins it falls."""
    radiance = Radiance()
    lights = [("sun", wi, WIDE_DEGREES) for wi in suns]
    lights += [("sun", (0, 1, 0), 180), ("sun", (0, 0, -1), 180)]
    (folder / "window.rad").write_text(WINDOW)
    options = ["-I+", "-fa", "-ab", "1", "-ad", "200000", "-lw", "1e-9"]
    view = radiance.run(folder, "rfluxmtx", *options, "-", "window.rad", stdin=b"0 0 1 0 0 -1\n", timeout=3600)
    (folder / "view.mtx").write_bytes(view)
    # One sample of radiance 1 in each of the three channels.
    sky = "#?RADIANCE\nNROWS=1\nNCOLS=1\nNCOMP=3\nFORMAT=ascii\n\n1 1 1\n"
    (folder / "sky.mtx").write_text(sky)
    omega, found, bins = matrix(view)[0], [], []
    for _, towards, degrees in lights:
        (folder / "light.rad").write_text("#@rfluxmtx h=u\n" + source("sun", "glow", 1, towards, degrees))
        daylight = radiance.run(folder, "rfluxmtx", "-fa", "-c", SAMPLES, "window.rad", "light.rad", timeout=3600)
        (folder / "daylight.mtx").write_bytes(daylight)
        inside = radiance.run(folder, "dctimestep", "-h", "view.mtx", xml.name, "daylight.mtx", "sky.mtx", timeout=3600)
        falls = omega * matrix(daylight)[:, 0]
        found.append(float(inside.split()[1]) / falls.sum())
        bins.append(falls / falls.sum())
    return np.array(found), np.array(bins)
