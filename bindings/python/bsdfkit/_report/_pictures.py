"""The pictures of a page."""

from .. import direction, plot
from .._errors import ArgumentError
from ..plot._subject import name_of
from ._page import picture, section, tag

#: Incident polar angles of curves.
THETAS = (0, 15, 30, 45, 60, 75)


def drawn(subjects, kind, caption, format="png", **options):
    """A picture, or nothing where there is nothing of that kind to draw."""
    try:
        return picture(plot.draw(subjects, kind, **options), caption, kind=format)
    except ArgumentError:
        return None


def hemispherical(subject, label):
    return drawn(
        subject, "hemispherical", "Directional-hemispherical values over the incident angle.", "svg", labels=[label]
    )


def of_bsdf(bsdf, label, pairs):
    """What is worth a look of something that answers for all directions."""
    shown = []
    for side in sorted({i for i, _ in pairs}, reverse=True):
        lit = [(t if side == "front" else 180 - t, 0) for t in THETAS]
        shown.append(
            drawn(
                bsdf,
                "slice",
                f"Light from the {side}, in its planes of incidence at φᵢ = 0°.",
                "svg",
                labels=[label],
                incident=lit,
            )
        )
    for incident, scattered in pairs:
        way = "reflection" if incident == scattered else "transmission"
        for theta, phi in ((30, 0), (60, 45)):
            at = (theta if incident == "front" else 180 - theta, phi)
            words = (
                f"{name_of(incident, scattered).capitalize()} for light from θᵢ = {at[0]}°, φᵢ = {phi}°, seen from "
                f"the front: +X right, +Y up."
            )
            shown.append(drawn(bsdf, "hemisphere", words, labels=[label], incident=at, way=way))
        at = (30 if incident == "front" else 150, 0)
        for kind in ("patches", "leaves"):
            shown.append(drawn(bsdf, kind, f"The stored {kind}.", labels=[label], incident=at, way=way))
    side = pairs[0][0]
    shown.append(
        drawn(
            bsdf,
            "lobe",
            "The same light as a surface: the distance from the specimen is the logarithm of f.",
            labels=[label],
            incident=(30 if side == "front" else 150, 0),
        )
    )
    return _gallery("Pictures", shown)


def of_interpolant(interpolant, label, pairs, measured):
    """Mesh and families, and points where they are known."""
    shown = []
    for incident, scattered in pairs:
        way = "reflection" if incident == scattered else "transmission"
        shown.append(
            drawn(
                interpolant,
                "mesh",
                "Measured incidences and their mesh; where the families of peaks are for them.",
                labels=[label],
                incident_side=incident,
                way=way,
            )
        )
        if measured:
            at = (30 if incident == "front" else 150, 0)
            shown.append(
                drawn(
                    [interpolant, measured],
                    "points",
                    "A measured incidence and what was made of it.",
                    labels=[label, label],
                    incident=at,
                    way=way,
                )
            )
    return _gallery("Mesh, families and residuals", shown)


def of_measurement(measurements, label):
    """Incidences, and what some of them show."""
    shown = []
    for m in measurements:
        way = "reflection" if m.incident == m.scattered else "transmission"
        shown.append(
            drawn(measurements, "mesh", "Where light came from.", labels=[label], incident_side=m.incident, way=way)
        )
        asked = [(theta if m.incident == "front" else 180 - theta, 0) for theta in (30, 60)]
        # Each measured incidence once.
        for at in {m.nearest(list(direction(*at)))[0]: at for at in reversed(asked)}.values():
            shown.append(
                drawn(
                    measurements,
                    "hemisphere",
                    "Measured points, seen from the front: +X right, +Y up.",
                    labels=[label],
                    incident=at,
                    way=way,
                )
            )
        shown.append(
            drawn(
                measurements,
                "slice",
                "Points within 2° of the plane of incidence.",
                "svg",
                labels=[label],
                incident=[(30 if m.incident == "front" else 150, 0)],
            )
        )
    return _gallery("Pictures", shown)


def _gallery(title, shown):
    shown = [figure for figure in shown if figure is not None]
    return section(title, tag("div", shown, class_="gallery") if shown else None)
