#!/usr/bin/env bash
# WINDOW's engine multiplies a Klems Full matrix by another basis's solid angles when told so, and loses half the light.
#
# Program:  pywincalc 3.3.1 (LBNL's WINDOW engine).
# Expected: GlazingSystem's bsdf_hemisphere agrees with the file or is refused.
# Happens:  a file of 145 patches with BSDFBasisType.HALF (77 patches) or QUARTER (41) is calculated without a message:
#           the first 77 or 41 patches stand for all.
# Matters:  HALF and QUARTER look like a matter of speed, as in WINDOW's own settings; transmittance falls from 0.60 to 0.32
#           and 0.17, solar heat gain with it. The energy that is lost appears nowhere.
# Seen:     2026-11-30
#   pywincalc 3.3.1, numpy 2.4.6
#   FULL     transmittance 0.6000
#   HALF     transmittance 0.3201
#   QUARTER  transmittance 0.1674
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check pywincalc==3.3.1 numpy==2.4.6
venv/bin/pip list --disable-pip-version-check | grep -iE '^(pywincalc|numpy) '
venv/bin/python - <<'END'
import sys

import numpy as np
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


film = klems_xml([(band, f"{kind} {side}", np.full((145, 145), value / np.pi)) for band in ("Visible", "Solar")
                  for kind, value in (("Transmission", 0.6), ("Reflection", 0.2)) for side in ("Front", "Back")])
found = {}
for name in ("FULL", "HALF", "QUARTER"):
    found[name] = visible(film, getattr(pywincalc.BSDFBasisType, name))
    print(f"{name:8} transmittance {found[name]:.4f}")
still(abs(found["FULL"] - 0.6) < 1e-4, "the film does not transmit 0.6")
still(0.3 < found["HALF"] < 0.35 and 0.15 < found["QUARTER"] < 0.2, "a hemisphere that does not fit is noticed")
END
