"""Every kind of file that we write, of small specimens in closed form: what the sweep hands to the programs."""

import places
import film
import metal

BANDS = [400, 450, 500, 550, 600, 650, 700, 1000, 1500, 2200]


def tinted(columns, shares):
    """The film's measurement in several columns, the second half of them weaker: a colour, or bands."""
    head, *rows = film.table().split()
    lines = [head.replace("value", ",".join(columns))]
    for row in rows:
        *angles, value = row.split(",")
        lines.append(",".join(angles + [f"{float(value) * share:.6g}" for share in shares]))
    return "\n".join(lines) + "\n"


def one_way(theta_i_front, theta_o_front):
    """The film's measurement between one pair of sides."""
    head, *rows = film.table().split()
    kept = [row for row in rows if (float(row.split(",")[0]) < 90) == theta_i_front and (float(row.split(",")[2]) < 90) == theta_o_front]
    return "\n".join([head, *kept]) + "\n"


def specimens(folder):
    """Measurements by name, with the options of their fits."""
    film_rows = {
        "film": film.table(),
        "colour": tinted("XYZ", [0.9, 0.8, 0.5]),
        "spectrum": tinted(map(str, BANDS), [0.3 + 0.06 * k for k in range(len(BANDS))]),
        "reflects": one_way(True, True),
        "transmits": one_way(True, False),
        "transmits from behind": one_way(False, True),
    }
    for name, text in film_rows.items():
        (folder / f"{name}.csv").write_text(text)
        yield name, folder / f"{name}.csv", ["--symmetry", "isotropic"]
    (folder / "metal.csv").write_text(metal.table())
    yield "metal", folder / "metal.csv", ["--symmetry", "none"]
    few = ["--sweeps", 36, "--points-per-sweep", 120, "--spiral-points", 2000]
    for name in ("clear-glass", "mirror-film"):
        places.bsdf("simulate", name, *few, "-o", folder / name)
        yield name, folder / name, ["--aperture", 1]


#: Kinds of file by specimen: label, name of the file, arguments of `bsdf convert`.
TREE, FULL = ("tensor tree", "tree", ["--to", "tensor-tree", "--max-depth", 4]), ("Klems full", "full", ["--to", "klems-full"])
WINDOW = ("--for window", "window", ["--for", "window"])
RADIANCE = ("--for radiance", "radiance", ["--for", "radiance", "--max-depth", 4])
EVERY = [
    TREE,
    FULL,
    ("Klems half", "half", ["--to", "klems-half"]),
    ("Klems quarter", "quarter", ["--to", "klems-quarter"]),
    RADIANCE,
    WINDOW,
    ("--for energyplus", "energyplus", ["--for", "energyplus"]),
]


def write(folder, wanted=lambda name: True):
    """Fits all specimens whose names are wanted and writes every kind: (label, path), one after the other."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, measured, options in specimens(folder):
        if not wanted(name):
            continue
        fitted = folder / f"{name}.safetensors"
        if not fitted.exists():
            places.bsdf("fit", measured, *options, "-o", fitted)
        kinds = EVERY if name in ("film", "metal") else [TREE, RADIANCE, FULL, WINDOW]
        if name in ("colour", "spectrum"):
            # Their trees take minutes.
            kinds = [FULL, WINDOW]
        for label, short, arguments in kinds:
            path = folder / f"{name} {short}.xml".replace(" ", "_")
            if not path.exists():
                places.bsdf("convert", fitted, *arguments, "-o", path)
            yield f"{name}: {label}", path
        if name in ("film", "metal"):
            form = folder / f"{name}_render.safetensors"
            if not form.exists():
                places.bsdf("compile", fitted, "-o", form)
            yield f"{name}: render form", form
            tables = folder / f"{name}_rgb.bsdf"
            if not tables.exists():
                places.bsdf("convert", fitted, "-o", tables)
            yield f"{name}: RGL's tables", tables
        if name == "film":
            path = folder / "film_rank4.xml"
            if not path.exists():
                places.bsdf("convert", folder / "film_quarter.xml", "--to", "tensor-tree", "--max-leaves", 100_000, "-o", path)
            yield "film: rank 4, of the matrix", path
