//! The tables of a pair of sides, and their verbs.

use bsdfkit_sphere::hilbert;

use super::chart::{Chart, Stencil};
use super::frame::{Placed, Pose};
use super::incidence::Incidence;
use super::layer::Layer;
use super::polar::{angle, distance, scale, unit};
use crate::words::Words;
use crate::{DVec2, DVec3, Distribution, Error, Result, Sense, Xyz};

/// A function of two directions in the render form.
///
/// Immutable, shared by any number of threads.
///
/// Accuracy: totals are interpolated between nodes of a finer chart, as the factor is that gives each incidence its
/// energy. Cost: a value reads four numbers a node and layer, of three nodes (two of isotropic materials).
#[derive(Clone, Debug)]
pub struct RenderTable {
    pub(crate) chart: Chart,
    /// Where `incidences` has its nodes.
    pub(crate) fine: Chart,
    pub(crate) layers: Vec<Layer>,
    /// (nodes of `fine`, 1 + 6 layers): the total; of each layer its pose and what its values are multiplied by.
    pub(crate) incidences: Words<f32>,
    pub(crate) largest_total: f64,
    pub(crate) smallest_cell: f64,
    /// From the scattered direction to the incident one: totals and samples.
    pub(crate) reverse: Option<Box<RenderTable>>,
}

/// How many times as many intervals the finer chart has.
pub(crate) const FINER: usize = 2;

/// Most layers.
pub(crate) const MOST_LAYERS: usize = 16;

/// Cells along the radius and about the normal that stand in for a table in reverse where there is none.
const STAND_IN: (usize, usize) = (8, 12);

/// What queries of one known direction share.
#[derive(Clone, Copy)]
struct Seen {
    at: Incidence,
    nodes: Stencil,
    fine: Stencil,
}

impl RenderTable {
    /// A table of these layers, and `poses` of each at the nodes of the finer chart. All factors are 1, totals 0: see
    /// [`RenderTable::with_energy`].
    ///
    /// Errors: argument, for shapes that do not fit.
    pub fn new(chart: Chart, layers: Vec<Layer>, poses: &[Vec<Pose>]) -> Result<Self> {
        let fine = chart.refined(FINER).nodes();
        if poses.len() != layers.len() || poses.iter().any(|p| p.len() != fine) {
            let found: Vec<usize> = poses.iter().map(Vec::len).collect();
            return Err(Error::argument(format!(
                "poses: expected {fine} of each of {} layers, found {found:?}",
                layers.len(),
            )));
        }
        let mut incidences = Vec::with_capacity(fine * columns(layers.len()));
        for node in 0..fine {
            incidences.push(0.0);
            for poses in poses {
                incidences.extend(poses[node].numbers());
                incidences.push(1.0);
            }
        }
        Self::of_incidences(chart, layers, incidences)
    }

    fn of_incidences(chart: Chart, layers: Vec<Layer>, incidences: Vec<f32>) -> Result<Self> {
        let totals = incidences.iter().step_by(columns(layers.len()));
        let largest = f64::from(totals.fold(0.0_f32, |most, total| most.max(*total)));
        let mut table = Self::of_arrays(chart, layers, incidences.into(), largest, 0.0)?;
        table.smallest_cell = table.smallest();
        Ok(table)
    }

    pub(crate) fn of_arrays(
        chart: Chart,
        layers: Vec<Layer>,
        incidences: Words<f32>,
        largest_total: f64,
        smallest_cell: f64,
    ) -> Result<Self> {
        let fine = chart.refined(FINER);
        if !(1..=MOST_LAYERS).contains(&layers.len()) {
            return Err(Error::argument(format!(
                "layers: expected 1 to {MOST_LAYERS}, found {}",
                layers.len()
            )));
        }
        let (expected, found) = (columns(layers.len()) * fine.nodes(), incidences.len());
        if expected != found {
            return Err(Error::argument(format!(
                "incidences: expected {expected} elements, found {found}"
            )));
        }
        let sound = |v: f64| (0.0..=1e12).contains(&v);
        if !sound(largest_total) || !sound(smallest_cell) {
            return Err(Error::argument(format!(
                "largest total, smallest cell: expected finite numbers, found {largest_total} and {smallest_cell}"
            )));
        }
        Ok(Self { chart, fine, layers, incidences, largest_total, smallest_cell, reverse: None })
    }

