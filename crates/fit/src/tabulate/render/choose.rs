//! Which frames, and how many nodes.

use bsdfkit::render::{Chart, Fold, Frame, FrameKind, RenderTable, Shape};
use bsdfkit::{DVec3, Result};
use rayon::prelude::*;

use super::build;
use super::plan::{PLAIN, Plan, cosines, slopes};
use super::probe::Probe;
use super::settings::{RenderReport, RenderSettings};
use crate::source::Source;
use crate::watch::Watch;

/// How strongly nodes are drawn to the horizon.
const GRAZING: f64 = 1.0;

/// The shape of a layer in `frame`.
pub(super) fn shape(frame: Frame, fold: Fold, channels: usize) -> Shape {
    let mirrored = fold == Fold::IsotropicMirrored;
    let (angles, radii) = if mirrored { (32, 64) } else { (56, 56) };
    let drawn = if mirrored { (20, 40) } else { (36, 36) };
    let (roots, spread) = match frame.kind {
        FrameKind::Slopes => (3, 0.7),
        FrameKind::Cosines => (2, 1.0),
    };
    Shape {
        frame,
        angles,
        radii,
        roots,
        spread,
        colour_angles: if channels == 3 { angles / 2 } else { 0 },
        colour_radii: if channels == 3 { radii / 2 } else { 0 },
        drawn_angles: drawn.0,
        drawn_radii: drawn.1,
        drawn_roots: 3,
        value_unit: 1.0,
        drawn_unit: 1.0,
    }
}

/// Incidences between nodes: of the finer chart, those that are none of the coarser.
pub(super) fn between(chart: &Chart, count: usize) -> Vec<DVec3> {
    let fine = chart.refined(2);
    let step = (fine.nodes() as f64 / count as f64).max(1.0);
    let at = (0..count).map(|k| ((k as f64 + 0.37) * step) as usize).filter(|&n| n < fine.nodes());
    at.map(|n| fine.direction(n)).collect()
}

/// The nodes about some incidences.
fn nodes_about(chart: &Chart, incidences: &[DVec3]) -> Vec<usize> {
    let mut nodes: Vec<usize> = incidences.iter().flat_map(|&wi| chart.about(wi)).collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

/// Mean error of a plan at some probes.
fn error(source: &dyn Source, plan: &Plan, probes: &[Probe], watch: &Watch<'_>) -> Result<f64> {
    let at: Vec<DVec3> = probes.iter().map(|p| p.wi).collect();
    let table = build::partial(source, plan, &nodes_about(&plan.chart, &at), watch)?;
    let sum: f64 = probes.par_iter().map(|p| p.error(&table).0).sum();
    Ok(sum / probes.len().max(1) as f64)
}

/// Probes by which frames are told apart.
const PROBES: usize = 12;

/// The plan that comes nearest to the source.
pub(super) fn plan(
    source: &dyn Source,
    fold: Fold,
    settings: &RenderSettings,
    watch: &Watch<'_>,
) -> Result<Plan> {
    let quiet = Watch { progress: None, ..*watch };
    let intervals = if fold.is_isotropic() { 24 } else { 8 };
    let chart = Chart::new(fold, intervals, GRAZING)?;
    let channels = source.channels();
    let probes: Vec<Probe> =
        between(&chart, PROBES).into_par_iter().map(|wi| Probe::new(source, &chart, wi)).collect();
    let frames = [slopes(PLAIN), cosines(-1.0, PLAIN), cosines(0.0, PLAIN), cosines(1.0, PLAIN)];
    let mut best: Option<(f64, Plan)> = None;
    for frame in frames {
        let plan = Plan { chart, layers: vec![shape(frame, fold, 1)] };
        let error = error(source, &plan, &probes, &quiet)?;
        if best.as_ref().is_none_or(|(least, _)| error < *least) {
            best = Some((error, plan));
        }
    }
    let mut plan = best.map(|(_, plan)| plan).unwrap_or(Plan { chart, layers: Vec::new() });
    plan.layers = plan.layers.iter().map(|s| shape(s.frame, fold, channels)).collect();
    let mut most = 1;
    while most < 64 {
        let next = Plan { chart: Chart::new(fold, most + 1, GRAZING)?, ..plan.clone() };
        if next.bytes(channels) > settings.max_bytes {
            break;
        }
        most += 1;
    }
    plan.chart = Chart::new(fold, most, GRAZING)?;
    Ok(plan)
}

/// What came of it.
pub(super) fn report(source: &dyn Source, table: &RenderTable) -> RenderReport {
    let probes = between(table.chart(), PROBES);
    let errors: Vec<f64> = probes
        .into_par_iter()
        .map(|wi| Probe::new(source, table.chart(), wi).error(table).0)
        .collect();
    RenderReport {
        bytes: table.bytes(),
        nodes: table.chart().nodes(),
        layers: table.layers().len(),
        error: errors.iter().sum::<f64>() / errors.len().max(1) as f64,
    }
}
