//! A plan carried out.

use std::sync::atomic::AtomicUsize;

use bsdfkit::render::{Content, Hues, Layer, Place, RenderTable, View};
use bsdfkit::{DVec3, Result};
use rayon::prelude::*;

use super::plan::{Plan, Planned};
use super::probe::Probe;
use super::subject::Subject;
use crate::watch::Watch;

/// Part of the mean density that is drawn from everywhere, so that nothing is missed.
const EVERYWHERE: f64 = 1e-3;

/// Cosines of incidences at which places beyond the horizon of others are looked for.
const INWARD: [f64; 9] = [0.03, 0.06, 0.12, 0.2, 0.3, 0.45, 0.6, 0.8, 1.0];

/// The table of a plan.
pub(super) fn table(subject: &Subject<'_>, plan: &Plan, watch: &Watch<'_>) -> Result<RenderTable> {
    let all: Vec<usize> = (0..plan.chart.nodes()).collect();
    let table = partial(subject, plan, &all, watch)?;
    let fine = *table.fine();
    let energy: Result<Vec<(f64, Vec<f64>)>> = (0..fine.nodes())
        .into_par_iter()
        .map(|node| {
            watch.check()?;
            let wi = fine.direction(node);
            let probe = Probe::new(subject, wi, &plan.views(wi));
            Ok((probe.total, probe.factors(subject, plan, &table)))
        })
        .collect();
    let energy = energy?;
    let totals: Vec<f32> = energy.iter().map(|e| e.0 as f32).collect();
    let factors = energy.iter().flat_map(|e| e.1.iter().map(|f| *f as f32));
    table.with_energy(&totals, &factors.collect::<Vec<_>>())
}

/// A table whose `nodes` alone are filled; totals are 0, factors 1.
pub(super) fn partial(
    subject: &Subject<'_>,
    plan: &Plan,
    nodes: &[usize],
    watch: &Watch<'_>,
) -> Result<RenderTable> {
    let done = AtomicUsize::new(0);
    let filled = nodes.par_iter().map(|&node| {
        watch.check()?;
        let filled = self::node(subject, plan, node);
        watch.finished(&done, nodes.len());
        Ok(filled)
    });
    let filled = filled.collect::<Result<Vec<_>>>()?;
    let (mut layers, mut hues) = (Vec::new(), Vec::new());
    for (l, planned) in plan.layers.iter().enumerate() {
        let mut content = Content::default();
        let width = |of: fn(&Content) -> usize| filled.first().map_or(0, |f| of(&f[l]));
        let count = plan.chart.nodes();
        let (values, colour, density, hue) = (
            width(|c| c.values.len()),
            width(|c| c.colour.len()),
            width(|c| c.density.len()),
            width(|c| c.hue.len()),
        );
        content.values.resize(values * count, 0.0);
        content.colour.resize(colour * count, 1.0);
        content.density.resize(density * count, 0.0);
        content.hue.resize(hue * count, 0.0);
        for (&node, filled) in nodes.iter().zip(&filled) {
            let put = |to: &mut [f64], from: &[f64]| {
                to[node * from.len()..][..from.len()].copy_from_slice(from);
            };
            put(&mut content.values, &filled[l].values);
            put(&mut content.colour, &filled[l].colour);
            put(&mut content.density, &filled[l].density);
            put(&mut content.hue, &filled[l].hue);
        }
        layers.push(Layer::new(&plan.chart, planned.shape, &content)?);
        hues.push(content.hue);
    }
    let table = RenderTable::new(plan.chart, layers, &plan.poses)?;
    let sizes: Vec<[usize; 2]> = plan.layers.iter().map(|l| l.hue).collect();
    match subject.hue().filter(|_| sizes.iter().all(|size| *size != [0; 2])) {
        Some(hue) => table.with_hues(Hues::new(hue, sizes, &hues)?),
        None => Ok(table),
    }
}

