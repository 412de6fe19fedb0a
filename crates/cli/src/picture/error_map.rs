//! A picture of errors over incident directions.

use std::path::Path;

use bsdfkit::{DVec3, Error, Result, Side};

use crate::picture::canvas::{CAPTION, Canvas, FAINT, SUPER, Scale, TEXT, type_size};
use crate::picture::raster::Raster;

/// The errors of one component.
pub(crate) struct ErrorMap {
    /// Words under it.
    pub(crate) title: String,
    /// Incident directions with their errors.
    pub(crate) spots: Vec<(DVec3, f64)>,
    /// The error everywhere.
    pub(crate) field: Raster,
}

/// Pixels across one disk.
const SIZE: usize = 360;

impl ErrorMap {
    /// `error` gives the error at each of many incident directions of the front hemisphere.
    pub(crate) fn new(
        title: String,
        spots: Vec<(DVec3, f64)>,
        error: impl FnOnce(&[DVec3]) -> Vec<f64>,
    ) -> Self {
        Self { title, spots, field: Raster::of(SIZE * SUPER, Side::Front, error) }
    }
}

/// Draws the maps side by side, colours logarithmic and the same in all.
///
/// Errors: io; argument where no error is above zero.
pub(crate) fn save(path: &Path, maps: &[ErrorMap], words: &str) -> Result<()> {
    const MARGIN: usize = 18;
    let width = MARGIN + maps.len() * (SIZE + MARGIN);
    let captioned = MARGIN + SIZE + 12;
    let mut canvas = Canvas::new(width, captioned + 94);
    let scale = scale(maps)?;
    for (k, map) in maps.iter().enumerate() {
        let left = MARGIN + k * (SIZE + MARGIN);
        canvas.disk(&map.field, &scale, left, MARGIN);
        for &(w, error) in &map.spots {
            canvas.spot((w.x, w.y), (SIZE, left, MARGIN), error, &scale);
        }
        canvas.text(&map.title, left + SIZE / 2, captioned, CAPTION, TEXT);
    }
    canvas.bar(&scale, (width - SIZE) / 2, captioned + 28, SIZE, 10);
    canvas.text(words, width / 2, captioned + 70, type_size(words, width), FAINT);
    canvas.save(path)
}

/// From the least to the largest error shown, at most three decades.
fn scale(maps: &[ErrorMap]) -> Result<Scale> {
    let errors = |m: &ErrorMap| {
        let spots: Vec<f64> = m.spots.iter().map(|s| s.1).collect();
        m.field.known().chain(spots).filter(|e| *e > 0.0 && e.is_finite()).collect::<Vec<f64>>()
    };
    let all: Vec<f64> = maps.iter().flat_map(errors).collect();
    let (low, high) = all.iter().fold((f64::MAX, 0.0f64), |(l, h), &e| (l.min(e), h.max(e)));
    if high > 0.0 {
        Ok(Scale { low: low.max(1e-3 * high).min(0.5 * high), high })
    } else {
        Err(Error::argument("nothing to draw: no error is above zero"))
    }
}
