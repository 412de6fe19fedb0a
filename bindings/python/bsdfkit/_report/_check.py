"""What `bsdf check` says of a file: the command decides what is wrong, the page repeats it."""

import json
import os
import shutil
import subprocess

from ._page import facts, section, tag

#: The command that runs this page, or another than the one on PATH.
COMMAND = "BSDFKIT_COMMAND"


def command():
    """The command `bsdf`, or None."""
    return os.environ.get(COMMAND) or shutil.which("bsdf")


def checked(path):
    """Its JSON, or None where there is no such command or it cannot read the file."""
    bsdf = command()
    if bsdf is None:
        return None
    ran = subprocess.run([bsdf, "check", "--json", "--", str(path)], capture_output=True, encoding="utf-8")
    try:
        return json.loads(ran.stdout.splitlines()[0])
    except (IndexError, ValueError):
        return None


BADGES = {"good": ("good", "✓ good"), "bad": ("bad", "✗ faults")}


def verdict(said):
    """The section of what was found, with the limits it was judged by."""
    if said is None:
        words = (
            "Not checked: the command bsdf was not found. With it on PATH, this section says what `bsdf check` finds."
        )
        return section("Verdict", tag("p", words))
    kind, words = BADGES.get(said["verdict"], ("fair", said["verdict"]))
    rows = [("bsdf check", tag("span", words, class_=f"badge {kind}"))]
    for e in said.get("energy", []):
        what = "of the part seen, scatters into it" if e.get("of_the_part_seen") else "scatters"
        found = (
            f"{what} at most {e['largest']:.4f} of the light (θᵢ = {e['theta_degrees']:.0f}°, φᵢ = "
            f"{e['phi_degrees']:.0f}°)"
        )
        rows.append((f"energy, {e['component']}", [found, "; limit 1, to which 2 % of calibration are added"]))
    for r in said.get("reciprocity", []):
        rows.append(
            (
                f"reciprocity, {r['component']}",
                f"f(ωᵢ, ωₒ) and f(ωₒ, ωᵢ) differ by {100 * r['defect']:.1f} % of the light; reported, without a limit",
            )
        )
    children = [facts(rows)]
    faults = said.get("faults", [])
    # What the reader remarked may be a fault, with its component before it.
    remarks = [text for text in said.get("remarks", []) if not any(fault.endswith(text) for fault in faults)]
    for told, words in ((faults, "Faults"), (remarks, "Remarks")):
        if told:
            children += [tag("h3", words), tag("ul", [tag("li", text) for text in told])]
    return section(
        "Verdict",
        children,
        note=(
            "Faults are energy above the limit, values that are negative or not finite, and a measurement that lacks "
            "what its symmetry or a lobe needs."
        ),
    )