    /// The same with these totals at the nodes of the finer chart, and factors of each layer there: (nodes, layers).
    ///
    /// Errors: argument, for numbers that do not fit.
    pub fn with_energy(self, totals: &[f32], factors: &[f32]) -> Result<Self> {
        let Self { chart, fine, layers, incidences, reverse, .. } = self;
        let (nodes, count) = (fine.nodes(), layers.len());
        if (totals.len(), factors.len()) != (nodes, nodes * count) {
            return Err(Error::argument(format!(
                "energy: expected {nodes} totals and {count} factors of each, found {} and {}",
                totals.len(),
                factors.len()
            )));
        }
        let mut incidences = incidences.to_vec();
        let records = incidences.chunks_exact_mut(columns(count));
        for ((record, total), factors) in records.zip(totals).zip(factors.chunks_exact(count)) {
            record[0] = *total;
            let layers = record[1..].chunks_exact_mut(LAYER);
            layers.zip(factors).for_each(|(layer, factor)| layer[LAYER - 1] = *factor);
        }
        Ok(Self { reverse, ..Self::of_incidences(chart, layers, incidences)? })
    }

    /// The same with tables for the opposite direction of travel, whose values are not asked for.
    #[must_use]
    pub fn with_reverse(self, reverse: Self) -> Self {
        Self { reverse: Some(Box::new(reverse)), ..self }
    }

    /// Bytes of all arrays.
    pub fn bytes(&self) -> usize {
        let layer = |l: &Layer| {
            let halves = l.values.len() + l.colour.len() + l.drawing.density.len();
            2 * halves + 4 * (l.drawing.sums.len() + l.drawing.running.len())
        };
        let reverse = self.reverse.as_ref().map_or(0, |r| r.bytes());
        self.layers.iter().map(layer).sum::<usize>() + 4 * self.incidences.len() + reverse
    }

    /// Where the nodes of incident directions are.
    pub fn chart(&self) -> &Chart {
        &self.chart
    }

    /// The layers, the sum of which are values.
    pub fn layers(&self) -> &[Layer] {
        &self.layers
    }

    /// Tables for the opposite direction of travel.
    pub fn reverse(&self) -> Option<&Self> {
        self.reverse.as_deref()
    }

    /// The chart that energy and poses are stored on.
    pub fn fine(&self) -> &Chart {
        &self.fine
    }

    #[inline]
    fn seen(&self, known: DVec3) -> Seen {
        let at = self.chart.incidence(known);
        Seen { at, nodes: self.chart.stencil(&at), fine: self.fine.stencil(&at) }
    }

    /// Columns of the incidences' array, blended.
    #[inline(always)]
    fn blended<const N: usize>(&self, seen: &Seen, first: usize) -> [f64; N] {
        let columns = columns(self.layers.len());
        let mut sum = [0.0; N];
        for (node, weight) in seen.fine.iter() {
            let at = node * columns + first;
            if let Some(record) = self.incidences.get(at..at + N) {
                for (sum, v) in sum.iter_mut().zip(record) {
                    *sum += weight * f64::from(*v);
                }
            }
        }
        sum
    }

    #[inline(always)]
    fn total_of(&self, seen: &Seen) -> f64 {
        let [total] = self.blended(seen, 0);
        total
    }

    /// The frame of a layer, and what its values are multiplied by.
    #[inline(always)]
    fn placed(&self, number: usize, seen: &Seen) -> (Placed, f64) {
        let [x, y, xx, xy, yy, factor] = self.blended(seen, columns(number));
        let placed = Placed::new(self.layers[number].shape.frame, &seen.at, [x, y, xx, xy, yy]);
        (placed, factor)
    }

    /// x and y as tables have them, and a cosine of at least 0.
    #[inline(always)]
    fn turned(seen: &Seen, w: DVec3) -> (DVec2, f64) {
        (seen.at.turn.apply(w.truncate()), w.z.abs())
    }

    #[inline]
    fn value_of(&self, seen: &Seen, wo: DVec3) -> f64 {
        let (xy, z) = Self::turned(seen, wo);
        let of = |(n, layer): (usize, &Layer)| {
            let (placed, factor) = self.placed(n, seen);
            factor * layer.value(&seen.nodes, placed.place(xy, z))
        };
        self.layers.iter().enumerate().map(of).sum()
    }

    /// What each layer adds to a value, its factor left out: `add` is told the number of the layer, and that.
    pub fn layer_values(&self, wi: DVec3, wo: DVec3, mut add: impl FnMut(usize, f64)) {
        let seen = self.seen(wi);
        let (xy, z) = Self::turned(&seen, wo);
        for (n, layer) in self.layers.iter().enumerate() {
            let (placed, _) = self.placed(n, &seen);
            add(n, layer.value(&seen.nodes, placed.place(xy, z)));
        }
    }

