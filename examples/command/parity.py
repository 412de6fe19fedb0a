"""Prints what the command `bsdf` answers to every verb; the text is specified in ../README.md.

    python parity.py BSDF FILE      (BSDF: the command)
"""

import json
import subprocess
import sys

CLASSES = {2: "argument", 3: "io", 4: "format", 5: "limit"}
INCIDENT = [((-2, 3, 6), 7), ((6, -2, 3), 7), ((-8, -1, 4), 9), ((0, 0, 1), 1), ((3, -4, 12), 13)]
SCATTERED = [((2, -3, 6), 7), ((1, 2, 2), 3), ((-4, 4, 7), 9), ((6, 2, 9), 11), ((-2, -6, 3), 7)]
SAMPLES = 12
SIDES = [("front", "front"), ("back", "back"), ("front", "back"), ("back", "front")]


class Command:
    """The command and the file that it is asked about."""

    def __init__(self, command, path):
        self.command, self.path = command, path

    def run(self, verb, *options, rows=()):
        """Lines of standard output; `rows` are numbers, one row a line of standard input."""
        text = "".join(" ".join(f"{x:.17g}" for x in row) + "\n" for row in rows)
        command = [self.command, verb, self.path, *options]
        done = subprocess.run(command, input=text, capture_output=True, text=True)
        if done.returncode:
            message = done.stderr.split("bsdf: ", 1)[-1].rstrip("\n")
            sys.exit(f"parity: {CLASSES[done.returncode]}: {message}")
        return done.stdout.splitlines()

    def numbers(self, verb, *options, rows):
        return [list(map(float, line.split())) for line in self.run(verb, *options, rows=rows)]


def directions(table):
    front = [tuple(x / length for x in vector) for vector, length in table]
    return front + [(x, y, -z) for x, y, z in front]


def real(*numbers):
    return " ".join(f"{x:.6e}" for x in numbers)


def representation(structure):
    if structure.startswith("tensor tree"):
        return "tree" + structure[-1]
    return {"matrix": "matrix", "render form": "render"}.get(structure, "continuous")


def described(bsdf):
    (line,) = bsdf.run("info", "--json")
    info = json.loads(line)
    yield f"name {info['name']}"
    yield f"manufacturer {info['manufacturer']}"
    yield f"size {real(*(info[f'{size}_metres'] for size in ('width', 'height', 'thickness')))}"
    for n, c in enumerate(info["components"]):
        side, sense = c["component"].split()
        other = side if sense == "reflection" else {"front": "back", "back": "front"}[side]
        yield f"component {n} {side} {other} {representation(c['structure'])}"
    sense = {True: "reflection", False: "transmission"}
    names = [f"{incident}_{sense[incident == scattered]}" for incident, scattered in SIDES]
    yield f"lambertian {real(*(info['lambertian'].get(name, 0.0) for name in names))}"


def samples(verb, bsdf, options, rows):
    drawn = bsdf.run("sample", "--vectors", "--stdin", *options, rows=rows)
    for n, line in enumerate(drawn):
        where = f"{verb} {n // SAMPLES} {n % SAMPLES}"
        if line == "none":
            yield f"{where} none"
            continue
        *numbers, part = line.split()
        part = f"component {part}" if part.isdigit() else part.replace("specular_", "specular ")
        yield f"{where} {real(*map(float, numbers))} {part}"


def lines(bsdf):
    bsdf.run("eval")  # first of all what is wrong with the file
    yield from described(bsdf)
    wi, wo = directions(INCIDENT), directions(SCATTERED)
    pairs = [(i, j) for i in range(len(wi)) for j in range(len(wo))]
    both = [wi[i] + wo[j] for i, j in pairs]
    verbs = {
        "eval": ["eval", "--vectors"],
        "pdf": ["pdf", "--vectors"],
        "eval_pdf": ["eval", "--vectors", "--pdf"],
        "projected_solid_angle": ["solid-angle", "--vectors", "--stdin", "--pairs"],
    }
    for verb, command in verbs.items():
        for (i, j), numbers in zip(pairs, bsdf.numbers(*command, rows=both)):
            yield f"{verb} {i} {j} {real(*numbers)}"
    totals = bsdf.numbers("hemispherical", "--vectors", "--stdin", rows=wi)
    for i, (reflectance, transmittance) in enumerate(totals):
        yield f"hemispherical {i} {real(reflectance + transmittance, reflectance, transmittance)}"
    for i, sizes in enumerate(bsdf.numbers("solid-angle", "--vectors", "--stdin", rows=wi)):
        yield f"projected_solid_angle {i} {real(*sizes)}"
    u = [(k + 0.5) / SAMPLES for k in range(SAMPLES)]
    v = [(5 * k % SAMPLES + 0.5) / SAMPLES for k in range(SAMPLES)]
    yield from samples("sample", bsdf, [], [w + (x,) for w in wi for x in u])
    square = [w + point for w in wi for point in zip(u, v)]
    yield from samples("sample2", bsdf, ["--square"], square)


def main():
    text = "".join(line + "\n" for line in lines(Command(*sys.argv[1:])))
    sys.stdout.buffer.write(text.encode())


if __name__ == "__main__":
    main()
