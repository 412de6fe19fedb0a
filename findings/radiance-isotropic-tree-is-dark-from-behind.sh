#!/usr/bin/env bash
# Radiance traces no light through an isotropic tensor tree of one transmission when it is seen from the other side.
#
# Program:  Radiance "6.0a" in pyradiance 1.3.1: rtrace, oconv, checkBSDF.
# Expected: a file that holds transmission from one side alone answers for the other side, too, as matrices and anisotropic
#           trees do: by reciprocity both sides have the same transmittance here.
# Happens:  in a sky of radiance 1 a pane shows its transmittance from one side and black from the other, without a message. The sun, whose light is looked up and not sampled, comes through from both sides. With TensorTree4
#           instead of TensorTree3, same values, both sides are right.
# Matters:  a diffuser measured from one side and stored as an isotropic tree (the usual form for it) lights a room with the
#           sun and not with the sky, unless the pane is turned.
# Seen:     2026-11-30
#   pyradiance 1.3.1
#                 sky from the front   from behind    sun from the front   from behind
#   TensorTree3               0.471        0.000                 0.265         0.264
#   TensorTree4               0.471        0.471                 0.265         0.265
#   (transmittance 0.15 pi = 0.471)
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


def still(condition, what):
    """Ends with an error where the program no longer does what is described above."""
    if not condition:
        sys.exit(f"changed: {what}")


def run(*command, stdin=""):
    done = subprocess.run(command, env=environment, input=stdin.encode(), capture_output=True, timeout=300)
    if done.returncode:
        sys.exit(f"changed: {command[0]}: {done.stderr.decode()}")
    return done.stdout


def write(rank):
    """f = 0.3 1/sr where light goes on in the half that it came along, 0 in the other: the same from both sides."""
    if rank == 3:
        # Dimensions: incident, scattered along the light's travel, scattered across it.
        values = [0.3 if k >> 1 & 1 else 0.0 for k in range(8)]
    else:
        # Dimensions: x and y of the incident light's travel, x and y of the scattered.
        values = [0.3 if (k & 1) == (k >> 2 & 1) else 0.0 for k in range(16)]
    Path(f"tree{rank}.xml").write_text(f"""<?xml version="1.0" encoding="UTF-8"?>
<WindowElement xmlns="http://windows.lbl.gov">
<WindowElementType>System</WindowElementType>
<FileType>BSDF</FileType>
<Optical>
<Layer>
<Material><Name>half</Name><Manufacturer>none</Manufacturer></Material>
<DataDefinition><IncidentDataStructure>TensorTree{rank}</IncidentDataStructure></DataDefinition>
<WavelengthData><LayerNumber>System</LayerNumber><Wavelength unit="Integral">Visible</Wavelength>
<WavelengthDataBlock><WavelengthDataDirection>Transmission Back</WavelengthDataDirection>
<AngleBasis>LBNL/Shirley-Chiu</AngleBasis>
<ScatteringDataType>BTDF</ScatteringDataType>
<ScatteringData>
{{ {" ".join(f"{{ {v} }}" for v in values)} }}
</ScatteringData>
</WavelengthDataBlock></WavelengthData>
</Layer>
</Optical>
</WindowElement>
""")


PANE = "void BSDF half\n6 0 {name}.xml 0 1 0 .\n0\n0\nhalf polygon pane\n0\n0\n12 -9 -9 0 9 -9 0 9 9 0 -9 9 0\n"
SKY = "void glow sky\n0\n0\n4 1 1 1 0\nsky source dome\n0\n0\n4 0 0 1 360\n"
# A sun of half a degree on each side, in the plane of view, whose irradiance on the pane is 1.
SUN = "void light sun\n0\n0\n3 {b} {b} {b}\nsun source front\n0\n0\n4 {x} 0 {z} .533\nsun source back\n0\n0\n4 {x} 0 -{z} .533\n"


def seen(name, light, front):
    """Mean radiance of the pane, seen 20 degrees off its normal from the front (+Z) or from behind."""
    Path("scene.rad").write_text(light + PANE.format(name=name))
    Path("scene.oct").write_bytes(run("oconv", "scene.rad"))
    z = 1 if front else -1
    tilt = math.tan(math.radians(20))
    ray = f"{tilt} 0 {z} {-tilt} 0 {-z}\n"
    text = run("rtrace", "-h", "-ov", "-ab", "1", "-ad", "1024", "-lr", "4", "-st", "0", "-ss", "16", "-dj", "0",
               "scene.oct", stdin=ray * 200).decode()
    values = [float(row.split()[1]) for row in text.splitlines()]
    return sum(values) / len(values)


omega = 2 * math.pi * (1 - math.cos(math.radians(0.533 / 2)))
x, z = -math.sin(math.radians(30)), math.cos(math.radians(30))
sun = SUN.format(b=1 / (omega * z), x=x, z=z)
print("                sky from the front   from behind    sun from the front   from behind")
found = {}
for rank in (3, 4):
    write(rank)
    row = [seen(f"tree{rank}", light, front) for light in (SKY, sun) for front in (True, False)]
    found[rank] = row
    print(f"  TensorTree{rank}   {row[0]:17.3f}  {row[1]:11.3f}  {row[2]:20.3f}  {row[3]:12.3f}")
total = 0.15 * math.pi
print(f"  (transmittance 0.15 pi = {total:.3f})")
lit, dark = max(found[3][:2]), min(found[3][:2])
still(abs(lit - total) < 0.03, "one side of an isotropic tree no longer shows its transmittance")
still(dark < 1e-3, "the other side is no longer black")
still(all(abs(v - total) < 0.05 for v in found[4][:2]), "an anisotropic tree does not show its transmittance on both sides")
suns = found[3][2:] + found[4][2:]
still(min(suns) > 0.2 and max(suns) < 1.02 * min(suns), "the sun does not come through alike from both sides")
END
