//! What queries make of bands: luminance, colour, the sun, one wavelength.

use std::sync::Arc;

use bsdfkit::spectrum::{Bands, Illuminant, View};
use bsdfkit::{DVec3, Error, Result};

use crate::interpolant::answer::distribution::Distribution;
use bsdfkit_represent::{Peak, Slice};

/// Weights of bands in the order in which sources answer: luminance first.
#[derive(Clone, Debug)]
pub(crate) struct Seen {
    pub(crate) view: View,
    /// One row a value, one weight a band.
    rows: Arc<[Vec<f32>]>,
    /// Whether nobody asked for it: then tables keep the bands, too.
    pub(crate) usual: bool,
}

impl Seen {
    /// Errors: as [`View::weights`].
    pub(crate) fn new(view: View, bands: &Bands) -> Result<Self> {
        if let View::Rgb(_) = view {
            return Err(Error::argument(format!(
                "{view}: expected a view of luminance or X, Y, Z, which queries answer: of RGB there are weights alone"
            )));
        }
        let weights = view.weights(bands)?;
        let row = |k: usize| weights.rows()[k].iter().map(|w| *w as f32).collect();
        let rows =
            if weights.rows().len() == 3 { [1, 0, 2].map(row).into() } else { [row(0)].into() };
        Ok(Self { view, rows, usual: false })
    }

    /// Colour in daylight, or the mean where bands do not tell it.
    pub(crate) fn usual(bands: &Bands) -> Self {
        let mean = || Seen {
            view: View::Mean,
            rows: [vec![1.0 / bands.count() as f32; bands.count()]].into(),
            usual: true,
        };
        let colour = Self::new(View::Colour(Illuminant::D65), bands);
        colour.map_or_else(|_| mean(), |seen| Self { usual: true, ..seen })
    }

    /// What luminance is of bands.
    pub(crate) fn luminance(&self) -> Vec<f64> {
        self.rows[0].iter().map(|w| f64::from(*w)).collect()
    }

    pub(crate) fn channels(&self) -> usize {
        self.rows.len()
    }
}

/// Directions whose bands are held together.
const BLOCK: usize = 64;

/// The scattering of one incident direction, as its bands are seen.
pub(crate) struct SeenSlice<'a> {
    pub(crate) of: Distribution<'a>,
    pub(crate) seen: &'a Seen,
}

impl Slice for SeenSlice<'_> {
    fn eval(&self, wo: &[DVec3], out: &mut [f32]) {
        let (channels, seen) = (self.of.channels(), self.seen.channels());
        let mut values = vec![0.0; channels * wo.len().min(BLOCK)];
        for (wo, out) in wo.chunks(BLOCK).zip(out.chunks_mut(BLOCK * seen)) {
            let values = &mut values[..channels * wo.len()];
            Slice::eval(&self.of, wo, values);
            for (point, out) in values.chunks_exact(channels).zip(out.chunks_exact_mut(seen)) {
                for (row, out) in self.seen.rows.iter().zip(out) {
                    *out = row.iter().zip(&point[1..]).map(|(w, v)| w * v).sum::<f32>().max(0.0);
                }
            }
        }
    }

    fn peaks(&self, out: &mut Vec<Peak>) {
        self.of.peaks(out);
    }
}
