//! What a measurement covers and how noisy it is: for `bsdf info`, and for whom weighs its points.

use std::f64::consts::PI;

use bsdfkit::{DVec2, DVec3};
use bsdfkit_sphere::{concentric, direction};
use rayon::prelude::*;
use serde::Serialize;

use super::extension::Extension;
use super::neighbours::Neighbours;
use super::noise::{self, median, quantile};
use super::pattern::Pattern;
use super::scant::{Sight, scant};
use super::seen::{Seen, limit};
use super::{Incidence, Measurement, Symmetry};
use crate::frame::Frame;
use bsdfkit::component::name_of_sides;

/// Coverage and noise of one component.
#[derive(Clone, Debug, Serialize)]
pub struct Quality {
    /// "front reflection", "front transmission", "back reflection" or "back transmission".
    pub component: String,
    /// As the files name the specimen.
    pub sample_name: Option<String>,
    /// What the values mean.
    pub colorimetry: String,
    /// The symmetry's name.
    pub symmetry: String,
    /// Points over all incidences.
    pub points: usize,
    /// One for each, in the measurement's order.
    pub incidences: Vec<IncidenceQuality>,
    /// What the reader noted.
    pub notes: Vec<String>,
    /// What too little was seen of, a sentence for each arrangement of points.
    pub scant: Vec<String>,
}

/// Coverage and noise of one incidence.
#[derive(Clone, Debug, Serialize)]
pub struct IncidenceQuality {
    /// Incident polar angle from +Z, 0–180.
    pub theta_degrees: f64,
    /// Incident azimuth.
    pub phi_degrees: f64,
    /// Measured points.
    pub points: usize,
    /// Points with a negative luminance: noise, kept.
    pub negatives: usize,
    /// Median distance from a point to its nearest one.
    pub spacing_degrees: f64,
    /// Largest scattered angle from the normal (of its own side) that was measured, 0–90.
    pub grazing_limit_degrees: f64,
    /// Regions without points below the grazing limit, largest first.
    pub holes: Vec<Hole>,
    /// Standard deviation of the noise that grows with the value, as a fraction of it.
    pub relative_noise: f64,
    /// Standard deviation of the noise that stays where there is no light, 1/sr.
    pub absolute_noise: f64,
    /// Where the points lie, in words.
    pub pattern: String,
    /// Share of the projected hemisphere that lies between points, or their images under the symmetry.
    pub seen: f64,
    /// ∫ f cos θo dωo over the measured side, one a channel. NaN where the part that was seen does not tell it.
    ///
    /// Of a plane, what peaks as wide across it as along it would scatter: the middle between what peaks that are round on
    /// the sphere, in direction cosines and in slopes of facets give. Directions that were not seen otherwise count as their nearest point.
    pub hemispherical: Vec<f64>,
    /// How far the least and the most of these are from the middle, one a channel; `None` but for a plane.
    pub hemispherical_uncertainty: Option<Vec<f64>>,
    /// What is scattered in directions that were seen, one a channel; NaN of too few points.
    pub hemispherical_at_least: Vec<f64>,
    /// Whether less of the hemisphere was seen than a total should rest on: [`Seen::ENOUGH`].
    pub extrapolated: bool,
}

/// The largest empty circle around a direction.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Hole {
    /// Polar angle of its centre from +Z, 0–180.
    pub theta_degrees: f64,
    /// Azimuth of its centre.
    pub phi_degrees: f64,
    /// Distance from its centre to the nearest point.
    pub radius_degrees: f64,
    /// It holds the incident direction: the detector would stand in the light.
    pub retro_reflection: bool,
}

/// Cells along a side of the square on which the hemisphere is integrated and searched: 16,384 equal projected solid
/// angles of about 0.8°. Doubled, each incidence takes 60 ms more.
const CELLS: usize = 128;

/// Parts along a side of a cell that differs from its neighbours: 0.2 degrees.
const PARTS: usize = 4;

/// Cells are steep that differ from a neighbour by so large a share of their value, or of the mean where that is larger.
/// Were none, the plateau of a real engineered diffuser would lose 5 % of its light.
const STEEP: f64 = 0.03;

