#!/usr/bin/env bash
# Mitsuba's measured BSDF renders negative light from RGL files in RGB whose colours lie outside of sRGB's gamut.
#
# Program:  mitsuba 3.9.1 (drjit 1.5.0), plugin "measured" in an RGB variant, RGL's tensor files (.bsdf).
# Expected: a saturated colour comes out as the nearest one that there is, or the file is refused, or something is said.
# Happens:  linear R, G or B below 0 is handed on as it stands. A constant environment of radiance 1 then sees the surface
#           with a negative channel; the reflectance that sampling finds is negative, too.
# Matters:  RGL publishes its materials in RGB with such entries (of two saturated vinyl films 3 and 21 % of the numbers, down
#           to -0.6). Negative pixels survive tone mapping as black or as noise, and denoisers and error measures that take
#           logarithms fail on them. As CIE XYZ the same entries are colours like any other.
# Seen:     2026-11-30
#   mitsuba 3.9.1, drjit 1.5.0, numpy 2.4.6
#   table, f cos of a mint beyond sRGB   -0.020  0.080  0.060
#   its CIE XYZ, white 1                  0.033  0.057  0.061
#   eval                                 -0.020  0.080  0.060
#   mean weight of 4096 samples          -0.126  0.504  0.378
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check mitsuba==3.9.1 drjit==1.5.0 numpy==2.4.6
venv/bin/pip list --disable-pip-version-check | grep -iE '^(mitsuba|drjit|numpy) '
venv/bin/python - <<'END'
import sys

import mitsuba as mi
import numpy as np


def still(condition, what):
    """Ends with an error where the program no longer does what is described above."""
    if not condition:
        sys.exit(f"changed: {what}")


def show(label, numbers):
    print(f"{label:36} " + " ".join(f"{n:6.3f}" for n in numbers))
    return np.array(numbers)


mi.set_variant("scalar_rgb")
mint = show("table, f cos of a mint beyond sRGB", [-0.02, 0.08, 0.06])
to_xyz = np.array([[0.4125, 0.3576, 0.1804], [0.2127, 0.7152, 0.0722], [0.0193, 0.1192, 0.9502]])
xyz = show("its CIE XYZ, white 1", to_xyz @ mint / to_xyz.sum(axis=1))
still((xyz > 0).all(), "the colour of this script is none")

theta = np.linspace(0, 1.5, 8)
flat = np.ones((1, 8, 16, 16))
rgb = np.broadcast_to(mint[None, None, :, None, None], (1, 8, 3, 16, 16))
fields = dict(theta_i=theta, phi_i=np.zeros(1), ndf=np.full((2, 2), 4), sigma=np.ones((2, 2)), vndf=flat, luminance=flat, rgb=rgb)
fields = {name: np.ascontiguousarray(value, np.float32) for name, value in fields.items()}
fields |= dict(jacobian=np.ones(1, np.uint8), description=np.frombuffer(b"synthetic", np.uint8))
mi.tensor_io.write("mint.bsdf", **fields)

bsdf = mi.load_dict({"type": "measured", "filename": "mint.bsdf"})
si = mi.SurfaceInteraction3f()
si.sh_frame = mi.Frame3f(mi.Vector3f(0, 0, 1))
si.n = mi.Normal3f(0, 0, 1)
si.wi = mi.Vector3f(np.sin(0.7), 0, np.cos(0.7))
found = show("eval", bsdf.eval(mi.BSDFContext(), si, mi.Vector3f(-np.sin(0.5), 0, np.cos(0.5))))
random = np.random.default_rng(1).random((4096, 3))
weights = [bsdf.sample(mi.BSDFContext(), si, u[0], mi.Point2f(u[1], u[2]))[1] for u in random.tolist()]
mean = show("mean weight of 4096 samples", np.mean(weights, axis=0))
still(np.allclose(found, mint, atol=1e-5), "eval does not hand the table on as it is")
still(mean[0] < -0.1, "sampled light is not negative")
END
