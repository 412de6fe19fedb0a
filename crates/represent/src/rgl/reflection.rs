//! What a file answers between its nodes, as Mitsuba's `measured` does.

use std::f64::consts::TAU;

use bsdfkit::Side;
use bsdfkit::limits::MAGNITUDE;
use bsdfkit_sphere::{DVec2, DVec3};

use super::material::{Grid, Material, square};
use super::warp::Warp;
use crate::dense::{Dense, around, between, mirror_peak};
use crate::source::{Peak, Slice, Source};

/// The reflection of a file as a function: RGB as it is, spectra as they are seen in daylight (D65).
///
/// Differs from: Mitsuba, which hands negative values on; here they are 0.
#[derive(Debug)]
pub struct Reflection {
    material: Material,
    /// By slice: luminance, then X and Z of coloured materials.
    tables: Vec<Vec<Grid>>,
}

impl Reflection {
    /// Errors: the message, where spectra do not cover the visible.
    pub fn new(material: Material) -> Result<Self, String> {
        let colour = material.colour()?;
        let channels = if material.is_coloured() { 3 } else { 1 };
        let tables = (0..material.warps.len())
            .map(|s| material.tables(s, channels, colour.as_ref()))
            .collect();
        Ok(Self { material, tables })
    }

    /// What the file says of the specimen.
    pub fn description(&self) -> &str {
        &self.material.description
    }

    /// What is asked at an incident direction.
    fn at(&self, wi: DVec3) -> At<'_> {
        let m = &self.material;
        let turn = self.turn(wi);
        let wi = turned(wi, turn);
        let azimuth = azimuth_of(wi);
        let mut parts = Vec::new();
        for (p, along_phi) in self.between_azimuths(azimuth) {
            let theta = wi.truncate().length().atan2(wi.z);
            for (t, along_theta) in between(&m.thetas, theta) {
                let weight = along_phi * along_theta;
                if weight > 0.0 {
                    parts.push((weight, p * m.thetas.len() + t));
                }
            }
        }
        let warps = parts.iter().map(|(w, s)| (*w, &m.warps[*s])).collect();
        let origin = if m.is_isotropic() { azimuth } else { 0.0 };
        At { of: self, wi, turn, origin, parts, warps }
    }

    /// The signs of x and y of the image, under the symmetry of the file, that its azimuths hold.
    fn turn(&self, wi: DVec3) -> DVec2 {
        let m = &self.material;
        let images: &[DVec2] = match m.copies() {
            2 => &[DVec2::ONE, DVec2::NEG_ONE],
            4 => &[DVec2::ONE, DVec2::NEG_ONE, DVec2::new(-1.0, 1.0), DVec2::new(1.0, -1.0)],
            _ => return DVec2::ONE,
        };
        let outside = |turn: &DVec2| {
            let w = turned(wi, *turn);
            let past = (azimuth_of(w) - m.phis[0]).rem_euclid(TAU);
            let span = m.phis[m.phis.len() - 1] - m.phis[0];
            (past - span).max(0.0).min(TAU - past)
        };
        let nearest = images.iter().min_by(|a, b| outside(a).total_cmp(&outside(b)));
        nearest.copied().unwrap_or(DVec2::ONE)
    }

    /// The azimuths of the file about `phi` with their weights; around a whole turn the first comes after the last.
    fn between_azimuths(&self, phi: f64) -> [(usize, f64); 2] {
        let phis = &self.material.phis;
        if self.material.copies() == 1 {
            return around(phis, phi, TAU);
        }
        // Of part of a turn the image chosen lies within it, but for rounding.
        let past = (phi - phis[0]).rem_euclid(TAU);
        let span = phis[phis.len() - 1] - phis[0];
        let past = if past > 0.5 * (TAU + span) { 0.0 } else { past };
        between(phis, phis[0] + past)
    }
}

/// No zero has a sign here: along the normal it is 0.
fn azimuth_of(w: DVec3) -> f64 {
    (w.y + 0.0).atan2(w.x + 0.0)
}

fn turned(w: DVec3, turn: DVec2) -> DVec3 {
    DVec3::new(turn.x * w.x, turn.y * w.y, w.z)
}

impl Source for Reflection {
    fn incident(&self) -> Side {
        Side::Front
    }

    fn scattered(&self) -> Side {
        Side::Front
    }

    fn isotropic(&self) -> bool {
        self.material.is_isotropic()
    }

    fn channels(&self) -> usize {
        self.tables.first().map_or(1, Vec::len)
    }

    fn slice<'a>(&'a self, wi: DVec3) -> Box<dyn Slice + 'a> {
        Box::new(self.at(wi))
    }
}

impl Dense for Reflection {
    fn incidences(&self) -> usize {
        self.material.warps.len()
    }

    fn structure(&self) -> &'static str {
        "RGL's tables over warped half vectors"
    }
}

/// One incident direction.
struct At<'a> {
    of: &'a Reflection,
    /// In the file's part of the symmetry.
    wi: DVec3,
    turn: DVec2,
    /// Where azimuths of half vectors count from.
    origin: f64,
    /// Weights and slices.
    parts: Vec<(f64, usize)>,
    warps: Vec<(f64, &'a Warp)>,
}

impl At<'_> {
    fn value(&self, wo: DVec3, out: &mut [f32]) {
        let wo = turned(wo, self.turn);
        let m = (self.wi + wo).normalize_or_zero();
        if self.wi.z <= 0.0 || wo.z <= 0.0 || m == DVec3::ZERO {
            return out.fill(0.0);
        }
        let point = square(m, self.origin);
        let even = Warp::back(&self.warps, point);
        let factor = self.of.material.factor(point, self.wi) / wo.z;
        for (c, out) in out.iter_mut().enumerate() {
            let value = |s: usize| self.of.tables[s][c].at(even);
            let value: f64 = self.parts.iter().map(|(w, s)| w * value(*s)).sum();
            // A factor has no value where the file's areas vanish.
            let value = factor * value;
            *out = if value.is_nan() { 0.0 } else { value.clamp(0.0, MAGNITUDE) as f32 };
        }
    }
}

impl Slice for At<'_> {
    fn eval(&self, wo: &[DVec3], out: &mut [f32]) {
        let channels = self.of.channels();
        for (wo, out) in wo.iter().zip(out.chunks_exact_mut(channels)) {
            self.value(*wo, out);
        }
    }

    fn peaks(&self, out: &mut Vec<Peak>) {
        out.push(mirror_peak(self, turned(self.wi, self.turn), self.of.channels()));
    }
}
