#!/usr/bin/env bash
# A file that gives Radiance colour is refused by WINDOW's engine, and the other way about.
#
# Program:  pywincalc 3.3.1 (LBNL's WINDOW engine), Radiance in pyradiance 1.3.1.
# Expected: bands that a program has no use for are passed over. Radiance reads colour from the bands CIE-X and CIE-Z
#           beside Visible; WINDOW needs Visible and Solar.
# Happens:  one block of any other band (CIE-X, CIE-Z, NIR) and the engine refuses the whole file, "Unsupported
#           wavelength range", without saying which. Without Solar it says that only "LBNL/Klems Full" is supported,
#           of a file that is LBNL/Klems Full.
# Matters:  no Klems file serves both programs in colour, and the second message sends its reader to the wrong element.
# Seen:     2026-11-30
#   pyradiance 1.3.1, pywincalc 3.3.1, numpy 2.4.6
#   Visible, Solar:               Radiance 0.500 0.500 0.500; WINDOW's engine 0.5000
#   and CIE-X, CIE-Z:             Radiance 1.176 0.278 0.034; WINDOW's engine: XML error: Unsupported wavelength range
#   and NIR:                      Radiance 0.500 0.500 0.500; WINDOW's engine: XML error: Unsupported wavelength range
#   Visible alone:                Radiance 0.500 0.500 0.500; WINDOW's engine: Only "LBNL/Klems Full" is currently
#                                 supported for a BSDF angle basis.
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


def film(*extra, solar=True):
    """Half transparent, a fifth reflected, in Visible and Solar; further bands by (name, transmittance)."""
    bands = [("Visible", 0.5)] + [("Solar", 0.5)] * solar + list(extra)
    return klems_xml([(band, f"{kind} {side}", np.full((145, 145), value / np.pi)) for band, transmittance in bands
                      for kind, value in (("Transmission", transmittance), ("Reflection", 0.2))
                      for side in ("Front", "Back")])


def rendered(text):
    """Colour of a white sky seen through the material at normal incidence."""
    Path("film.xml").write_text(text)
    Path("scene.rad").write_text("""void glow sky 0 0 4 1 1 1 0
sky source behind 0 0 4 0 0 -1 180
void BSDF film 6 0 film.xml 0 1 0 . 0 0
film polygon window 0 0 12 -1 -1 0  1 -1 0  1 1 0  -1 1 0
""")
    Path("scene.oct").write_bytes(radiance("oconv", "scene.rad"))
    line = radiance("rtrace", "-h", "-ab", "1", "-ad", "2000", "-lw", "1e-6", "scene.oct", text="0 0 1 0 0 -1\n")
    return [float(word) for word in line.split()]


def show(label, text):
    colour = rendered(text)
    try:
        answer = f" {visible(text):.4f}"
    except RuntimeError as error:
        answer = f": {error}"
    print(f"{label:29} Radiance {' '.join(f'{c:.3f}' for c in colour)}; WINDOW's engine{answer}")
    return colour, answer


colour = [("CIE-X", 0.7), ("CIE-Z", 0.1)]
grey, answer = show("Visible, Solar:", film())
still(max(grey) - min(grey) < 1e-3 and answer == " 0.5000", "the plain file")
red, answer = show("and CIE-X, CIE-Z:", film(*colour))
still(red[0] > 2 * red[1] and "Unsupported wavelength range" in answer, "colour bands")
_, answer = show("and NIR:", film(("NIR", 0.5)))
still("Unsupported wavelength range" in answer, "NIR")
_, answer = show("Visible alone:", film(solar=False))
still("LBNL/Klems Full" in answer, "the message of a file without Solar")
END
