"""Spheres of several materials in one light, by Mitsuba's plugin.

    pip install '.[mitsuba]' pillow                    in the root of the repository; LLVM 19 for speed
    python spheres.py metal.xml fabric.xml -o spheres.png
"""

import argparse

import bsdfkit.mitsuba
import mitsuba as mi


def scene(paths, width):
    T = mi.ScalarTransform4f
    count = len(paths)
    found = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 6},
        "sensor": {
            "type": "perspective",
            "fov": 14.0 * count,
            "fov_axis": "x",
            "to_world": T().look_at([0, -8, 2.4], [0, 0, 0.75], [0, 0, 1]),
            "film": {"type": "hdrfilm", "width": width, "height": width * 5 // (4 * count)},
        },
        "sky": {"type": "constant", "radiance": 0.25},
        "lamp": {
            "type": "rectangle",
            "to_world": T().look_at([3, -4, 5], [0, 0, 0.8], [0, 0, 1]).scale(0.7),
            "emitter": {"type": "area", "radiance": 25.0},
        },
        "floor": {
            "type": "rectangle",
            "to_world": T().scale(40),
            "bsdf": {"type": "diffuse", "reflectance": 0.3},
        },
    }
    for k, path in enumerate(paths):
        found[f"sphere{k}"] = {
            "type": "sphere",
            # A sphere's u runs round its axis: brushed materials are brushed along it.
            "to_world": T().translate([2.0 * k - (count - 1), 0, 0.85]).scale(0.85),
            "bsdf": {"type": "bsdfkit", "filename": path},
        }
    return mi.load_dict(found)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("materials", nargs="+")
    parser.add_argument("-o", "--output", required=True)
    parser.add_argument("--width", type=int, default=720)
    parser.add_argument("--samples", type=int, default=256)
    given = parser.parse_args()
    variant, why = bsdfkit.mitsuba.best_variant("rgb")
    if why:
        print(f"slowly, in {variant}: {why}")
    mi.set_variant(variant)
    image = mi.render(scene(given.materials, given.width), spp=given.samples)
    mi.util.write_bitmap(given.output, image)


if __name__ == "__main__":
    main()
