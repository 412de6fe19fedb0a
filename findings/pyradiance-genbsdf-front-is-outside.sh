#!/usr/bin/env bash
# pyradiance.generate_bsdf: what its documentation calls the room side is the exterior.
#
# Program:  pyradiance.generate_bsdf 1.3.1.
# Expected: BSDFDataBytes documents "front: data sampled from the front (room-side)", with the room at positive z.
# Happens:  .front is sampled from negative z, the exterior, and .back from the room: WINDOW's meaning of the words, not the
#           documented one. generate_xml then sorts them rightly.
#           Besides, the numbers are flux fractions (a column sums to the reflectance), not BSDF in 1/sr.
# Matters:  whoever takes the matrices themselves, by the documentation, swaps the two sides of a shade.
# Seen:     2026-11-30
#   pyradiance 1.3.1, numpy 2.4.6
#   room side reflects 0.80, exterior 0.20
#   .front.reflectance, normal incidence: 0.200
#   .back.reflectance, normal incidence:  0.800
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check pyradiance==1.3.1 numpy==2.4.6
venv/bin/pip list --disable-pip-version-check | grep -iE '^(pyradiance|numpy) '
venv/bin/python - <<'END'
import sys

import numpy as np
import pyradiance


def still(condition, what):
    """Ends with an error where the program no longer does what is described above."""
    if not condition:
        sys.exit(f"changed: {what}")


# A slab: the face at z = 0 looks into the room, the one at z = -0.01 outside.
slab = b"""void plastic light 0 0 5 .8 .8 .8 0 0
void plastic dark 0 0 5 .2 .2 .2 0 0
light polygon roomside 0 0 12 0 0 0  1 0 0  1 1 0  0 1 0
dark polygon exterior 0 0 12 0 0 -.01  0 1 -.01  1 1 -.01  1 0 -.01
"""
box = pyradiance.genbsdf.SamplingBox(0.4, 0.6, 0.4, 0.6, -0.01, 0)
result = pyradiance.generate_bsdf(slab, dim=box, nsamp=400, params=["-ad", "50"])


def total(matrix):
    """Sum of the first column: normal incidence."""
    return sum(float(line.split()[0]) for line in matrix.decode().splitlines() if line.strip())


front, back = total(result.front.reflectance), total(result.back.reflectance)
print("room side reflects 0.80, exterior 0.20")
print(f".front.reflectance, normal incidence: {front:.3f}")
print(f".back.reflectance, normal incidence:  {back:.3f}")
still("room-side" in pyradiance.genbsdf.BSDFDataBytes.__doc__.split("back:")[0], "the documentation says otherwise")
still(abs(front - 0.2) < 0.02 and abs(back - 0.8) < 0.02, "front is the room side")
END
