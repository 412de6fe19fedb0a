"""Where a specimen was measured: the mesh of incident directions, and where their peaks are."""

from .._errors import ArgumentError
from . import _style
from ._disk import Disk
from ._subject import name_of, scattered_side


def draw(figure, subjects, *, incident_side=None, way=None, projection="equal-area", numbers=False):
    """The mesh of measured incidences, and on the hemisphere of scattered light the families of peaks that follow it.

    Each family is drawn as the image of the measured part of the mesh: where its peak is for every incidence, and on
    the way from one to the next. Of a measurement, which has no families, there are the incidences alone.

    Args:
        incident_side: "front" or "back"; None: the first that was measured.
        way: "reflection" or "transmission"; None: reflection where there is any.
        projection: As of "hemisphere".
        numbers: Number the incidences, from 0, in the order of the file.
    """
    if len(subjects) != 1 or not (subjects[0].is_measured or subjects[0].is_interpolant):
        raise ArgumentError("mesh: expected one interpolant or measurement")
    (subject,) = subjects
    side = incident_side or subject.pairs()[0][0]
    scattered = scattered_side(subjects, side, way)
    disk = Disk(projection)
    if subject.is_measured:
        measurement = subject.measurement(side, scattered)
        figure = _style.figure(figure, 4.6, 4.9)
        ax = figure.subplots()
        disk.axes(ax, title=_title(measurement.wi, measurement.symmetry), side=side)
        _incidences(ax, disk, measurement.wi, None, numbers)
        figure.suptitle(f"{subject.label}: {name_of(side, scattered)}", size=9.5)
        _legend(figure, mesh=False, families=0)
        return figure
    fitted = subject.what.fitted(side, scattered)
    figure = _style.figure(figure, 8.4, 4.9)
    left, right = figure.subplots(1, 2)
    disk.axes(left, title=_title(fitted["wi"], fitted["symmetry"]), side=side)
    lines = fitted["edge_paths"]
    for line in lines:
        left.plot(*disk.place(line).T, color=_style.FAINT, lw=0.7, zorder=4)
    _incidences(left, disk, fitted["wi"], fitted["vertices"], numbers)

    at_vertices, _ = subject.what.families(fitted["wi"], side, scattered)
    # The measured part alone: its images would lie over each other.
    measured = (fitted["edges"] < len(fitted["wi"])).all(axis=1)
    along, _ = subject.what.families(lines[measured], side, scattered)
    count = at_vertices.shape[1]
    disk.axes(right, title=f"{count} {'family' if count == 1 else 'families'} of peaks", side=scattered)
    for k in range(count):
        colour = _style.LINES[k % len(_style.LINES)]
        for line in along[:, :, k]:
            right.plot(*disk.place(line).T, color=colour, lw=0.6, alpha=0.75, zorder=5)
        marker = "osD^vPX<"[k % 8]
        right.plot(
            *disk.place(at_vertices[:, k]).T,
            marker,
            ls="",
            color=colour,
            ms=4,
            mec="white",
            mew=0.4,
            zorder=6,
            label=f"family {k + 1}",
        )
    figure.suptitle(f"{subject.label}: {name_of(side, scattered)}", size=9.5)
    _legend(figure, mesh=True, families=count)
    return figure


def _title(wi, symmetry):
    return f"{len(wi)} measured incidence{'' if len(wi) == 1 else 's'}, {symmetry} symmetry"


def _incidences(ax, disk, wi, vertices, numbers):
    if vertices is not None:
        ax.plot(*disk.place(vertices).T, "o", mfc="white", mec=_style.FAINT, mew=0.9, ms=4.5, zorder=5)
    places = disk.place(wi)
    ax.plot(*places.T, "o", color=_style.LINES[0], mec="white", mew=0.5, ms=6, zorder=6)
    if numbers:
        for k, (x, y) in enumerate(places):
            ax.annotate(str(k), (x, y), xytext=(4, 4), textcoords="offset points", size=6.5, zorder=7)


def _legend(figure, *, mesh, families):
    from matplotlib.lines import Line2D

    handles = [Line2D([], [], marker="o", ls="", color=_style.LINES[0], mec="white", ms=6, label="measured incidence")]
    if mesh:
        handles.append(
            Line2D([], [], marker="o", ls="", mfc="white", mec=_style.FAINT, ms=5, label="its image under the symmetry")
        )
    for k in range(families):
        handles.append(
            Line2D(
                [],
                [],
                marker="osD^vPX<"[k % 8],
                color=_style.LINES[k % len(_style.LINES)],
                lw=0.8,
                ms=4,
                label=f"family {k + 1}",
            )
        )
    figure.legend(handles=handles, loc="outside lower center", ncols=min(4, len(handles)))
