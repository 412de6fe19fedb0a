"""A Klems matrix: the value of every patch of scattered directions for one incident direction."""

from ._cells import draw_cells
from ._disk import text


def draw(
    figure, subjects, *, incident=(30, 0), way=None, projection="equal-area", decades=4.0, linear=False, numbers=True
):
    """The patches of a Klems matrix, coloured by their value, one panel a subject.

    Args:
        incident: (theta, phi) in degrees, away from the surface: any direction of the incident patch.
        way: "reflection" or "transmission"; None: reflection where there is any.
        projection: As of "hemisphere".
        decades: Most decades of the scale.
        linear: Linear colours from 0 instead of logarithmic ones.
        numbers: Write the number of each patch, from 1, as WINDOW counts them.
    """

    def number(ax, places, patches, shades):
        for (x, y), k, shade in zip(places, patches, shades):
            # Dark words on light colours.
            text(ax, x, y, str(k + 1), size=5, halo=False, colour="black" if shade > 0.55 else "white")

    form = (("matrix",), "patches")
    return draw_cells(
        figure, subjects, incident, way, projection, decades, linear, form=form, number=number if numbers else None
    )