/// Points whose neighbourhood is looked at for noise and spacing: a tenth of them still gives a quartile good to 7 %.
const QUERIES: usize = 4000;

/// Holes listed for an incidence.
const MOST_HOLES: usize = 8;

impl Measurement {
    /// Coverage and noise of every incidence. Cost: about 0.1 s for 50,000 points; parallel over incidences.
    pub fn quality(&self) -> Quality {
        let luminance = self.colorimetry.luminance_channel();
        let of = |i: &Incidence| i.qualities(luminance, self.symmetry);
        let (incidences, sights): (Vec<_>, Vec<_>) = self.incidences.par_iter().map(of).unzip();
        Quality {
            component: name_of_sides(self.incident, self.scattered).to_owned(),
            sample_name: self.sample_name.clone(),
            colorimetry: self.colorimetry.to_string(),
            symmetry: self.symmetry.to_string(),
            points: self.points(),
            incidences,
            notes: self.notes.clone(),
            scant: scant(&sights),
        }
    }
}

impl Incidence {
    /// Coverage and noise, noise and negatives of channel `luminance`; `symmetry` is the specimen's.
    pub fn quality(&self, luminance: usize, symmetry: Symmetry) -> IncidenceQuality {
        self.qualities(luminance, symmetry).0
    }

    fn qualities(&self, luminance: usize, symmetry: Symmetry) -> (IncidenceQuality, Sight) {
        let tree = Neighbours::new(&self.wo);
        let (sight, seen) = Sight::of(self, symmetry);
        let total = Total::of(self, symmetry, &sight, &seen);
        let (theta_degrees, phi_degrees) = direction::to_degrees(self.wi);
        let lowest = self.wo.iter().map(|w| w.z.abs()).fold(1.0, f64::min);
        let (relative_noise, absolute_noise) =
            noise::estimate(self, &tree, queries(self), luminance);
        let quality = IncidenceQuality {
            theta_degrees,
            phi_degrees,
            points: self.wo.len(),
            negatives: self.channel(luminance).filter(|v| *v < 0.0).count(),
            spacing_degrees: spacing(self, &tree),
            grazing_limit_degrees: lowest.acos().to_degrees(),
            holes: holes(self, &tree, lowest),
            relative_noise,
            absolute_noise,
            pattern: sight.pattern.to_string(),
            seen: sight.share,
            hemispherical: total.values,
            hemispherical_uncertainty: total.uncertainty,
            hemispherical_at_least: total.at_least,
            extrapolated: sight.is_scant(),
        };
        (quality, sight)
    }
}

/// Indices of at most [`QUERIES`] points, evenly through the file.
fn queries(incidence: &Incidence) -> impl Iterator<Item = usize> {
    let count = incidence.wo.len();
    (0..count).step_by(count.div_ceil(QUERIES).max(1))
}

/// Squared chord → angle in degrees.
fn chord_degrees(squared: f64) -> f64 {
    (2.0 * (squared.sqrt() / 2.0).min(1.0).asin()).to_degrees()
}

fn spacing(incidence: &Incidence, tree: &Neighbours) -> f64 {
    let nearest = |i| tree.nearest::<1>(incidence.wo.at(i), Some(i)).items().first().copied();
    let mut chords: Vec<f64> = queries(incidence).filter_map(nearest).map(|(d, _)| d).collect();
    chord_degrees(median(&mut chords))
}

/// The centre of cell (i, j) on the measured side.
fn cell(i: usize, j: usize, incidence: &Incidence) -> DVec3 {
    let square = DVec2::new(i as f64 + 0.5, j as f64 + 0.5) / CELLS as f64;
    let side = bsdfkit::Side::of(incidence.wo.at(0));
    concentric::square_to_hemisphere(square, side)
}

/// The light in all, one value a channel.
struct Total {
    values: Vec<f64>,
    uncertainty: Option<Vec<f64>>,
    at_least: Vec<f64>,
}

