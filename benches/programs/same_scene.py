"""The room (room.py) by Mitsuba and by Radiance from the same files: mean radiance of each region, and both pictures.

    BSDF=target/release/bsdf python benches/programs/same_scene.py build/scene [--size 32 --error 0.4]

Both trace paths along the same rays from the eye: Radiance by one ambient and one specular sample a ray (-ad 1 -ss 1). Samples are
parted into batches, whose spread tells the standard error of each mean; regions that are not known well enough get more of them.
"""

import argparse
import os
import subprocess
import sys
import time
from pathlib import Path

import bsdfkit.mitsuba
import mitsuba as mi
import numpy as np
import room
from places import bsdf
from radiance import HOME, Radiance

#: By region: the virtual material, and the values of its tree.
MATERIALS = {"sphere": "brushed-metal", "drape": "fabric", "pane": "prism-film"}
LEAVES = 200_000
#: What comes later is below 0.1 % of the light.
BOUNCES = 10
#: Samples a pixel in a batch, batches of the first round, most batches of all.
PER, FIRST, MOST = 48, 16, 2048
#: Rays that are traced at a time.
CHUNK = 4_000_000


def files(folder):
    """The tree of each region's material, measured and fitted where it is not there yet."""
    folder.mkdir(parents=True, exist_ok=True)
    found = {}
    for region, material in MATERIALS.items():
        path = found[region] = folder / f"{material}.xml"
        if not path.exists():
            bsdf("simulate", material, "-o", folder / material)
            bsdf("fit", folder / material, "-o", path, "--max-leaves", LEAVES)
    return found


