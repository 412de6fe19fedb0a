#!/usr/bin/env bash
# WINDOW's engine takes <IncidentDataStructure>Rows as Columns: the matrix is read transposed.
#
# Program:  pywincalc 3.3.1 (LBNL's WINDOW engine).
# Expected: the element says whether a row or a column holds the values of one incident direction; "Rows" is read so, as
#           Radiance does, or refused.
# Happens:  it is not looked at: the same values give the same answers under "Columns" and "Rows".
# Matters:  a film that lets in light from above only and spreads it evenly has a transmittance of 0.60 from above, 0 from
#           below. Written by rows, the engine finds 0.26 from everywhere. Symmetric materials hide it.
# Seen:     2026-11-30
#   pywincalc 3.3.1, numpy 2.4.6
#   transmittance at 40 degrees, light from above / below
#   the film:         0.6000 / 0.0000
#   file in columns:  0.6000 / 0.0000
#   file in rows:     0.2647 / 0.2647
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


azimuths = np.concatenate([360 * np.arange(k) / k for _, _, _, k in FULL])
above = (azimuths > 180) & (azimuths < 360)  # incident patches are turned by 180 degrees
film = np.zeros((145, 145))
film[:, above] = 0.6 / np.pi
reflection = np.zeros((145, 145))


def file(matrix, structure):
    sides = {"Transmission Front": matrix, "Transmission Back": matrix.T,
             "Reflection Front": reflection, "Reflection Back": reflection}
    return klems_xml([(band, side, m) for band in ("Visible", "Solar") for side, m in sides.items()], structure=structure)


def both(text):
    """At 40 degrees, from the two sides of the horizontal plane."""
    return sorted((visible(text, theta=40, phi=phi) for phi in (90, 270)), reverse=True)


columns, rows = both(file(film, "Columns")), both(file(film.T, "Rows"))
print("transmittance at 40 degrees, light from above / below")
print("the film:         0.6000 / 0.0000")
print(f"file in columns:  {columns[0]:.4f} / {columns[1]:.4f}")
print(f"file in rows:     {rows[0]:.4f} / {rows[1]:.4f}")
still(abs(columns[0] - 0.6) < 1e-3 and abs(columns[1]) < 1e-3, "columns are not read as columns")
still(abs(rows[0] - rows[1]) < 1e-6 and abs(rows[0] - 0.3) < 0.05, "rows are read")
END
