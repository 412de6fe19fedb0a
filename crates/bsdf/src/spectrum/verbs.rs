//! The verbs that answer a spectrum: values and totals of every band.

use std::f64::consts::FRAC_1_PI;

use bsdfkit_sphere::sequence::golden;

use super::bands::Bands;
use crate::component::Components;
use crate::query::Selected;
use crate::{Bsdf, DVec2, DVec3, Error, Result, Side};

/// Directions that tell the hue of a total: with 2048, even along the Hilbert curve, it is within .2 %.
const DRAWN: usize = 2048;

impl Bsdf {
    /// Wavelengths of the bands that [`Bsdf::eval_bands`] answers; `None` unless all components have the same ones.
    ///
    /// These are the bands of a spectral measurement, which all forms that are made of it may keep; [`Bsdf::bands`] are further
    /// functions that a file holds beside the visible.
    pub fn wavelengths(&self) -> Option<&Bands> {
        let mut all = self.components().iter().map(|c| c.distribution().wavelengths());
        let first = all.next()??;
        all.all(|other| other == Some(first)).then_some(first)
    }

    /// [`Bsdf::wavelengths`], or what is wrong.
    ///
    /// Errors: argument, without bands.
    pub fn expect_wavelengths(&self) -> Result<&Bands> {
        self.wavelengths().ok_or_else(|| {
            let found: Vec<String> = self
                .components()
                .iter()
                .map(|c| c.distribution().wavelengths().map_or("none".to_owned(), Bands::to_string))
                .collect();
            Error::argument(format!(
                "bands: expected a spectral BSDF, all of whose components have the same wavelengths, found {}",
                if found.is_empty() { "no components".to_owned() } else { found.join("; ") }
            ))
        })
    }

    /// f(wi, wo) in 1/sr of every band, shortest wavelength first: no cosine. `out` has as many elements as there are
    /// [`Bsdf::wavelengths`].
    ///
    /// Sides without data are dark. Lambertian parts that a file states beside its components are alike in all bands.
    /// Invalid: NaN in, NaN out.
    /// Errors: argument, without bands or for another length of `out`.
    /// Cost: that of a value, and some 10 ns a band.
    pub fn eval_bands(&self, wi: DVec3, wo: DVec3, out: &mut [f64]) -> Result<()> {
        self.expect_bands(1, out.len())?;
        self.bands_of(wi, &[wo], out);
        Ok(())
    }

    /// ∫ f |cos θo| dωo of every band over the selected components, peaks of no width included, which count alike in all
    /// bands: dimensionless. `out`: as for [`Bsdf::eval_bands`].
    ///
    /// `components` tell reflection from transmission; of what is not a peak of no width, all kinds count if any does.
    /// Accuracy: what bands weigh in light is [`Bsdf::directional_hemispherical`]; its hue is told by 2048 directions drawn from
    /// f, within .2 %. The same at every call. Invalid: NaN in, NaN out.
    /// Errors: as [`Bsdf::eval_bands`].
    /// Cost: 2048 samples and spectra, about 1 ms; of an interpolant some ms more.
    pub fn directional_hemispherical_bands(
        &self,
        wi: DVec3,
        components: Components,
        out: &mut [f64],
    ) -> Result<()> {
        self.expect_bands(1, out.len())?;
        self.bands_of_total(wi, components, out);
        Ok(())
    }

    /// Errors: argument, unless `length` is that of so many spectra.
    pub(crate) fn expect_bands(&self, count: usize, length: usize) -> Result<()> {
        let expected = count * self.expect_wavelengths()?.count();
        if length != expected {
            return Err(Error::argument(format!(
                "out: expected {expected} elements, one a band and result, found {length}"
            )));
        }
        Ok(())
    }

    /// [`Bsdf::eval_bands`] of one incident direction and several scattered ones.
    pub(crate) fn bands_of(&self, wi: DVec3, wo: &[DVec3], out: &mut [f64]) {
        let bands = out.len() / wo.len().max(1);
        for side in [Side::Front, Side::Back] {
            let on_side = |n: &usize| Side::of(wo[*n]) == side;
            let numbers: Vec<usize> = (0..wo.len()).filter(on_side).collect();
            if numbers.is_empty() {
                continue;
            }
            let some: Vec<DVec3> = numbers.iter().map(|n| wo[*n]).collect();
            let found = self.bands_to(side, wi, &some, bands);
            for (n, found) in numbers.into_iter().zip(found.chunks_exact(bands)) {
                out[n * bands..][..bands].copy_from_slice(found);
            }
        }
    }

    /// The same, scattered to one side.
    fn bands_to(&self, scattered: Side, wi: DVec3, wo: &[DVec3], bands: usize) -> Vec<f64> {
        let incident = Side::of(wi);
        let flat = self.explicit_lambertian().get(incident, scattered).y * FRAC_1_PI;
        let mut sums = vec![flat; bands * wo.len()];
        let mut values = vec![0.0; sums.len()];
        for (_, c, sense) in self.answering(incident, scattered) {
            if c.is_negligible() {
                values.fill(c.floor().y);
            } else {
                c.distribution().spectra(wi, wo, sense, &mut values);
            }
            sums.iter_mut().zip(&values).for_each(|(sum, value)| *sum += value);
        }
        for (sums, wo) in sums.chunks_exact_mut(bands).zip(wo) {
            if wi.is_nan() || wo.is_nan() {
                sums.fill(f64::NAN);
            }
        }
        sums
    }

    /// [`Bsdf::directional_hemispherical_bands`] of bands that are there.
    pub(crate) fn bands_of_total(&self, wi: DVec3, components: Components, out: &mut [f64]) {
        out.fill(if wi.is_nan() { f64::NAN } else { 0.0 });
        if components.intersects(Components::LAMBERTIAN | Components::DIRECTIONAL_DIFFUSE) {
            self.add_hue(&self.selected(wi, components.smooth()), wi, out);
        }
        let peaks: f64 = self.specular_peaks(wi, components).map(|p| p.coefficient.y).sum();
        out.iter_mut().for_each(|out| *out += peaks);
    }

    /// Adds the total of what is selected in every band.
    fn add_hue(&self, selected: &Selected<'_>, wi: DVec3, out: &mut [f64]) {
        let total = selected.total();
        let even = |k: usize| (k as f64 + 0.5) / DRAWN as f64;
        // Tables take two numbers as they are, others one by the Hilbert curve.
        let drawn = |k: usize| match self.prepares() {
            true => selected.sample(even(k)),
            false => selected.sample(DVec2::new(even(k), golden(k))),
        };
        let drawn: Vec<_> = (0..DRAWN).filter_map(drawn).filter(|s| s.pdf > 0.0).collect();
        let wo: Vec<DVec3> = drawn.iter().map(|s| s.wo).collect();
        let mut bands = vec![0.0; out.len() * wo.len()];
        self.bands_of(wi, &wo, &mut bands);
        let mut sums = vec![0.0; out.len()];
        let mut light = 0.0;
        for (sample, bands) in drawn.iter().zip(bands.chunks_exact(out.len())) {
            let share = sample.wo.z.abs() / sample.pdf;
            light += sample.weight;
            sums.iter_mut().zip(bands).for_each(|(sum, f)| *sum += share * f);
        }
        if light > 0.0 {
            out.iter_mut().zip(&sums).for_each(|(out, sum)| *out += total * sum / light);
        }
    }
}
