#!/usr/bin/env bash
# honeybee-radiance writes a BSDF's added diffuse transmittance where Radiance reads a back reflectance.
#
# Program:  honeybee-radiance 1.66.299, rendered by Radiance in pyradiance 1.3.1.
# Expected: BSDF and aBSDF have front_diffuse_reflectance, back_diffuse_reflectance and diffuse_transmittance, each to be
#           set by itself, added to what the file says.
# Happens:  Radiance tells them apart by place: three numbers are front reflectance, six also back reflectance, nine also
#           transmittance. honeybee leaves out what is None without filling its place: with front and transmittance set it
#           writes six numbers, and the transmittance is rendered as back reflectance. With transmittance alone it
#           writes none at all. No message.
# Matters:  the haze that one adds to a fabric comes back as brightness on its other side, or not at all.
#           Set all three, to zeros where nothing is to be added.
# Seen:     2026-11-30
#   honeybee-radiance 1.66.299, pyradiance 1.3.1, numpy 2.4.6
#   added: transmittance 0.3                 written: 0 numbers  through 0.0000, back 0.0000
#   added: front 0.1, transmittance 0.3      written: 6 numbers  through 0.0000, back 0.3000
#   added: front 0.1, back 0, transm. 0.3    written: 9 numbers  through 0.3000, back 0.0000
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check honeybee-radiance==1.66.299 pyradiance==1.3.1 numpy==2.4.6
venv/bin/pip list --disable-pip-version-check | grep -iE '^(honeybee-radiance|pyradiance|numpy) '
venv/bin/python - <<'END'
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pyradiance
from honeybee_radiance.modifier.material import BSDF

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


# A file that is black on both sides: all light seen is what honeybee adds.
Path("film.xml").write_text(klems_xml([("Visible", f"{kind} {side}", np.zeros((145, 145)))
                                       for kind in ("Transmission", "Reflection") for side in ("Front", "Back")]))


def rendered(material, side, sky):
    """Radiance of the film seen from one side (1 front, -1 back), the sky being on one side."""
    Path("scene.rad").write_text(f"""void glow sky 0 0 4 1 1 1 0
sky source s 0 0 4 0 0 {sky} 180
{material}
film polygon window 0 0 12 -1 -1 0  1 -1 0  1 1 0  -1 1 0
""")
    Path("scene.oct").write_bytes(radiance("oconv", "scene.rad"))
    line = radiance("rtrace", "-h", "-ab", "1", "-ad", "1000", "-lw", "1e-6", "scene.oct", text=f"0 0 {side} 0 0 {-side}\n")
    return float(line.split()[1])


def show(label, **added):
    film = BSDF("film.xml", "film", up_orientation=(0, 1, 0))
    for name, value in added.items():
        setattr(film, name, (value,) * 3)
    material = film.to_radiance(True)
    numbers = material.split(" . 0 ")[1].split()[0]
    through, back = rendered(material, 1, -1), rendered(material, -1, -1)
    print(f"added: {label:33} written: {numbers} numbers  through {through:.4f}, back {back:.4f}")
    return numbers, round(through, 2), round(back, 2)


still(show("transmittance 0.3", diffuse_transmittance=0.3) == ("0", 0, 0), "transmittance alone")
still(show("front 0.1, transmittance 0.3", front_diffuse_reflectance=0.1, diffuse_transmittance=0.3) == ("6", 0, 0.3),
      "front and transmittance")
still(show("front 0.1, back 0, transm. 0.3", front_diffuse_reflectance=0.1, back_diffuse_reflectance=0,
           diffuse_transmittance=0.3) == ("9", 0.3, 0), "all three")
END
