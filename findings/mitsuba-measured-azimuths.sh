#!/usr/bin/env bash
# Mitsuba's measured BSDF forgets its anisotropy when azimuths run from 0 instead of from -180 degrees.
#
# Program:  mitsuba 3.9.1 (drjit 1.5.0), plugin "measured", RGL's tensor files (.bsdf).
# Expected: phi_i holds the azimuths that were measured, 0 to 360 or 0 to 180 degrees as goniophotometers give them; the
#           value at any azimuth comes from the two nearest, or the file is refused.
# Happens:  azimuths are looked up between -180 and 180 degrees, and what lies outside the table is held at its end, without
#           a message: with 0..360 half of all azimuths show one value, with 0..180 all but the far half of them.
#           -180..180 and -180..0 (taken for half-turn symmetry) are right.
# Matters:  brushed metal or cloth exported from 0..360 renders without error, isotropic on one side. The mean may even
#           look plausible.
# Seen:     2026-11-30
#   mitsuba 3.9.1, drjit 1.5.0, numpy 2.4.6
#   the table, 0.2 (1 + 0.8 cos 2 phi)  0.360 0.200 0.040 0.200 0.360 0.200 0.040 0.200
#   file with phi_i from -180 to 180    0.360 0.200 0.040 0.200 0.360 0.200 0.040 0.200
#   file with phi_i from -180 to   0    0.360 0.200 0.040 0.200 0.360 0.200 0.040 0.200
#   file with phi_i from    0 to 360    0.360 0.200 0.040 0.200 0.360 0.360 0.360 0.360
#   file with phi_i from    0 to 180    0.360 0.360 0.360 0.360 0.360 0.360 0.360 0.360
#   (incident azimuths 0, 45 .. 315 degrees)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check mitsuba==3.9.1 drjit==1.5.0 numpy==2.4.6
venv/bin/pip list --disable-pip-version-check | grep -iE '^(mitsuba|drjit|numpy) '
venv/bin/python - <<'END'
import sys

import drjit as dr
import mitsuba as mi
import numpy as np


def still(condition, what):
    """Ends with an error where the program no longer does what is described above."""
    if not condition:
        sys.exit(f"changed: {what}")


mi.set_variant("scalar_rgb")


def table(phi):
    return 0.2 * (1 + 0.8 * np.cos(2 * np.radians(phi)))


def write(low, high):
    """A tensor file whose values depend on the incident azimuth only; nothing but phi_i differs between files."""
    phi = np.arange(low, high + 1, 22.5)
    theta = np.linspace(0, 89, 8)
    rgb = np.broadcast_to(table(phi)[:, None, None, None, None], (len(phi), len(theta), 3, 16, 16))
    flat = np.ones((len(phi), len(theta), 16, 16))
    fields = dict(theta_i=np.radians(theta), phi_i=np.radians(phi), ndf=np.full((2, 2), 4), sigma=np.ones((2, 2)),
                  vndf=flat, luminance=flat, rgb=rgb)
    fields = {name: np.ascontiguousarray(value, np.float32) for name, value in fields.items()}
    fields |= dict(jacobian=np.ones(1, np.uint8), description=np.frombuffer(b"synthetic", np.uint8))
    mi.tensor_io.write("film.bsdf", **fields)


def values():
    """What the plugin finds at eight incident azimuths; its tables hold the cosine, too."""
    bsdf = mi.load_dict({"type": "measured", "filename": "film.bsdf"})
    found = []
    for phi in np.radians(np.arange(0, 360, 45)):
        si = dr.zeros(mi.SurfaceInteraction3f)
        si.sh_frame = mi.Frame3f(mi.Vector3f(0, 0, 1))
        si.n = mi.Normal3f(0, 0, 1)
        si.wi = mi.Vector3f(np.sin(0.7) * np.cos(phi), np.sin(0.7) * np.sin(phi), np.cos(0.7))
        wo = mi.Vector3f(np.sin(0.5) * np.cos(phi + 2), np.sin(0.5) * np.sin(phi + 2), np.cos(0.5))
        found.append(float(bsdf.eval(mi.BSDFContext(), si, wo)[0]))
    return np.array(found)


def show(label, numbers):
    print(f"{label:35} " + " ".join(f"{n:.3f}" for n in numbers))
    return numbers


truth = show("the table, 0.2 (1 + 0.8 cos 2 phi)", table(np.arange(0, 360, 45)))
found = {}
for low, high in ((-180, 180), (-180, 0), (0, 360), (0, 180)):
    write(low, high)
    found[low, high] = show(f"file with phi_i from {low:4} to {high:3}", values())
print("(incident azimuths 0, 45 .. 315 degrees)")
still(np.allclose(found[-180, 180], truth, atol=2e-3), "-180..180 is wrong")
still(np.allclose(found[-180, 0], truth, atol=2e-3), "-180..0 is wrong")
still(np.allclose(found[0, 360][5:], truth[0], atol=2e-3), "0..360 keeps its anisotropy")
still(np.ptp(found[0, 180]) < 2e-3, "0..180 keeps its anisotropy")
END
