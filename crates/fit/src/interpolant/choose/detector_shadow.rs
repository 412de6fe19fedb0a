//! What the detector cannot see of one incidence, filled in from what its neighbours show there.
//!
//! In reflection the detector would stand in the light around the incident direction. Lobes go on
//! smoothly through such a hole, but a peak that lies in it (a mirror's at normal incidence) loses
//! its tip, or is not seen at all. The neighbours' holes are elsewhere: moved to this incidence and
//! matched to the points around the hole, they show it.

use std::f64::consts::TAU;

use bsdfkit::{DVec2, DVec3};

use crate::interpolant::component::fitted::Fitted;
use crate::interpolant::component::planned::{Peaks, Planned};
use crate::interpolant::incidence::fitted::FittedIncidence;
use crate::interpolant::motion::hypothesis::Motion;
use crate::lobe::leaves::{Leaf, bin};
use bsdfkit_measure::{Image, Incidence, Measurement, Symmetry};

/// Smaller holes hide nothing that the points around them do not show: a chord, 1.5 degrees.
const SMALLEST: f64 = 0.026;
/// Larger ones are no detector in the light, and the neighbours have seen no more: 10 degrees.
const LARGEST: f64 = 0.17;
/// As dense as around it, points would have been so many in the hole.
const MISSED: f64 = 8.0;
/// The points around a hole reach to so many of its radii.
const AROUND: f64 = 2.0;
/// Rings of points filled in; ring k has 6 k.
const RINGS: usize = 8;
/// Neighbours that are asked: all that share a cell with an incidence, and some more.
const NEIGHBOURS: usize = 12;
/// What they show must differ from the incidence's own fit by so many times what it misses the
/// points around the hole by, root mean squares.
const TELLING: f64 = 4.0;

/// A place around the incident direction where nothing was measured.
struct Hole {
    centre: DVec3,
    axes: [DVec3; 2],
    /// Chord to the nearest point.
    radius: f64,
    /// Numbers of the points around it.
    around: Vec<usize>,
}

impl Hole {
    fn of(i: &Incidence) -> Option<Self> {
        let distance = |w: DVec3| w.distance(i.wi);
        let radius = i.wo.iter().map(distance).fold(f64::MAX, f64::min);
        let near = |k: &usize| distance(i.wo.at(*k)) < AROUND * radius;
        let around: Vec<usize> = (0..i.wo.len()).filter(near).collect();
        let missed = around.len() as f64 / (AROUND * AROUND - 1.0);
        let (u, v) = i.wi.any_orthonormal_pair();
        let hides = radius > SMALLEST && radius < LARGEST && missed >= MISSED;
        hides.then_some(Self { centre: i.wi, axes: [u, v], radius, around })
    }

    /// Where a direction is, from the centre, in radii.
    fn place(&self, w: DVec3) -> DVec2 {
        DVec2::new(w.dot(self.axes[0]), w.dot(self.axes[1])) / self.radius
    }

    /// Directions in the hole, evenly.
    fn directions(&self) -> Vec<DVec3> {
        let ring = |k: usize| {
            let (r, count) = (k as f64 / RINGS as f64, (6 * k).max(1));
            (0..count).map(move |n| r * DVec2::from_angle(TAU * n as f64 / count as f64))
        };
        let direction = |p: DVec2| {
            (self.centre + self.radius * (p.x * self.axes[0] + p.y * self.axes[1])).normalize()
        };
        let above = |w: &DVec3| w.z * self.centre.z > 0.0;
        (0..RINGS).flat_map(ring).map(direction).filter(above).collect()
    }
}

/// log (measured / shown) around a hole: its mean, and its slope by the place.
struct Match {
    mean: f64,
    place: DVec2,
    slope: DVec2,
}

impl Match {
    /// Least squares, each axis by itself: around the whole hole they do not depend on each other.
    fn of(logs: &[(DVec2, f64)]) -> Self {
        let n = logs.len().max(1) as f64;
        let place = logs.iter().map(|l| l.0).sum::<DVec2>() / n;
        let mean = logs.iter().map(|l| l.1).sum::<f64>() / n;
        let (mut both, mut square) = (DVec2::ZERO, DVec2::splat(1e-9));
        for (p, log) in logs {
            both += (*p - place) * (log - mean);
            square += (*p - place) * (*p - place);
        }
        Self { mean, place, slope: both / square }
    }

