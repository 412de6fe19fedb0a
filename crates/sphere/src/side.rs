//! Which side of the surface a direction points to.

use glam::DVec3;

/// A side of the surface: front is +Z, the interior (Radiance's sense).
///
/// Convention: only z > 0 is front; z = 0 and NaN count as back, as in the reference library.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Side {
    /// z > 0.
    Front,
    /// z ≤ 0.
    Back,
}

impl Side {
    /// The side that direction `w` points to.
    #[inline]
    pub fn of(w: DVec3) -> Side {
        if w.z > 0.0 { Side::Front } else { Side::Back }
    }

    /// +1 for front, −1 for back: the sign of z on this side.
    #[inline]
    pub fn sign(self) -> f64 {
        match self {
            Side::Front => 1.0,
            Side::Back => -1.0,
        }
    }

    /// `w`, mirrored at the surface where it points to the other side.
    #[inline]
    pub fn facing(self, w: DVec3) -> DVec3 {
        w.with_z(self.sign() * w.z.abs())
    }

    /// The other side.
    #[inline]
    pub fn opposite(self) -> Side {
        match self {
            Side::Front => Side::Back,
            Side::Back => Side::Front,
        }
    }
}
