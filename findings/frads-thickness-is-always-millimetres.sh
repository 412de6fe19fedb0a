#!/usr/bin/env bash
# frads takes a layer's thickness as millimetres whatever unit its file states.
#
# Program:  frads 2.1.16 (with pywincalc 3.3.1, pyradiance 1.2.4).
# Expected: <Thickness unit="meter">0.001 and <Thickness unit="millimeter">1 are the same layer.
# Happens:  pywincalc hands out the number as written, without its unit, and frads divides it by 1000: a layer given in
#           metres (as Radiance's programs write it) becomes 1 micrometre. The system's thickness and what is saved from it
#           are wrong; what pywincalc calculates is not.
# Matters:  the sampling box of a coplanar system, EnergyPlus's layers and the saved XML get a layer without thickness.
# Seen:     2026-11-30
#   frads 2.1.16, pywincalc 3.3.1, numpy 2.4.6
#   unit millimeter, 1:      layer 0.001 m, system 0.001 m
#   unit meter, 0.001:       layer 1e-06 m, system 1e-06 m
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check frads==2.1.16 pywincalc==3.3.1 numpy==2.4.6
venv/bin/pip list --disable-pip-version-check | grep -iE '^(frads|pywincalc|numpy) '
venv/bin/python - <<'END'
import sys
from pathlib import Path

import numpy as np
from frads.window import LayerInput, create_glazing_system

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


def layer(unit, thickness):
    """Thickness in metres of the layer and of a system of this layer alone, as frads has them."""
    Path("film.xml").write_text(klems_xml(
        [(band, f"{kind} {side}", np.full((145, 145), value / np.pi)) for band in ("Visible", "Solar")
         for kind, value in (("Transmission", 0.5), ("Reflection", 0.2)) for side in ("Front", "Back")],
        unit=unit, thickness=thickness))
    system = create_glazing_system("film", [LayerInput("film.xml")])
    found = system.layers[0].thickness_m, system.thickness
    print(f"{f'unit {unit}, {thickness}:':24} layer {found[0]:g} m, system {found[1]:g} m")
    return found


still(np.allclose(layer("millimeter", 1), 1e-3, rtol=1e-9), "millimetres")
still(np.allclose(layer("meter", 0.001), 1e-6, rtol=1e-9), "metres are read as metres")
END
