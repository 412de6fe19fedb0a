"""Golden vectors of Radiance's library, from tests/golden/*.json as lines that golden.c reads.

Usage: python3 golden.py GOLDEN > TABLE. A line is a word and its numbers:

    open FILE                              what the lines below ask
    eval WI WO VALUE TOLERANCE BORDER      BORDER 1: either cell beside WO is right
    cells WI WO SMALLEST LARGEST           projected solid angles, sr
    total WI COMPONENTS VALUE              relative to 1e-4
    draw WI COMPONENTS U WO DISTANCE       counted: most are that near
"""

import json
import sys
from pathlib import Path

TREES = ["tree4_tf", "tree4_tb", "tree4_rf_rb_tf_tb", "tree3_tf", "tree3_tb", "tree3_rf_rb_tf_tb"]
EITHER_SIDE = 0b110000  # the reference's flags lack sides


def line(word, *numbers):
    flat = (x for n in numbers for x in (n if isinstance(n, list) else [n]))
    return " ".join([word, *(repr(x) for x in flat)])


def border(wi, wo):
    return int(abs(wi[0] * wo[1] - wi[1] * wo[0]) < 1e-12)


def sampling(cases, distance, isotropic_sides=None):
    for case in cases:
        if isotropic_sides and ("front" if case["in"][2] > 0 else "back") not in isotropic_sides:
            continue  # the reference has no reverse totals at rank 3
        components = case["flags"] | EITHER_SIDE
        yield line("total", case["in"], components, case["hemi"])
        if case["hemi"] > 0 and case["flags"] == 15:
            for u, wo, _ in case["samples"]:
                yield line("draw", case["in"], components, u, wo, distance)


def lines(golden):
    def load(name):
        return json.loads((golden / f"{name}.json").read_text())

    for name in TREES:
        data, isotropic = load(name), name.startswith("tree3")
        yield f"open {data['file']}"
        for q in data["eval"]:
            # At rank 3 mirror and straight-through directions lie between two cells.
            yield line("eval", q["in"], q["out"], q["eval"][2], 4e-4, isotropic * border(q["in"], q["out"]))
            if q["size"] and not isotropic:
                yield line("cells", q["in"], q["out"], q["size"][1])
        sides = {"tree3_tf": ["front"], "tree3_tb": ["back"]}.get(name)
        yield from sampling(data["sampling"], 1e-3, sides)
    data = load("klems_sampling")
    yield f"open {data['file']}"
    yield from sampling(data["cases"], 2e-2)
    data = load("klems_rows_columns")
    for file in [*data["files"], "compiled/kq_columns.safetensors"]:
        yield f"open {file}"
        for q in data["queries"]:
            yield line("eval", q["in"], q["out"], q["file_value"], 1e-6, 0)
    for file in ["xml/custom_basis.xml", "compiled/custom_basis.safetensors"]:
        yield f"open {file}"
        for q in load("klems_custom")["queries"]:
            yield line("eval", q["in"], q["out"], q["custom_file"], 1e-6, 0)


print("\n".join(lines(Path(sys.argv[1]))))
