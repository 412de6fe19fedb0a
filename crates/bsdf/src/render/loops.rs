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
const ABREAST: usize = 32;

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
            block.values(table, wi, wo);
            for (k, out) in out.iter_mut().enumerate() {
                let nan = wi.at(k).is_nan() | wo.at(k).is_nan();
                *out = if nan { f64::NAN } else { block.sum[k] };
            }
        }
    }
}

type Row<T> = [T; ABREAST];

/// What pairs have in hand.
struct Block {
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
    pose: [Row<f64>; LAYER],
    /// Where it is read, and how much further along angle and radius.
    first: Row<usize>,
    along: [Row<f64>; 2],
    /// Four neighbours of three nodes.
    read: [Row<Half>; 12],
    sum: Row<f64>,
}

impl Block {
    #[inline(always)]
    fn new() -> Self {
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
            first: N,
            along: [F; 2],
            read: [[Half(0); ABREAST]; 12],
            sum: F,
        }
    }

    #[inline(always)]
    fn values(&mut self, table: &RenderTable, wi: Lanes<'_>, wo: Lanes<'_>) {
        for (to, from) in [(&mut self.wi, wi), (&mut self.wo, wo)] {
            for (to, from) in to.iter_mut().zip([from.x, from.y, from.z]) {
                to[..from.len()].copy_from_slice(from);
            }
        }
        self.see(table);
        self.sum = [0.0; ABREAST];
        let incidences: &[f32] = &table.incidences;
        let width = columns(table.layers.len());
        for (n, layer) in table.layers.iter().enumerate() {
            self.blend(incidences, width, columns(n));
            match layer.shape.frame.kind {
                FrameKind::Cosines => self.find(layer, FrameKind::Cosines),
                FrameKind::Slopes => self.find(layer, FrameKind::Slopes),
            }
            self.read(layer);
        }
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

    /// The columns of a layer.
    #[inline(always)]
    fn blend(&mut self, incidences: &[f32], width: usize, first: usize) {
        for k in 0..ABREAST {
            let mut sum = [0.0; LAYER];
            for (nodes, weights) in self.fine.iter().zip(&self.fine_weights) {
                let found = incidences.get(nodes[k] * width + first..);
                let record: Option<&[f32; LAYER]> = found.and_then(<[f32]>::first_chunk);
                let record = record.unwrap_or(&[0.0; LAYER]);
                for (sum, v) in sum.iter_mut().zip(record) {
                    *sum += weights[k] * f64::from(*v);
                }
            }
            for (row, sum) in self.pose.iter_mut().zip(sum) {
                row[k] = sum;
            }
        }
    }

    /// Where the tables of a layer are read.
    #[inline(always)]
    fn find(&mut self, layer: &Layer, kind: FrameKind) {
        let frame = Frame { kind, ..layer.shape.frame };
        for k in 0..ABREAST {
            let turn = Turn {
                x: DVec2::new(self.turn[0][k], self.turn[1][k]),
                y: DVec2::new(self.turn[2][k], self.turn[3][k]),
            };
            let xy = DVec2::new(self.at[0][k], self.at[1][k]);
            let at = Incidence { xy, z: self.at[2][k], turn };
            let pose = std::array::from_fn(|n| self.pose[n][k]);
            let placed = Placed::new(frame, &at, pose);
            let xy = turn.apply(DVec2::new(self.wo[0][k], self.wo[1][k]));
            let spot = layer.spot(&placed, xy, self.wo[2][k].abs());
            let read = layer.read(&spot);
            self.first[k] = read.first;
            (self.along[0][k], self.along[1][k]) = (read.a, read.t);
        }
    }

    /// Adds what a layer has there.
    #[inline(always)]
    fn read(&mut self, layer: &Layer) {
        let shape = &layer.shape;
        if shape.angles == 0 {
            return;
        }
        let table: &[Half] = &layer.values;
        let next = shape.radii + 1;
        let size = (shape.angles + 1) * next;
        for k in 0..ABREAST {
            for (n, nodes) in self.nodes.iter().enumerate() {
                let first = nodes[k] * size + self.first[k];
                let [a, b] = two(table, first);
                let [c, d] = two(table, first + next);
                (self.read[4 * n][k], self.read[4 * n + 1][k]) = (a, b);
                (self.read[4 * n + 2][k], self.read[4 * n + 3][k]) = (c, d);
            }
        }
        let factor = &self.pose[LAYER - 1];
        for k in 0..ABREAST {
            let read = Read { first: 0, next, size, a: self.along[0][k], t: self.along[1][k] };
            let mut value = 0.0;
            for (n, weights) in self.weights.iter().enumerate() {
                let four = std::array::from_fn(|c| self.read[4 * n + c][k].value());
                value += weights[k] * read.mix(four);
            }
            self.sum[k] += factor[k] * (value * shape.value_unit);
        }
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
