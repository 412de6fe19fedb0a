//! Which layers, how large tables and how many nodes.

use bsdfkit::render::{Chart, Fold, Frame, FrameKind, Pose, RenderTable, Shape, View};
use bsdfkit::{DVec2, DVec3, Error, Result};
use rayon::prelude::*;

use super::build;
use super::fold;
use super::plan::{Beside, Plan, Planned, bytes};
use super::probe::{Probe, golden};
use super::settings::{RenderReport, RenderSettings};
use super::stretch;
use super::subject::{Course, Subject};
use crate::watch::Watch;

/// How strongly nodes may be drawn to the horizon: with 3 the first ring of 13 is 25 degrees from the normal, which peaks that
/// part do not bear, with 1 12, which metals do not past 75 degrees.
const GRAZING: [f64; 2] = [1.0, 3.0];

/// Sizes of tables to choose from: angles and radii of values, then of densities.
const SIZES: [[usize; 4]; 5] =
    [[24, 32, 16, 20], [32, 44, 20, 28], [44, 56, 28, 36], [60, 72, 36, 44], [80, 96, 44, 56]];

/// Which of them layers are compared with.
const COMPARED: usize = 1;

/// Intervals of the chart that layers are compared on: of a line, of a square.
const COARSE: [usize; 2] = [28, 16];

/// Intervals of the chart that peaks are followed on: of a line, of a square.
const TRACKED: [usize; 2] = [64, 24];

/// Incidences at the largest angle that is looked at.
const GRAZING_PROBES: u32 = 6;

/// Others, and nodes.
const PROBES: [usize; 2] = [16, 6];

/// Largest angle from the normal that is looked at: its cosine.
const LOWEST: f64 = 0.1;

/// Part of wrong energy between nodes that counts as error: factors, known at half their distance, take away the rest. A guess.
const ENERGY: f64 = 0.5;

/// Most intervals: of a line, of a square.
const MOST: [usize; 2] = [96, 40];

/// Widths of a peak from which on cells widen, and the farthest that cells go.
const CORE: f64 = 0.6;
const FARTHEST: f64 = 400.0;

/// The form of a layer's tables; how far they go is not known yet.
fn shape(frame: Frame, size: usize, fold: Fold, beside: Beside) -> Shape {
    let [angles, radii, drawn_angles, drawn_radii] = SIZES[size];
    let half = |n: usize| if fold == Fold::IsotropicMirrored { n / 2 } else { n };
    let colour = beside.coloured;
    Shape {
        frame,
        angles: half(angles),
        radii,
        core: CORE,
        far: 1.0,
        colour_angles: if colour { half(angles) / 2 } else { 0 },
        colour_radii: if colour { radii / 2 } else { 0 },
        drawn_angles: half(drawn_angles),
        drawn_radii,
        value_unit: 1.0,
        drawn_unit: 1.0,
    }
}

/// How far from a peak the hemisphere reaches, up to 75 degrees of incidence.
fn far(chart: &Chart, frame: Frame, poses: &[Pose]) -> f64 {
    let mut far = 1.0_f64;
    let step = poses.len().div_ceil(200);
    for (node, pose) in poses.iter().enumerate().step_by(step) {
        let wi = chart.direction(node);
        if wi.z > 0.25 {
            let view = View::new(chart, frame, wi, pose);
            for k in 0..16 {
                let rim = DVec2::from_angle(f64::from(k) * 0.393).extend(0.0);
                far = far.max(view.place(rim).length());
            }
        }
    }
    far.min(FARTHEST)
}

/// Incidences spread over the hemisphere, or the nodes nearest to them.
fn incidences(chart: &Chart, at_nodes: bool, count: usize) -> Vec<DVec3> {
    let spread = (0..count).map(|n| {
        let wi = golden(n, count);
        let r = wi.truncate() * (1.0 - LOWEST * LOWEST).sqrt();
        r.extend((1.0 - r.length_squared()).sqrt())
    });
    let grazing = (0..GRAZING_PROBES).map(|n| {
        let r = DVec2::from_angle(0.3 + f64::from(n) * 2.4) * (1.0 - LOWEST * LOWEST).sqrt();
        r.extend(LOWEST)
    });
    let spread = spread.chain(grazing);
    let nearest = |wi: DVec3| {
        let blend = chart.blend(wi);
        let node = blend.iter().max_by(|a, b| a.1.total_cmp(&b.1));
        node.map_or(wi, |&(node, _)| chart.direction(node))
    };
    spread.map(|wi| if at_nodes { nearest(wi) } else { wi }).collect()
}

