//! Spectra over slices.

use rayon::prelude::*;

use super::block::Input;
use super::runs::runs;
use crate::component::Components;
use crate::{Bsdf, DVec3, Result};

impl Bsdf {
    /// [`Bsdf::eval_bands`] of many pairs; `out`: (results, bands).
    ///
    /// Equal incident directions that follow each other share their set-up: of an interpolant values then differ from those of the
    /// single query by 1e-6 of themselves at most.
    ///
    /// Errors: argument, without bands, or for other lengths.
    pub fn eval_bands_many(&self, wi: &[DVec3], wo: &[DVec3], out: &mut [f64]) -> Result<()> {
        let mut rows = self.rows(out)?;
        let (wi, wo) = (Input::new("wi", wi, rows.len())?, Input::new("wo", wo, rows.len())?);
        runs(wi, &mut rows, |w, first, rows| {
            let to: Vec<DVec3> = (0..rows.len()).map(|n| wo.at(first + n)).collect();
            let bands = rows.first().map_or(1, |row| row.len());
            let mut found = vec![0.0; bands * rows.len()];
            self.bands_of(w, &to, &mut found);
            rows.iter_mut()
                .zip(found.chunks_exact(bands))
                .for_each(|(row, f)| row.copy_from_slice(f));
        });
        Ok(())
    }

    /// [`Bsdf::directional_hemispherical_bands`] of many incident directions; `out`: (results, bands).
    ///
    /// Errors: argument, without bands, or for other lengths.
    pub fn directional_hemispherical_bands_many(
        &self,
        wi: &[DVec3],
        components: Components,
        out: &mut [f64],
    ) -> Result<()> {
        let rows = self.rows(out)?;
        let wi = Input::new("wi", wi, rows.len())?;
        rows.into_par_iter()
            .enumerate()
            .for_each(|(n, row)| self.bands_of_total(wi.at(n), components, row));
        Ok(())
    }

    /// One row of bands a result.
    fn rows<'a>(&self, out: &'a mut [f64]) -> Result<Vec<&'a mut [f64]>> {
        let bands = self.expect_wavelengths()?.count();
        self.expect_bands(out.len() / bands, out.len())?;
        Ok(out.chunks_exact_mut(bands).collect())
    }
}
