//! What a prism's facet does to light: where its peak goes and how bright it is.
//!
//! Light enters through a plane, is refracted into index n, and leaves through a facet that leans, as
//! Snell and Fresnel have it. Near total reflection both place and energy of the peak change with
//! the square root of the way that is left, which no interpolation of measured values foresees; index and
//! lean of the facet, though, are told by all incidences together. [`super::facets`] asks which peaks
//! were made so.

use bsdfkit::{DVec2, DVec3};

use crate::interpolant::field::multiquadric::solve;
use crate::interpolant::mesh::incidence_mesh::IncidenceMesh;

/// A plane entrance, index n behind it, and an exit facet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Facet {
    index: f64,
    /// (x, y) of the facet's normal, which points out of the material.
    tilt: DVec2,
    /// Energy if nothing were reflected.
    share: f64,
}

/// A peak: where it is in the disk of scattered directions, and its energy.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Passed {
    pub(crate) u: DVec2,
    pub(crate) energy: f64,
}

/// A peak that was measured.
#[derive(Clone, Debug)]
pub(crate) struct Seen {
    pub(crate) vertex: usize,
    /// The lobes it is made of.
    pub(crate) lobes: Vec<u16>,
    pub(crate) passed: Passed,
}

/// Peaks are looked for so close to where a facet has them: 3.4 degrees near the normal, less than
/// peaks are apart and more than a guess from one peak is off.
pub(crate) const NEAR: f64 = 0.06;
/// And as bright as it has them within this factor's logarithm.
const BRIGHT: f64 = 0.5;
/// Peaks of less than this share of what a facet lets through at most are not missed: they are about
/// to end, or have.
const MISSED: f64 = 0.2;
/// Nor are those that may have run into a brighter one so close (9 degrees near the normal): two of 4 degrees
/// are one peak to the fit up to twice as far apart.
const MERGED: f64 = 0.15;
/// Standard errors of a peak's place, and of the logarithm of its energy: places decide, since
/// scattering about the facet changes how much leaves.
const ERRORS: [f64; 2] = [0.001, 0.05];

/// Transmittance of unpolarised light at a cosine outside of index n.
fn transmittance(cosine: f64, n: f64) -> f64 {
    let c = (1.0 - (1.0 - cosine * cosine) / (n * n)).max(0.0).sqrt();
    let (s, p) = ((cosine - n * c) / (cosine + n * c), (n * cosine - c) / (n * cosine + c));
    1.0 - 0.5 * (s * s + p * p)
}

/// The direction of travel behind a plane entrance, times n.
fn inside(wi: DVec3, index: f64) -> DVec3 {
    let p = wi.truncate();
    (-p).extend(-(index * index - p.length_squared()).max(0.0).sqrt())
}

impl Facet {
    /// Sine of the angle between entrance and facet.
    pub(crate) fn leans(&self) -> f64 {
        self.tilt.length()
    }

    /// The one of this index that refracts `wi` to where `seen` is.
    pub(crate) fn through(wi: DVec3, seen: Passed, index: f64) -> Option<Self> {
        let e = seen.u.extend(-(1.0 - seen.u.length_squared()).max(0.0).sqrt());
        let normal = (inside(wi, index) - e).normalize_or_zero();
        let facet = Self { index, tilt: normal.truncate(), share: 1.0 };
        let energy = facet.pass(wi)?.energy;
        (normal.z < 0.0).then_some(Self { share: seen.energy / energy.max(1e-9), ..facet })
    }

    /// What it does to light from `wi`; `None` where it reflects all.
    pub(crate) fn pass(&self, wi: DVec3) -> Option<Passed> {
        let n = self.index;
        let normal = self.tilt.extend(-(1.0 - self.tilt.length_squared()).max(0.0).sqrt());
        let d = inside(wi, n);
        let within = d.dot(normal);
        let c2 = 1.0 - n * n + within * within;
        if within <= 0.0 || c2 <= 0.0 {
            return None;
        }
        let c = c2.sqrt();
        let e = d + (c - within) * normal;
        let energy = self.share * transmittance(wi.z.abs(), n) * transmittance(c, n);
        (e.z < 0.0).then_some(Passed { u: e.truncate(), energy })
    }