/// A plan of these layers on a chart, its tables of this size and wide enough.
fn sized_plan(
    subject: &Subject<'_>,
    layers: &[Planned],
    chart: Chart,
    size: usize,
    beside: Beside,
) -> Plan {
    let resized = |l: &Planned| {
        let shape = shape(l.shape.frame, size, chart.fold(), beside);
        let hue = if beside.rank > 0 { [shape.angles / 2, shape.radii / 2] } else { [0; 2] };
        Planned { shape, hue, ..l.clone() }
    };
    let mut plan = Plan::new(subject, chart, layers.iter().map(resized).collect());
    let fine = chart.refined(2);
    for (layer, poses) in plan.layers.iter_mut().zip(&plan.poses) {
        layer.shape.far = far(&fine, layer.shape.frame, poses);
    }
    plan
}

/// A material, and incidences at which plans are judged.
struct Judge<'a> {
    subject: &'a Subject<'a>,
    fold: Fold,
    grazing: f64,
    coarse: Chart,
    /// Anywhere, and at nodes.
    probes: [Vec<Probe>; 2],
    watch: Watch<'a>,
}

/// Where light is mirrored or goes straight through, where it came from, and the normal.
const LAWS: [Frame; 4] = [
    Frame { kind: FrameKind::Slopes, factor: -1.0 },
    Frame { kind: FrameKind::Cosines, factor: -1.0 },
    Frame { kind: FrameKind::Cosines, factor: 1.0 },
    Frame { kind: FrameKind::Cosines, factor: 0.0 },
];

impl<'a> Judge<'a> {
    fn new(subject: &'a Subject<'a>, fold: Fold, grazing: f64, watch: &Watch<'a>) -> Result<Self> {
        let coarse = Chart::new(fold, COARSE[usize::from(!fold.is_isotropic())], grazing)?;
        let watch = Watch { progress: None, ..*watch };
        let probes = [Vec::new(), Vec::new()];
        let mut judge = Self { subject, fold, grazing, coarse, probes, watch };
        // Quadratures about each place where a peak may be.
        let mut all: Vec<Planned> = judge.followed();
        for frame in &LAWS[1..] {
            let course = Course::Law(stretch::of(subject, &coarse, *frame)[0]);
            all.push(judge.planned(*frame, course, Vec::new()));
        }
        let about = Plan::new(subject, coarse, all);
        judge.probes = [false, true].map(|at_nodes| {
            let at = incidences(&coarse, at_nodes, PROBES[usize::from(at_nodes)]);
            at.into_par_iter().map(|wi| Probe::new(subject, wi, &about.views(wi))).collect()
        });
        Ok(judge)
    }

    fn planned(&self, frame: Frame, course: Course, peaks: Vec<usize>) -> Planned {
        Planned {
            course,
            shape: shape(frame, COMPARED, self.fold, Beside::NONE),
            peaks,
            hue: [0; 2],
        }
    }

    /// A layer for each peak that is followed.
    fn followed(&self) -> Vec<Planned> {
        let factors = self.subject.factors(&self.coarse).into_iter().enumerate();
        let frame = |factor| Frame { kind: FrameKind::Cosines, factor };
        factors.map(|(k, f)| self.planned(frame(f), Course::Peak(k), vec![k])).collect()
    }

    /// Mean error of layers on the coarse chart, between nodes or at them; between nodes with the energy that is wrong there.
    fn error(&self, layers: &[Planned], size: usize, at_nodes: bool) -> Result<f64> {
        let plan = sized_plan(self.subject, layers, self.coarse, size, Beside::NONE);
        let probes = &self.probes[usize::from(at_nodes)];
        let about = probes.iter().flat_map(|p| plan.chart.blend(p.wi));
        let mut nodes: Vec<usize> = about.map(|(node, _)| node).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let table = build::partial(self.subject, &plan, &nodes, &self.watch)?;
        let energy = if at_nodes { 0.0 } else { ENERGY };
        let of = |[wrong, imbalance]: [f64; 2]| wrong + energy * imbalance;
        let sum: f64 = probes.par_iter().map(|p| of(p.errors(&table))).sum();
        Ok(sum / probes.len().max(1) as f64)
    }

    /// All light in one layer.
    fn lone(&self) -> Vec<Vec<Planned>> {
        let mut all = Vec::new();
        for frame in LAWS {
            for stretch in stretch::of(self.subject, &self.coarse, frame) {
                all.push(vec![self.planned(frame, Course::Law(stretch), Vec::new())]);
            }
        }
        for first in self.followed().into_iter().take(1) {
            for kind in [FrameKind::Cosines, FrameKind::Slopes] {
                let mut layer = Planned { peaks: Vec::new(), ..first.clone() };
                layer.shape.frame.kind = kind;
                all.push(vec![layer]);
            }
        }
        all
    }

