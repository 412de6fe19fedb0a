//! Which frames, how large tables and how many nodes.

use bsdfkit::render::{Chart, Fold, Frame, RenderTable, Shape, View};
use bsdfkit::{DVec2, DVec3, Result};
use rayon::prelude::*;

use super::build;
use super::plan::{PLAIN, Plan, Planned, bytes, cosines, slopes};
use super::probe::Probe;
use super::settings::{RenderReport, RenderSettings};
use super::stretch;
use super::track::{Seed, peaks};
use crate::source::Source;
use crate::watch::Watch;

/// How strongly nodes are drawn to the horizon: with less, blends fail beyond 75 degrees, with more at 45.
const GRAZING: f64 = 3.0;

/// Sizes of tables to choose from: angles and radii of values, then of densities.
const SIZES: [[usize; 4]; 5] =
    [[24, 32, 16, 20], [32, 44, 20, 28], [44, 56, 28, 36], [60, 72, 36, 44], [80, 96, 44, 56]];

/// Which of them frames are compared with.
const COMPARED: usize = 1;

/// Intervals of the chart that frames are compared on: of a line, of a square.
const COARSE: [usize; 2] = [14, 8];

/// Incidences between nodes that are looked at, and nodes.
const PROBES: [usize; 2] = [10, 5];

/// Largest angle from the normal that is looked at: its cosine.
const LOWEST: f64 = 0.12;

/// More layers are worth it if the error falls to this: of twice the layers half the nodes fit into the same bytes, and
/// blending is twice as far off.
const WORTH: f64 = 0.5;

/// Most intervals: of a line, of a square.
const MOST: [usize; 2] = [96, 40];

/// Width of a peak over the distance from which cells widen.
const CORE: f64 = 0.6;

/// The form of a layer's tables.
fn shape(frame: Frame, size: usize, fold: Fold, channels: usize, width: f64) -> Shape {
    let [angles, radii, drawn_angles, drawn_radii] = SIZES[size];
    let half = |n: usize| if fold == Fold::IsotropicMirrored { n / 2 } else { n };
    let colour = channels == 3;
    Shape {
        frame,
        angles: half(angles),
        radii,
        core: (CORE * width).clamp(0.003, 0.3),
        far: far(&frame),
        colour_angles: if colour { half(angles) / 2 } else { 0 },
        colour_radii: if colour { radii / 2 } else { 0 },
        drawn_angles: half(drawn_angles),
        drawn_radii,
        value_unit: 1.0,
        drawn_unit: 1.0,
    }
}

/// The same with tables of another size.
fn resized(shape: &Shape, size: usize, fold: Fold, channels: usize) -> Shape {
    Shape { core: shape.core, ..self::shape(shape.frame, size, fold, channels, 0.1) }
}

/// How far from the peak of a frame the hemisphere reaches, up to 75 degrees of incidence.
fn far(frame: &Frame) -> f64 {
    let Ok(chart) = Chart::new(Fold::None, 1, 1.0) else { return 1.0 };
    let mut far = 0.0_f64;
    for (theta, turn) in (0..4).flat_map(|t| (0..8).map(move |k| (25.0 * f64::from(t), k))) {
        let (sin, cos) = f64::to_radians(theta).sin_cos();
        let wi = (DVec2::from_angle(f64::from(turn) * 0.785) * sin).extend(cos);
        let view = View::new(&chart, frame, wi, DVec2::ZERO);
        for k in 0..16 {
            let rim = DVec2::from_angle(f64::from(k) * 0.393).extend(0.0);
            far = far.max(view.squared(rim).sqrt());
        }
    }
    far
}

/// Incidences between nodes: of the finer chart, those that are none of the coarser; or nodes.
fn incidences(chart: &Chart, between: bool, count: usize) -> Vec<DVec3> {
    let fine = if between { chart.refined(2) } else { *chart };
    let high = |w: &DVec3| w.z > LOWEST;
    let node = |w: &DVec3| chart.blend(*w).iter().any(|(_, weight)| *weight > 0.99);
    let all = (0..fine.nodes()).map(|n| fine.direction(n)).filter(high);
    let all: Vec<DVec3> = all.filter(|w| node(w) != between).collect();
    let step = all.len() as f64 / count as f64;
    let at = |k: usize| ((k as f64 + 0.37) * step) as usize;
    (0..count).filter_map(|k| all.get(at(k)).copied()).collect()
}

