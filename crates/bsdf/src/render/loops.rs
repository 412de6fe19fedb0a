//! Values of many pairs, step by step side by side.

use bsdfkit_sphere::widest::Loop;

use super::chart::{Fold, Stencil};
use super::frame::{Frame, FrameKind, Placed};
use super::half::Half;
use super::incidence::{Incidence, Turn};
use super::known::{LAYER, columns};
use super::layer::{Layer, Read};
use super::table::RenderTable;
use crate::lanes::Lanes;
use crate::{DVec2, DVec3};

/// Pairs that go through each step together: what they have in hand stays in the first-level cache.
pub(super) const ABREAST: usize = 32;

/// The loop of [`Distribution::values`](crate::Distribution::values). What each step computes are the functions that single
/// queries call, too.
pub(super) struct Values<'a> {
    pub(super) table: &'a RenderTable,
    pub(super) wi: Lanes<'a>,
    pub(super) wo: Lanes<'a>,
    pub(super) out: &'a mut [f64],
}

impl Loop for Values<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { table, wi, wo, out } = self;
        let mut block = Block::new();
        for (n, out) in out.chunks_mut(ABREAST).enumerate() {
            let part = n * ABREAST..n * ABREAST + out.len();
            let (wi, wo) = (wi.part(part.clone()), wo.part(part));
            block.mix::<false>(table, wi, wo);
            for (k, out) in out.iter_mut().enumerate() {
                let nan = wi.at(k).is_nan() | wo.at(k).is_nan();
                *out = if nan { f64::NAN } else { block.sum[k] };
            }
        }
    }
}

/// The loop of [`Distribution::values_and_drawn`](crate::Distribution::values_and_drawn).
pub(super) struct Mixtures<'a> {
    pub(super) table: &'a RenderTable,
    pub(super) wi: Lanes<'a>,
    pub(super) wo: Lanes<'a>,
    pub(super) values: &'a mut [f64],
    pub(super) drawn: &'a mut [f64],
}

impl Loop for Mixtures<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { table, wi, wo, values, drawn } = self;
        let mut block = Block::new();
        let parts = values.chunks_mut(ABREAST).zip(drawn.chunks_mut(ABREAST));
        for (n, (values, drawn)) in parts.enumerate() {
            let part = n * ABREAST..n * ABREAST + values.len();
            let (wi, wo) = (wi.part(part.clone()), wo.part(part));
            block.mix::<true>(table, wi, wo);
            let [total] = block.blended::<1>(table, 0);
            for (k, (value, drawn)) in values.iter_mut().zip(drawn).enumerate() {
                let (density, mass) = (block.density[k], block.mass[k]);
                let of = if mass > 0.0 { density / mass * total[k] } else { 0.0 };
                let nan = wi.at(k).is_nan() | wo.at(k).is_nan();
                (*value, *drawn) = if nan { (f64::NAN, f64::NAN) } else { (block.sum[k], of) };
            }
        }
    }
}

/// The loop of [`Distribution::totals`](crate::Distribution::totals).
pub(super) struct Totals<'a> {
    pub(super) table: &'a RenderTable,
    pub(super) known: Lanes<'a>,
    pub(super) out: &'a mut [f64],
}

impl Loop for Totals<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { table, known, out } = self;
        let mut block = Block::new();
        for (n, out) in out.chunks_mut(ABREAST).enumerate() {
            let known = known.part(n * ABREAST..n * ABREAST + out.len());
            block.seen(table, known);
            let [total] = block.blended::<1>(table, 0);
            for (k, out) in out.iter_mut().enumerate() {
                *out = if known.at(k).is_nan() { f64::NAN } else { total[k] };
            }
        }
    }
}

pub(super) type Row<T> = [T; ABREAST];

