"""The room (room.py) by Mitsuba and by Radiance from the same files: mean radiance of each region, and both pictures.

    BSDF=target/release/bsdf python benches/programs/same_scene.py build/scene [--size 64 --samples 512]

Both trace paths: Radiance by one ambient and one specular sample a ray (-ad 1 -ss 1), many rays a pixel. Samples are parted into
batches, whose spread tells the standard error of each mean.
"""

import argparse
import os
import subprocess
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
LEAVES = 300_000
#: What comes later is below 0.1 % of the light.
BOUNCES = 10
BATCHES = 16


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


def by_mitsuba(paths, size, samples):
    """Radiance by batch and pixel, and the region of each pixel."""
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
    images = [np.array(mi.render(scene, spp=samples // BATCHES, seed=k))[..., 1] for k in range(BATCHES)]
    return np.array(images), regions(scene, list(shapes), size)


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


def by_radiance(paths, folder, size, samples):
    radiance = Radiance()
    octree = radiance.octree(folder, "room", radiance_scene(paths))
    towards = np.array(room.LOOK_AT) - room.EYE
    view = ["-vtv", "-vp", *room.EYE, "-vd", *towards, "-vu", 0, 0, 1, "-vh", room.FIELD, "-vv", room.FIELD]
    rays = [HOME / "bin" / "vwrays", "-ff", "-x", size, "-y", size, "-c", samples, "-pj", 1, *view]
    trace = [HOME / "bin" / "rtrace", "-n", 1, "-h", "-fff", "-u+", "-ab", BOUNCES, "-ad", 1, "-as", 0, "-aa", 0]
    # Roulette ends paths of little weight.
    trace += ["-ss", 1, "-st", 0, "-lr", -BOUNCES, "-lw", 0.03, "-dj", 1, "-ds", 0, "-dt", 0, "-dc", 0, "-dr", 0, octree]
    first = subprocess.Popen(list(map(str, rays)), cwd=folder, env=radiance.environment, stdout=subprocess.PIPE)
    done = subprocess.run(list(map(str, trace)), cwd=folder, env=radiance.environment, stdin=first.stdout, capture_output=True)
    assert done.returncode == 0 and first.wait() == 0, done.stderr
    values = np.frombuffer(done.stdout, np.float32).reshape(size, size, BATCHES, samples // BATCHES, 3)
    return values[..., 1].mean(-1, dtype=float).transpose(2, 0, 1)


def mean(images, own):
    """The mean over a region's pixels, and its standard error from batch to batch."""
    means = images[:, own].mean(1)
    return means.mean(), means.std(ddof=1) / np.sqrt(len(means))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--size", type=int, default=64)
    parser.add_argument("--samples", type=int, default=512, help=f"a pixel of Mitsuba's, a multiple of {BATCHES}")
    parser.add_argument("--radiance-samples", type=int, default=512, help=f"a pixel of Radiance's, a multiple of {BATCHES}")
    arguments = parser.parse_args()
    variant, why = bsdfkit.mitsuba.best_variant("rgb")
    mi.set_variant(variant)
    paths = files(arguments.folder)
    start = time.process_time()
    ours, region = by_mitsuba(paths, arguments.size, arguments.samples)
    between = time.process_time()
    before = os.times().children_user
    theirs = by_radiance(paths, arguments.folder, arguments.size, arguments.radiance_samples)
    print(f"processor seconds: Mitsuba ({variant}) {between - start:.0f}, Radiance {os.times().children_user - before:.0f}")
    print(f"{'region':12} {'pixels':>6} {'Mitsuba':>10} {'Radiance':>10} {'difference':>10} {'its error':>10}")
    for name in sorted(set(region.ravel())):
        own = region == name
        (a, noise), (b, other) = mean(ours, own), mean(theirs, own)
        error = 100 * np.hypot(noise / a, other / b)
        print(f"{name or 'nothing':12} {own.sum():6d} {a:10.4f} {b:10.4f} {100 * (a / b - 1):9.2f}% {error:9.2f}%")
    ours, theirs = ours.mean(0), theirs.mean(0)
    both = np.concatenate([ours, theirs], axis=1)
    tone = np.clip(both / (4 * np.median(both)), 0, 1)
    mi.Bitmap(np.repeat(tone[..., None], 3, 2).astype(np.float32)).convert(
        mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.UInt8, True
    ).write(str(arguments.folder / "room.png"))
    np.savez_compressed(arguments.folder / "room.npz", mitsuba=ours, radiance=theirs, region=region)


if __name__ == "__main__":
    main()
