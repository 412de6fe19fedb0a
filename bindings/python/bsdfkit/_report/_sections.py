"""What a page says of numbers: specimen, components, coverage, errors, energy, peaks."""

import numpy as np

from .. import Components, angles, direction
from ..plot._subject import SIDES, name_of
from ._page import facts, section, table, tag

THETAS = (0, 15, 30, 45, 60, 75)
LIT = ((0, 0), (30, 0), (60, 0), (30, 90))


def percent(share, digits=1):
    return "" if share is None else f"{100 * share:.{digits}f} %"


def brief(value):
    """Three digits, or a dash for what is not known."""
    return "–" if value is None or not np.isfinite(value) else f"{value:.3g}"


def specimen(metadata, bands=()):
    """What the file says about the piece of material."""
    length = lambda m: f"{1000 * m:g} mm" if m > 0 else None  # noqa: E731
    pairs = [
        ("name", metadata.name),
        ("manufacturer", metadata.manufacturer),
        ("thickness", length(metadata.thickness)),
        (
            "width × height",
            (
                f"{length(metadata.width)} × {length(metadata.height)}"
                if metadata.width > 0 and metadata.height > 0
                else None
            ),
        ),
        ("further bands", ", ".join(bands)),
        *metadata.properties,
        ("comments", [tag("div", c.strip()) for c in metadata.comments if c.strip()]),
    ]
    return section("Specimen", facts(pairs))


def components(bsdf):
    """What is stored, by pairs of sides."""
    forms = {
        "tree3": "tensor tree, isotropic",
        "tree4": "tensor tree, anisotropic",
        "matrix": "Klems matrix",
        "render": "render form",
        "transport": "interpolant",
        "sir": "interpolant of Radiance",
    }
    rows = []
    for c in bsdf.components:
        size = f"{c.leaves:,} leaves" if c.leaves is not None else f"{c.incidences} incident directions"
        rows.append(
            (
                name_of(c.incident, c.scattered),
                forms.get(c.representation, c.representation),
                size,
                "colour (CIE XYZ)" if c.coloured else "luminance",
            )
        )
    for n, incident in enumerate(SIDES):
        for m, scattered in enumerate(SIDES):
            if bsdf.lambertian[n][m] > 0:
                rows.append((name_of(incident, scattered), "Lambertian part", brief(bsdf.lambertian[n][m]), ""))
    return section("Components", table(("pair of sides", "form", "size", "values"), rows))


def energy(bsdf, pairs, figure):
    """Directional-hemispherical values over the incident angle."""
    rows = []
    for side in SIDES:
        if not any(i == side for i, _ in pairs):
            continue
        for theta in THETAS:
            row = [side, f"{theta}°"]
            wi = direction(theta if side == "front" else 180 - theta, [0.0, 90.0])
            for way in (Components.REFLECTION, Components.TRANSMISSION):
                row += [f"{value:.4f}" for value in bsdf.directional_hemispherical(wi, components=way)]
            rows.append(row)
    head = ("side lit", "θᵢ", "reflectance φᵢ = 0°", "φᵢ = 90°", "transmittance φᵢ = 0°", "φᵢ = 90°")
    note = (
        "Directional-hemispherical reflectance ρ(θᵢ, φᵢ; 2π) and transmittance τ(θᵢ, φᵢ; 2π): the share of light "
        "from one direction that is scattered into the whole hemisphere."
    )
    return section("Energy", figure, table(head, rows, numbers=(1, 2, 3, 4, 5)), note=note)


def peaks(bsdf, pairs):
    """Where peaks are, how high and how wide, for some incident directions."""
    rows = []
    for incident, scattered in pairs:
        for theta, phi in LIT:
            wi = direction(theta if incident == "front" else 180 - theta, phi)
            for n, peak in enumerate(bsdf.peaks(list(wi), scattered)):
                theta_o, phi_o = angles(peak["wo"])
                widths = [peak["narrowest_degrees"], peak["widest_degrees"]]
                wide = " × ".join("past the horizon" if not np.isfinite(w) else f"{w:.1f}°" for w in widths)
                lit = [name_of(incident, scattered), f"{theta}°, {phi}°"] if n == 0 else ["", ""]
                rows.append([*lit, f"{theta_o:.1f}°, {phi_o:.0f}°", brief(peak["f"]), wide])
    head = ("pair of sides", "light from θᵢ, φᵢ", "peak at θₒ, φₒ", "f (1/sr)", "full width at half maximum")
    note = (
        "Maxima of f · cos θₒ, the highest first: those above 15 % of it, 12° apart, with a dip of a quarter between "
        "them. Widths along the narrowest and the widest great circle."
    )
    return section("Peaks", table(head, rows, numbers=(3,)), note=note)