impl Total {
    /// What `sight` allows to say.
    fn of(incidence: &Incidence, symmetry: Symmetry, sight: &Sight, seen: &Seen) -> Self {
        let unknown = || vec![f64::NAN; incidence.channels()];
        if matches!(sight.pattern, Pattern::Direction { .. } | Pattern::Few { .. }) {
            return Self { values: unknown(), uncertainty: None, at_least: unknown() };
        }
        let all = incidence.with_images(symmetry);
        if !sight.is_scant() {
            let values = hemispherical(&all, |_| true);
            return Self { at_least: values.clone(), values, uncertainty: None };
        }
        let limit = limit(&all.wo);
        let at_least = hemispherical(&all, |w| w.truncate().length() <= limit && seen.holds(w));
        let round = |frame| Some(extended(&all, &Extension::of(&all, frame)?));
        let ways: Vec<Vec<f64>> =
            [Frame::Turned, Frame::Shift, Frame::Half].into_iter().filter_map(round).collect();
        // Where the peak may be beside the plane, its width along the plane tells nothing of it.
        if ways.is_empty() || !sight.specular {
            return Self { values: unknown(), uncertainty: None, at_least };
        }
        // None scatters more light than there is.
        let way = |c: usize| ways.iter().map(move |w| w[c].min(1.0));
        let bounds = (0..at_least.len())
            .map(|c| (way(c).fold(f64::MAX, f64::min), way(c).fold(f64::MIN, f64::max)));
        let (values, uncertainty) =
            bounds.map(|(low, high)| (0.5 * (low + high), 0.5 * (high - low))).unzip();
        Self { values, uncertainty: Some(uncertainty), at_least }
    }
}

/// The integral of what a plane lets expect, one a channel.
fn extended(incidence: &Incidence, extension: &Extension) -> Vec<f64> {
    let channels = incidence.channels();
    let cells = || (0..CELLS * CELLS).map(|k| cell(k / CELLS, k % CELLS, incidence).truncate());
    let sum = |c: usize| cells().map(|u| extension.value(c, u)).sum::<f64>();
    (0..channels).map(|c| sum(c) * PI / (CELLS * CELLS) as f64).collect()
}

/// The integral over the cells that `counts` takes, one a channel.
///
/// A cell has the mean of its points, or its nearest point where it has none. Where that differs from what its
/// neighbours have, points that lie on one side of a cell would speak for all of it: there, parts of
/// the cell have their nearest points.
fn hemispherical(incidence: &Incidence, counts: impl Fn(DVec3) -> bool) -> Vec<f64> {
    let tree = Neighbours::new(&incidence.wo);
    let channels = incidence.channels();
    let side = bsdfkit::Side::of(incidence.wo.at(0));
    let nearest = |square: DVec2| {
        let w = concentric::square_to_hemisphere(square / CELLS as f64, side);
        incidence.point(tree.nearest::<1>(w, None).items()[0].1)
    };
    let mut cells = vec![0.0; CELLS * CELLS * channels];
    let mut points = vec![0u32; CELLS * CELLS];
    for (index, w) in incidence.wo.iter().enumerate() {
        let square = concentric::hemisphere_to_square(w) * CELLS as f64;
        let at = |x: f64| (x as usize).min(CELLS - 1);
        let cell = at(square.x) * CELLS + at(square.y);
        points[cell] += 1;
        for (sum, value) in cells[cell * channels..].iter_mut().zip(incidence.point(index)) {
            *sum += f64::from(*value);
        }
    }
    let corner = |k: usize| DVec2::new((k / CELLS) as f64, (k % CELLS) as f64);
    for (k, (cell, &count)) in cells.chunks_exact_mut(channels).zip(&points).enumerate() {
        if count > 0 {
            cell.iter_mut().for_each(|sum| *sum /= f64::from(count));
        } else {
            let values = nearest(corner(k) + DVec2::splat(0.5));
            cell.iter_mut().zip(values).for_each(|(cell, v)| *cell = f64::from(*v));
        }
    }
    let level: Vec<f64> = cells.chunks_exact(channels).map(|c| c.iter().sum()).collect();
    let mean = level.iter().sum::<f64>() / level.len() as f64;
    let steep = |k: usize| {
        let (i, j) = (k / CELLS, k % CELLS);
        let beside = [
            (i > 0).then(|| k - CELLS),
            (i + 1 < CELLS).then_some(k + CELLS),
            (j > 0).then(|| k - 1),
            (j + 1 < CELLS).then_some(k + 1),
        ];
        let differs = |n: usize| (level[n] - level[k]).abs() > STEEP * level[k].max(mean);
        beside.into_iter().flatten().any(differs)
    };
    let mut total = vec![0.0; channels];
    for k in (0..CELLS * CELLS).filter(|&k| counts(cell(k / CELLS, k % CELLS, incidence))) {
        if !steep(k) {
            total.iter_mut().zip(&cells[k * channels..]).for_each(|(sum, v)| *sum += v);
            continue;
        }
        for part in 0..PARTS * PARTS {
            let part = DVec2::new((part / PARTS) as f64 + 0.5, (part % PARTS) as f64 + 0.5);
            let values = nearest(corner(k) + part / PARTS as f64);
            let share = 1.0 / (PARTS * PARTS) as f64;
            total.iter_mut().zip(values).for_each(|(sum, v)| *sum += share * f64::from(*v));
        }
    }
    total.iter().map(|t| t * PI / (CELLS * CELLS) as f64).collect()
}