    /// What may come nearest to the source: the best lone layer, and one for each peak; with the mean errors.
    fn candidates(&self) -> Result<Vec<(f64, Vec<Planned>)>> {
        let mut all = Vec::new();
        for layers in self.lone() {
            all.push((self.error(&layers, COMPARED, false)?, layers));
        }
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        all.truncate(1);
        let followed = self.followed();
        if followed.len() > 1 {
            all.push((self.error(&followed, COMPARED, false)?, followed));
        }
        Ok(all)
    }
}

/// The plan that comes nearest to the source.
pub(super) fn plan(
    subject: &mut Subject<'_>,
    settings: &RenderSettings,
    watch: &Watch<'_>,
) -> Result<Plan> {
    let fold = fold::of(subject);
    let tracked = TRACKED[usize::from(!fold.is_isotropic())];
    subject.follow(&Chart::new(fold, tracked, GRAZING[0])?);
    let subject = &*subject;
    let mut best: Option<Sized> = None;
    for grazing in GRAZING {
        let judge = Judge::new(subject, fold, grazing, watch)?;
        // Which layers are best is asked once.
        let candidates = match &best {
            None => judge.candidates()?,
            Some(b) => vec![(judge.error(&b.layers, COMPARED, false)?, b.layers.clone())],
        };
        for (between, layers) in candidates {
            let found = sized(&judge, layers, between, settings)?;
            if best.as_ref().is_none_or(|b| found.is_better(b)) {
                best = Some(found);
            }
        }
    }
    let Some(best) = best else { return Err(Error::argument("layers: expected at least one")) };
    Ok(sized_plan(subject, &best.layers, best.chart, best.size, Beside::of(subject)))
}

/// Layers with a size of tables and nodes, and what is expected of them.
struct Sized {
    layers: Vec<Planned>,
    size: usize,
    chart: Chart,
    bytes: usize,
    error: f64,
    /// Whether the error is small enough.
    enough: bool,
}

impl Sized {
    /// Of those that are near enough the smallest, else the nearest.
    fn is_better(&self, other: &Self) -> bool {
        match (self.enough, other.enough) {
            (true, true) => self.bytes < other.bytes,
            (false, false) => self.error < other.error,
            (enough, _) => enough,
        }
    }
}

/// The smallest tables and fewest nodes that are near enough; or the nearest that memory allows for.
fn sized(
    judge: &Judge<'_>,
    layers: Vec<Planned>,
    between: f64,
    settings: &RenderSettings,
) -> Result<Sized> {
    let (fold, beside) = (judge.fold, Beside::of(judge.subject));
    let line = usize::from(!fold.is_isotropic());
    let coarse = judge.coarse.intervals() as f64;
    let mut at_nodes = [0.0; SIZES.len()];
    for (size, error) in at_nodes.iter_mut().enumerate() {
        *error = judge.error(&layers, size, true)?;
    }
    // What blending adds falls as the square of the nodes' distance.
    let blending = (between - at_nodes[COMPARED]).max(0.1 * between) * coarse * coarse;
    let smallest = Chart::new(fold, 4, judge.grazing)?;
    let mut best = Sized {
        layers: Vec::new(),
        size: 0,
        chart: smallest,
        bytes: 0,
        error: f64::INFINITY,
        enough: false,
    };
    for (size, at_nodes) in at_nodes.into_iter().enumerate() {
        let shapes: Vec<Shape> =
            layers.iter().map(|l| shape(l.shape.frame, size, fold, beside)).collect();
        for intervals in 4..=MOST[line] {
            let chart = Chart::new(fold, intervals, judge.grazing)?;
            let bytes = bytes(&chart, shapes.iter(), beside);
            if bytes > settings.max_bytes {
                break;
            }
            let error = at_nodes + blending / (intervals * intervals) as f64;
            let enough = error <= settings.max_error;
            let found = Sized { layers: Vec::new(), size, chart, bytes, error, enough };
            if found.is_better(&best) {
                best = found;
            }
        }
    }
    Ok(Sized { layers, ..best })
}

/// What came of it.
pub(super) fn report(subject: &Subject<'_>, plan: &Plan, table: &RenderTable) -> RenderReport {
    let errors: Vec<f64> = incidences(table.chart(), false, PROBES[0])
        .into_par_iter()
        .map(|wi| Probe::new(subject, wi, &plan.views(wi)).error(table))
        .collect();
    RenderReport {
        bytes: table.bytes(),
        nodes: table.chart().nodes(),
        layers: table.layers().len(),
        error: errors.iter().sum::<f64>() / errors.len().max(1) as f64,
    }
}
