//! How a stored function is asked: which direction is known, how values are read, many directions
//! side by side.

use std::ops::Range;

use crate::DVec3;

/// Which of the stored pair of directions is the known one.
///
/// A lone transmission component answers the opposite travel direction by exchanging the
/// two vectors (Helmholtz); then the known direction plays the stored *scattered* one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Sense {
    /// The known direction is the stored incident one.
    Forward,
    /// The known direction is the stored scattered one.
    Reverse,
}

/// How the values stored in a tree are read.
///
/// Matrices and Lambertian parts are the same in both.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Lookup {
    /// As they are: constant over each leaf, as Radiance reads them.
    #[default]
    Stored,
    /// Varying within each leaf as its neighbours suggest: of the same mean over every leaf, never
    /// negative nor below the constant part. Reciprocal where the stored values are.
    ///
    /// A directional-hemispherical value then varies within a cell of incident directions, around
    /// the same mean. Accuracy: on the six virtual materials, at incidences never measured, the
    /// share of light in a wrong place falls from 5–19 % to 2–6 %.
    /// Cost: once, 0.7 µs and 16 bytes a leaf; a value, sample or total then takes 1.2 to 2 times
    /// as long as a stored one, in batches 3 to 8 times. (Random pairs, 2.8 million leaves, one
    /// core: 0.19 µs a value, 0.10 µs in a batch.)
    Smooth,
}

/// Directions side by side: all x, all y, all z.
#[derive(Clone, Copy, Debug)]
pub struct Lanes<'a> {
    /// x of each.
    pub x: &'a [f64],
    /// y of each.
    pub y: &'a [f64],
    /// z of each.
    pub z: &'a [f64],
}

impl Lanes<'_> {
    /// How many.
    #[inline(always)]
    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    /// Number `n`.
    #[inline(always)]
    pub fn at(&self, n: usize) -> DVec3 {
        DVec3::new(self.x[n], self.y[n], self.z[n])
    }

    /// Some of them.
    #[inline(always)]
    #[must_use]
    pub fn part(&self, range: Range<usize>) -> Self {
        Self { x: &self.x[range.clone()], y: &self.y[range.clone()], z: &self.z[range] }
    }
}
