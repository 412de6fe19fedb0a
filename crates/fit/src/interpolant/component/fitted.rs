//! All incidences of one pair of sides, fitted.

use std::sync::Arc;

use bsdfkit::spectrum::Basis;
use bsdfkit::{DVec3, Side};
use rayon::prelude::*;

use crate::interpolant::incidence::fitted::FittedIncidence;
use crate::interpolant::incidence::hues::Hues;
use bsdfkit_measure::frame::Frame;
use bsdfkit_measure::{Measurement, Symmetry};

/// Fitted incidences, and what holds for all of them: the first step on the way to a component. Nothing moves yet.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// Side of the incident directions.
    pub incident: Side,
    /// Side of the scattered directions.
    pub scattered: Side,
    /// Symmetry of the specimen.
    pub symmetry: Symmetry,
    /// Small BSDF added to data and lobes before their ratio is taken, 1/sr.
    pub epsilon: f64,
    /// How bands are made of details, where bands were measured.
    pub spectra: Option<Arc<Basis>>,
    /// The measured incidences.
    pub incidences: Vec<FittedIncidence>,
}

impl Fitted {
    /// What was fitted to the incidences of `m`.
    pub(crate) fn to(m: &Measurement, epsilon: f64, incidences: Vec<FittedIncidence>) -> Self {
        let (incident, scattered, symmetry) = (m.incident, m.scattered, m.symmetry);
        Self { incident, scattered, symmetry, epsilon, spectra: None, incidences }
    }

    /// The same with other incidences.
    pub(crate) fn with(&self, incidences: Vec<FittedIncidence>) -> Self {
        Self { incidences, spectra: self.spectra.clone(), ..*self }
    }

    /// The same with bands, as the `hues` of the points of `guide` say.
    ///
    /// Cost: about that of two details an incidence.
    #[must_use]
    pub(crate) fn with_hues(mut self, hues: Hues, guide: &Measurement, cells: usize) -> Self {
        let (symmetry, epsilon) = (guide.symmetry, self.epsilon);
        let pairs = self.incidences.par_iter_mut().zip(&guide.incidences).enumerate();
        pairs.for_each(|(k, (fitted, seen))| {
            fitted.coefficients = hues.fitted(k, seen, symmetry, epsilon, cells);
        });
        self.spectra = Some(hues.spectra.into());
        self
    }

    /// All but incidence `k`.
    pub(crate) fn without(&self, k: usize) -> Self {
        let others = self.incidences.iter().enumerate().filter(|(i, _)| *i != k);
        self.with(others.map(|(_, incidence)| incidence.clone()).collect())
    }

    /// The same with directional-hemispherical values by quadrature of what was fitted, in `frame`: sums over leaves lack
    /// what was not seen.
    ///
    /// Cost: some milliseconds an incidence.
    #[must_use]
    pub(crate) fn integrated(mut self, frame: Frame) -> Self {
        let epsilon = self.epsilon;
        self.incidences.par_iter_mut().for_each(|i| {
            let at = frame.at(i.wi);
            i.hemispherical = i.distribution(&at, epsilon).directional_hemispherical();
        });
        self
    }

    /// The measured incident directions.
    pub fn directions(&self) -> Vec<DVec3> {
        self.incidences.iter().map(|i| i.wi).collect()
    }
}
