//! Samples of many directions, step by step side by side.

use bsdfkit_sphere::widest::Loop;

use super::chart::Stencil;
use super::drawing::{Column, Drawn, Strip, Within};
use super::frame::Pose;
use super::known::{LAYER, columns};
use super::layer::Layer;
use super::loops::{ABREAST, Block, Row};
use super::table::{MOST_LAYERS, RenderTable};
use crate::DVec2;
use crate::canonical::Canonical;
use crate::lanes::Lanes;
use crate::unit::{BELOW_ONE, choose};

/// The loop of [`Distribution::samples`](crate::Distribution::samples). What each step computes are the functions that
/// single queries call, too.
pub(super) struct Draws<'a, U> {
    pub(super) table: &'a RenderTable,
    pub(super) known: Lanes<'a>,
    pub(super) u: &'a [U],
    pub(super) out: &'a mut [Option<DVec2>],
}

impl<U: Canonical> Loop for Draws<'_, U> {
    #[inline(always)]
    fn run(self) {
        let Self { table, known, u, out } = self;
        let (mut block, mut steps) = (Block::new(), Steps::new());
        for (n, out) in out.chunks_mut(ABREAST).enumerate() {
            let part = n * ABREAST..n * ABREAST + out.len();
            let (known, u) = (known.part(part.clone()), &u[part]);
            block.seen(table, known);
            steps.choose(&block, table, known, u);
            out.fill(None);
            for (n, layer) in table.layers.iter().enumerate() {
                steps.draw(&mut block, table, (n, layer), out);
            }
        }
    }
}

/// What directions have in hand.
struct Steps {
    /// The layer drawn from, and the point that decides where in it.
    layer: Row<Option<usize>>,
    point: Row<DVec2>,
    /// Which directions draw from the layer at hand.
    members: Row<usize>,
    nodes: Row<Stencil>,
    column: Row<Column>,
    strip: Row<Strip>,
    within: Row<Within>,
    angle: Row<f64>,
    v: Row<f64>,
}

impl Steps {
    #[inline(always)]
    fn new() -> Self {
        Self {
            layer: [None; ABREAST],
            point: [DVec2::ZERO; ABREAST],
            members: [0; ABREAST],
            nodes: [Stencil { nodes: [0; 3], weights: [0.0; 3] }; ABREAST],
            column: [Column::default(); ABREAST],
            strip: [Strip::default(); ABREAST],
            within: [Within::default(); ABREAST],
            angle: [0.0; ABREAST],
            v: [0.0; ABREAST],
        }
    }

    /// The layer that each direction draws from.
    #[inline(always)]
    fn choose<U: Canonical>(
        &mut self,
        block: &Block,
        table: &RenderTable,
        known: Lanes<'_>,
        u: &[U],
    ) {
        self.layer = [None; ABREAST];
        let [total] = block.blended::<1>(table, 0);
        for k in 0..ABREAST {
            self.nodes[k] = block.stencil(k);
        }
        let mut masses = [[0.0; MOST_LAYERS]; ABREAST];
        for (n, layer) in table.layers.iter().enumerate() {
            let [factor] = block.blended::<1>(table, columns(n) + Pose::NUMBERS);
            for k in 0..ABREAST {
                masses[k][n] = factor[k] * layer.drawing.mass(&self.nodes[k]);
            }
        }
        let layers = table.layers.len();
        for (k, &u) in u.iter().enumerate() {
            if u.has_nan() || known.at(k).is_nan() || total[k] <= 0.0 {
                continue;
            }
            let masses = &masses[k][..layers];
            let found = match *masses {
                [mass] if mass > 0.0 => Some((0, u.first().clamp(0.0, BELOW_ONE))),
                _ => {
                    let all: f64 = masses.iter().sum();
                    let at = u.first().clamp(0.0, BELOW_ONE) * all;
                    choose(masses.iter().copied().enumerate(), at)
                }
            };
            if let Some((layer, left)) = found {
                (self.layer[k], self.point[k]) = (Some(layer), u.with_first(left).point());
            }
        }
    }

    /// Draws from one layer whatever falls in it.
    #[inline(always)]
    fn draw(
        &mut self,
        block: &mut Block,
        table: &RenderTable,
        (number, layer): (usize, &Layer),
        out: &mut [Option<DVec2>],
    ) {
        let mut count = 0;
        for k in 0..out.len() {
            self.members[count.min(ABREAST - 1)] = k;
            count += usize::from(self.layer[k] == Some(number));
        }
        let members = &self.members[..count];
        if members.is_empty() {
            return;
        }
        let drawing = &layer.drawing;
        for &k in members {
            self.column[k] = drawing.column(&self.nodes[k], self.point[k].x);
        }
        for &k in members {
            self.strip[k] = drawing.strip(&self.nodes[k], &self.column[k]);
        }
        for &k in members {
            self.within[k] = drawing.within(&self.strip[k], self.point[k].y);
        }
        for &k in members {
            let Drawn { angle, v } =
                drawing.place(&self.column[k], &self.strip[k], &self.within[k]);
            (self.angle[k], self.v[k]) = (angle, v);
        }
        block.pose = block.blended::<LAYER>(table, columns(number));
        for &k in members {
            let placed = block.placed(layer.shape.frame, k);
            let at = layer.direction(&placed, &Drawn { angle: self.angle[k], v: self.v[k] });
            out[k] = Some(block.turned_back(k, at));
        }
    }
}