/// Empty circles much larger than is usual between the points.
fn holes(incidence: &Incidence, tree: &Neighbours, lowest: f64) -> Vec<Hole> {
    /// Smaller ones hide nothing that a cell of the integral shows.
    const SMALLEST_DEGREES: f64 = 1.5;
    /// Radius over the distance to a point that nine in ten directions keep; between jittered sweeps it reaches 2.2.
    const UNUSUAL: f64 = 2.5;
    /// Directions further from a point than this many medians say nothing about what is usual: they may be the hole.
    const CLIPPED: f64 = 4.0;
    let gap = |w: DVec3| chord_degrees(tree.nearest::<1>(w, None).items()[0].0);
    let mut gaps: Vec<(f64, DVec3)> = (0..CELLS * CELLS)
        .map(|k| cell(k / CELLS, k % CELLS, incidence))
        .filter(|w| w.z.abs() >= lowest)
        .map(|w| (gap(w), w))
        .collect();
    let mut radii: Vec<f64> = gaps.iter().map(|g| g.0).collect();
    let clip = CLIPPED * median(&mut radii);
    radii.retain(|&r| r <= clip);
    let smallest = SMALLEST_DEGREES.max(UNUSUAL * quantile(&mut radii, 0.9));
    gaps.retain(|&(radius, _)| radius > smallest);
    gaps.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut holes: Vec<(f64, DVec3)> = Vec::new();
    for (radius, w) in gaps {
        let apart = |h: &(f64, DVec3)| h.1.angle_between(w).to_degrees() > h.0 + radius;
        if holes.len() < MOST_HOLES && holes.iter().all(apart) {
            holes.push(climb(w, lowest, &gap));
        }
    }
    holes
        .into_iter()
        .map(|(radius, w)| {
            let (theta_degrees, phi_degrees) = direction::to_degrees(w);
            let retro_reflection = incidence.wi.angle_between(w).to_degrees() < radius;
            Hole { theta_degrees, phi_degrees, radius_degrees: radius, retro_reflection }
        })
        .collect()
}

/// The radius and centre of the largest empty circle that uphill steps from `w` find below the grazing limit.
fn climb(mut w: DVec3, lowest: f64, gap: &impl Fn(DVec3) -> f64) -> (f64, DVec3) {
    let mut radius = gap(w);
    let mut step = 1.0 / CELLS as f64;
    while step > 1e-4 {
        let (u, v) = w.any_orthonormal_pair();
        let around = [u, -u, v, -v].map(|d| (w + step * d).normalize());
        let inside = around.into_iter().filter(|a| a.z.abs() >= lowest);
        let best = inside.map(|a| (gap(a), a)).max_by(|a, b| a.0.total_cmp(&b.0));
        match best.filter(|b| b.0 > radius + 1e-9) {
            Some(better) => (radius, w) = better,
            None => step /= 2.0,
        }
    }
    (radius, w)
}
