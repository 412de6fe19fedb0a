#!/usr/bin/env bash
# checkBSDF gives the largest total of a perfectly diffuse file 100 times too small, and exit status 0 to any file.
#
# Program:  checkBSDF in pyradiance 1.3.1.
# Expected: "Max. Tot. Dir" is the largest directional total in per cent, here that of the Lambertian part; and a file that
#           returns more light than it gets is an error, by the exit status at least.
# Happens:  a diffuse transmittance of 50 % is printed as 50 % under "Lambertian" and as 0.5 % under "Max. Tot. Dir".
#           A matrix that transmits 250 % is printed as 250 % with exit status 0.
# Matters:  scripts that look for totals above 100 % miss diffuse files: one of 250 % passes as 2.5 %; those that look at
#           the exit status miss all.
# Seen:     2026-11-30
#   pyradiance 1.3.1, numpy 2.4.6
#   diffuse, 50 %:  Lambertian 50.0, Max. Tot. Dir 0.5 %
#   diffuse, 250 %: Lambertian 249.9, Max. Tot. Dir 2.5 %
#   through, 250 %: Lambertian 0.0, Max. Tot. Dir 250.0 %
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


def check(label, matrix):
    """The Lambertian part and the largest total, both in per cent, that checkBSDF prints."""
    Path("film.xml").write_text(klems_xml([("Visible", f"Transmission {side}", matrix) for side in ("Front", "Back")]))
    report = radiance("checkBSDF", "film.xml").decode()  # fails unless the exit status is 0
    line = next(line for line in report.splitlines() if line.startswith("Ext->Int Trans"))
    _, lambertian, rest = line.split("\t", 2)
    found = float(lambertian.split()[1]), float(rest.split("%")[0])
    print(f"{label} Lambertian {found[0]:.1f}, Max. Tot. Dir {found[1]:.1f} %")
    return found


def near(found, lambertian, maximum):
    return abs(found[0] - lambertian) < 0.3 and abs(found[1] - maximum) < 0.3


still(near(check("diffuse, 50 %: ", np.full((145, 145), 0.5 / np.pi)), 50, 0.5), "diffuse 50 %")
still(near(check("diffuse, 250 %:", np.full((145, 145), 2.5 / np.pi)), 250, 2.5), "diffuse 250 %")
still(near(check("through, 250 %:", np.diag(2.5 / solid_angles(FULL))), 0, 250), "through 250 %")
END
