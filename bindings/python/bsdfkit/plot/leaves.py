"""A tensor tree: the leaves that light of one incident direction meets."""

from ._cells import draw_cells


def draw(figure, subjects, *, incident=(30, 0), way=None, projection="cosines", decades=4.0, linear=False):
    """The leaves of a tensor tree on the hemisphere, coloured by their value: where it is fine, and where coarse.

    Args:
        incident: (theta, phi) in degrees, away from the surface.
        way: "reflection" or "transmission"; None: reflection where there is any.
        projection: As of "hemisphere"; "cosines" shows leaves of one level with one area, as the tree has them.
        decades: Most decades of the scale.
        linear: Linear colours from 0 instead of logarithmic ones.
    """
    form = (("tree3", "tree4"), "leaves")
    return draw_cells(figure, subjects, incident, way, projection, decades, linear, form=form, line=0.25)