    /// The measured peaks that it explains, at most `near` from where it has them, and how many it misses.
    pub(crate) fn explains<'a>(
        &self,
        mesh: &IncidenceMesh,
        seen: &'a [Vec<Seen>],
        near: f64,
    ) -> (Vec<&'a Seen>, usize) {
        let (mut hits, mut missed) = (Vec::new(), 0);
        for (vertex, peaks) in mesh.vertices.iter().zip(seen) {
            let Some(passed) = self.pass(vertex.wi) else { continue };
            let off = |s: &Seen| s.passed.u.distance(passed.u);
            let as_bright = |s: &Seen| (s.passed.energy / passed.energy).ln().abs() < BRIGHT;
            let close = peaks.iter().filter(|s| off(s) < near && as_bright(s));
            match close.min_by(|a, b| off(a).total_cmp(&off(b))) {
                Some(s) => hits.push(s),
                None if passed.energy > MISSED * self.share => {
                    let brighter = |s: &Seen| s.passed.energy > passed.energy && off(s) < MERGED;
                    missed += usize::from(!peaks.iter().any(brighter));
                }
                None => {}
            }
        }
        (hits, missed)
    }

    /// The facet that fits these peaks best, beginning from this one, and how far from it they are, the
    /// nearest first. Peaks about to end have no say: they move so fast there that the least error of
    /// theirs outweighs all others.
    pub(crate) fn refined(self, mesh: &IncidenceMesh, hits: &[&Seen]) -> (Self, Vec<f64>) {
        let bright = |s: &&&Seen| s.passed.energy > MISSED * self.share;
        let hits: &[&Seen] = &hits.iter().filter(bright).copied().collect::<Vec<_>>();
        let mut best = self;
        let (mut least, mut damping) = (f64::INFINITY, 1e-3);
        let mut next = best;
        for _ in 0..30 {
            let (residuals, share) = next.residuals(mesh, hits);
            let sum: f64 = residuals.iter().flatten().map(|r| r * r).sum();
            if sum < least {
                let done = sum > least * (1.0 - 1e-9);
                (best, least, damping) = (Self { share, ..next }, sum, damping * 0.3);
                if done {
                    break;
                }
            } else {
                damping *= 10.0;
            }
            let (residuals, _) = best.residuals(mesh, hits);
            // Normal equations, the right-hand side last.
            let mut normal = vec![vec![0.0; 4]; 3];
            let step = 1e-5;
            let slopes = DVec3::AXES.map(|axis| best.stepped(axis * step).residuals(mesh, hits).0);
            for (k, row) in residuals.iter().enumerate() {
                for (j, r) in row.iter().enumerate() {
                    let slope = [0, 1, 2].map(|a| (slopes[a][k][j] - r) / step);
                    for (row, s) in normal.iter_mut().zip(slope) {
                        (0..3).for_each(|a| row[a] += s * slope[a]);
                        row[3] -= s * r;
                    }
                }
            }
            (0..3).for_each(|a| normal[a][a] *= 1.0 + damping);
            let Some(by) = solve(normal) else { break };
            next = best.stepped(DVec3::new(by[0], by[1], by[2]));
        }
        let off = |s: &&Seen| {
            let passed = best.pass(mesh.vertices[s.vertex].wi);
            passed.map_or(1.0, |p| p.u.distance(s.passed.u))
        };
        let mut distances: Vec<f64> = hits.iter().map(off).collect();
        distances.sort_by(f64::total_cmp);
        (best, distances)
    }

    fn stepped(self, by: DVec3) -> Self {
        let index = (self.index + by.x).clamp(1.05, 3.0);
        Self { index, tilt: (self.tilt + DVec2::new(by.y, by.z)).clamp_length_max(0.99), ..self }
    }

    /// Place and energy of each peak less the facet's, in standard errors, and the share that makes
    /// energies equal in the mean.
    fn residuals(self, mesh: &IncidenceMesh, hits: &[&Seen]) -> (Vec<[f64; 3]>, f64) {
        let mut rows: Vec<[f64; 3]> = hits
            .iter()
            .map(|s| match self.pass(mesh.vertices[s.vertex].wi) {
                Some(passed) => {
                    let off = (s.passed.u - passed.u) / ERRORS[0];
                    let brighter = (s.passed.energy / passed.energy.max(1e-9)).ln() / ERRORS[1];
                    [off.x, off.y, brighter]
                }
                None => [30.0, 30.0, 30.0],
            })
            .collect();
        let mean = rows.iter().map(|r| r[2]).sum::<f64>() / rows.len().max(1) as f64;
        rows.iter_mut().for_each(|r| r[2] -= mean);
        (rows, self.share * (mean * ERRORS[1]).exp())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bsdfkit_measure::Symmetry;
    use bsdfkit_sphere::direction::from_degrees;

    fn mesh() -> IncidenceMesh {
        let mut wi = vec![DVec3::Z];
        for t in [15.0, 30.0, 45.0, 60.0] {
            wi.extend((0..12).map(|p| from_degrees(t, f64::from(p) * 30.0)));
        }
        IncidenceMesh::new(&wi, Symmetry::None).expect("mesh")
    }

    fn leaning(index: f64, degrees: f64, azimuth: f64, share: f64) -> Facet {
        let tilt = DVec2::from_angle(azimuth.to_radians()) * degrees.to_radians().sin();
        Facet { index, tilt, share }
    }

    /// The deviation of a prism in its principal section: sin i = n sin r, twice.
    #[test]
    fn in_the_principal_section_snells_law_holds_twice() {
        let (n, lean) = (1.5, 20.0f64);
        let facet = leaning(n, lean, 0.0, 1.0);
        for polar in [-30.0f64, -10.0, 0.0, 10.0] {
            // Light that comes from +x travels toward −x, and meets the facet the steeper.
            let within = (polar.to_radians().sin() / n).asin() + lean.to_radians();
            let out = (n * within.sin()).asin() - lean.to_radians();
            let wi = from_degrees(polar.abs(), if polar < 0.0 { 180.0 } else { 0.0 });
            let passed = facet.pass(wi).expect("transmitted");
            assert!((passed.u - DVec2::new(-out.sin(), 0.0)).length() < 1e-12, "{polar}");
            assert!(passed.energy > 0.8 && passed.energy < 0.93, "{}", passed.energy);
        }
        // Critical where n sin(within) = 1, at 33 degrees.
        let critical = n * ((1.0 / n).asin() - lean.to_radians()).sin();
        let at = |sine: f64| facet.pass(DVec3::new(sine, 0.0, (1.0 - sine * sine).sqrt()));
        assert!(at(critical - 1e-4).expect("transmitted").energy < 0.15);
        assert!(at(critical + 1e-4).is_none());
    }

    #[test]
    fn from_one_peak_guessed_and_from_all_of_them_found() {
        let mesh = mesh();
        for truth in [leaning(1.49, 25.0, 0.0, 0.6), leaning(1.62, 14.0, 130.0, 0.3)] {
            let peak = |vertex: usize| {
                let passed = truth.pass(mesh.vertices[vertex].wi)?;
                Some(Seen { vertex, lobes: vec![0], passed })
            };
            let seen: Vec<Vec<Seen>> =
                (0..mesh.vertices.len()).map(|v| peak(v).into_iter().collect()).collect();
            let guess = Facet::through(DVec3::Z, seen[0][0].passed, 1.55).expect("a facet");
            let (hits, missed) = guess.explains(&mesh, &seen, NEAR);
            assert!(hits.len() > 20 && missed < 6, "{} {missed}", hits.len());
            let (found, off) = guess.refined(&mesh, &hits);
            assert!((found.index - truth.index).abs() < 1e-6, "{found:?}");
            assert!(found.tilt.distance(truth.tilt) < 1e-6, "{found:?}");
            assert!(off.iter().all(|d| *d < 1e-6), "{off:?}");
            assert!((found.share / truth.share - 1.0).abs() < 1e-6, "{found:?}");
            assert_eq!(found.explains(&mesh, &seen, NEAR).0.len(), seen.iter().flatten().count());
        }
    }

    #[test]
    fn a_peak_about_to_end_does_not_move_the_facet() {
        let mesh = mesh();
        let (truth, lower) = (leaning(1.49, 25.0, 0.0, 0.6), leaning(1.465, 25.0, 0.0, 0.6));
        let seen = |facet: Facet, vertex: usize| {
            Some(Seen { vertex, lobes: vec![0], passed: facet.pass(mesh.vertices[vertex].wi)? })
        };
        let all = 0..mesh.vertices.len();
        let peaks: Vec<Seen> = all.clone().filter_map(|v| seen(truth, v)).collect();
        // What roughness lets through where all should be reflected.
        let ended = all.clone().filter(|&v| seen(truth, v).is_none());
        let late: Vec<Seen> = ended.filter_map(|v| seen(lower, v)).collect();
        assert!(late.iter().any(|s| s.passed.energy < MISSED * truth.share), "{late:?}");
        let hits: Vec<&Seen> = peaks.iter().chain(&late).collect();
        let (found, off) = lower.refined(&mesh, &hits);
        assert!((found.index - truth.index).abs() < 1e-6, "{found:?}");
        assert!(off.iter().all(|d| *d < 1e-6), "{off:?}");
    }
}