def mesh(name, polygons, bsdf, uv=None):
    """Quadrilaterals with flat normals; `uv` by corner, else none."""
    corners = np.array(polygons, np.float32).reshape(-1, 3)
    first = 4 * np.arange(len(corners) // 4)[:, None]
    faces = np.concatenate([first + [0, 1, 2], first + [0, 2, 3]]).astype(np.uint32)
    properties = mi.Properties()
    properties["bsdf"] = mi.load_dict(bsdf)
    properties["face_normals"] = True
    made = mi.Mesh(name, len(corners), len(faces), has_vertex_texcoords=uv is not None, props=properties)
    parameters = mi.traverse(made)
    parameters["vertex_positions"] = mi.Float(corners.ravel())
    parameters["faces"] = mi.UInt32(faces.ravel())
    if uv is not None:
        parameters["vertex_texcoords"] = mi.Float(np.array(uv, np.float32).ravel())
    parameters.update()
    return made


def drape_quads():
    x, y, along = room.drape()
    low, high = room.DRAPE_HEIGHT
    quads, uv = [], []
    for k in range(len(x) - 1):
        quads.append([(x[k], y[k], low), (x[k + 1], y[k + 1], low), (x[k + 1], y[k + 1], high), (x[k], y[k], high)])
        uv.append([(along[k], low), (along[k + 1], low), (along[k + 1], high), (along[k], high)])
    return quads, uv


def mitsuba_scene(paths, size):
    """The room, and the names of its shapes."""
    T = mi.ScalarTransform4f
    own = {region: {"type": "bsdfkit", "filename": str(path)} for region, path in paths.items()}
    shapes = {}
    for name, (polygons, reflectance) in room.quads().items():
        matte = {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": reflectance}}
        shapes[name] = mesh(name, polygons, matte)
    quads, uv = drape_quads()
    shapes["drape"] = mesh("drape", quads, own["drape"], uv)
    shapes["pane"] = mesh("pane", [room.pane()], own["pane"], [(0, 0), (1, 0), (1, 1), (0, 1)])
    place = T().translate(list(room.SPHERE["centre"])).scale(room.SPHERE["radius"])
    shapes["sphere"] = {"type": "sphere", "to_world": place, "bsdf": own["sphere"]}
    # A disk far away, of radiance SUN_RADIANCE.
    far = 1e4
    disk = T().look_at((far * room.SUN).tolist(), [0, 0, 0], [0, 0, 1]).scale(far * float(np.tan(np.radians(room.SUN_DEGREES / 2))))
    scene = mi.load_dict({
        "type": "scene",
        "integrator": {"type": "path", "max_depth": BOUNCES + 1, "rr_depth": 100},
        "sensor": {
            "type": "perspective",
            "fov": room.FIELD,
            "to_world": T().look_at(list(room.EYE), list(room.LOOK_AT), [0, 0, 1]),
            "film": {"type": "hdrfilm", "width": size, "height": size, "rfilter": {"type": "box"}},
            "sampler": {"type": "independent"},
        },
        "sky": {"type": "constant", "radiance": room.SKY_RADIANCE},
        "sun": {"type": "disk", "to_world": disk, "emitter": {"type": "area", "radiance": room.SUN_RADIANCE}},
        **shapes,
    })
    return scene, list(shapes)


def regions(scene, names, size):
    """The name of what is in the middle of each pixel."""
    at = (np.arange(size) + 0.5) / size
    x, y = np.meshgrid(at, at)
    ray, _ = scene.sensors()[0].sample_ray(0.0, 0.5, mi.Point2f(x.ravel(), y.ravel()), mi.Point2f(0.5))
    found = scene.ray_intersect(ray)
    label = np.full(size * size, "", dtype="U12")
    order = {shape.id(): shape for shape in scene.shapes()}
    for name in names:
        label[np.array(found.shape == mi.ShapePtr(order[name]))] = name
    return label.reshape(size, size)


def radiance_scene(paths):
    """The same as text of Radiance."""
    text = []

    def polygon(modifier, name, corners):
        numbers = " ".join(f"{c:.6f}" for corner in corners for c in corner)
        text.append(f"{modifier} polygon {name}\n0\n0\n{3 * len(corners)} {numbers}\n")

    for region, path in paths.items():
        text.append(f"void BSDF {region}_bsdf\n6 0 {path.name} 0 0 1 .\n0\n0\n")
    for name, (polygons, reflectance) in room.quads().items():
        text.append(f"void plastic {name}_paint\n0\n0\n5 {reflectance} {reflectance} {reflectance} 0 0\n")
        for k, corners in enumerate(polygons):
            polygon(f"{name}_paint", f"{name}_{k}", corners)
    for k, corners in enumerate(drape_quads()[0]):
        polygon("drape_bsdf", f"drape_{k}", corners)
    polygon("pane_bsdf", "pane", room.pane())
    x, y, z = room.SPHERE["centre"]
    text.append(f"sphere_bsdf sphere ball\n0\n0\n4 {x} {y} {z} {room.SPHERE['radius']}\n")
    s, k = room.SUN_RADIANCE, room.SKY_RADIANCE
    text.append(f"void light bright\n0\n0\n3 {s} {s} {s}\nbright source sun\n0\n0\n4 {' '.join(map(str, room.SUN))} {room.SUN_DEGREES}\n")
    text.append(f"void glow dim\n0\n0\n4 {k} {k} {k} 0\ndim source sky\n0\n0\n4 0 0 1 360\n")
    return "\n".join(text)


class ByMitsuba:
    """Radiance along rays from the eye."""

    def __init__(self, scene, size):
        self.scene, self.size, self.seed = scene, size, 0

    def rays(self, pixels, samples):
        """Origins and directions (pixels, samples, 6) at random in pixels, numbered along rows from the top."""
        random = np.random.default_rng(self.seed)
        place = random.random((len(pixels), samples, 2)) + np.stack([pixels % self.size, pixels // self.size], -1)[:, None]
        x, y = np.float32(place.reshape(-1, 2).T / self.size)
        ray, _ = self.scene.sensors()[0].sample_ray(0.0, 0.5, mi.Point2f(x, y), mi.Point2f(0.5))
        directions = np.array(ray.d).T
        return np.concatenate([np.broadcast_to(np.float32(room.EYE), directions.shape), directions], 1)

    def __call__(self, rays):
        self.seed += 1
        sampler = mi.load_dict({"type": "independent"})
        sampler.seed(self.seed, len(rays))
        ray = mi.RayDifferential3f(mi.Ray3f(mi.Point3f(np.float32(rays[:, :3].T)), mi.Vector3f(np.float32(rays[:, 3:].T))))
        found, _, _ = self.scene.integrator().sample(self.scene, sampler, ray)
        return np.array(found.y)


class ByRadiance:
    """The same by Radiance."""

    def __init__(self, paths, folder):
        self.radiance, self.folder = Radiance(), folder
        octree = self.radiance.octree(folder, "room", radiance_scene(paths))
        trace = [HOME / "bin" / "rtrace", "-n", 1, "-h", "-fff", "-u+", "-ab", BOUNCES, "-ad", 1, "-as", 0, "-aa", 0]
        # Roulette ends paths of little weight.
        trace += ["-ss", 1, "-st", 0, "-lr", -BOUNCES, "-lw", 0.03, "-dj", 1, "-ds", 0, "-dt", 0, "-dc", 0, "-dr", 0, octree]
        self.command = list(map(str, trace))

    def __call__(self, rays):
        done = subprocess.run(
            self.command, cwd=self.folder, env=self.radiance.environment, input=np.float32(rays).tobytes(), capture_output=True
        )
        assert done.returncode == 0, done.stderr
        return np.frombuffer(done.stdout, np.float32).reshape(-1, 3)[:, 1]


class Region:
    """What both programs say of some pixels: means by batch, and sums by pixel."""

    def __init__(self, name, pixels):
        self.name, self.pixels = name, pixels
        self.batches, self.sums, self.samples = ([], []), np.zeros((2, len(pixels))), 0

    def add(self, values, batches):
        """Values of both programs (2, pixels · batches · PER)."""
        values = values.reshape(2, len(self.pixels), batches, PER).mean(-1, dtype=float)
        for own, found in zip(self.batches, values.mean(1)):
            own.extend(found)
        self.sums += values.sum(-1)
        self.samples += batches

    def compared(self):
        """Both means, their difference as a share of Radiance's, and its standard error by program."""
        (a, b), errors = (np.mean(self.batches, 1), np.std(self.batches, 1, ddof=1) / np.sqrt(self.samples))
        return a, b, a / b - 1, errors / [a, b]

    def wanted(self, error):
        """Batches that are missing for a standard error."""
        now = np.hypot(*self.compared()[3])
        return int(np.clip(np.ceil(1.1 * self.samples * (now / error) ** 2), 0, MOST)) - self.samples


def trace(region, batches, ours, theirs):
    """More batches of a region by both programs."""
    most = max(1, CHUNK // (len(region.pixels) * PER))
    while batches > 0:
        some = min(batches, most)
        rays = ours.rays(region.pixels, some * PER)
        region.add(np.stack([ours(rays), theirs(rays)]), some)
        batches -= some


def show(regions, size, path):
    """Both pictures side by side, as PNG."""
    pictures = np.zeros((2, size * size))
    for region in regions:
        pictures[:, region.pixels] = region.sums / region.samples
    both = np.concatenate(pictures.reshape(2, size, size), axis=1)
    tone = np.clip(both / (4 * np.median(both)), 0, 1)
    mi.Bitmap(np.repeat(tone[..., None], 3, 2).astype(np.float32)).convert(
        mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.UInt8, True
    ).write(str(path))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--size", type=int, default=32)
    parser.add_argument("--error", type=float, default=0.4, help="percent: standard error of a region's difference that is aimed at")
    parser.add_argument("--regions", nargs="+", help="these alone get more than the first samples")
    arguments = parser.parse_args()
    variant, why = bsdfkit.mitsuba.best_variant("rgb")
    if why:
        sys.exit(why)
    mi.set_variant(variant)
    paths, size = files(arguments.folder), arguments.size
    scene, names = mitsuba_scene(paths, size)
    label = regions(scene, names, size).ravel()
    own = [Region(name, np.flatnonzero(label == name)) for name in sorted(set(label))]
    ours, theirs = ByMitsuba(scene, size), ByRadiance(paths, arguments.folder)
    start, before = time.process_time(), os.times().children_user
    for region in own:
        trace(region, FIRST, ours, theirs)
    for region in own:
        while region.name in (arguments.regions or names) and (missing := region.wanted(arguments.error / 100)) > 0:
            trace(region, missing, ours, theirs)
    print(f"processor seconds: Mitsuba ({variant}) {time.process_time() - start:.0f}, Radiance {os.times().children_user - before:.0f}")
    print(f"{'region':12} {'pixels':>6} {'a pixel':>8} {'Mitsuba':>10} {'Radiance':>10} {'difference':>10} {'its error':>10}  by program")
    for region in own:
        a, b, difference, errors = region.compared()
        print(
            f"{region.name or 'nothing':12} {len(region.pixels):6d} {PER * region.samples:8d} {a:10.4f} {b:10.4f} {100 * difference:9.2f}% "
            f"{100 * np.hypot(*errors):9.2f}%  {100 * errors[0]:.2f}% {100 * errors[1]:.2f}%",
            flush=True,
        )
    show(own, size, arguments.folder / "room.png")


if __name__ == "__main__":
    main()