/// A source, and incidences at which plans are judged.
struct Judge<'a> {
    source: &'a dyn Source,
    fold: Fold,
    coarse: Chart,
    /// Between nodes, and at them.
    probes: [Vec<Probe>; 2],
    watch: Watch<'a>,
}

impl Judge<'_> {
    /// Mean error of a plan on the coarse chart, between nodes or at them.
    fn error(&self, plan: &Plan, at_nodes: bool) -> Result<f64> {
        let probes = &self.probes[usize::from(at_nodes)];
        let about = probes.iter().flat_map(|p| plan.chart.blend(p.wi));
        let mut nodes: Vec<usize> = about.map(|(node, _)| node).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let table = build::partial(self.source, plan, &nodes, &self.watch)?;
        let sum: f64 = probes.par_iter().map(|p| p.error(&table).0).sum();
        Ok(sum / probes.len().max(1) as f64)
    }

    fn planned(&self, frame: Frame, seed: Option<Seed>) -> Vec<Planned> {
        let extent = stretch::of(self.source, &self.coarse, &frame);
        let of = |stretch: [f64; 3]| {
            let frame = Frame { stretch, ..frame };
            let moved = seed.map_or(Vec::new(), |s| s.track(self.source, &self.coarse, &frame));
            let shape = shape(frame, COMPARED, self.fold, 1, extent.width);
            Planned { shape, seed, moved }
        };
        std::iter::once(PLAIN).chain(extent.stretch).map(of).collect()
    }
}

/// Where light is mirrored or goes straight through, where it came from, and the normal.
fn frames() -> [Frame; 4] {
    [slopes(PLAIN), cosines(-1.0, PLAIN), cosines(1.0, PLAIN), cosines(0.0, PLAIN)]
}

/// Most peaks that are followed each by itself.
const MOST_SEEDS: usize = 5;

/// Incidences at which peaks are looked for.
const LOOKED_AT: usize = 4;

impl Judge<'_> {
    /// Layers about peaks that are at none of the usual places, each followed over the coarse chart.
    fn followed(&self) -> Vec<Planned> {
        let mut all: Vec<Planned> = Vec::new();
        let aslant =
            incidences(&self.coarse, false, 40).into_iter().filter(|w| (0.5..0.8).contains(&w.z));
        let aslant: Vec<DVec3> = aslant.collect();
        let step = aslant.len().div_ceil(LOOKED_AT).max(1);
        let normal = DVec3::new(0.01, 0.004, 1.0).normalize();
        for wi in std::iter::once(normal).chain(aslant.into_iter().step_by(step)) {
            for seed in peaks(self.source, wi) {
                let usual = frames()[1..3].iter().any(|f| seed.is_at(f));
                let plan = Plan { chart: self.coarse, layers: all.clone() };
                let known = plan.views(wi).iter().any(|view| view.squared(seed.direction()) < SAME);
                if !usual && !known && all.len() < MOST_SEEDS {
                    let layers = self.planned(cosines(-1.0, PLAIN), Some(seed));
                    all.extend(layers.into_iter().next());
                }
            }
        }
        all
    }

    /// The layers of `plan` without which it is no worse, taken away one by one.
    fn pruned(&self, mut plan: Plan, mut error: f64) -> Result<(f64, Plan)> {
        let mut n = plan.layers.len();
        while n > 0 && plan.layers.len() > 1 {
            n -= 1;
            let mut without = plan.clone();
            without.layers.remove(n);
            let found = self.error(&without, false)?;
            if found < NEEDLESS * error {
                (error, plan) = (found, without);
            }
        }
        Ok((error, plan))
    }
}

/// Square of the distance within which two peaks are one.
const SAME: f64 = 0.002;

/// A layer is needless if without it the error rises less than this.
const NEEDLESS: f64 = 1.1;

