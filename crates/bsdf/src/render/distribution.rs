//! The verbs of a table.

use std::f64::consts::{FRAC_1_PI, PI, TAU};

use bsdfkit_sphere::widest::widest;

use super::draws::Draws;
use super::frame::Placed;
use super::known::Known;
use super::layer::Layer;
use super::loops::{Mixtures, Totals, Values};
use super::polar::{distance, scale, unit};
use super::table::RenderTable;
use crate::canonical::Canonical;
use crate::lanes::Lanes;
use crate::spectrum::Bands;
use crate::{DVec2, DVec3, Distribution, Sense, Xyz};

/// Cells along the radius and about the normal that stand in for a table in reverse where there is none.
const STAND_IN: (usize, usize) = (8, 12);

impl Distribution for RenderTable {
    fn value(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.is_nan() || wo.is_nan() {
            return f64::NAN;
        }
        Known::new(self, wi).value(wo)
    }

    fn values(&self, wi: Lanes<'_>, wo: Lanes<'_>, out: &mut [f64]) {
        widest(Values { table: self, wi, wo, out });
    }

    fn value_xyz(&self, wi: DVec3, wo: DVec3) -> Xyz {
        if wi.is_nan() || wo.is_nan() {
            return Xyz::grey(f64::NAN);
        }
        let [x, y, z] = Known::new(self, wi).value_xyz(wo);
        Xyz::new(x, y, z)
    }

    fn is_coloured(&self) -> bool {
        self.layers.iter().any(|l| l.shape.colour_angles > 0)
    }

    fn wavelengths(&self) -> Option<&Bands> {
        self.hues.as_ref().map(|hues| hues.hue().basis().bands())
    }

    fn spectra(&self, known: DVec3, other: &[DVec3], sense: Sense, out: &mut [f64]) {
        let Some(hues) = self.hues.as_ref().filter(|_| !known.is_nan()) else {
            return out.fill(f64::NAN);
        };
        let (forward, bands) = (Known::new(self, known), out.len() / other.len().max(1));
        for (&w, row) in other.iter().zip(out.chunks_exact_mut(bands.max(1))) {
            match sense {
                _ if w.is_nan() => row.fill(f64::NAN),
                Sense::Forward => forward.bands(hues, w, row),
                Sense::Reverse => Known::new(self, w).bands(hues, known, row),
            }
        }
    }

    fn constant_part(&self) -> Xyz {
        Xyz::ZERO
    }

    fn total(&self, known: DVec3, sense: Sense, _floor: f64) -> f64 {
        match (sense, &self.reverse) {
            _ if known.is_nan() => f64::NAN,
            (Sense::Forward, _) => Known::new(self, known).total(),
            (Sense::Reverse, Some(reverse)) => reverse.total(known, Sense::Forward, 0.0),
            (Sense::Reverse, None) => {
                let (radii, angles) = STAND_IN;
                let of = |n: usize| {
                    let r = (((n / angles) as f64 + 0.5) / radii as f64).sqrt();
                    let turn = (n % angles) as f64 / angles as f64 * TAU;
                    let wi = (DVec2::from_angle(turn) * r).extend((1.0 - r * r).sqrt());
                    self.value(wi, known)
                };
                let count = radii * angles;
                (0..count).map(of).sum::<f64>() * PI / count as f64
            }
        }
    }

    fn totals(&self, known: Lanes<'_>, sense: Sense, floor: f64, out: &mut [f64]) {
        match (sense, &self.reverse) {
            (Sense::Forward, _) => widest(Totals { table: self, known, out }),
            (Sense::Reverse, Some(reverse)) => reverse.totals(known, Sense::Forward, 0.0, out),
            (Sense::Reverse, None) => {
                let totals = (0..out.len()).map(|n| self.total(known.at(n), sense, floor));
                out.iter_mut().zip(totals).for_each(|(out, total)| *out = total);
            }
        }
    }

    fn max_total(&self, _floor: f64) -> f64 {
        self.largest_total
    }

    fn sample(&self, known: DVec3, sense: Sense, _floor: f64, u: f64) -> Option<DVec2> {
        match (sense, &self.reverse) {
            _ if known.is_nan() => None,
            (Sense::Forward, _) => Known::new(self, known).sample(u),
            (Sense::Reverse, Some(reverse)) => reverse.sample(known, Sense::Forward, 0.0, u),
            (Sense::Reverse, None) => Some(stand_in(bsdfkit_sphere::hilbert::unfold(u))),
        }
    }

    fn sample2(&self, known: DVec3, sense: Sense, _floor: f64, u: DVec2) -> Option<DVec2> {
        match (sense, &self.reverse) {
            _ if known.is_nan() => None,
            (Sense::Forward, _) => Known::new(self, known).sample2(u),
            (Sense::Reverse, Some(reverse)) => reverse.sample2(known, Sense::Forward, 0.0, u),
            (Sense::Reverse, None) => Some(stand_in(u)),
        }
    }

    fn samples(
        &self,
        known: Lanes<'_>,
        sense: Sense,
        floor: f64,
        u: &[f64],
        out: &mut [Option<DVec2>],
    ) {
        self.draw_many(known, sense, u, out, |of, known, sense, u| {
            of.sample(known, sense, floor, u)
        });
    }