    fn factor(&self, place: DVec2) -> f64 {
        (self.mean + self.slope.dot(place - self.place)).exp()
    }
}

/// Incidence `k` with points in its hole, if its neighbours show there what its own fit does not.
///
/// Cost: the mesh and plans of [`NEIGHBOURS`] incidences.
pub(crate) fn filled(
    m: &Measurement,
    motion: Motion,
    fitted: &Fitted,
    k: usize,
) -> Option<Incidence> {
    let (i, own, epsilon) = (&m.incidences[k], &fitted.incidences[k], fitted.epsilon);
    let hole = Some(i).filter(|_| m.incident == m.scattered).and_then(Hole::of)?;
    let others = fitted.with(neighbours(&fitted.incidences, k, m.symmetry));
    // What cannot be meshed, or only extrapolated, shows nothing.
    let others = Planned::new(others, motion, Peaks::Apart).ok();
    let others = others.filter(|others| others.is_measured(own.wi))?;
    let shown = others.at(own.wi);
    let (channels, y) = (m.colorimetry.channels(), m.colorimetry.luminance_channel());
    let measured = |n: &usize| i.value(*n, y);
    let log = |n: &usize| {
        let ratio = (measured(n).max(0.0) + epsilon) / (shown.eval(i.wo.at(*n)) + epsilon);
        (hole.place(i.wo.at(*n)), ratio.ln())
    };
    let matched = Match::of(&hole.around.iter().map(log).collect::<Vec<_>>());
    let factor = |w: DVec3| matched.factor(hole.place(w));

    let miss = |n: &usize| {
        let w = i.wo.at(*n);
        (w, factor(w) * shown.eval(w) - measured(n))
    };
    let missed = structure(&bin(hole.around.iter().map(miss)));
    let inside = hole.directions();
    let fit = |w: DVec3| own.eval(motion.frame, epsilon, w.truncate());
    let news = |w: &DVec3| (factor(*w) * shown.eval(*w) - fit(*w)).powi(2);
    let news = inside.iter().map(news).sum::<f64>() / inside.len() as f64;
    if news < TELLING * TELLING * missed {
        return None;
    }
    let mut whole = i.clone();
    // The fit has luminance, then X and Z; other channels are not fitted.
    let mut values = vec![0.0; own.details.len()];
    for w in inside {
        shown.eval_channels(w, &mut values);
        let rest = values.iter().skip(1).chain(std::iter::repeat(&values[0]));
        let mut rest = rest.copied();
        let channel = |c: usize| if c == y { values[0] } else { rest.next().unwrap_or(values[0]) };
        whole.wo.push(w);
        whole.values.extend((0..channels).map(channel).map(|v| (factor(w) * v) as f32));
    }
    Some(whole)
}

/// The mean square of differences, without what the scatter of their points explains: to be sure of that, its
/// own uncertainty at least.
fn structure(leaves: &[Leaf]) -> f64 {
    let (mut square, mut noise, mut area, mut count) = (0.0, 0.0, 1e-12, 1.0);
    for leaf in leaves.iter().filter(|l| l.count > 1) {
        square += leaf.value.powi(2) * leaf.area;
        noise += leaf.variance * leaf.area;
        area += leaf.area;
        count += 1.0;
    }
    (square - noise).max(noise / f64::sqrt(count)) / area
}

/// The incidences nearest to `k`, itself left out.
fn neighbours(fitted: &[FittedIncidence], k: usize, symmetry: Symmetry) -> Vec<FittedIncidence> {
    let wi = fitted[k].wi;
    let distance = |f: &FittedIncidence| {
        if symmetry == Symmetry::Isotropic {
            return (f.wi.z - wi.z).abs();
        }
        let image = |i: &Image| i.apply(f.wi).distance(wi);
        symmetry.images().iter().map(image).fold(f64::MAX, f64::min)
    };
    let others = fitted.iter().enumerate().filter(|(n, _)| *n != k);
    let mut others: Vec<(f64, &FittedIncidence)> = others.map(|(_, f)| (distance(f), f)).collect();
    others.sort_by(|a, b| a.0.total_cmp(&b.0));
    others.truncate(NEIGHBOURS);
    others.into_iter().map(|(_, f)| f.clone()).collect()
}
