"""Transmittance by Mitsuba: an irradiance meter behind a pane of the plugin `bsdfkit`.

The scene's axes are the film's: the room is z > 0, up is +Y.
"""

import numpy as np

import bsdfkit.mitsuba
import mitsuba as mi

VARIANT, WHY_NOT_FASTER = bsdfkit.mitsuba.best_variant("rgb")
#: Rays that the meter sends.
SAMPLES = 1 << 20 if not WHY_NOT_FASTER else 1 << 12


def irradiance(pane, emitter, samples=SAMPLES):
    """What falls on a spot one metre behind a pane of 2 km."""
    mi.set_variant(VARIANT)
    T = mi.ScalarTransform4f
    meter = {
        "type": "rectangle",
        "to_world": T().look_at([0, 0, 1], [0, 0, 0], [0, 1, 0]).scale(1e-3),
        "bsdf": {"type": "diffuse", "reflectance": 0.0},
        "sensor": {
            "type": "irradiancemeter",
            "sampler": {"type": "independent", "sample_count": samples},
            "film": {"type": "hdrfilm", "width": 1, "height": 1, "rfilter": {"type": "box"}},
        },
    }
    glass = {"type": "rectangle", "to_world": T().scale(1e3), "bsdf": pane}
    # Twice along the path: the pane, then the light.
    path = {"type": "path", "max_depth": 2}
    # Behind the meter it is dark, else the pane would reflect the room's half of a sky.
    black = {"type": "diffuse", "reflectance": 0.0}
    wall = {"type": "rectangle", "to_world": T().translate([0, 0, 2]).scale(1e4), "bsdf": black}
    scene = {"type": "scene", "integrator": path, "meter": meter, "pane": glass, "wall": wall, "light": emitter}
    scene = mi.load_dict(scene)
    return float(np.array(mi.render(scene, seed=1)).ravel()[1])


def transmittances(xml, suns):
    """Of suns, of an even sky, of an even hemisphere."""
    mi.set_variant(VARIANT)
    pane = mi.load_dict({"type": "bsdfkit", "filename": str(xml)})
    found = []
    for wi in suns:
        sun = {"type": "directional", "direction": (-wi).tolist(), "irradiance": 1.0}
        found.append(irradiance(pane, sun) / -wi[2])
    # Up is +Y in an envmap, too.
    half = np.zeros((512, 8, 3), np.float32)
    half[:256] = 1.0
    sky = {"type": "envmap", "bitmap": mi.Bitmap(half)}
    found.append(irradiance(pane, sky) / (np.pi / 2))
    found.append(irradiance(pane, {"type": "constant", "radiance": 1.0}) / np.pi)
    return np.array(found)
