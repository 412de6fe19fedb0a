//! The regions of directions by which a stored form answers.

use crate::{Bsdf, DVec2, DVec3, Side};

/// A region of directions over which the stored f of one known direction is constant: a leaf, a patch.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// The stored f, photopic, 1/sr.
    pub value: f64,
    /// Once round: projections (x, y) of unit vectors that point away from the surface; chords of its curved edges.
    pub outline: Vec<DVec2>,
}

impl Cell {
    /// The image under `at` of a rectangle whose edges are drawn in `steps` chords each, along x and along y.
    pub(crate) fn new(
        value: f64,
        [low, high]: [DVec2; 2],
        steps: [usize; 2],
        at: impl Fn(DVec2) -> DVec2,
    ) -> Self {
        let corners = [low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)];
        let edges = (0..4).flat_map(|n| {
            let (from, to, steps) = (corners[n], corners[(n + 1) % 4], steps[n % 2].max(1));
            (0..steps).map(move |k| from.lerp(to, k as f64 / steps as f64))
        });
        Self { value, outline: edges.map(at).collect() }
    }
}

impl Bsdf {
    /// The leaves or patches by which light from `wi` to `scattered` is answered, for pictures; those of a smooth reading are
    /// the stored ones. Lambertian parts, interpolants and render forms have none.
    ///
    /// Exact but for chords in place of curves: outlines of one component cover the hemisphere once. A lone
    /// transmission of rank 3 has none against its direction of travel: there its cells are no rectangles.
    /// Invalid: none for NaN. Cost: 0.1 µs a cell.
    pub fn cells(&self, wi: DVec3, scattered: Side) -> Vec<Cell> {
        if wi.is_nan() {
            return Vec::new();
        }
        let answering = self.answering(Side::of(wi), scattered);
        let of = answering.flat_map(|(_, c, sense)| {
            let distribution = c.distribution();
            distribution.stored().unwrap_or(distribution).cells(wi, sense)
        });
        of.collect()
    }
}
