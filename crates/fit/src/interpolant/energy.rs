//! Energy of the interpolant: directional-hemispherical values are interpolated, not left to chance.
//!
//! Lobes that move toward the horizon lose part of their mass below it. Here the
//! directional-hemispherical values of the measured incidences are interpolated smoothly (and go
//! on smoothly past the last of them, never above 1), and whatever the moved lobes give is scaled
//! to that.

use bsdfkit::{DVec3, Side};
use bsdfkit_sphere::concentric::square_to_hemisphere;
use bsdfkit_sphere::{DVec2, direction};
use rayon::prelude::*;

use super::component::{Component, Distribution};
use super::multiquadric::Multiquadric;
use crate::measurement::{Image, Symmetry};

/// log(wanted / raw) directional-hemispherical value over incident directions.
#[derive(Clone, Debug)]
pub struct Energy {
    correction: Multiquadric,
}

/// Cells across the square for one directional-hemispherical value; the peak of a lobe of 1
/// degree is then still integrated to 1 %.
const CELLS: usize = 72;
/// A correction beyond this factor is not believed.
const LIMIT: f64 = 30.0;

impl Energy {
    /// No correction.
    pub fn none() -> Self {
        Self { correction: Multiquadric::through(&[], &[]) }
    }

    /// Makes the correction of `component`, which must carry none yet.
    ///
    /// Cost: about 2 ms for each vertex, edge and triangle of the mesh within one fundamental domain.
    pub fn of(component: &Component) -> Self {
        let vertices = component.vertices();
        let isotropic = component.symmetry == Symmetry::Isotropic;
        let at_vertices: Vec<f64> = component
            .incidences
            .par_iter()
            .map(|i| component.at(i.wi).directional_hemispherical())
            .collect();
        let (places, values) =
            spread(vertices.iter().map(|v| (v.wi, at_vertices[v.incidence])), isotropic);
        let wanted = Multiquadric::through(&places, &values);
        let samples: Vec<(DVec3, f64)> = component
            .probes()
            .into_par_iter()
            .map(|(wi, corners)| {
                let raw = component.at(wi).directional_hemispherical();
                let (lo, hi) = corners
                    .iter()
                    .map(|&v| at_vertices[vertices[v as usize].incidence])
                    .fold((f64::MAX, 0.0f64), |(lo, hi), h| (lo.min(h), hi.max(h)));
                let play = 0.5 * (hi - lo) + 0.02;
                let target = if component.is_measured(wi) {
                    wanted.at(wi).clamp((lo - play).max(0.5 * lo), hi + play)
                } else {
                    wanted.at(wi).clamp(0.02 * lo, 1.0f64.max(hi))
                };
                (wi, (target.max(1e-9) / raw.max(1e-9)).clamp(1.0 / LIMIT, LIMIT).ln())
            })
            .collect();
        let images = component.symmetry.images();
        let known = vertices.iter().map(|v| (v.wi, 0.0));
        let probed =
            samples.iter().flat_map(|&(wi, c)| images.iter().map(move |i| (i.apply(wi), c)));
        let (places, values) = spread(known.chain(probed), isotropic);
        Self { correction: Multiquadric::through(&places, &values) }
    }

    /// The constants and the centres with weights, as stored.
    pub(super) fn parts(&self) -> (f64, f64, Vec<[f64; 4]>) {
        self.correction.parts()
    }

    /// From what [`Energy::parts`] gave.
    pub(super) fn from_parts(constant: f64, slope: f64, centres: &[[f64; 4]]) -> Self {
        Self { correction: Multiquadric::from_parts(constant, slope, centres) }
    }

    /// The factor on f at incident direction `wi` (front hemisphere, folded).
    pub fn factor(&self, wi: DVec3) -> f64 {
        self.correction.at(wi).exp()
    }
}

/// Values as centres of a function on the hemisphere, doubles removed; an isotropic chain is
/// repeated round the circle so that the function has no preferred azimuth.
fn spread(values: impl Iterator<Item = (DVec3, f64)>, isotropic: bool) -> (Vec<DVec3>, Vec<f64>) {
    let turns: u32 = if isotropic { 6 } else { 1 };
    let (mut places, mut kept): (Vec<DVec3>, Vec<f64>) = Default::default();
    for (w, v) in values {
        for k in 0..turns {
            let turned =
                Image::rotation_to(direction::from_degrees(90.0, f64::from(k) * 60.0)).apply(w);
            if places.iter().all(|p: &DVec3| p.distance(turned) > 1e-3) {
                places.push(turned);
                kept.push(v);
            }
        }
    }
    (places, kept)
}

impl Distribution<'_> {
    /// ∫ f cos θₒ dωₒ over the scattered hemisphere, by midpoint quadrature on the square.
    pub fn directional_hemispherical(&self) -> f64 {
        let step = 1.0 / CELLS as f64;
        let mut sum = 0.0;
        for i in 0..CELLS {
            for j in 0..CELLS {
                let s = DVec2::new(i as f64 + 0.5, j as f64 + 0.5) * step;
                sum += self.eval(square_to_hemisphere(s, Side::Front));
            }
        }
        sum * std::f64::consts::PI * step * step
    }
}
