#!/usr/bin/env bash
# Through an isotropic tensor tree `aBSDF` passes half of a straight peak at exactly normal incidence, from one side.
#
# Program:  Radiance "6.0a" in pyradiance 1.3.1: rtrace, oconv.
# Expected: a pane that lets 0.8 of the light straight through shows 0.8 of the sun behind it, from either side and at every
#           angle: a peak in the plane of incidence lies on the border of two cells, mirror images with equal values.
# Happens:  of light at exactly normal incidence one side shows the half: there one of the two cells alone is looked up, as all
#           incident directions near the normal are turned onto the same scattered direction. The other side, and other
#           angles, are right; nothing is said.
# Matters:  views straight through a window, and sensors that face the sun, have half of its light. Who writes trees may put
#           the peak of the innermost ring of incidences into the one cell above the middle of the square.
# Seen:     2026-11-30
#   pyradiance 1.3.1
#   angle   sun in front   sun behind
#       0          0.400        0.800
#       3          0.800        0.800
#      20          0.800        0.800
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check pyradiance==1.3.1
venv/bin/pip list --disable-pip-version-check | grep -iE '^pyradiance '
venv/bin/python - <<'END'
import math
import os
import subprocess
import sys
from pathlib import Path

import pyradiance

home = Path(pyradiance.__file__).parent
environment = dict(os.environ, RAYPATH=f".:{home / 'lib'}", PATH=f"{home / 'bin'}:{os.environ['PATH']}")
THROUGH, CELLS = 0.8, 64


def still(condition, what):
    """Ends with an error where the program no longer does what is described above."""
    if not condition:
        sys.exit(f"changed: {what}")


def run(*command, stdin=""):
    done = subprocess.run(command, env=environment, input=stdin.encode(), capture_output=True, timeout=300)
    if done.returncode:
        sys.exit(f"changed: {command[0]}: {done.stderr.decode()}")
    return done.stdout


def write():
    """Straight transmission, on a grid: incident ring, scattered along the light's travel, scattered across it."""
    values = [0.01] * CELLS**3
    size = math.pi / CELLS**2
    for ring in range(CELLS // 2):
        # Ring 0 is at grazing, the last at the normal; straight on means as far from the middle on the other side.
        for across in (CELLS // 2 - 1, CELLS // 2):
            values[(ring * CELLS + CELLS - 1 - ring) * CELLS + across] = THROUGH / 2 / size
    Path("peak.xml").write_text(f"""<?xml version="1.0" encoding="UTF-8"?>
<WindowElement xmlns="http://windows.lbl.gov">
<WindowElementType>System</WindowElementType>
<FileType>BSDF</FileType>
<Optical>
<Layer>
<Material><Name>peak</Name><Manufacturer>none</Manufacturer></Material>
<DataDefinition><IncidentDataStructure>TensorTree3</IncidentDataStructure></DataDefinition>
<WavelengthData><LayerNumber>System</LayerNumber><Wavelength unit="Integral">Visible</Wavelength>
<WavelengthDataBlock><WavelengthDataDirection>Transmission Back</WavelengthDataDirection>
<AngleBasis>LBNL/Shirley-Chiu</AngleBasis>
<ScatteringDataType>BTDF</ScatteringDataType>
<ScatteringData>
{{ {" ".join(f"{v:.6g}" for v in values)} }}
</ScatteringData>
</WavelengthDataBlock></WavelengthData>
</Layer>
</Optical>
</WindowElement>
""")


PANE = "void aBSDF peak\n5 peak.xml 0 1 0 .\n0\n0\npeak polygon pane\n0\n0\n12 -99 -99 0 99 -99 0 99 99 0 -99 99 0\n"
SUN = "void light sun\n0\n0\n3 1e3 1e3 1e3\nsun source disk\n0\n0\n4 {} 0 {} .533\n"


def seen(theta, side):
    """Share of the sun's radiance that a ray toward it finds behind the pane; side 1: the eye is behind, the sun in front."""
    x, z = math.sin(math.radians(theta)), side * math.cos(math.radians(theta))
    Path("scene.rad").write_text(SUN.format(x, z) + PANE)
    Path("scene.oct").write_bytes(run("oconv", "scene.rad"))
    text = run("rtrace", "-h", "-ab", "0", "scene.oct", stdin=f"0 0 {-side} {x} 0 {z}\n")
    return float(text.split()[1]) / 1e3


write()
print("  angle   sun in front   sun behind")
found = {theta: [seen(theta, side) for side in (1, -1)] for theta in (0, 3, 20)}
for theta, (front, behind) in found.items():
    print(f"  {theta:5}   {front:12.3f}   {behind:10.3f}")
low, high = sorted(found[0])
still(abs(low / THROUGH - 0.5) < 0.05, "no side shows the half at the normal")
still(abs(high / THROUGH - 1) < 0.05, "the other side does not show all of it")
still(all(abs(v / THROUGH - 1) < 0.05 for t in (3, 20) for v in found[t]), "other angles do not show all of it")
END
