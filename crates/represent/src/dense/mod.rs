//! Functions that files of others hold whole: they answer values as they are, without a fit.

use std::fmt;

use bsdfkit::DVec3;

use crate::source::{Peak, Slice, Source};

mod nodes;

pub use nodes::{around, between};

/// A function on a grid that covers all incident directions of one side.
pub trait Dense: Source + Send + fmt::Debug {
    /// Incident directions of the grid.
    fn incidences(&self) -> usize;

    /// What it is a table over, in words.
    fn structure(&self) -> &'static str;
}

/// Where what is glossy peaks: the mirror direction of `wi`, and about how wide.
pub fn mirror_peak(slice: &dyn Slice, wi: DVec3, channels: usize) -> Peak {
    let direction = DVec3::new(-wi.x, -wi.y, wi.z);
    let across = DVec3::new(-wi.y, wi.x, 0.0).try_normalize().unwrap_or(DVec3::X);
    let mut values = vec![0.0; channels];
    let mut value = |w: DVec3| {
        slice.eval(&[w], &mut values);
        values[0]
    };
    let middle = value(direction);
    // The width where f has fallen to that of one standard deviation, sought among halves of a radian.
    let mut widths = (1..9).map(|k| 0.5_f64.powi(k));
    let within = |r: &f64| value((direction + *r * across).normalize()) > 0.6 * middle;
    Peak { direction, radius: widths.find(within).unwrap_or(1.0 / 512.0) }
}