/// What pairs have in hand.
pub(super) struct Block {
    wi: [Row<f64>; 3],
    wo: [Row<f64>; 3],
    /// x, y and z of incidences, and the rows of their turns.
    at: [Row<f64>; 3],
    turn: [Row<f64>; 4],
    square: [Row<f64>; 2],
    nodes: [Row<usize>; 3],
    weights: [Row<f64>; 3],
    fine: [Row<usize>; 3],
    fine_weights: [Row<f64>; 3],
    /// Of a layer: its pose and factor.
    pub(super) pose: [Row<f64>; LAYER],
    values: Reads,
    densities: Reads,
    /// What makes them densities per projected solid angle.
    over: Row<f64>,
    under: Row<f64>,
    read: Neighbours,
    /// Of all layers: values, densities times the mass that is drawn from, and that mass.
    sum: Row<f64>,
    density: Row<f64>,
    mass: Row<f64>,
}

impl Block {
    #[inline(always)]
    pub(super) fn new() -> Self {
        const F: Row<f64> = [0.0; ABREAST];
        const N: Row<usize> = [0; ABREAST];
        Self {
            wi: [F; 3],
            wo: [F; 3],
            at: [F; 3],
            turn: [F; 4],
            square: [F; 2],
            nodes: [N; 3],
            weights: [F; 3],
            fine: [N; 3],
            fine_weights: [F; 3],
            pose: [F; LAYER],
            values: Reads::NONE,
            densities: Reads::NONE,
            over: F,
            under: F,
            read: Neighbours([[Half(0); ABREAST]; 12]),
            sum: F,
            density: F,
            mass: F,
        }
    }

    #[inline(always)]
    fn take(to: &mut [Row<f64>; 3], from: Lanes<'_>) {
        for (to, from) in to.iter_mut().zip([from.x, from.y, from.z]) {
            to[..from.len()].copy_from_slice(from);
        }
    }

    /// Sums over all layers; of densities if `DRAWN`.
    #[inline(always)]
    fn mix<const DRAWN: bool>(&mut self, table: &RenderTable, wi: Lanes<'_>, wo: Lanes<'_>) {
        Self::take(&mut self.wi, wi);
        Self::take(&mut self.wo, wo);
        self.see(table);
        self.sum = [0.0; ABREAST];
        self.density = [0.0; ABREAST];
        self.mass = [0.0; ABREAST];
        for (n, layer) in table.layers.iter().enumerate() {
            self.pose = self.blended(table, columns(n));
            match layer.shape.frame.kind {
                FrameKind::Cosines => self.find::<DRAWN>(layer, FrameKind::Cosines),
                FrameKind::Slopes => self.find::<DRAWN>(layer, FrameKind::Slopes),
            }
            self.add_values(layer);
            if DRAWN {
                self.add_densities(layer);
            }
        }
    }

    /// Incident directions, where they are on the chart.
    #[inline(always)]
    pub(super) fn seen(&mut self, table: &RenderTable, known: Lanes<'_>) {
        Self::take(&mut self.wi, known);
        self.see(table);
    }

    /// The nodes about a direction.
    #[inline(always)]
    pub(super) fn stencil(&self, k: usize) -> Stencil {
        Stencil {
            nodes: std::array::from_fn(|n| self.nodes[n][k]),
            weights: std::array::from_fn(|n| self.weights[n][k]),
        }
    }

    #[inline(always)]
    fn turn_of(&self, k: usize) -> Turn {
        Turn {
            x: DVec2::new(self.turn[0][k], self.turn[1][k]),
            y: DVec2::new(self.turn[2][k], self.turn[3][k]),
        }
    }

    /// The frame of the layer whose pose is at hand.
    #[inline(always)]
    pub(super) fn placed(&self, frame: Frame, k: usize) -> Placed {
        let xy = DVec2::new(self.at[0][k], self.at[1][k]);
        let at = Incidence { xy, z: self.at[2][k], turn: self.turn_of(k) };
        Placed::new(frame, &at, std::array::from_fn(|n| self.pose[n][k]))
    }

