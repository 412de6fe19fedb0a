#!/usr/bin/env bash
# Radiance knows an angle basis by its name alone, for as long as the process runs.
#
# Program:  Radiance's BSDF library and checkBSDF in pyradiance 1.3.1; pywincalc 3.3.1 beside it.
# Expected: a Klems file brings its angle basis with it (AngleBasisBlock: ring bounds and numbers of patches), and its
#           values are integrated over those patches.
# Happens:  the first file that names a basis decides what that name means; the blocks of all later files are skipped.
#           Two files whose bases are both called "mine" change each other's transmittance, by order of loading, one of
#           them to more than 1. "LBNL/Klems Full" is built in, so a file with this name and other ring bounds is
#           integrated over bounds that are not its own, and WINDOW's engine does the same. No message.
# Matters:  ring bounds of measured data are easily changed and the name kept; two such materials in one scene are enough.
#           Give every basis of your own a name of its own.
# Seen:     2026-11-30
#   pyradiance 1.3.1, pywincalc 3.3.1, numpy 2.4.6
#   basis "mine", narrow rings: own total 0.7193, alone 0.7193, after the other file 1.1286
#   basis "mine", wide rings:   own total 0.8268, alone 0.8268, after the other file 0.4176
#   "LBNL/Klems Full", first ring to 2 degrees: own total 0.7000, Radiance 4.3657, WINDOW's engine 4.3657
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check pyradiance==1.3.1 pywincalc==3.3.1 numpy==2.4.6
venv/bin/pip list --disable-pip-version-check | grep -iE '^(pyradiance|pywincalc|numpy) '
venv/bin/python - <<'END'
import subprocess
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


def library(*lines):
    """Radiance's own BSDF library, in a process of its own; the numbers it prints."""
    program = "import pyradiance.bsdf as b\n" + "\n".join(lines)
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    return [float(word) for word in done.stdout.split()]


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


def both_ways(matrix, **basis):
    zero = np.zeros_like(matrix)
    sides = {"Transmission Front": matrix, "Transmission Back": matrix, "Reflection Front": zero, "Reflection Back": zero}
    return klems_xml([(band, side, m) for band in ("Visible", "Solar") for side, m in sides.items()], **basis)


def forward(rings, name):
    """Writes a material that scatters forward; its total at normal incidence."""
    column = np.concatenate([np.full(k, 1.6 / np.pi * np.cos(np.radians(c))**2) for c, _, _, k in rings])
    matrix = np.tile(column[:, None], len(column))
    open(name, "w").write(both_ways(matrix, basis="mine", rings=rings))
    return column @ solid_angles(rings)


def totals(*names):
    """Total transmittance at normal incidence of each file, loaded one after the other in one process."""
    return library(*(f"print(b.direct_hemi(b.load_file('{name}'), 0, 0, b.SAMPLE_ALL))" for name in names))


narrow = forward([(0, 0, 10, 1), (25, 10, 40, 8), (65, 40, 90, 8)], "narrow.xml")
wide = forward([(0, 0, 30, 1), (45, 30, 60, 8), (75, 60, 90, 8)], "wide.xml")
after_wide = totals("wide.xml", "narrow.xml")[1]
after_narrow = totals("narrow.xml", "wide.xml")[1]
alone = totals("narrow.xml") + totals("wide.xml")
print(f'basis "mine", narrow rings: own total {narrow:.4f}, alone {alone[0]:.4f}, after the other file {after_wide:.4f}')
print(f'basis "mine", wide rings:   own total {wide:.4f}, alone {alone[1]:.4f}, after the other file {after_narrow:.4f}')
still(np.allclose(alone, [narrow, wide], atol=1e-3), "a file alone is not integrated over its own rings")
still(after_wide > 1.1 and after_narrow < 0.45, "a second file is read by its own basis")

rings = [(0, 0, 2, 1), (8.5, 2, 15, 8)] + FULL[2:]
text = both_ways(np.diag(0.7 / solid_angles(rings)), rings=rings)
open("full.xml", "w").write(text)
radiance, engine = totals("full.xml")[0], visible(text)
print('"LBNL/Klems Full", first ring to 2 degrees: own total 0.7000, '
      f"Radiance {radiance:.4f}, WINDOW's engine {engine:.4f}")
still(abs(radiance - 4.366) < 0.01, "Radiance reads the ring bounds of a file with a built-in basis")
still(abs(engine - 4.366) < 0.01, "WINDOW's engine reads the ring bounds")
END
