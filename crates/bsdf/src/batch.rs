//! The five verbs over slices: what renderers and array languages call.
//!
//! Shapes: one result for each element of `out`. Each input has as many elements, or a single one
//! that counts for all. Errors: argument, for any other length; then nothing is written.
//!
//! Every result equals that of the single query, bit for bit, whatever the number of threads.
//! Cost: slices of at least [`PARALLEL`] results are shared out to rayon's current pool.

use rayon::prelude::*;

use crate::component::Components;
use crate::query::Sample;
use crate::{Bsdf, DVec2, DVec3, Error, Result, Xyz};

/// Results from which on several threads share the work: about a millisecond's worth.
pub const PARALLEL: usize = 1 << 14;

/// Results that one thread takes at a time. A guess: 0.1 ms outweighs handing it over.
const GRAIN: usize = 1 << 11;

/// A slice with one element for each result, or one for all.
#[derive(Clone, Copy)]
struct Input<'a, T> {
    values: &'a [T],
    /// 1, or 0 when one element counts for all.
    step: usize,
}

impl<'a, T: Copy> Input<'a, T> {
    fn new(name: &str, values: &'a [T], results: usize) -> Result<Self> {
        match values.len() {
            found if found == results => Ok(Self { values, step: 1 }),
            1 => Ok(Self { values, step: 0 }),
            found => Err(Error::argument(format!(
                "{name}: expected {results} elements (as many as results) or 1, found {found}"
            ))),
        }
    }

    #[inline]
    fn at(&self, n: usize) -> T {
        self.values[n * self.step]
    }
}

/// Fills `out`; `f` gets the number of a result.
fn fill<T: Send>(out: &mut [T], f: impl Fn(usize) -> T + Sync) {
    let fill_from = |first: usize, part: &mut [T]| {
        for (n, result) in part.iter_mut().enumerate() {
            *result = f(first + n);
        }
    };
    if out.len() < PARALLEL {
        fill_from(0, out);
    } else {
        out.par_chunks_mut(GRAIN).enumerate().for_each(|(n, part)| fill_from(n * GRAIN, part));
    }
}

impl Bsdf {
    /// [`Bsdf::eval`] of many pairs: f(wi, wo), 1/sr.
    pub fn eval_many(&self, wi: &[DVec3], wo: &[DVec3], out: &mut [f64]) -> Result<()> {
        let (wi, wo) = (Input::new("wi", wi, out.len())?, Input::new("wo", wo, out.len())?);
        fill(out, |n| self.eval(wi.at(n), wo.at(n)));
        Ok(())
    }

    /// [`Bsdf::eval_xyz`] of many pairs: f(wi, wo) in colour, 1/sr.
    pub fn eval_xyz_many(&self, wi: &[DVec3], wo: &[DVec3], out: &mut [Xyz]) -> Result<()> {
        let (wi, wo) = (Input::new("wi", wi, out.len())?, Input::new("wo", wo, out.len())?);
        fill(out, |n| self.eval_xyz(wi.at(n), wo.at(n)));
        Ok(())
    }

    /// [`Bsdf::pdf`] of many pairs, 1/sr.
    pub fn pdf_many(
        &self,
        wi: &[DVec3],
        wo: &[DVec3],
        components: Components,
        out: &mut [f64],
    ) -> Result<()> {
        let (wi, wo) = (Input::new("wi", wi, out.len())?, Input::new("wo", wo, out.len())?);
        fill(out, |n| self.pdf(wi.at(n), wo.at(n), components));
        Ok(())
    }

    /// [`Bsdf::directional_hemispherical`] of many incident directions.
    pub fn directional_hemispherical_many(
        &self,
        wi: &[DVec3],
        components: Components,
        out: &mut [f64],
    ) -> Result<()> {
        let wi = Input::new("wi", wi, out.len())?;
        fill(out, |n| self.directional_hemispherical(wi.at(n), components));
        Ok(())
    }

    /// [`Bsdf::projected_solid_angle`] of many directions or pairs: \[smallest, largest\], sr.
    pub fn projected_solid_angle_many(
        &self,
        wi: &[DVec3],
        wo: Option<&[DVec3]>,
        out: &mut [[f64; 2]],
    ) -> Result<()> {
        let results = out.len();
        let wi = Input::new("wi", wi, results)?;
        let wo = wo.map(|wo| Input::new("wo", wo, results)).transpose()?;
        fill(out, |n| self.projected_solid_angle(wi.at(n), wo.map(|wo| wo.at(n))).into());
        Ok(())
    }

    /// [`Bsdf::sample`] of many incident directions, each with its own `u`.
    pub fn sample_many(
        &self,
        wi: &[DVec3],
        u: &[f64],
        components: Components,
        out: &mut [Option<Sample>],
    ) -> Result<()> {
        let (wi, u) = (Input::new("wi", wi, out.len())?, Input::new("u", u, out.len())?);
        fill(out, |n| self.sample(wi.at(n), u.at(n), components));
        Ok(())
    }

    /// [`Bsdf::sample2`] of many incident directions, each with its own `u`.
    pub fn sample2_many(
        &self,
        wi: &[DVec3],
        u: &[DVec2],
        components: Components,
        out: &mut [Option<Sample>],
    ) -> Result<()> {
        let (wi, u) = (Input::new("wi", wi, out.len())?, Input::new("u", u, out.len())?);
        fill(out, |n| self.sample2(wi.at(n), u.at(n), components));
        Ok(())
    }
}
