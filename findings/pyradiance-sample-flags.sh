#!/usr/bin/env bash
# pyradiance.bsdf answers 0 for SAMPLE_T and SAMPLE_R, the flags named after what one wants.
#
# Program:  pyradiance.bsdf 1.3.1.
# Expected: direct_hemi(data, theta, phi, SAMPLE_T) is the total transmittance, with SAMPLE_R the total reflectance.
# Happens:  both are 0.0, and sample() gives rows of zeros. The flags are bits: SAMPLE_T means "transmitted" without saying
#           whether the diffuse or the sharp part of it, and nothing is both. SAMPLE_T + SAMPLE_DF + SAMPLE_SP is right.
# Matters:  a script that adds up or compares totals takes the zeros for an opaque or a black material; nothing is raised.
# Seen:     2026-11-30
#   pyradiance 1.3.1, numpy 2.4.6
#   the file: transmittance 0.6000, reflectance 0.2000
#   SAMPLE_ALL 0.8000  SAMPLE_T 0.0000  SAMPLE_R 0.0000  T+DF+SP 0.6000  R+DF+SP 0.2000
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check pyradiance==1.3.1 numpy==2.4.6
venv/bin/pip list --disable-pip-version-check | grep -iE '^(pyradiance|numpy) '
venv/bin/python - <<'END'
import sys
from pathlib import Path

import numpy as np
import pyradiance.bsdf as b

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


through = np.diag(0.5 / solid_angles(FULL)) + 0.1 / np.pi
back = np.diag(0.1 / solid_angles(FULL)) + 0.1 / np.pi
Path("film.xml").write_text(klems_xml([("Visible", f"{kind} {side}", m) for kind, m in
                                       (("Transmission", through), ("Reflection", back)) for side in ("Front", "Back")]))
data = b.load_file("film.xml")
both = b.SAMPLE_DF | b.SAMPLE_SP
flags = {"SAMPLE_ALL": b.SAMPLE_ALL, "SAMPLE_T": b.SAMPLE_T, "SAMPLE_R": b.SAMPLE_R,
         "T+DF+SP": b.SAMPLE_T | both, "R+DF+SP": b.SAMPLE_R | both}
found = {name: b.direct_hemi(data, 0, 0, flag) for name, flag in flags.items()}
print("the file: transmittance 0.6000, reflectance 0.2000")
print("  ".join(f"{name} {value:.4f}" for name, value in found.items()))
still(found["SAMPLE_T"] == 0 and found["SAMPLE_R"] == 0, "the flags answer")
still(not np.any(b.sample(data, 0, 0, 4, b.SAMPLE_T)), "sample() answers")
still(abs(found["T+DF+SP"] - 0.6) < 1e-3 and abs(found["R+DF+SP"] - 0.2) < 1e-3, "the sums are wrong")
END
