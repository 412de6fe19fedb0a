"""Numbers that are literals of a kernel where they are the same for all lanes, in Dr.Jit."""

import drjit as dr


class Numbers:
    """Columns of numbers: a literal where all rows have the same, else a gather."""

    def __init__(self, columns, types):
        self.types = types
        self.columns, self.arrays = columns, {}
        for name, column in columns.items():
            if not (column == column[0]).all():
                kind = {"b": types.Bool, "i": types.UInt32, "f": types.Float}[column.dtype.kind]
                self.arrays[name] = kind(column)

    def __call__(self, name, row):
        if isinstance(row, int) or name not in self.arrays:
            return self.columns[name][row if isinstance(row, int) else 0].item()
        return dr.gather(type(self.arrays[name]), self.arrays[name], row)


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
