//! An incident direction, turned to where its nodes are.

use crate::{DVec2, DVec3};

/// Cosines of incidence below this count as this: 89.4 degrees. No frame stays finite to the horizon.
pub(crate) const LOWEST: f64 = 0.01;

/// A rotation or reflection of the plane, by its rows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turn {
    pub(crate) x: DVec2,
    pub(crate) y: DVec2,
}

impl Turn {
    pub(crate) const IDENTITY: Self = Self { x: DVec2::X, y: DVec2::Y };

    #[inline(always)]
    pub(crate) fn apply(self, v: DVec2) -> DVec2 {
        DVec2::new(self.x.dot(v), self.y.dot(v))
    }

    #[inline(always)]
    pub(crate) fn undo(self, v: DVec2) -> DVec2 {
        self.x * v.x + self.y * v.y
    }
}

/// An incident direction above the horizon, as tables know it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Incidence {
    /// x and y, turned.
    pub(crate) xy: DVec2,
    /// At least [`LOWEST`].
    pub(crate) z: f64,
    /// From the caller's frame to that of the tables.
    pub(crate) turn: Turn,
}

impl Incidence {
    /// x and y of a direction whose cosine is |z|, raised above the horizon.
    #[inline(always)]
    pub(crate) fn raised(w: DVec3) -> (DVec2, f64) {
        let (xy, z) = (w.truncate(), w.z.abs());
        if z >= LOWEST {
            return (xy, z);
        }
        let radius = (1.0 - LOWEST * LOWEST).sqrt();
        let length = xy.length();
        let xy = if length > 0.0 { xy * (radius / length) } else { DVec2::new(radius, 0.0) };
        (xy, LOWEST)
    }
}
