#!/usr/bin/env bash
# A back transmission of zeros darkens a material in Radiance: reversed for the shaped part of the light, not for the rest.
#
# Program:  Radiance (rtrace, dctimestep) in pyradiance 1.3.1.
# Expected: a file with "Transmission Front" alone is turned round for the other direction. A "Transmission Back" of zeros,
#           which stands in many files for "not given", is either taken at its word (black) or like one that is missing.
# Happens:  something between. The part that depends on direction is taken from the front block, turned round; the
#           Lambertian part (the matrix's minimum) from the block of zeros. A film that passes 65 % passes 29 % when seen
#           from the room, a purely diffuse one nothing at all, and dctimestep loses all of the latter, too. No message.
# Matters:  the window is too dark by just its haze, and looks plausible. Leave out blocks that hold nothing.
# Seen:     2026-11-30
#   pyradiance 1.3.1, numpy 2.4.6
#   haze with a shape, no back block:     rtrace 0.6500, dctimestep 0.4998
#   haze with a shape, back block zeros:  rtrace 0.2950, dctimestep 0.4998
#   diffuse, no back block:               rtrace 0.4998, dctimestep 0.4999
#   diffuse, back block zeros:            rtrace 0.0000, dctimestep 0.0000
#   (rtrace: white sky, seen from the room at the normal; dctimestep: the same, over the whole hemisphere)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check pyradiance==1.3.1 numpy==2.4.6
venv/bin/pip list --disable-pip-version-check | grep -iE '^(pyradiance|numpy) '
venv/bin/python - <<'END'
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pyradiance

# A LBNL XML file with Klems matrices: columns are incident patches, rows outgoing ones, values 1/sr.
FULL = [(0, 0, 5, 1), (10, 5, 15, 8), (20, 15, 25, 16), (30, 25, 35, 20), (40, 35, 45, 24),
        (50, 45, 55, 24), (60, 55, 65, 24), (70, 65, 75, 16), (82.5, 75, 90, 12)]  # centre, from, to, patches


def solid_angles(rings):
    """Projected solid angle of each patch."""
    return np.concatenate([np.full(k, np.pi * (np.sin(np.radians(b))**2 - np.sin(np.radians(a))**2) / k)
                           for _, a, b, k in rings])


def klems_xml(blocks, basis="LBNL/Klems Full", rings=FULL, structure="Columns", unit="meter", thickness=0.001):
    """The file's text; blocks are (band, direction, matrix)."""
    text = [f'''<?xml version="1.0" encoding="UTF-8"?>
<WindowElement xmlns="http://windows.lbl.gov">
<WindowElementType>System</WindowElementType>
<FileType>BSDF</FileType>
<Optical>
<Layer>
<Material>
<Name>film</Name>
<Manufacturer>nobody</Manufacturer>
<Thickness unit="{unit}">{thickness}</Thickness>
<DeviceType>Other</DeviceType>
<ThermalConductivity>0.2</ThermalConductivity>
<EmissivityFront>0.84</EmissivityFront>
<EmissivityBack>0.84</EmissivityBack>
<TIR>0</TIR>
</Material>
<DataDefinition>
<IncidentDataStructure>{structure}</IncidentDataStructure>
<AngleBasis>
<AngleBasisName>{basis}</AngleBasisName>''']
    for centre, low, high, count in rings:
        text.append(f'''<AngleBasisBlock>
<Theta>{centre}</Theta>
<nPhis>{count}</nPhis>
<ThetaBounds>
<LowerTheta>{low}</LowerTheta>
<UpperTheta>{high}</UpperTheta>
</ThetaBounds>
</AngleBasisBlock>''')
    text.append("</AngleBasis>\n</DataDefinition>")
    for band, direction, matrix in blocks:
        values = ",\n".join(", ".join(f"{v:.6g}" for v in row) for row in matrix)
        text.append(f'''<WavelengthData>
<LayerNumber>System</LayerNumber>
<Wavelength unit="Integral">{band}</Wavelength>
<SourceSpectrum>CIE Illuminant D65 1nm.ssp</SourceSpectrum>
<DetectorSpectrum>ASTM E308 1931 Y.dsp</DetectorSpectrum>
<WavelengthDataBlock>
<WavelengthDataDirection>{direction}</WavelengthDataDirection>
<ColumnAngleBasis>{basis}</ColumnAngleBasis>
<RowAngleBasis>{basis}</RowAngleBasis>
<ScatteringDataType>BTDF</ScatteringDataType>
<ScatteringData>
{values}
</ScatteringData>
</WavelengthDataBlock>
</WavelengthData>''')
    return "\n".join(text) + "\n</Layer>\n</Optical>\n</WindowElement>\n"

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


def write_matrix(name, rows):
    """A matrix of three equal channels as Radiance's programs read it."""
    rows = np.atleast_2d(rows)
    header = f"#?RADIANCE\nNCOMP=3\nNROWS={rows.shape[0]}\nNCOLS={rows.shape[1]}\nFORMAT=ascii\n\n"
    Path(name).write_text(header + "\n".join(" ".join(f"{v:.9g} {v:.9g} {v:.9g}" for v in row) for row in rows) + "\n")


write_matrix("view.mtx", solid_angles(FULL) / np.pi)  # all light that leaves into the room
write_matrix("daylight.mtx", np.ones((145, 1)))  # a white sky
write_matrix("sky.mtx", [[1]])


def show(label, front, zeros):
    blocks = [("Visible", "Transmission Front", front)]
    if zeros:
        blocks.append(("Visible", "Transmission Back", np.zeros((145, 145))))
    Path("film.xml").write_text(klems_xml(blocks))
    Path("scene.rad").write_text("""void glow sky 0 0 4 1 1 1 0
sky source behind 0 0 4 0 0 -1 180
void BSDF film 6 0 film.xml 0 1 0 . 0 0
film polygon window 0 0 12 -1 -1 0  1 -1 0  1 1 0  -1 1 0
""")
    Path("scene.oct").write_bytes(radiance("oconv", "scene.rad"))
    line = radiance("rtrace", "-h", "-ab", "1", "-ad", "2000", "-lw", "1e-6", "-st", "0", "scene.oct", text="0 0 1 0 0 -1\n")
    flux = radiance("dctimestep", "-h", "view.mtx", "film.xml", "daylight.mtx", "sky.mtx")
    found = float(line.split()[1]), float(flux.split()[1])
    print(f"{label + (', back block zeros:' if zeros else ', no back block:'):37} rtrace {found[0]:.4f}, "
          f"dctimestep {found[1]:.4f}")
    return found


angles = np.concatenate([np.full(k, c) for c, _, _, k in FULL])
shaped = np.tile(0.5 / np.pi * (1 + 0.3 * np.cos(np.radians(2 * angles)))[:, None], 145)
diffuse = np.full((145, 145), 0.5 / np.pi)
whole, halved = show("haze with a shape", shaped, False), show("haze with a shape", shaped, True)
all_light, none = show("diffuse", diffuse, False), show("diffuse", diffuse, True)
print("(rtrace: white sky, seen from the room at the normal; dctimestep: the same, over the whole hemisphere)")
still(abs(whole[0] - 0.65) < 0.01 and abs(all_light[0] - 0.5) < 0.01, "files without a back block")
still(0.25 < halved[0] < 0.35, "the shaped film beside zeros")
still(none == (0, 0), "the diffuse film beside zeros")
END
