#!/usr/bin/env bash
# A line break inside <Wavelength> makes a material black in Radiance; WINDOW's engine reads the same file well.
#
# Program:  Radiance (oconv, rtrace, checkBSDF) in pyradiance 1.3.1; pywincalc 3.3.1 beside it.
# Expected: white space round an element's text means nothing, as after any tool that indents XML; or an error.
# Happens:  Radiance does not know the band "\n Visible\n", skips all blocks, and loads a material without any
#           component: no light comes through, exit status 0, no message. WINDOW's engine gives the right total.
#           Blanks inside <WavelengthDataDirection>, and "CIE-Y" for "Visible", end the same way.
# Matters:  pretty-printing a file, or writing it with an XML library that indents, blackens a window without a word.
# Seen:     2026-11-30
#   pyradiance 1.3.1, pywincalc 3.3.1, numpy 2.4.6
#   as WINDOW writes it      Radiance 0.4998  WINDOW's engine 0.5000
#   line breaks in the band  Radiance 0.0000  WINDOW's engine 0.5000
#   line breaks in direction Radiance 0.0000
#   band CIE-Y               Radiance 0.0000
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check pyradiance==1.3.1 pywincalc==3.3.1 numpy==2.4.6
venv/bin/pip list --disable-pip-version-check | grep -iE '^(pyradiance|pywincalc|numpy) '
venv/bin/python - <<'END'
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pyradiance
import pywincalc

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


def rendered(text):
    """Radiance of a white sky seen through the material at normal incidence."""
    Path("film.xml").write_text(text)
    Path("scene.rad").write_text("""void glow sky 0 0 4 1 1 1 0
sky source behind 0 0 4 0 0 -1 180
void BSDF film 6 0 film.xml 0 1 0 . 0 0
film polygon window 0 0 12 -1 -1 0  1 -1 0  1 1 0  -1 1 0
""")
    Path("scene.oct").write_bytes(radiance("oconv", "scene.rad"))
    radiance("checkBSDF", "film.xml")  # exit status 0, too
    line = radiance("rtrace", "-h", "-ab", "1", "-ad", "2000", "-lw", "1e-6", "scene.oct", text="0 0 1 0 0 -1\n")
    return float(line.split()[1])


half = np.full((145, 145), 0.5 / np.pi)
fifth = np.full((145, 145), 0.2 / np.pi)
plain = klems_xml([(band, f"{kind} {side}", m) for band in ("Visible", "Solar")
                   for kind, m in (("Transmission", half), ("Reflection", fifth)) for side in ("Front", "Back")])
indented = plain.replace(">Visible<", ">\n Visible\n<")
directions = plain.replace(">Transmission Front<", ">\nTransmission Front\n<")
directions = directions.replace(">Transmission Back<", ">\nTransmission Back\n<")
results = [rendered(plain), rendered(indented), rendered(directions), rendered(plain.replace(">Visible<", ">CIE-Y<"))]
engine = [visible(plain), visible(indented)]
print(f"as WINDOW writes it      Radiance {results[0]:.4f}  WINDOW's engine {engine[0]:.4f}")
print(f"line breaks in the band  Radiance {results[1]:.4f}  WINDOW's engine {engine[1]:.4f}")
print(f"line breaks in direction Radiance {results[2]:.4f}")
print(f"band CIE-Y               Radiance {results[3]:.4f}")
still(abs(results[0] - 0.5) < 0.01, "the plain file is not half transparent")
still(results[1:] == [0, 0, 0], "the other spellings are read")
still(abs(engine[1] - 0.5) < 1e-4, "WINDOW's engine does not read the line breaks")
END
