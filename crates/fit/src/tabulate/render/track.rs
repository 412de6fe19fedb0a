//! Peaks followed from one incidence to the next.

use bsdfkit::render::{Chart, Frame};
use bsdfkit_sphere::{DVec2, DVec3};

use super::probe::Sides;
use crate::source::{Slice, Source};

/// A peak at one incidence.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seed {
    wi: DVec3,
    /// Direction cosines.
    pub(super) at: DVec2,
    value: f64,
}

/// Cells along each axis of direction cosines in which peaks are looked for.
const GRID: usize = 128;

/// Most peaks of an incidence.
const MOST: usize = 5;

/// Peaks nearer than this, in direction cosines, are one.
const APART: f64 = 0.05;

/// A peak has at least this part of the brightest one's value.
const FAINTEST: f64 = 0.02;

/// First and last step of a climb.
const STEPS: [f64; 2] = [0.02, 0.0003];

/// How far from where it is expected a followed peak may be found.
const STRAYED: f64 = 0.06;

fn lifted(xy: DVec2) -> DVec3 {
    xy.extend((1.0 - xy.length_squared()).max(0.0).sqrt())
}

/// Where one climbs to from `from`, and the value there.
fn climb(of: &dyn Fn(&[DVec3]) -> Vec<f64>, from: DVec2) -> (DVec2, f64) {
    let mut at = from.clamp_length_max(0.999);
    let mut value = of(&[lifted(at)])[0];
    let mut step = STEPS[0];
    let mut turns = 0;
    while step > STEPS[1] && turns < 60 {
        let around: Vec<DVec2> = (0..8)
            .map(|k| at + DVec2::from_angle(f64::from(k) * std::f64::consts::FRAC_PI_4) * step)
            .map(|xy| xy.clamp_length_max(0.999))
            .collect();
        let wo: Vec<DVec3> = around.iter().map(|&xy| lifted(xy)).collect();
        let found = of(&wo);
        let best = (0..8).fold(0, |best, k| if found[k] > found[best] { k } else { best });
        if found[best] > value {
            (at, value) = (around[best], found[best]);
        } else {
            step *= 0.5;
        }
        turns += 1;
    }
    (at, value)
}

fn values<'a>(
    source: &'a dyn Source,
    sides: Sides,
    wi: DVec3,
) -> impl Fn(&[DVec3]) -> Vec<f64> + 'a {
    let slice: Box<dyn Slice + 'a> = sides.slice(source, wi);
    move |wo| sides.of_slice(source, &*slice, wo)
}

/// The peaks of an incidence, brightest first.
pub(super) fn peaks(source: &dyn Source, wi: DVec3) -> Vec<Seed> {
    let of = values(source, Sides::of(source), wi);
    let step = 2.0 / GRID as f64;
    let cell = |n: usize| {
        let (i, j) = (n % GRID, n / GRID);
        DVec2::new(i as f64 + 0.5, j as f64 + 0.5) * step - 1.0
    };
    let inside: Vec<usize> =
        (0..GRID * GRID).filter(|&n| cell(n).length_squared() < 0.99).collect();
    let wo: Vec<DVec3> = inside.iter().map(|&n| lifted(cell(n))).collect();
    let mut grid = vec![0.0; GRID * GRID];
    inside.iter().zip(of(&wo)).for_each(|(&n, value)| grid[n] = value);
    let near = [-1, 1, -(GRID as isize), GRID as isize];
    let top = |n: usize| {
        let of = |d: &isize| grid.get(n.wrapping_add_signed(*d)).copied().unwrap_or(0.0);
        grid[n] > 0.0 && near.iter().all(|d| grid[n] >= of(d))
    };
    let mut starts: Vec<usize> = inside.into_iter().filter(|&n| top(n)).collect();
    starts.sort_by(|&a, &b| grid[b].total_cmp(&grid[a]));
    starts.truncate(4 * MOST);
    let mut found: Vec<Seed> = Vec::new();
    for start in starts {
        let (at, value) = climb(&of, cell(start));
        if found.iter().all(|s| s.at.distance(at) > APART) {
            found.push(Seed { wi, at, value });
        }
    }
    found.sort_by(|a, b| b.value.total_cmp(&a.value));
    let faintest = found.first().map_or(0.0, |s| s.value * FAINTEST);
    found.retain(|s| s.value >= faintest);
    found.truncate(MOST);
    found
}

impl Seed {
    /// Whether the peak is where `frame` has its own.
    pub(super) fn is_at(&self, frame: &Frame) -> bool {
        law(frame, self.wi).distance(self.at) < APART
    }

    /// Where it is.
    pub(super) fn direction(&self) -> DVec3 {
        lifted(self.at)
    }

    /// What is to be added to the law of `frame` at each node of the finer chart.
    pub(super) fn track(&self, source: &dyn Source, chart: &Chart, frame: &Frame) -> Vec<[f32; 2]> {
        let fine = chart.refined(2);
        let wi: Vec<DVec3> = (0..fine.nodes()).map(|n| fine.direction(n)).collect();
        let mut order: Vec<usize> = (0..wi.len()).collect();
        order.sort_by(|&a, &b| {
            wi[a].distance_squared(self.wi).total_cmp(&wi[b].distance_squared(self.wi))
        });
        let sides = Sides::of(source);
        let mut moved = vec![DVec2::ZERO; wi.len()];
        let mut value = vec![0.0; wi.len()];
        let mut known: Vec<usize> = Vec::new();
        for node in order {
            let nearest = known.iter().copied().min_by(|&a, &b| {
                wi[a].distance_squared(wi[node]).total_cmp(&wi[b].distance_squared(wi[node]))
            });
            let (before, bright) = match nearest {
                Some(n) => (moved[n], value[n]),
                None => (self.at - law(frame, self.wi), self.value),
            };
            let expected = law(frame, wi[node]) + before;
            (moved[node], value[node]) = (before, bright);
            if expected.length() < 0.999 {
                let (at, found) = climb(&values(source, sides, wi[node]), expected);
                if at.distance(expected) < STRAYED && found > 0.1 * bright && at.length() < 0.995 {
                    (moved[node], value[node]) = (at - law(frame, wi[node]), found);
                }
            }
            known.push(node);
        }
        moved.into_iter().map(|m| [m.x as f32, m.y as f32]).collect()
    }
}

/// Where `frame` has its peak without what is added.
fn law(frame: &Frame, wi: DVec3) -> DVec2 {
    let [x, y] = frame.law;
    let at = DVec2::new(x[0] * wi.x + x[1] * wi.y, y[0] * wi.x + y[1] * wi.y);
    match frame.kind {
        bsdfkit::render::FrameKind::Slopes => -wi.truncate(),
        bsdfkit::render::FrameKind::Cosines => at + DVec2::from_array(frame.offset),
    }
}
