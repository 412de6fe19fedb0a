//! A plan carried out.

use std::sync::atomic::AtomicUsize;

use bsdfkit::render::{Content, Layer, RenderTable};
use bsdfkit::{DVec3, Distribution, Result};
use rayon::prelude::*;

use super::plan::{Plan, Planned, shares};
use super::probe::{CELLS, Sides, quadrature};
use crate::source::Source;
use crate::watch::Watch;

/// Part of the mean density that is drawn from everywhere, so that nothing is missed.
const EVERYWHERE: f64 = 1e-3;

/// Limits of the factor that gives an incidence its energy: a blend far from the source is not blown up.
const GAIN: [f64; 2] = [0.25, 4.0];

/// The table of a plan.
pub(super) fn table(source: &dyn Source, plan: &Plan, watch: &Watch<'_>) -> Result<RenderTable> {
    let all: Vec<usize> = (0..plan.chart.nodes()).collect();
    let table = partial(source, plan, &all, watch)?;
    energy(source, plan, table, watch)
}

/// A table whose `nodes` alone are filled; totals are 0, factors 1.
pub(super) fn partial(
    source: &dyn Source,
    plan: &Plan,
    nodes: &[usize],
    watch: &Watch<'_>,
) -> Result<RenderTable> {
    let sides = Sides::of(source);
    let done = AtomicUsize::new(0);
    let filled = nodes.par_iter().map(|&node| {
        watch.check()?;
        let filled = self::node(source, sides, plan, node);
        watch.finished(&done, nodes.len());
        Ok(filled)
    });
    let filled = filled.collect::<Result<Vec<_>>>()?;
    let mut layers = Vec::new();
    for (l, planned) in plan.layers.iter().enumerate() {
        let mut content = Content { moved: planned.moved.clone(), ..Content::default() };
        let width = |of: fn(&Content) -> usize| filled.first().map_or(0, |f| of(&f[l]));
        let count = plan.chart.nodes();
        let (values, colour, density) =
            (width(|c| c.values.len()), width(|c| c.colour.len()), width(|c| c.density.len()));
        content.values.resize(values * count, 0.0);
        content.colour.resize(colour * count, 1.0);
        content.density.resize(density * count, 0.0);
        for (&node, filled) in nodes.iter().zip(&filled) {
            let put = |to: &mut [f64], from: &[f64]| {
                to[node * from.len()..][..from.len()].copy_from_slice(from);
            };
            put(&mut content.values, &filled[l].values);
            put(&mut content.colour, &filled[l].colour);
            put(&mut content.density, &filled[l].density);
        }
        layers.push(Layer::new(&plan.chart, planned.shape, &content)?);
    }
    let fine = plan.chart.refined(2).nodes();
    RenderTable::new(plan.chart, layers, vec![[0.0, 1.0]; fine])
}

/// What the layers have at one node.
fn node(source: &dyn Source, sides: Sides, plan: &Plan, node: usize) -> Vec<Content> {
    let wi = plan.chart.direction(node);
    let views = plan.views(wi);
    let channels = source.channels();
    let mut part = vec![0.0; views.len()];
    let mut share = |l: usize, wo: DVec3| {
        shares(&views, wo, &mut part);
        part[l]
    };
    let mut layer = |(l, planned): (usize, &Planned)| {
        let shape = &planned.shape;
        let view = &views[l];
        let mut values = Vec::new();
        if shape.angles > 0 {
            let wo = view.values(shape, shape.angles, shape.radii);
            let found = sides.values(source, wi, &wo);
            values.extend(wo.iter().zip(found).map(|(&w, f)| f * share(l, w)));
        }
        let mut colour = Vec::new();
        if channels == 3 && shape.colour_angles > 0 {
            let wo = view.values(shape, shape.colour_angles, shape.colour_radii);
            let found = sides.channels(source, wi, &wo);
            for yxz in found.chunks_exact(3) {
                let ratio = |v: f32| if yxz[0] > 0.0 { f64::from(v / yxz[0]) } else { 1.0 };
                colour.extend([ratio(yxz[1]), ratio(yxz[2])]);
            }
        }
        let places = view.densities(shape);
        let wo: Vec<DVec3> = places.iter().map(|p| p.wo).collect();
        let found = sides.values(source, wi, &wo);
        let of = |(p, f): (&bsdfkit::render::Place, f64)| f * p.size * share(l, p.wo);
        let mut density: Vec<f64> = places.iter().zip(found).map(of).collect();
        let mean = density.iter().sum::<f64>() / density.len() as f64;
        let knots = shape.drawn_radii + 1;
        for (n, density) in density.iter_mut().enumerate() {
            // Nothing in the middle, where area vanishes.
            *density += EVERYWHERE * mean * (n % knots) as f64 / knots as f64;
        }
        Content { values, colour, density, moved: Vec::new() }
    };
    plan.layers.iter().enumerate().map(&mut layer).collect()
}

/// The same with the source's totals, and factors that give values these.
fn energy(
    source: &dyn Source,
    plan: &Plan,
    table: RenderTable,
    watch: &Watch<'_>,
) -> Result<RenderTable> {
    let sides = Sides::of(source);
    let fine = *table.fine();
    let all: Result<Vec<[f32; 2]>> = (0..fine.nodes())
        .into_par_iter()
        .map(|node| {
            watch.check()?;
            let wi = fine.direction(node);
            let places = quadrature(&plan.views(wi), CELLS);
            let wo: Vec<DVec3> = places.iter().map(|p| p.wo).collect();
            let values = sides.values(source, wi, &wo);
            let (mut total, mut blend) = (0.0, 0.0);
            for (place, value) in places.iter().zip(values) {
                total += place.size * value;
                blend += place.size * table.value(wi, place.wo);
            }
            let gain = if blend > 0.0 { (total / blend).clamp(GAIN[0], GAIN[1]) } else { 1.0 };
            Ok([total as f32, gain as f32])
        })
        .collect();
    table.with_energy(all?)
}
