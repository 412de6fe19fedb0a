//! A file whose values and totals are asked for as a view sees its bands.

use std::path::Path;

use bsdfkit::spectrum::{View, Weights};
use bsdfkit::{Bsdf, Components, DVec3, Error, Result, Xyz};

use super::load::{Loaded, Reading, bsdf, load};
use super::surface::Surface;

/// A BSDF, and what is made of its bands where it is stored; an interpolant sees for itself.
pub(crate) struct Seen {
    pub(crate) bsdf: Bsdf,
    weights: Option<Weights>,
}

impl Seen {
    /// A file as asked for.
    ///
    /// Errors: as [`bsdf`]; argument, where a view is asked for of a stored BSDF that has no bands, or whose bands lack what the view weighs.
    pub(crate) fn open(path: &Path, reading: Reading) -> Result<Self> {
        let Some(view) = reading.view() else {
            return Ok(Self { bsdf: bsdf(path, reading)?, weights: None });
        };
        match load(path)? {
            Loaded { surface: Surface::Stored(stored), .. } => {
                let weights = weights(&stored, view).map_err(|e| e.context(path.display()))?;
                let bsdf = reading.looked_up(*stored, path)?;
                Ok(Self { bsdf, weights: Some(weights) })
            }
            _ => Ok(Self { bsdf: bsdf(path, reading)?, weights: None }),
        }
    }

    /// f in 1/sr of many pairs; of a view with one value X, Y and Z are that.
    pub(crate) fn eval_xyz(&self, wi: &[DVec3], wo: &[DVec3], out: &mut [Xyz]) -> Result<()> {
        let Some(weights) = &self.weights else { return self.bsdf.eval_xyz_many(wi, wo, out) };
        let mut all = self.bands(out.len())?;
        self.bsdf.eval_bands_many(wi, wo, &mut all)?;
        for (value, bands) in out.iter_mut().zip(rows(&all, weights)) {
            *value = colour(weights, bands);
        }
        Ok(())
    }

    /// Directional-hemispherical values of these components.
    pub(crate) fn totals(
        &self,
        wi: &[DVec3],
        components: Components,
        out: &mut [f64],
    ) -> Result<()> {
        let Some(weights) = &self.weights else {
            return self.bsdf.directional_hemispherical_many(wi, components, out);
        };
        let mut all = self.bands(out.len())?;
        self.bsdf.directional_hemispherical_bands_many(wi, components, &mut all)?;
        for (value, bands) in out.iter_mut().zip(rows(&all, weights)) {
            *value = colour(weights, bands).y;
        }
        Ok(())
    }

    /// Room for the bands of so many results.
    fn bands(&self, results: usize) -> Result<Vec<f64>> {
        Ok(vec![0.0; results * self.bsdf.expect_wavelengths()?.count()])
    }
}

fn weights(stored: &Bsdf, view: View) -> Result<Weights> {
    let Some(bands) = stored.wavelengths() else {
        return Err(Error::argument(format!(
            "--view {view}: expected what was made of a spectral measurement, found a stored BSDF without bands"
        )));
    };
    view.weights(bands)
}

/// Bands of one result after the other.
fn rows<'a>(all: &'a [f64], weights: &Weights) -> impl Iterator<Item = &'a [f64]> {
    all.chunks_exact(weights.rows()[0].len().max(1))
}

fn colour(weights: &Weights, bands: &[f64]) -> Xyz {
    match weights.apply(bands).collect::<Vec<_>>()[..] {
        [x, y, z] => Xyz::new(x, y, z),
        [y] => Xyz::new(y, y, y),
        _ => Xyz::new(f64::NAN, f64::NAN, f64::NAN),
    }
}