    fn samples2(
        &self,
        known: Lanes<'_>,
        sense: Sense,
        floor: f64,
        u: &[DVec2],
        out: &mut [Option<DVec2>],
    ) {
        self.draw_many(known, sense, u, out, |of, known, sense, u| {
            of.sample2(known, sense, floor, u)
        });
    }

    fn draws_apart(&self) -> bool {
        true
    }

    fn drawn(&self, known: DVec3, other: DVec3, sense: Sense) -> f64 {
        match (sense, &self.reverse) {
            _ if known.is_nan() || other.is_nan() => f64::NAN,
            (Sense::Forward, _) => self.value_and_drawn(known, other, sense).1,
            (Sense::Reverse, Some(reverse)) => reverse.drawn(known, other, Sense::Forward),
            (Sense::Reverse, None) => self.total(known, sense, 0.0) * FRAC_1_PI,
        }
    }

    fn value_and_drawn(&self, known: DVec3, other: DVec3, sense: Sense) -> (f64, f64) {
        if sense == Sense::Reverse || known.is_nan() || other.is_nan() {
            return (self.value(other, known), self.drawn(known, other, sense));
        }
        let known = Known::new(self, known);
        let found = known.mixture(other);
        let drawn = if found.mass > 0.0 { found.density / found.mass * known.total() } else { 0.0 };
        (found.value, drawn)
    }

    fn values_and_drawn(
        &self,
        known: Lanes<'_>,
        other: Lanes<'_>,
        sense: Sense,
        values: &mut [f64],
        drawn: &mut [f64],
    ) {
        if sense == Sense::Forward {
            return widest(Mixtures { table: self, wi: known, wo: other, values, drawn });
        }
        self.values(other, known, values);
        for (n, drawn) in drawn.iter_mut().enumerate() {
            *drawn = self.drawn(known.at(n), other.at(n), sense);
        }
    }

    fn projected_solid_angle(
        &self,
        known: DVec3,
        other: Option<DVec3>,
        sense: Sense,
    ) -> Option<(f64, f64)> {
        if known.is_nan() || other.is_some_and(DVec3::is_nan) {
            return None;
        }
        if sense == Sense::Reverse {
            return match &self.reverse {
                Some(reverse) => reverse.projected_solid_angle(known, other, Sense::Forward),
                None => Some((PI, PI)),
            };
        }
        let known = Known::new(self, known);
        let mut range = (f64::INFINITY, 0.0_f64);
        let mut widen = |found: f64| range = (range.0.min(found), range.1.max(found));
        for (n, layer) in self.layers.iter().enumerate() {
            let (placed, _) = known.placed(n, layer);
            if let Some(other) = other {
                let (xy, z) = known.turned(other);
                let spot = layer.spot(&placed, xy, z);
                let (e, rate) = unit(spot.angle);
                let radii = layer.drawing.radii as f64;
                let v = spot.scaled / scale(reach(&placed, e) * layer.over_core);
                let middle = ((v * radii).floor().min(radii - 1.0) + 0.5) / radii;
                widen(cell(layer, &placed, e, rate, middle));
                continue;
            }
            let (angles, radii) = (layer.drawing.angles, layer.drawing.radii);
            for i in 0..angles {
                let (e, rate) = unit((i as f64 + 0.5) * layer.span / angles as f64);
                for k in 0..radii {
                    widen(cell(layer, &placed, e, rate, (k as f64 + 0.5) / radii as f64));
                }
            }
        }
        Some(range)
    }

    fn min_projected_solid_angle(&self) -> f64 {
        self.smallest_cell
    }
}

impl RenderTable {
    /// Side by side where there is a table to draw from; else one by one.
    fn draw_many<U: Canonical>(
        &self,
        known: Lanes<'_>,
        sense: Sense,
        u: &[U],
        out: &mut [Option<DVec2>],
        one: impl Fn(&Self, DVec3, Sense, U) -> Option<DVec2>,
    ) {
        let table = if sense == Sense::Forward { Some(self) } else { self.reverse.as_deref() };
        match table {
            Some(table) => widest(Draws { table, known, u, out }),
            None => {
                for (n, out) in out.iter_mut().enumerate() {
                    *out = one(self, known.at(n), sense, u[n]);
                }
            }
        }
    }
}

/// How far it is along the unit vector `e` of the plane from the peak to the horizon.
fn reach(placed: &Placed, e: DVec2) -> f64 {
    placed.reach(placed.unstretched(e))
}

/// Projected solid angle of the cells of densities about a place.
fn cell(layer: &Layer, placed: &Placed, e: DVec2, rate: f64, v: f64) -> f64 {
    let core = layer.shape.core;
    let whole = scale(reach(placed, e) * layer.over_core);
    let rho = distance(v * whole, core);
    let plane = layer.drawing.cell() * rho * (rho + core) * whole * rate;
    let xy = placed.direction(e * rho);
    let z = (1.0 - xy.length_squared()).max(1e-6).sqrt();
    plane / placed.area(xy, z)
}

/// Any direction, as likely as its projected solid angle.
fn stand_in(u: DVec2) -> DVec2 {
    bsdfkit_sphere::concentric::square_to_disk(u)
}
