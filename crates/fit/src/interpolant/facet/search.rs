//! Which facets explain the peaks of the measured incidences.

use bsdfkit::{DVec2, DVec3};

use crate::interpolant::facet::facet::{Facet, NEAR, Passed, Seen};
use crate::interpolant::facet::facets::{Facets, Followed};
use crate::interpolant::facet::refracted_lobe::{Shape, direction};
use crate::interpolant::mesh::incidence_mesh::IncidenceMesh;
use crate::lobe::{Covariance, Lobe, LobeSet};
use bsdfkit_measure::frame::Frame;

/// Indices tried first: from water to heavy glass. The refinement bridges the gaps.
const INDICES: [f64; 5] = [1.35, 1.45, 1.55, 1.65, 1.8];
/// A facet's normal leans at least so far (3 degrees): what is not refracted ends nowhere.
const TILTED: f64 = 0.05;
/// Root of the mean square distance between a facet's peaks and the measured ones, at most: half a
/// degree.
const PLACED: f64 = 0.01;
/// Peaks have no say in a facet that are so many times as far from where it has them as half of them are, ...
const OUTLYING: f64 = 4.0;
/// ... and not close even so: two that run into one another, or that the horizon cuts.
const CLOSE: f64 = 0.005;
/// Peaks below this share of their incidence's energy are not looked at.
const SEEN: f64 = 0.03;
/// Incidences that show a facet's peak, at least: of three numbers each, more than four times its
/// unknowns.
const HITS: usize = 6;
/// One in so many may miss it, where few show it two: with one in ten and nine hits a facet was lost to one
/// incidence close to where it reflects, and L1 went from 0.024 to 0.08.
const MISSED: usize = 6;
/// Peaks from which facets are guessed, at most.
const SEEDS: usize = 60;
/// A lobe that covers so many times as much as a peak is no part of it. A guess.
const WIDE: f64 = 3.0;
/// Facets looked for, at most: a guess, structures have two or three.
const MOST: usize = 8;

impl Facets {
    /// Looks for facets that explain the peaks of the vertices. `energy`: directional-hemispherical
    /// values there.
    ///
    /// Cost: about 0.1 ms a vertex and facet.
    pub(crate) fn of(
        mesh: &IncidenceMesh,
        lobes: &[LobeSet],
        energy: &[f64],
        frame: Frame,
    ) -> Self {
        let mut seen: Vec<Vec<Seen>> = (0..lobes.len())
            .map(|v| peaks_of(v, mesh.vertices[v].wi, &lobes[v], energy[v], frame))
            .collect();
        let mut areas = Vec::new();
        let mut found = Self {
            facets: Vec::new(),
            of: lobes.iter().map(|s| vec![None; s.lobes.len()]).collect(),
        };
        while found.facets.len() < MOST
            && let Some((facet, hits, near)) = next(mesh, &seen)
        {
            let mut say = vec![1.0; lobes.len()];
            let mut extents = Vec::new();
            for Seen { vertex, lobes: of, passed } in hits {
                let Some(own) = facet.pass(mesh.vertices[vertex].wi) else { continue };
                let off = own.u.distance(passed.u);
                // Where it is not the facet's it is no guide: the horizon cuts it.
                say[vertex] = (near / off.max(near)).powi(2);
                if off <= near {
                    let parts = of.iter().map(|&i| lobes[vertex].lobes[i as usize]);
                    extents.push((own.u, together(parts)));
                }
                for &i in &of {
                    found.of[vertex][i as usize] = Some(found.facets.len() as u8);
                }
                seen[vertex].retain(|s| s.lobes != of);
            }
            let shape = Shape::kept(&extents, frame);
            found.facets.push(Followed { facet, shape, say, at: Vec::new() });
            let area = extents.iter().map(|(_, c)| c.determinant().sqrt()).sum::<f64>();
            areas.push(area / extents.len().max(1) as f64);
        }
        found.adopt(mesh, lobes, &areas, frame);
        found.placed(mesh, frame)
    }

