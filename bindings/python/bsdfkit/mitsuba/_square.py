"""The concentric map between square and disk, in Dr.Jit: `crates/sphere/src/concentric.rs`."""

import drjit as dr


def disk_to_square(x, y):
    """Unit disk → unit square; +X ↔ (1, ½), +Y ↔ (½, 1)."""
    a, b = dr.abs(x), dr.abs(y)
    wide = a > b
    small, large = dr.minimum(a, b), dr.maximum(a, b)
    long = dr.sqrt(dr.fma(a, a, b * b))
    short = long * dr.atan2(small, large) * (4.0 / dr.pi)
    a, b = dr.select(wide, long, short), dr.select(wide, short, long)
    a = dr.clip(dr.fma(dr.copysign(a, x), 0.5, 0.5), 0.0, 1.0)
    b = dr.clip(dr.fma(dr.copysign(b, y), 0.5, 0.5), 0.0, 1.0)
    return a, b


def square_to_disk(s, t):
    """Unit square → unit disk, area-preserving up to the factor π."""
    a, b = dr.fma(2.0, s, -1.0), dr.fma(2.0, t, -1.0)
    wide = dr.abs(a) > dr.abs(b)
    small, large = dr.select(wide, b, a), dr.select(wide, a, b)
    turn = dr.select(large == 0.0, 0.0, small / large) * (dr.pi / 4.0)
    sin, cos = dr.sincos(turn)
    x, y = large * cos, large * sin
    return dr.select(wide, x, y), dr.select(wide, y, x)
