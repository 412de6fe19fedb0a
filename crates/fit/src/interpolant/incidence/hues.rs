//! The spectra of a measurement's points in few numbers: all that a fit keeps of their bands.

use crate::interpolant::incidence::spectra::{Shown, basis_of, tell};
use crate::lobe::detail::Detail;
use bsdfkit::spectrum::Basis;
use bsdfkit_measure::{Incidence, Measurement, Symmetry};
use rayon::prelude::*;

/// Coefficients of every point, and the basis that they are of.
pub(crate) struct Hues {
    pub(crate) spectra: Basis,
    /// By incidence: as many numbers a point as there are coefficients.
    points: Vec<Vec<f32>>,
}

impl Hues {
    /// Those of `m`; `None` where it has no bands.
    ///
    /// Cost: that of the basis ([`basis_of`]), and a logarithm a band and point.
    pub(crate) fn of(m: &Measurement, epsilon: f64) -> Option<Self> {
        let spectra = basis_of(m, epsilon)?;
        let of = |i: &Incidence| {
            let mut shown = Shown::default();
            let mut all = Vec::with_capacity(i.wo.len() * spectra.rank());
            (0..i.wo.len()).for_each(|k| tell(&spectra, i.point(k), epsilon, &mut shown, &mut all));
            all
        };
        let points = m.incidences.par_iter().map(of).collect();
        Some(Self { spectra, points })
    }

    /// One detail a coefficient of incidence `k`, whose guide is `guide`, and its images.
    ///
    /// On cells twice as wide as the guide's: hue changes less from place to place than light does.
    pub(crate) fn fitted(
        &self,
        k: usize,
        guide: &Incidence,
        symmetry: Symmetry,
        epsilon: f64,
        cells: usize,
    ) -> Vec<Detail> {
        let rank = self.spectra.rank();
        let rows = guide.channel(0).zip(self.points[k].chunks_exact(rank));
        // What is bright counts more.
        let weight = |guide: f64| (guide.max(0.0) + epsilon) as f32;
        let values =
            rows.flat_map(|(g, row)| std::iter::once(weight(g)).chain(row.iter().copied()));
        let (wo, files) = (guide.wo.clone(), Vec::new());
        let alone = Incidence { wi: guide.wi, wo, values: values.collect(), files };
        let all = alone.with_images(symmetry);
        let of = |channel: usize| all.channel(channel).map(|v| v as f32).collect::<Vec<f32>>();
        let logs: Vec<Vec<f32>> = (1..=rank).map(of).collect();
        Detail::fit_each(all.wo.iter(), &logs, &of(0), cells / 2)
    }
}