    /// Lets lobes that are not parts of a peak explained follow the facet whose peak should be where
    /// they are: peaks run into one another, and have wings. `areas`: what each facet's peaks cover.
    fn adopt(&mut self, mesh: &IncidenceMesh, lobes: &[LobeSet], areas: &[f64], frame: Frame) {
        for ((vertex, set), of) in mesh.vertices.iter().zip(lobes).zip(&mut self.of) {
            let at = frame.at(vertex.wi);
            let centres: Vec<Option<DVec2>> =
                self.facets.iter().map(|f| Some(at.forward(f.facet.pass(vertex.wi)?.u))).collect();
            for (lobe, of) in set.lobes.iter().zip(of).filter(|(_, of)| of.is_none()) {
                let precision = lobe.covariance.inverse();
                let off = |k: usize| {
                    let narrow = lobe.covariance.determinant().sqrt() < WIDE * areas[k];
                    let off = precision.quadratic(lobe.mean - centres[k]?);
                    (narrow && off < 9.0).then_some((off, k as u8))
                };
                let nearest = (0..centres.len()).filter_map(off);
                *of = nearest.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, k)| k);
            }
        }
    }
}

/// The facet that explains most of what is left, its peaks, and how near to it they are that have a say.
fn next(mesh: &IncidenceMesh, seen: &[Vec<Seen>]) -> Option<(Facet, Vec<Seen>, f64)> {
    let all: Vec<&Seen> = seen.iter().flatten().collect();
    let step = all.len().div_ceil(SEEDS).max(1);
    let guesses = all.iter().step_by(step).flat_map(|s| {
        INDICES.iter().filter_map(|&n| Facet::through(mesh.vertices[s.vertex].wi, s.passed, n))
    });
    let (mut facet, hits, _) = guesses
        .filter(|f| f.leans() > TILTED)
        .map(|f| (f, f.explains(mesh, seen, NEAR)))
        .map(|(f, (hits, missed))| (f, hits.len(), missed))
        .max_by_key(|&(_, hits, missed)| hits as i64 - missed as i64)?;
    if hits < HITS / 2 {
        return None;
    }
    let (mut off, mut near) = (Vec::new(), NEAR);
    for _ in 0..5 {
        let (hits, _) = facet.explains(mesh, seen, near);
        (facet, off) = facet.refined(mesh, &hits);
        let usual = off.get(off.len() / 2).copied().unwrap_or(NEAR);
        near = near.min((OUTLYING * usual).max(CLOSE));
    }
    let off = (off.iter().map(|d| d * d).sum::<f64>() / off.len().max(1) as f64).sqrt();
    let (hits, missed) = facet.explains(mesh, seen, NEAR);
    let holds = hits.len() >= HITS && MISSED * missed <= hits.len().max(2 * MISSED) && off < PLACED;
    let hits = hits.into_iter().cloned().collect();
    (holds && facet.leans() > TILTED).then_some((facet, hits, near))
}

/// The covariance of lobes taken together.
pub(super) fn together(lobes: impl Iterator<Item = Lobe> + Clone) -> Covariance {
    let mass: f64 = lobes.clone().map(|l| l.mass).sum();
    let mean = lobes.clone().map(|l| l.mass * l.mean).sum::<DVec2>() / mass;
    lobes.fold(Covariance::isotropic(0.0), |sum, l| {
        let (d, c, w) = (l.mean - mean, l.covariance, l.mass / mass);
        let own = Covariance { xx: c.xx + d.x * d.x, xy: c.xy + d.x * d.y, yy: c.yy + d.y * d.y };
        Covariance::combine(1.0, sum, w, own)
    })
}

/// The peaks of a vertex: where they are and their energy.
fn peaks_of(vertex: usize, wi: DVec3, set: &LobeSet, energy: f64, frame: Frame) -> Vec<Seen> {
    let total = set.total() + std::f64::consts::PI * set.floor;
    let at = frame.at(wi);
    let seen = |lobes: Vec<u16>| {
        let of = |i: &u16| set.lobes[*i as usize];
        let mass: f64 = lobes.iter().map(|i| of(i).mass).sum();
        let mean = lobes.iter().map(|i| direction(&of(i), &at)).sum::<DVec3>().normalize_or_zero();
        let passed = Passed { u: mean.truncate(), energy: energy * mass / total.max(1e-300) };
        (mass > SEEN * total && mean.z > 0.0).then_some(Seen { vertex, lobes, passed })
    };
    set.peaks().into_iter().filter_map(seen).collect()
}
