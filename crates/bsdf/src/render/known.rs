//! A known direction in a table: what its verbs share.

use bsdfkit_sphere::hilbert;

use super::chart::Stencil;
use super::frame::{Placed, Pose};
use super::hues::Hues;
use super::incidence::Incidence;
use super::layer::Layer;
use super::table::{MOST_LAYERS, RenderTable};
use crate::spectrum::Basis;
use crate::unit::BELOW_ONE;
use crate::{DVec2, DVec3};

/// One incident direction, with the nodes around it.
#[derive(Clone, Copy)]
pub(crate) struct Known<'a> {
    table: &'a RenderTable,
    incidences: &'a [f32],
    at: Incidence,
    pub(crate) nodes: Stencil,
    fine: Stencil,
}

/// What is drawn from at one scattered direction.
#[derive(Clone, Copy, Default)]
pub(crate) struct Mixture {
    /// f, 1/sr.
    pub(crate) value: f64,
    /// Density per projected solid angle of samples, times the mass that they are drawn from.
    pub(crate) density: f64,
    /// That mass.
    pub(crate) mass: f64,
}

impl<'a> Known<'a> {
    #[inline(always)]
    pub(crate) fn new(table: &'a RenderTable, known: DVec3) -> Self {
        let at = table.chart.incidence(known);
        let square = table.chart.square(&at);
        let (nodes, fine) = (table.chart.around(square), table.fine.around(square));
        Self { table, incidences: &table.incidences, at, nodes, fine }
    }

    /// Columns of the incidences' array, blended.
    #[inline(always)]
    fn blended<const N: usize>(&self, first: usize) -> [f64; N] {
        let columns = columns(self.table.layers.len());
        let mut sum = [0.0; N];
        for (node, weight) in self.fine.iter() {
            let found = self.incidences.get(node * columns + first..);
            let record: Option<&[f32; N]> = found.and_then(<[f32]>::first_chunk);
            if let Some(record) = record {
                for (sum, v) in sum.iter_mut().zip(record) {
                    *sum += weight * f64::from(*v);
                }
            }
        }
        sum
    }

    #[inline(always)]
    pub(crate) fn total(&self) -> f64 {
        let [total] = self.blended(0);
        total
    }

    /// The frame of a layer, and what its values are multiplied by.
    #[inline(always)]
    pub(crate) fn placed(&self, number: usize, layer: &Layer) -> (Placed, f64) {
        let [x, y, xx, xy, yy, factor] = self.blended(columns(number));
        (Placed::new(layer.shape.frame, &self.at, [x, y, xx, xy, yy]), factor)
    }

    #[inline(always)]
    fn mass(&self, number: usize, layer: &Layer) -> f64 {
        let [factor] = self.blended(columns(number) + Pose::NUMBERS);
        factor * layer.drawing.mass(&self.nodes)
    }

    /// x and y as tables have them, and a cosine of at least 0.
    #[inline(always)]
    pub(crate) fn turned(&self, w: DVec3) -> (DVec2, f64) {
        (self.at.turn.apply(w.truncate()), w.z.abs())
    }

    #[inline(always)]
    pub(crate) fn value(&self, wo: DVec3) -> f64 {
        let (xy, z) = self.turned(wo);
        let mut sum = 0.0;
        for (n, layer) in self.table.layers.iter().enumerate() {
            let (placed, factor) = self.placed(n, layer);
            sum += factor * layer.value(&self.nodes, &layer.spot(&placed, xy, z));
        }
        sum
    }

    pub(crate) fn value_xyz(&self, wo: DVec3) -> [f64; 3] {
        let (xy, z) = self.turned(wo);
        let mut sum = [0.0; 3];
        for (n, layer) in self.table.layers.iter().enumerate() {
            let (placed, factor) = self.placed(n, layer);
            let value = layer.value_xyz(&self.nodes, &layer.spot(&placed, xy, z));
            sum.iter_mut().zip(value).for_each(|(sum, value)| *sum += factor * value);
        }
        sum
    }

    /// f of all bands.
    pub(crate) fn bands(&self, hues: &Hues, wo: DVec3, out: &mut [f64]) {
        let (xy, z) = self.turned(wo);
        let mut sums = [0.0; 1 + Basis::MOST];
        for (n, layer) in self.table.layers.iter().enumerate() {
            let (placed, factor) = self.placed(n, layer);
            let spot = layer.spot(&placed, xy, z);
            hues.add(n, layer, factor, (&self.nodes, &spot), &mut sums);
        }
        hues.bands(&sums, out);
    }

    #[inline(always)]
    pub(crate) fn mixture(&self, wo: DVec3) -> Mixture {
        let (xy, z) = self.turned(wo);
        let mut sum = Mixture::default();
        for (n, layer) in self.table.layers.iter().enumerate() {
            let (placed, factor) = self.placed(n, layer);
            let spot = layer.spot(&placed, xy, z);
            sum.value += factor * layer.value(&self.nodes, &spot);
            sum.density += factor * layer.density(&self.nodes, &placed, &spot, z);
            sum.mass += factor * layer.drawing.mass(&self.nodes);
        }
        sum
    }

    /// x and y of a direction drawn; `rest` makes two numbers of what the choice of a layer leaves of `u`.
    #[inline(always)]
    fn draw(&self, u: f64, rest: impl Fn(f64) -> DVec2) -> Option<DVec2> {
        if u.is_nan() || self.total() <= 0.0 {
            return None;
        }
        let layers = &self.table.layers;
        let (n, left) = match layers.as_slice() {
            [layer] if self.mass(0, layer) > 0.0 => (0, u.clamp(0.0, BELOW_ONE)),
            _ => self.choose(u)?,
        };
        let layer = layers.get(n)?;
        let drawn = layer.drawing.draw(&self.nodes, rest(left));
        let (placed, _) = self.placed(n, layer);
        Some(self.at.turn.undo(layer.direction(&placed, &drawn)))
    }

    /// The layer that `u` falls in, and where in it.
    fn choose(&self, u: f64) -> Option<(usize, f64)> {
        let mut masses = [0.0; MOST_LAYERS];
        let mut total = 0.0;
        for (n, (mass, layer)) in masses.iter_mut().zip(&self.table.layers).enumerate() {
            *mass = self.mass(n, layer);
            total += *mass;
        }
        crate::unit::choose(masses.into_iter().enumerate(), u.clamp(0.0, BELOW_ONE) * total)
    }

    #[inline(always)]
    pub(crate) fn sample(&self, u: f64) -> Option<DVec2> {
        self.draw(u, hilbert::unfold)
    }

    #[inline(always)]
    pub(crate) fn sample2(&self, u: DVec2) -> Option<DVec2> {
        self.draw(u.x, |rest| DVec2::new(rest, u.y).clamp(DVec2::ZERO, DVec2::splat(BELOW_ONE)))
    }
}

/// Columns of the incidences' array before those of a layer; of all layers there are none after.
pub(crate) const fn columns(layers: usize) -> usize {
    1 + LAYER * layers
}

/// Columns of a layer: its pose and factor.
pub(crate) const LAYER: usize = Pose::NUMBERS + 1;