/// The plan that comes nearest to the source.
pub(super) fn plan(
    source: &dyn Source,
    fold: Fold,
    settings: &RenderSettings,
    watch: &Watch<'_>,
) -> Result<Plan> {
    let line = usize::from(!fold.is_isotropic());
    let coarse = Chart::new(fold, COARSE[line], GRAZING)?;
    let mut judge = Judge {
        source,
        fold,
        coarse,
        probes: [Vec::new(), Vec::new()],
        watch: Watch { progress: None, ..*watch },
    };
    let pool: Vec<Planned> = frames().into_iter().flat_map(|f| judge.planned(f, None)).collect();
    let followed = judge.followed();
    // Quadratures about each place where a peak may be.
    let plain =
        pool.iter().filter(|l| l.shape.frame.stretch == PLAIN && l.shape.frame != frames()[1]);
    let about = Plan { chart: coarse, layers: plain.chain(&followed).cloned().collect() };
    judge.probes = [true, false].map(|between| {
        let at = incidences(&coarse, between, PROBES[usize::from(!between)]);
        at.into_par_iter().map(|wi| Probe::new(source, wi, &about.views(wi))).collect()
    });
    let mut chosen: Option<(f64, Plan)> = None;
    for _ in 0..2 {
        let mut best: Option<(f64, Plan)> = None;
        for layer in &pool {
            let mut layers = chosen.as_ref().map_or(Vec::new(), |(_, plan)| plan.layers.clone());
            layers.push(layer.clone());
            let plan = Plan { chart: coarse, layers };
            let error = judge.error(&plan, false)?;
            if best.as_ref().is_none_or(|(least, _)| error < *least) {
                best = Some((error, plan));
            }
        }
        let worth = |found: f64| chosen.as_ref().is_none_or(|(least, _)| found < WORTH * least);
        match best {
            Some(found) if worth(found.0) => chosen = Some(found),
            _ => break,
        }
    }
    let Some((mut between, mut plan)) = chosen else { return Ok(about) };
    if !followed.is_empty() {
        let mut all = plan.clone();
        all.layers.extend(followed);
        let error = judge.error(&all, false)?;
        if error < WORTH * between {
            (between, plan) = judge.pruned(all, error)?;
        }
    }
    sized(&judge, &plan, between, settings)
}

/// The plan with the smallest tables and fewest nodes that are near enough; or the nearest that memory allows for.
fn sized(judge: &Judge<'_>, plan: &Plan, between: f64, settings: &RenderSettings) -> Result<Plan> {
    let (fold, channels) = (judge.fold, judge.source.channels());
    let line = usize::from(!fold.is_isotropic());
    let coarse = judge.coarse.intervals() as f64;
    let with = |size: usize, channels: usize| -> Plan {
        let layer =
            |l: &Planned| Planned { shape: resized(&l.shape, size, fold, channels), ..l.clone() };
        Plan { chart: plan.chart, layers: plan.layers.iter().map(layer).collect() }
    };
    let mut at_nodes = [0.0; SIZES.len()];
    for (size, error) in at_nodes.iter_mut().enumerate() {
        *error = judge.error(&with(size, 1), true)?;
    }
    // What blending adds falls as the square of the nodes' distance.
    let blending = (between - at_nodes[COMPARED]).max(0.1 * between) * coarse * coarse;
    let mut best: Option<(bool, f64, usize, Chart)> = None;
    for (size, at_nodes) in at_nodes.into_iter().enumerate() {
        let made = with(size, channels);
        for intervals in 4..=MOST[line] {
            let chart = Chart::new(fold, intervals, GRAZING)?;
            let bytes = bytes(&chart, made.layers.iter().map(|l| &l.shape), channels);
            if bytes > settings.max_bytes {
                break;
            }
            let error = at_nodes + blending / (intervals * intervals) as f64;
            let enough = error <= settings.max_error;
            // Of those that are near enough the smallest, else the nearest.
            let rank = if enough { bytes as f64 } else { error };
            let better = best.as_ref().is_none_or(|(was, least, ..)| match (enough, *was) {
                (true, false) => true,
                (false, true) => false,
                _ => rank < *least,
            });
            if better {
                best = Some((enough, rank, size, chart));
            }
        }
    }
    let Some((_, _, size, chart)) = best else { return Ok(plan.clone()) };
    Ok(with(size, channels).on(judge.source, chart))
}

/// What came of it.
pub(super) fn report(source: &dyn Source, plan: &Plan, table: &RenderTable) -> RenderReport {
    let errors: Vec<f64> = incidences(table.chart(), true, PROBES[0])
        .into_par_iter()
        .map(|wi| Probe::new(source, wi, &plan.views(wi)).error(table).0)
        .collect();
    RenderReport {
        bytes: table.bytes(),
        nodes: table.chart().nodes(),
        layers: table.layers().len(),
        error: errors.iter().sum::<f64>() / errors.len().max(1) as f64,
    }
}