def reciprocity(bsdf, pairs):
    """Helmholtz reciprocity of what has both directions."""
    rows = []
    for incident, scattered in pairs:
        if incident == scattered or (scattered, incident) in pairs and incident == "front":
            defect = bsdf.reciprocity_defect(incident, scattered)
            if defect is not None:
                rows.append((name_of(incident, scattered), percent(defect)))
    note = (
        "∫∫ |f(ωᵢ, ωₒ) − f(ωₒ, ωᵢ)| / ∫∫ (f(ωᵢ, ωₒ) + f(ωₒ, ωᵢ)): 0 % is reciprocal, 100 % is one-way. A "
        "transmission that is stored one way answers both, and has 0 %."
    )
    return section("Reciprocity", table(("pair of sides", "defect"), rows, numbers=(1,)), note=note)


def coverage_of_fit(interpolant, pairs):
    """What an interpolant rests on, and how well it meets it."""
    children = []
    for incident, scattered in pairs:
        try:
            fitted = interpolant.fitted(incident, scattered)
        except ValueError:
            continue
        known = fitted["expected_l1"]
        children.append(tag("h3", name_of(incident, scattered)))
        children.append(
            facts(
                [
                    ("symmetry", fitted["symmetry"]),
                    ("measured incidences", f"{len(fitted['wi'])}, of {int(fitted['points'].sum()):,} points"),
                    (
                        "fit error at them",
                        f"L1 {fitted['fit_l1'].mean():.4f} in the mean, {fitted['fit_l1'].max():.4f} at most",
                    ),
                    (
                        "error to expect half-way between them",
                        (
                            f"L1 {known:.3f}; not to be trusted above 0.2"
                            if known is not None
                            else "unknown: too few incidences to leave one out"
                        ),
                    ),
                    (
                        "extrapolated",
                        (
                            f"{percent(fitted['extrapolated'])} of all pairs of directions; "
                            f"{percent(fitted['incidence_extrapolated'])} of incident directions lie past the "
                            f"outermost incidences"
                        ),
                    ),
                ]
            )
        )
        theta, phi = angles(fitted["wi"])
        rows = [
            (f"{t:.1f}°", f"{p:.1f}°", f"{n:,}", str(m), f"{limit:.0f}°", percent(seen, 0), f"{total:.4f}", f"{l1:.4f}")
            for t, p, n, m, limit, seen, total, l1 in zip(
                theta,
                phi,
                fitted["points"],
                fitted["lobes"],
                fitted["limit_degrees"],
                fitted["seen"],
                fitted["hemispherical"],
                fitted["fit_l1"],
            )
        ]
        head = ("θᵢ", "φᵢ", "points", "lobes", "measured to θₒ", "seen", "hemispherical", "fit L1")
        children.append(details(f"all {len(rows)} incidences", table(head, rows, numbers=range(8))))
    note = (
        "L1 = Σ|f − f′| / Σ f over projected solid angles: half of it is the share of the light in a wrong place. "
        "Seen: the share of the projected hemisphere between measured points."
    )
    return section("Coverage and error", children, note=note)


