"""Variance of pictures at equal samples: tree and render form of a material beside the analytic material itself, drawn by its own program.

    BSDF=target/release/bsdf python benches/mitsuba_variance.py build/variance      needs bsdfkit[mitsuba] and LLVM 19

The material is Mitsuba's `roughconductor` (0.1 by 0.3, one reflection a facet), measured through its own values, fitted and
written as a tree and as a render form. Two scenes: an even sky alone, where all noise is that of drawing the material, and benches/mitsuba_speed.py's.
Variance of a pixel over RUNS pictures, the mean over pixels of the sphere, over the square of its mean; and by how much the
pictures differ in the mean. Samples a processor second in the same run.
"""

import os
import subprocess
import sys
import time
from pathlib import Path

import bsdfkit.mitsuba
import drjit as dr
import mitsuba as mi
import numpy as np

import mitsuba_speed

BSDF = os.environ.get("BSDF", "target/release/bsdf")
ANALYTIC = {"type": "roughconductor", "distribution": "ggx", "alpha_u": 0.1, "alpha_v": 0.3, "material": "none"}
THETAS, AZIMUTHS, POSITIONS = [0, 15, 30, 45, 60, 75, 85], range(0, 91, 30), 56
RUNS, SAMPLES = 32, 16


def positions():
    """Directions of equal projected solid angle, one in each cell of the concentric square."""
    at = (np.arange(POSITIONS) + 0.5) / POSITIONS * 2 - 1
    a, b = (g.ravel() for g in np.meshgrid(at, at))
    wide = np.abs(a) > np.abs(b)
    r = np.where(wide, a, b)
    other = np.where(wide, b, a) / r * np.pi / 4
    phi = np.where(wide, other, np.pi / 2 - other)
    return np.stack([r * np.cos(phi), r * np.sin(phi), np.sqrt(1 - r * r)], -1)


def table():
    """f of the analytic material as measurements."""
    material, wo = mi.load_dict(ANALYTIC), positions()
    theta_o, phi_o = np.degrees(np.arccos(wo[:, 2])), np.degrees(np.arctan2(wo[:, 1], wo[:, 0])) % 360
    lines = ["theta_i,phi_i,theta_o,phi_o,value"]
    for theta in THETAS:
        for phi in AZIMUTHS if theta else [0]:
            t, p = np.radians([theta, phi])
            si = dr.zeros(mi.SurfaceInteraction3f, len(wo))
            si.wi = mi.Vector3f(float(np.sin(t) * np.cos(p)), float(np.sin(t) * np.sin(p)), float(np.cos(t)))
            f = np.array(material.eval(mi.BSDFContext(), si, mi.Vector3f(np.float32(wo.T))))[1] / wo[:, 2]
            lines += [f"{theta},{phi},{a:.5f},{b:.5f},{v:.7g}" for a, b, v in zip(theta_o, phi_o, f)]
    return "\n".join(lines) + "\n"


def sky(bsdf):
    T = mi.ScalarTransform4f
    return mi.load_dict({
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 2},
        "sensor": {
            "type": "perspective",
            "fov": 26,
            "to_world": T().look_at([0, -5, 1], [0, 0, 0], [0, 0, 1]),
            "film": {"type": "hdrfilm", "width": 64, "height": 64, "rfilter": {"type": "box"}},
        },
        "sky": {"type": "envmap", "bitmap": mi.Bitmap(gradient())},
        "ball": {"type": "sphere", "bsdf": bsdf},
    })


def gradient():
    """A sky that is brighter on one side: what is drawn in the wrong place is noise."""
    u = (np.arange(64) + 0.5) / 64
    row = 0.2 + np.exp(-0.5 * ((u - 0.3) / 0.1) ** 2)
    return np.repeat(np.tile(row[None, :, None], (32, 1, 1)), 3, 2).astype(np.float32)


def figures(scene):
    """Mean of the picture's own part, its relative variance, samples a processor second."""
    film = scene.sensors()[0].film().size()
    dr.eval(mi.render(scene, spp=SAMPLES, seed=1000))
    dr.sync_thread()
    start, pictures = time.process_time(), []
    for k in range(RUNS):
        pictures.append(np.array(mi.render(scene, spp=SAMPLES, seed=k))[..., 1])
    seconds = time.process_time() - start
    pictures = np.array(pictures)
    inner = (slice(None), *(slice(int(n * 0.3), int(n * 0.7)) for n in pictures.shape[1:]))
    own = pictures[inner]
    return own.mean(), own.var(0, ddof=1).mean() / own.mean() ** 2, film[0] * film[1] * SAMPLES * RUNS / seconds / 1e6


def main(folder):
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    variant, why = bsdfkit.mitsuba.best_variant("rgb")
    if why:
        sys.exit(why)
    mi.set_variant(variant)
    fitted, tree, form = (folder / name for name in ("metal.safetensors", "metal.xml", "metal_render.safetensors"))
    if not form.exists():
        (folder / "metal.csv").write_text(table())
        run(BSDF, "fit", folder / "metal.csv", "--symmetry", "quadrilateral", "-o", fitted)
        run(BSDF, "convert", fitted, "--max-leaves", 300_000, "-o", tree)
        run(BSDF, "compile", fitted, "-o", form)
    print(f"mitsuba {mi.__version__}, {variant}, {RUNS} pictures of {SAMPLES} samples a pixel; all beside roughconductor's")
    for name, scene in (("sky", sky), ("lamp", lambda bsdf: mitsuba_speed.scene(bsdf, 96))):
        mean, variance, speed = figures(scene(ANALYTIC))
        for kind, path in (("tree", tree), ("render form", form)):
            own, noise, rate = figures(scene({"type": "bsdfkit", "filename": str(path)}))
            print(f"{name:5} {kind:11} variance {noise / variance:.3f}, mean {own / mean:.4f}, samples a second {rate / speed:.2f}", flush=True)


def run(*command):
    subprocess.run(list(map(str, command)), check=True)


if __name__ == "__main__":
    main(sys.argv[1])