    /// x and y as the caller has them.
    #[inline(always)]
    pub(super) fn turned_back(&self, k: usize, xy: DVec2) -> DVec2 {
        self.turn_of(k).undo(xy)
    }

    /// Incident directions, turned, and the nodes around them.
    #[inline(always)]
    fn see(&mut self, table: &RenderTable) {
        // With what decides known there is no branch.
        match table.chart.fold() {
            Fold::None => self.see_as(Fold::None, table),
            Fold::MirrorX => self.see_as(Fold::MirrorX, table),
            Fold::MirrorY => self.see_as(Fold::MirrorY, table),
            Fold::Quadrants => self.see_as(Fold::Quadrants, table),
            Fold::HalfTurn => self.see_as(Fold::HalfTurn, table),
            // Of these, turns are alike.
            Fold::Isotropic | Fold::IsotropicMirrored => self.see_as(Fold::Isotropic, table),
        }
    }

    #[inline(always)]
    fn see_as(&mut self, fold: Fold, table: &RenderTable) {
        let (chart, fine) = (table.chart.with_fold(fold), table.fine.with_fold(fold));
        for k in 0..ABREAST {
            let at = chart.incidence(DVec3::new(self.wi[0][k], self.wi[1][k], self.wi[2][k]));
            let square = chart.square(&at);
            (self.at[0][k], self.at[1][k], self.at[2][k]) = (at.xy.x, at.xy.y, at.z);
            (self.turn[0][k], self.turn[1][k]) = (at.turn.x.x, at.turn.x.y);
            (self.turn[2][k], self.turn[3][k]) = (at.turn.y.x, at.turn.y.y);
            (self.square[0][k], self.square[1][k]) = (square.x, square.y);
        }
        let at = |k: usize| DVec2::new(self.square[0][k], self.square[1][k]);
        put(&mut self.nodes, &mut self.weights, |k| chart.around(at(k)));
        put(&mut self.fine, &mut self.fine_weights, |k| fine.around(at(k)));
    }

    /// Columns of the incidences' array, blended.
    #[inline(always)]
    pub(super) fn blended<const N: usize>(
        &self,
        table: &RenderTable,
        first: usize,
    ) -> [Row<f64>; N] {
        let incidences: &[f32] = &table.incidences;
        let width = columns(table.layers.len());
        let mut rows = [[0.0; ABREAST]; N];
        for k in 0..ABREAST {
            let mut sum = [0.0; N];
            for (nodes, weights) in self.fine.iter().zip(&self.fine_weights) {
                let found = incidences.get(nodes[k] * width + first..);
                let record: Option<&[f32; N]> = found.and_then(<[f32]>::first_chunk);
                let record = record.unwrap_or(&[0.0; N]);
                for (sum, v) in sum.iter_mut().zip(record) {
                    *sum += weights[k] * f64::from(*v);
                }
            }
            for (row, sum) in rows.iter_mut().zip(sum) {
                row[k] = sum;
            }
        }
        rows
    }

    /// Where the tables of a layer are read; of densities if `DRAWN`.
    #[inline(always)]
    fn find<const DRAWN: bool>(&mut self, layer: &Layer, kind: FrameKind) {
        let frame = Frame { kind, ..layer.shape.frame };
        for k in 0..ABREAST {
            let placed = self.placed(frame, k);
            let xy = self.turn_of(k).apply(DVec2::new(self.wo[0][k], self.wo[1][k]));
            let z = self.wo[2][k].abs();
            let spot = layer.spot(&placed, xy, z);
            self.values.put(k, &layer.read(&spot));
            if DRAWN {
                let drawn = layer.drawn(&placed, &spot, z);
                self.densities.put(k, &layer.drawing.read(spot.angle, drawn.v));
                (self.over[k], self.under[k]) = (drawn.over, drawn.under);
            }
        }
    }

