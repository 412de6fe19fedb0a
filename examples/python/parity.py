"""Prints what a BSDF answers to every verb; the text is specified in ../README.md."""

import sys
import warnings

import bsdfkit
import numpy as np
from bsdfkit import Components

CLASSES = {
    bsdfkit.IoError: "io",
    bsdfkit.FormatError: "format",
    bsdfkit.ArgumentError: "argument",
    bsdfkit.LimitError: "limit",
}


def directions(rows):
    """Integer vectors over their lengths, then the same with z negated: shape (10, 3)."""
    front = np.array([np.array(w, dtype=float) / length for w, length in rows])
    return np.concatenate([front, front * [1, 1, -1]])


WI = directions(
    [((-2, 3, 6), 7), ((6, -2, 3), 7), ((-8, -1, 4), 9), ((0, 0, 1), 1), ((3, -4, 12), 13)]
)
WO = directions(
    [((2, -3, 6), 7), ((1, 2, 2), 3), ((-4, 4, 7), 9), ((6, 2, 9), 11), ((-2, -6, 3), 7)]
)
K = np.arange(12)


def real(*numbers):
    return " ".join(f"{x:.6e}" for x in numbers)


def part_name(part):
    if part <= bsdfkit.Part.SPECULAR:
        return f"specular {bsdfkit.Part.SPECULAR - part}"
    return f"component {part}" if part >= 0 else bsdfkit.Part(part).name.lower()


def samples(verb, drawn):
    for i in range(len(WI)):
        for k in K:
            wo, weight, pdf, part = (field[i, k] for field in drawn)
            if part == bsdfkit.Part.NOTHING:
                yield f"{verb} {i} {k} none"
            else:
                yield f"{verb} {i} {k} {real(*wo, weight, pdf)} {part_name(part)}"


def lines(bsdf):
    m = bsdf.metadata
    yield f"name {m.name}"
    yield f"manufacturer {m.manufacturer}"
    yield f"size {real(m.width, m.height, m.thickness)}"
    for n, c in enumerate(bsdf.components):
        stored = c.representation.startswith(("tree", "matrix", "render"))
        yield f"component {n} {c.incident} {c.scattered} {c.representation if stored else 'continuous'}"
    (front, front_to_back), (back_to_front, back) = bsdf.lambertian
    yield f"lambertian {real(front, back, front_to_back, back_to_front)}"

    wi, all_wi = WI, WI[:, None]
    pairs = {
        "eval": bsdf.eval(all_wi, WO)[..., None],
        "pdf": bsdf.pdf(all_wi, WO)[..., None],
        "eval_pdf": np.stack(bsdf.eval_pdf(all_wi, WO), axis=-1),
        "projected_solid_angle": bsdf.projected_solid_angle(all_wi, WO),
    }
    for verb, values in pairs.items():
        for i in range(len(WI)):
            for j in range(len(WO)):
                yield f"{verb} {i} {j} {real(*values[i, j])}"
    ways = [Components.ALL, Components.REFLECTION, Components.TRANSMISSION]
    totals = [bsdf.directional_hemispherical(wi, components=way) for way in ways]
    for i, ways in enumerate(zip(*totals)):
        yield f"hemispherical {i} {real(*ways)}"
    for i, sizes in enumerate(bsdf.projected_solid_angle(wi)):
        yield f"projected_solid_angle {i} {real(*sizes)}"
    u = (K + 0.5) / len(K)
    yield from samples("sample", bsdf.sample(all_wi, u))
    u2 = np.stack([u, (5 * K % len(K) + 0.5) / len(K)], axis=-1)
    yield from samples("sample2", bsdf.sample2(all_wi, u2))


def main():
    warnings.simplefilter("ignore", bsdfkit.FileWarning)
    try:
        bsdf = bsdfkit.open(sys.argv[1])
    except bsdfkit.Error as error:
        print(f"parity: {CLASSES[type(error)]}: {error}", file=sys.stderr)
        return 1
    text = "".join(line + "\n" for line in lines(bsdf))
    sys.stdout.buffer.write(text.encode())
    return 0


if __name__ == "__main__":
    sys.exit(main())