/// What the layers have at one node.
fn node(subject: &Subject<'_>, plan: &Plan, node: usize) -> Vec<Content> {
    let wi = plan.chart.direction(node);
    let views = plan.views(wi);
    let layers = views.iter().enumerate();
    layers.map(|(layer, view)| content(subject, plan, layer, view, wi)).collect()
}

/// A layer's part of f.
fn part(subject: &Subject<'_>, planned: &Planned, wi: DVec3, wo: &[DVec3]) -> Vec<f64> {
    let (mut values, shares) = (subject.values(wi, wo), subject.shares(wi, wo));
    planned.take(&mut values, &shares);
    values
}

/// Values of one layer at one incidence.
///
/// No light goes to a place beyond the horizon, but a blend with incidences that see it does read it there: it has the value of the
/// first incidence on the way to the normal that sees it, or of the normal's horizon, if that is less than at its own. Along the
/// horizon a peak may be at its brightest, and went on so beyond it.
fn values(subject: &Subject<'_>, plan: &Plan, layer: usize, view: &View, wi: DVec3) -> Vec<f64> {
    let planned = &plan.layers[layer];
    let (shape, angles, radii) = (&planned.shape, planned.shape.angles, planned.shape.radii);
    let mut values = part(subject, planned, wi, &view.values(shape, angles, radii));
    let beyond = view.beyond(shape, angles, radii);
    let mut unseen: Vec<usize> = (0..values.len()).filter(|&n| beyond[n]).collect();
    let out = wi.truncate().normalize_or_zero();
    for z in INWARD.into_iter().filter(|z| *z > wi.z) {
        if unseen.is_empty() {
            break;
        }
        let inner = (out * (1.0 - z * z).sqrt()).extend(z);
        let view = &plan.views(inner)[layer];
        let (wo, beyond) = (view.values(shape, angles, radii), view.beyond(shape, angles, radii));
        let (left, seen): (Vec<usize>, Vec<usize>) =
            unseen.iter().partition(|&&n| beyond[n] && z < 1.0);
        let places: Vec<DVec3> = seen.iter().map(|&n| wo[n]).collect();
        let found = part(subject, planned, inner, &places);
        for (n, value) in seen.into_iter().zip(found) {
            values[n] = values[n].min(value);
        }
        unseen = left;
    }
    values
}

fn content(subject: &Subject<'_>, plan: &Plan, layer: usize, view: &View, wi: DVec3) -> Content {
    let planned = &plan.layers[layer];
    let (shape, channels) = (&planned.shape, subject.channels());
    let mut content = Content::default();
    if shape.angles > 0 {
        content.values = values(subject, plan, layer, view, wi);
    }
    if channels == 3 && shape.colour_angles > 0 {
        let wo = view.values(shape, shape.colour_angles, shape.colour_radii);
        for yxz in subject.colours(wi, &wo).chunks_exact(3) {
            let ratio = |v: f32| if yxz[0] > 0.0 { f64::from(v / yxz[0]) } else { 1.0 };
            content.colour.extend([ratio(yxz[1]), ratio(yxz[2])]);
        }
    }
    let [angles, radii] = planned.hue;
    if let Some(hue) = subject.hue().filter(|_| angles > 0) {
        content.hue = subject.hues(&hue, wi, &view.values(shape, angles, radii));
    }
    let places = view.densities(shape);
    let wo: Vec<DVec3> = places.iter().map(|p| p.wo).collect();
    let of = |(p, f): (&Place, f64)| f * p.size;
    content.density = places.iter().zip(part(subject, planned, wi, &wo)).map(of).collect();
    let mean = content.density.iter().sum::<f64>() / content.density.len() as f64;
    let knots = shape.drawn_radii + 1;
    for (n, density) in content.density.iter_mut().enumerate() {
        // Nothing in the middle, where area vanishes.
        *density += EVERYWHERE * mean * (n % knots) as f64 / knots as f64;
    }
    content
}
