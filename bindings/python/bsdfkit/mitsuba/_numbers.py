"""Numbers that are literals of a kernel where they are the same for all lanes, in Dr.Jit."""

import drjit as dr

# Of so few rows a number is chosen by comparisons: they cost less than a gather.
_FEW = 4


class Numbers:
    """Columns of numbers: a literal where all rows have the same; else chosen among few rows, or a gather."""

    def __init__(self, columns, types):
        self.types = types
        self.columns, self.arrays = columns, {}
        for name, column in columns.items():
            if not (column == column[0]).all():
                kind = self._kind(column)
                self.arrays[name] = kind(column)

    def _kind(self, column):
        return {"b": self.types.Bool, "i": self.types.UInt32, "u": self.types.UInt32, "f": self.types.Float}[column.dtype.kind]

    def __call__(self, name, row):
        column = self.columns[name]
        if isinstance(row, int) or name not in self.arrays:
            return column[row if isinstance(row, int) else 0].item()
        if len(column) > _FEW:
            return dr.gather(type(self.arrays[name]), self.arrays[name], row)
        kind = self._kind(column)
        found = kind(column[0].item())
        for k in range(1, len(column)):
            if column[k] != column[0]:
                found = dr.select(row == k, kind(column[k].item()), found)
        return found


def select(condition, yes, no):
    """`dr.select`, whose condition may be a literal."""
    if isinstance(condition, bool):
        return yes if condition else no
    return dr.select(condition, yes, no)


def any_of(conditions):
    """Whether one of several conditions holds: literals or lanes."""
    found = conditions[0]
    for c in conditions[1:]:
        found = found | c
    return found
