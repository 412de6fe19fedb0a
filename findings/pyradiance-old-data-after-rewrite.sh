#!/usr/bin/env bash
# pyradiance.bsdf.load_file answers from memory after the file was rewritten, even relative to another folder.
#
# Program:  pyradiance.bsdf 1.3.1.
# Expected: load_file reads the file that is there.
# Happens:  while an object of the same path string lives, load_file hands out the old data: after the file was rewritten,
#           and after a change of folder, where the same relative path is another file. No message.
# Matters:  a loop that fits, writes film.xml and checks it compares every result with the first one; a test that runs each
#           case in a folder of its own reads the first case's file. Use a fresh process for each file, or a fresh name.
# Seen:     2026-11-30
#   pyradiance 1.3.1, numpy 2.4.6
#   first file, 30 %: 0.2999
#   rewritten, 60 %:  0.2999
#   other folder, 80 %, same relative path: 0.2999
#   same file by another path: 0.7999
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check pyradiance==1.3.1 numpy==2.4.6
venv/bin/pip list --disable-pip-version-check | grep -iE '^(pyradiance|numpy) '
venv/bin/python - <<'END'
import os
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


def write(transmittance):
    Path("film.xml").write_text(klems_xml([("Visible", f"Transmission {side}", np.full((145, 145), transmittance / np.pi))
                                           for side in ("Front", "Back")]))


alive = []


def total(path):
    alive.append(b.load_file(path))
    return b.direct_hemi(alive[-1], 0, 0, b.SAMPLE_ALL)


write(0.3)
first = total("film.xml")
write(0.6)
rewritten = total("film.xml")
os.mkdir("other")
os.chdir("other")
write(0.8)
elsewhere = total("film.xml")
fresh = total(str(Path("film.xml").resolve()))
print(f"first file, 30 %: {first:.4f}")
print(f"rewritten, 60 %:  {rewritten:.4f}")
print(f"other folder, 80 %, same relative path: {elsewhere:.4f}")
print(f"same file by another path: {fresh:.4f}")
still(abs(first - 0.3) < 1e-3, "the first file is not 30 %")
still(rewritten == first and elsewhere == first, "the file is read again")
still(abs(fresh - 0.8) < 1e-3, "another path does not help")
END