    /// Density per projected solid angle of `sample`, times the mass that it is drawn from; and that mass.
    #[inline]
    fn mixture(&self, seen: &Seen, other: DVec3) -> (f64, f64) {
        let (xy, z) = Self::turned(seen, other);
        let (mut density, mut mass) = (0.0, 0.0);
        for (n, layer) in self.layers.iter().enumerate() {
            let (placed, factor) = self.placed(n, seen);
            let q = placed.place(xy, z);
            density += factor * layer.density(&seen.nodes, &placed, q) * placed.area(xy, z);
            mass += factor * layer.drawing.mass(&seen.nodes);
        }
        (density, mass)
    }

    fn draw(&self, known: DVec3, u: f64, rest: impl Fn(f64) -> DVec2) -> Option<DVec2> {
        if known.is_nan() || u.is_nan() {
            return None;
        }
        let seen = self.seen(known);
        if self.total_of(&seen) <= 0.0 {
            return None;
        }
        let mass = |n: usize| {
            let (_, factor) = self.placed(n, &seen);
            factor * self.layers[n].drawing.mass(&seen.nodes)
        };
        let total: f64 = (0..self.layers.len()).map(mass).sum();
        let mut left = u.clamp(0.0, BELOW_ONE) * total;
        let mut chosen = None;
        for n in 0..self.layers.len() {
            let mass = mass(n);
            if mass > 0.0 {
                chosen = Some((n, (left / mass).min(BELOW_ONE)));
                if left < mass {
                    break;
                }
            }
            left -= mass;
        }
        let (n, left) = chosen?;
        let layer = &self.layers[n];
        let drawn = layer.drawing.draw(&seen.nodes, rest(left));
        let (placed, _) = self.placed(n, &seen);
        let (e, _) = unit(drawn.angle);
        let core = layer.shape.core;
        let q = e * distance(drawn.v * scale(placed.reach(e), core), core);
        Some(seen.at.turn.undo(placed.direction(q)))
    }

    /// Projected solid angle of the cells of densities about a place.
    fn cell(&self, layer: &Layer, placed: &Placed, e: DVec2, rate: f64, v: f64) -> f64 {
        let core = layer.shape.core;
        let whole = scale(placed.reach(e), core);
        let rho = distance(v * whole, core);
        let plane = layer.drawing.cell() * rho * (rho + core) * whole * rate;
        let xy = placed.direction(e * rho);
        let z = (1.0 - xy.length_squared()).max(1e-6).sqrt();
        plane / placed.area(xy, z)
    }

    fn smallest(&self) -> f64 {
        let step = (self.chart.nodes() / 32).max(1);
        let nodes = (0..self.chart.nodes()).step_by(step);
        let of =
            |node| self.projected_solid_angle(self.chart.direction(node), None, Sense::Forward);
        nodes.filter_map(of).fold(std::f64::consts::PI, |least, (low, _)| least.min(low))
    }
}

/// The largest number below 1 that stays below a mass when multiplied by it.
const BELOW_ONE: f64 = 1.0 - f64::EPSILON;

impl Distribution for RenderTable {
    fn value(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.is_nan() || wo.is_nan() {
            return f64::NAN;
        }
        self.value_of(&self.seen(wi), wo)
    }

    fn value_xyz(&self, wi: DVec3, wo: DVec3) -> Xyz {
        if wi.is_nan() || wo.is_nan() {
            return Xyz::grey(f64::NAN);
        }
        let seen = self.seen(wi);
        let (xy, z) = Self::turned(&seen, wo);
        let mut sum = [0.0; 3];
        for (n, layer) in self.layers.iter().enumerate() {
            let (placed, factor) = self.placed(n, &seen);
            let value = layer.value_xyz(&seen.nodes, placed.place(xy, z));
            sum.iter_mut().zip(value).for_each(|(sum, value)| *sum += factor * value);
        }
        Xyz::new(sum[0], sum[1], sum[2])
    }

    fn is_coloured(&self) -> bool {
        self.layers.iter().any(|l| l.shape.colour_angles > 0)
    }

    fn constant_part(&self) -> Xyz {
        Xyz::ZERO
    }

    fn total(&self, known: DVec3, sense: Sense, _floor: f64) -> f64 {
        match (sense, &self.reverse) {
            _ if known.is_nan() => f64::NAN,
            (Sense::Forward, _) => self.total_of(&self.seen(known)),
            (Sense::Reverse, Some(reverse)) => reverse.total(known, Sense::Forward, 0.0),
            (Sense::Reverse, None) => {
                let (radii, angles) = STAND_IN;
                let of = |n: usize| {
                    let r = (((n / angles) as f64 + 0.5) / radii as f64).sqrt();
                    let turn = (n % angles) as f64 / angles as f64 * std::f64::consts::TAU;
                    let wi = (DVec2::from_angle(turn) * r).extend((1.0 - r * r).sqrt());
                    self.value(wi, known)
                };
                let count = radii * angles;
                (0..count).map(of).sum::<f64>() * std::f64::consts::PI / count as f64
            }
        }
    }

