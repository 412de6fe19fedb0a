"""Samples per second of the plugin for Mitsuba beside `roughconductor`, in one run and one scene.

    python benches/mitsuba_speed.py fabric.xml glass.xml …      needs bsdfkit[mitsuba] and LLVM 19

A sphere on a floor of the same material, under a sky and a square lamp, path tracing of depth 4. Processor time of all
threads, the best of five renderings, without the first, which compiles.
"""

import sys
import time

import bsdfkit.mitsuba
import drjit as dr
import mitsuba as mi

SIZE, SAMPLES = 256, 16


def scene(bsdf, size=SIZE):
    T = mi.ScalarTransform4f
    film = {"type": "hdrfilm", "width": size, "height": size}
    lamp = T().look_at([2, -2, 4], [0, 0, 0], [0, 0, 1]).scale(0.5)
    return mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": 4},
            "sensor": {
                "type": "perspective",
                "fov": 35,
                "to_world": T().look_at([0, -4, 1.5], [0, 0, 0.3], [0, 0, 1]),
                "film": film,
            },
            "sky": {"type": "constant", "radiance": 0.3},
            "lamp": {"type": "rectangle", "to_world": lamp, "emitter": {"type": "area", "radiance": 20.0}},
            "sphere": {"type": "sphere", "center": [0, 0, 0.6], "radius": 0.8, "bsdf": bsdf},
            "floor": {"type": "rectangle", "to_world": T().scale(3), "bsdf": bsdf},
        }
    )


def seconds(bsdf):
    what, best = scene(bsdf), float("inf")
    for seed in range(6):
        begin = time.process_time()
        dr.eval(mi.render(what, spp=SAMPLES, seed=seed))
        dr.sync_thread()
        if seed:
            best = min(best, time.process_time() - begin)
    return best


def main(paths):
    variant, why = bsdfkit.mitsuba.best_variant("rgb")
    if why:
        sys.exit(why)
    mi.set_variant(variant)
    print(f"mitsuba {mi.__version__}, {variant}")
    peer = seconds({"type": "roughconductor", "distribution": "ggx", "alpha_u": 0.1, "alpha_v": 0.3})
    rate = SIZE * SIZE * SAMPLES / 1e6
    print(f"{'roughconductor':40} {rate / peer:6.2f} million samples a processor second")
    for path in paths:
        own = seconds({"type": "bsdfkit", "filename": path})
        print(f"{path:40} {rate / own:6.2f}, {peer / own:.2f} of roughconductor's")


if __name__ == "__main__":
    main(sys.argv[1:])