    /// Adds the values of a layer.
    #[inline(always)]
    fn add_values(&mut self, layer: &Layer) {
        let shape = &layer.shape;
        if shape.angles == 0 {
            return;
        }
        self.read.gather(&layer.values, &self.nodes, &self.values, shape.angles, shape.radii);
        let factor = &self.pose[LAYER - 1];
        for k in 0..ABREAST {
            let value = self.read.blend(k, &self.weights, &self.values);
            self.sum[k] += factor[k] * (value * shape.value_unit);
        }
    }

    /// Adds the densities of a layer, and their mass.
    #[inline(always)]
    fn add_densities(&mut self, layer: &Layer) {
        let drawing = &layer.drawing;
        let (angles, radii) = (drawing.angles, drawing.radii);
        self.read.gather(&drawing.density, &self.nodes, &self.densities, angles, radii);
        let running: &[f32] = &drawing.running;
        let mut runs = [[0.0_f32; ABREAST]; 3];
        for k in 0..ABREAST {
            for (runs, nodes) in runs.iter_mut().zip(&self.nodes) {
                runs[k] = running.get(nodes[k] * (angles + 1) + angles).copied().unwrap_or(0.0);
            }
        }
        let factor = &self.pose[LAYER - 1];
        let (unit, scale) = (drawing.unit, drawing.scale());
        for k in 0..ABREAST {
            let density = self.read.blend(k, &self.weights, &self.densities) * unit;
            self.density[k] += factor[k] * (density * self.over[k] / self.under[k]);
            let of = |n: usize| self.weights[n][k] * f64::from(runs[n][k]);
            self.mass[k] += factor[k] * ((of(0) + of(1) + of(2)) * unit * scale);
        }
    }
}

/// Where tables are read: an element, and how much further along angle and radius.
struct Reads {
    first: Row<usize>,
    a: Row<f64>,
    t: Row<f64>,
}

impl Reads {
    const NONE: Self = Self { first: [0; ABREAST], a: [0.0; ABREAST], t: [0.0; ABREAST] };

    #[inline(always)]
    fn put(&mut self, k: usize, read: &Read) {
        (self.first[k], self.a[k], self.t[k]) = (read.first, read.a, read.t);
    }
}

/// Four neighbours of three nodes.
struct Neighbours([Row<Half>; 12]);

impl Neighbours {
    #[inline(always)]
    fn gather(
        &mut self,
        table: &[Half],
        nodes: &[Row<usize>; 3],
        reads: &Reads,
        angles: usize,
        radii: usize,
    ) {
        let next = radii + 1;
        let size = (angles + 1) * next;
        for k in 0..ABREAST {
            for (n, nodes) in nodes.iter().enumerate() {
                let first = nodes[k] * size + reads.first[k];
                let ([a, b], [c, d]) = (two(table, first), two(table, first + next));
                (self.0[4 * n][k], self.0[4 * n + 1][k]) = (a, b);
                (self.0[4 * n + 2][k], self.0[4 * n + 3][k]) = (c, d);
            }
        }
    }

    #[inline(always)]
    fn blend(&self, k: usize, weights: &[Row<f64>; 3], reads: &Reads) -> f64 {
        let read = Read { first: 0, next: 0, size: 0, a: reads.a[k], t: reads.t[k] };
        let mut sum = 0.0;
        for (n, weights) in weights.iter().enumerate() {
            let four = std::array::from_fn(|c| self.0[4 * n + c][k].value());
            sum += weights[k] * read.mix(four);
        }
        sum
    }
}

#[inline(always)]
fn two(table: &[Half], at: usize) -> [Half; 2] {
    table.get(at..).and_then(<[Half]>::first_chunk).copied().unwrap_or([Half(0); 2])
}

#[inline(always)]
fn put(nodes: &mut [Row<usize>; 3], weights: &mut [Row<f64>; 3], at: impl Fn(usize) -> Stencil) {
    for k in 0..ABREAST {
        let found = at(k);
        for n in 0..3 {
            (nodes[n][k], weights[n][k]) = (found.nodes[n], found.weights[n]);
        }
    }
}