def validated(validations):
    """Every incidence predicted from the others."""
    rows = []
    for v in validations:
        past = np.array(v.extrapolated)
        for words, chosen in (("inside", ~past), ("past the rim of the others", past)):
            if chosen.any():
                offsets, heights = v.peak_offset_degrees[chosen], v.peak_height_ratio[chosen]
                rows.append(
                    (
                        name_of(v.incident, v.scattered),
                        words,
                        str(int(chosen.sum())),
                        f"{v.l1[chosen].mean():.4f}",
                        f"{v.l1[chosen].max():.4f}",
                        percent(float(np.sqrt(np.mean(v.hemispherical_error[chosen] ** 2)))),
                        f"{_mean(offsets):.2f}°",
                        f"{_mean(heights):.3f}",
                    )
                )
    head = (
        "pair of sides",
        "incidences left out",
        "number",
        "L1 mean",
        "largest",
        "hemispherical rms",
        "peak off by",
        "its height",
    )
    note = (
        "Each measured incidence predicted from the others: an upper bound of the usual error, as a hole is wider "
        "than the mesh."
    )
    return section("Incidences left out", table(head, rows, numbers=range(2, 8)), note=note)


def _mean(values):
    known = values[np.isfinite(values)]
    return known.mean() if len(known) else float("nan")


def coverage_of_points(measurements):
    """What a goniophotometer saw, incidence by incidence."""
    children = []
    for m in measurements:
        q = m.quality()
        channel = m.luminance_channel
        children.append(tag("h3", q["component"]))
        children.append(
            facts(
                [
                    ("symmetry", q["symmetry"]),
                    ("incidences", f"{len(q['incidences'])}, of {q['points']:,} points"),
                    ("values", q["colorimetry"]),
                    ("too little seen", q["scant"] and [tag("div", s) for s in q["scant"]]),
                    ("notes of the reader", q["notes"] and [tag("div", n) for n in q["notes"]]),
                ]
            )
        )
        rows = []
        for i in q["incidences"]:
            total = i["hemispherical"][channel]
            mark = "~" if i["extrapolated"] else ""
            rows.append(
                (
                    f"{i['theta_degrees']:.1f}°",
                    f"{i['phi_degrees']:.1f}°",
                    f"{i['points']:,}",
                    f"{i['spacing_degrees']:.2f}°",
                    f"{i['grazing_limit_degrees']:.0f}°",
                    percent(i["seen"], 0),
                    _holes(i),
                    percent(i["relative_noise"]),
                    brief(i["absolute_noise"]),
                    "–" if total is None else f"{mark}{total:.4f}",
                )
            )
        head = (
            "θᵢ",
            "φᵢ",
            "points",
            "spacing",
            "measured to θₒ",
            "seen",
            "holes",
            "noise",
            "noise (1/sr)",
            "hemispherical",
        )
        children.append(table(head, rows, numbers=(0, 1, 2, 3, 4, 5, 7, 8, 9)))
    note = (
        "Seen: the share of the projected hemisphere between points. Holes: the largest empty circles, retro where "
        "the detector would stand in the light. Totals marked ~ rest on less than nine tenths of the hemisphere."
    )
    return section("Coverage and holes", children, note=note)


def _holes(incidence):
    text = lambda h: f"{h['radius_degrees']:.1f}°{' retro' if h['retro_reflection'] else ''}"  # noqa: E731
    holes = incidence["holes"]
    return "none" if not holes else text(holes[0]) + (f", {len(holes) - 1} more" if len(holes) > 1 else "")


def details(summary, *children):
    return tag("details", tag("summary", summary), children, open="")


GLOSSARY = [
    (
        "BSDF, BRDF, BTDF",
        (
            "Bidirectional scattering, reflectance, transmittance distribution function: radiance of the scattered "
            "light over irradiance of the incident light, 1/sr (CIE S 017, ASTM E2387)."
        ),
    ),
    (
        "directional-hemispherical reflectance, transmittance",
        "Share of the flux of a collimated beam that is reflected, transmitted, into the whole hemisphere (CIE S 017).",
    ),
    (
        "θᵢ, φᵢ; θₒ, φₒ",
        (
            "Polar angle from the front normal and azimuth, counter-clockwise from +X toward +Y (up) as seen from "
            "the front, of the directions that light comes from and goes to; both point away from the surface."
        ),
    ),
    ("reciprocity", "Helmholtz: f(ωᵢ, ωₒ) = f(ωₒ, ωᵢ)."),
]


def glossary():
    return section("Terms", tag("dl", [[tag("dt", term), tag("dd", words)] for term, words in GLOSSARY]))
