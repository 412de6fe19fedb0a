#!/usr/bin/env bash
# wrapBSDF -W fills in thermal data that nobody gave, and WINDOW's engine then adds a fifth to the U-value.
#
# Program:  wrapBSDF in pyradiance 1.3.1, read by pywincalc 3.3.1 (LBNL's WINDOW engine).
# Expected: -W holds the file to WINDOW's rules: what it needs and was not given is asked for, as it is for the thickness.
# Happens:  conductivity 1, emissivities 0.9, infrared transmittance 0.1 and openness 0.05 are written without a word, and
#           nothing in the file tells them from measured ones. The infrared transmittance stays where both emissivities are
#           given: a layer of glass (0.84, 0.84, opaque to heat) lets 10 % of the heat through.
# Matters:  the U-value of a single layer goes from 5.27 to 6.23 W/m2K. frads 2.1.16 saves its glazing systems this way.
#           Give all of them: -f "c=..;ef=..;eb=..;tir=..;eo=..".
# Seen:     2026-11-30
#   pyradiance 1.3.1, pywincalc 3.3.1, numpy 2.4.6
#   given nothing:               conductivity 1, emissivity 0.9/0.9, TIR 0.1, openness 0.05, U 6.23
#   given the emissivities:      conductivity .2, emissivity .84/.84, TIR 0.1, openness 0.05, U 5.88
#   given all:                   conductivity .2, emissivity .84/.84, TIR 0, openness 0, U 5.27
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check pyradiance==1.3.1 pywincalc==3.3.1 numpy==2.4.6
venv/bin/pip list --disable-pip-version-check | grep -iE '^(pyradiance|pywincalc|numpy) '
venv/bin/python - <<'END'
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pyradiance
import pywincalc

HOME = Path(pyradiance.__file__).parent
ENV = dict(os.environ, RAYPATH=f".:{HOME / 'lib'}", PATH=f"{HOME / 'bin'}:{os.environ['PATH']}")


def radiance(*command, text=""):
    """Runs one of Radiance's programs; its output. Anything on standard error is printed."""
    done = subprocess.run(command, input=text.encode(), env=ENV, capture_output=True, check=True)
    sys.stdout.write(done.stderr.decode())
    return done.stdout


def still(condition, what):
    """Ends with an error where the program no longer does what is described above."""
    if not condition:
        sys.exit(f"changed: {what}")


def window(text, hemisphere=None):
    """The glazing system that LBNL's WINDOW engine makes of the file as its only layer."""
    layer = pywincalc.parse_bsdf_xml_string(text)
    if hemisphere is None:
        hemisphere = pywincalc.BSDFBasisType.FULL
    return pywincalc.GlazingSystem(
        solid_layers=[layer],
        bsdf_hemisphere=pywincalc.BSDFHemisphere.create(hemisphere),
        environment=pywincalc.nfrc_shgc_environments(),
    )


def visible(text, hemisphere=None, theta=0, phi=0):
    """Its direct-hemispherical visible transmittance from the front."""
    system = window(text, hemisphere).optical_method_results("PHOTOPIC", theta, phi).system_results
    return system.front.transmittance.direct_hemispherical


for name, value in (("t", 0.5), ("r", 0.2)):
    row = ", ".join([f"{value / np.pi:.6g}"] * 145)
    Path(f"{name}.txt").write_text(",\n".join([row] * 145))
BAND = ["-tf", "t.txt", "-tb", "t.txt", "-rf", "r.txt", "-rb", "r.txt"]


def wrap(label, fields):
    """The U-value of what wrapBSDF writes; prints its thermal data."""
    text = radiance("wrapBSDF", "-W", "-a", "kf", "-f", "n=film;m=nobody;t=0.001" + fields,
                    "-s", "Visible", *BAND, "-s", "Solar", *BAND).decode()
    c, ef, eb, tir, eo = (re.search(f"<{tag}>([^<]*)<", text).group(1) for tag in (
        "ThermalConductivity", "EmissivityFront", "EmissivityBack", "TIR", "EffectiveOpennessFraction"))
    u = window(text).u()
    print(f"{label:28} conductivity {c}, emissivity {ef}/{eb}, TIR {tir}, openness {eo}, U {u:.2f}")
    return float(tir), u


tir, u = wrap("given nothing:", "")
still(tir == 0.1 and 6.1 < u < 6.4, "what is filled in")
tir, u = wrap("given the emissivities:", ";c=.2;ef=.84;eb=.84")
still(tir == 0.1 and 5.8 < u < 6.0, "what is filled in beside the emissivities")
tir, u = wrap("given all:", ";c=.2;ef=.84;eb=.84;tir=0;eo=0")
still(tir == 0 and 5.2 < u < 5.4, "all given")
END