    fn max_total(&self, _floor: f64) -> f64 {
        self.largest_total
    }

    fn sample(&self, known: DVec3, sense: Sense, _floor: f64, u: f64) -> Option<DVec2> {
        match (sense, &self.reverse) {
            (Sense::Forward, _) => self.draw(known, u, hilbert::unfold),
            (Sense::Reverse, Some(reverse)) => reverse.sample(known, Sense::Forward, 0.0, u),
            (Sense::Reverse, None) => stand_in(known, hilbert::unfold(u)),
        }
    }

    fn sample2(&self, known: DVec3, sense: Sense, _floor: f64, u: DVec2) -> Option<DVec2> {
        match (sense, &self.reverse) {
            (Sense::Forward, _) => self.draw(known, u.x, |rest| {
                DVec2::new(rest, u.y).clamp(DVec2::ZERO, DVec2::splat(BELOW_ONE))
            }),
            (Sense::Reverse, Some(reverse)) => reverse.sample2(known, Sense::Forward, 0.0, u),
            (Sense::Reverse, None) => stand_in(known, u),
        }
    }

    fn draws_apart(&self) -> bool {
        true
    }

    fn drawn(&self, known: DVec3, other: DVec3, sense: Sense) -> f64 {
        match (sense, &self.reverse) {
            _ if known.is_nan() || other.is_nan() => f64::NAN,
            (Sense::Forward, _) => {
                let seen = self.seen(known);
                let (density, mass) = self.mixture(&seen, other);
                if mass > 0.0 { density / mass * self.total_of(&seen) } else { 0.0 }
            }
            (Sense::Reverse, Some(reverse)) => reverse.drawn(known, other, Sense::Forward),
            (Sense::Reverse, None) => self.total(known, sense, 0.0) * std::f64::consts::FRAC_1_PI,
        }
    }

    fn value_and_drawn(&self, known: DVec3, other: DVec3, sense: Sense) -> (f64, f64) {
        if sense == Sense::Reverse || known.is_nan() || other.is_nan() {
            return (self.value(other, known), self.drawn(known, other, sense));
        }
        let seen = self.seen(known);
        let (xy, z) = Self::turned(&seen, other);
        let (mut value, mut density, mut mass) = (0.0, 0.0, 0.0);
        for (n, layer) in self.layers.iter().enumerate() {
            let (placed, factor) = self.placed(n, &seen);
            let q = placed.place(xy, z);
            value += factor * layer.value(&seen.nodes, q);
            density += factor * layer.density(&seen.nodes, &placed, q) * placed.area(xy, z);
            mass += factor * layer.drawing.mass(&seen.nodes);
        }
        let total = self.total_of(&seen);
        (value, if mass > 0.0 { density / mass * total } else { 0.0 })
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
                None => Some((std::f64::consts::PI, std::f64::consts::PI)),
            };
        }
        let seen = self.seen(known);
        let mut range = (f64::INFINITY, 0.0_f64);
        let mut widen = |found: f64| range = (range.0.min(found), range.1.max(found));
        for (n, layer) in self.layers.iter().enumerate() {
            let (placed, _) = self.placed(n, &seen);
            if let Some(other) = other {
                let (xy, z) = Self::turned(&seen, other);
                let q = placed.place(xy, z);
                let (e, rate) = unit(angle(q));
                let (core, radii) = (layer.shape.core, layer.drawing.radii as f64);
                let v = scale(q.length(), core) / scale(placed.reach(e), core);
                let middle = ((v * radii).floor().min(radii - 1.0) + 0.5) / radii;
                widen(self.cell(layer, &placed, e, rate, middle));
                continue;
            }
            let (angles, radii) = (layer.drawing.angles, layer.drawing.radii);
            for i in 0..angles {
                let (e, rate) = unit((i as f64 + 0.5) * layer.span / angles as f64);
                for k in 0..radii {
                    widen(self.cell(layer, &placed, e, rate, (k as f64 + 0.5) / radii as f64));
                }
            }
        }
        Some(range)
    }

    fn min_projected_solid_angle(&self) -> f64 {
        self.smallest_cell
    }
}

/// Columns of the incidences' array before those of a layer; of all layers there are none after.
const fn columns(layers: usize) -> usize {
    1 + LAYER * layers
}

/// Columns of a layer: its pose and factor.
const LAYER: usize = Pose::NUMBERS + 1;

/// Any direction, as likely as its projected solid angle.
fn stand_in(known: DVec3, u: DVec2) -> Option<DVec2> {
    (!known.is_nan()).then(|| bsdfkit_sphere::concentric::square_to_disk(u))
}
