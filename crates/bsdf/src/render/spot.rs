//! A scattered direction as the tables of a layer see it.

use super::frame::Placed;
use super::polar::{angle, scale};
use crate::DVec2;

/// Where a scattered direction is in the plane of a layer.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spot {
    /// x and y as tables have them.
    pub(crate) xy: DVec2,
    /// The place less that of the peak, before the plane is stretched.
    pub(crate) v: DVec2,
    /// Stretched: |x| + |y|.
    pub(crate) sum: f64,
    pub(crate) length: f64,
    pub(crate) length2: f64,
    /// The length on the scale that widens in proportion to it.
    pub(crate) scaled: f64,
    /// Quarters of a turn; of the half that stands for both.
    pub(crate) angle: f64,
}

impl Spot {
    #[inline(always)]
    pub(crate) fn new(placed: &Placed, xy: DVec2, z: f64, span: f64, over_core: f64) -> Self {
        let v = placed.apart(xy, z);
        let q = placed.stretched(v);
        let length2 = q.length_squared();
        let length = length2.sqrt();
        let folded = if span < 4.0 { DVec2::new(q.x, q.y.abs()) } else { q };
        Self {
            xy,
            v,
            sum: q.x.abs() + q.y.abs(),
            length,
            length2,
            scaled: scale(length * over_core),
            angle: angle(folded),
        }
    }
}
