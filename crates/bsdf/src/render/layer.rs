//! One layer: values and densities in its frame.

use super::chart::{Chart, Fold, Stencil, whole};
use super::drawing::{Drawing, Drawn};
use super::frame::Placed;
use super::half::Half;
use super::polar::{distance, scale, unit};
use super::shape::Shape;
use super::spot::Spot;
use crate::words::Words;
use crate::{DVec2, Error, Result};

/// Arrays of a layer.
#[derive(Clone, Debug)]
pub struct Layer {
    pub(crate) shape: Shape,
    /// Quarter turns covered: 4, or 2 where one half mirrors the other.
    pub(crate) span: f64,
    /// 1 / core.
    pub(crate) over_core: f64,
    /// 1 / L(far).
    over_far: f64,
    /// (nodes, angles + 1, radii + 1).
    pub(crate) values: Words<Half>,
    /// (nodes, colour_angles + 1, colour_radii + 1, 2): X/Y and Z/Y, over 64.
    pub(crate) colour: Words<Half>,
    pub(crate) drawing: Drawing,
}

/// Distance over `core` about the peak within which densities are those there: over area, both of them vanish.
const MIDDLE: f64 = 1e-6;

/// Ratios of colour are stored over this.
pub(crate) const COLOUR_UNIT: f64 = 1.0 / 64.0;

/// A layer's numbers before they are stored.
#[derive(Clone, Debug, Default)]
pub struct Content {
    /// Values at (node, angle, radius), 1/sr.
    pub values: Vec<f64>,
    /// X/Y and Z/Y at (node, angle, radius).
    pub colour: Vec<f64>,
    /// Coefficients of hue at (node, angle, radius): what [`Hues`](super::Hues) are made of.
    pub hue: Vec<f64>,
    /// f |cos θo| over (a, β) at (node, angle, radius).
    pub density: Vec<f64>,
}

/// Largest number stored: room for blends.
const TOP: f64 = 32768.0;

impl Layer {
    /// A layer of these numbers; sets the units of `shape`.
    ///
    /// Errors: argument, for shapes that do not fit.
    pub fn new(chart: &Chart, mut shape: Shape, content: &Content) -> Result<Self> {
        let unit = |values: &[f64]| {
            let most = values.iter().copied().filter(|v| v.is_finite()).fold(0.0, f64::max);
            if most > 0.0 { (most / TOP).log2().ceil().exp2().clamp(1e-12, 1e12) } else { 1.0 }
        };
        shape.value_unit = unit(&content.values);
        shape.drawn_unit = unit(&content.density);
        let halves = |values: &[f64], unit: f64| {
            Words::from(values.iter().map(|v| Half::of(v / unit)).collect::<Vec<_>>())
        };
        let density = halves(&content.density, shape.drawn_unit);
        shape.check()?;
        let (sums, running) = Drawing::sums_of(&shape, &density);
        let arrays = Arrays {
            values: halves(&content.values, shape.value_unit),
            colour: halves(&content.colour, COLOUR_UNIT),
            density,
            sums: sums.into(),
            running: running.into(),
        };
        Self::of_arrays(chart, shape, arrays)
    }

    /// A layer of arrays as they are stored.
    ///
    /// Errors: argument, for shapes that do not fit.
    pub(crate) fn of_arrays(chart: &Chart, shape: Shape, arrays: Arrays) -> Result<Self> {
        shape.check()?;
        let lengths = shape.lengths(chart.nodes()).map(|l| l.iter().product::<usize>());
        let found = [
            arrays.values.len(),
            arrays.colour.len(),
            arrays.density.len(),
            arrays.sums.len(),
            arrays.running.len(),
        ];
        if lengths != found {
            return Err(Error::argument(format!(
                "layer: expected arrays of {lengths:?} elements, found {found:?}"
            )));
        }
        let span = if chart.fold() == Fold::IsotropicMirrored { 2.0 } else { 4.0 };
        let drawing = Drawing {
            angles: shape.drawn_angles,
            radii: shape.drawn_radii,
            unit: shape.drawn_unit,
            span,
            density: arrays.density,
            sums: arrays.sums,
            running: arrays.running,
        };
        let (values, colour) = (arrays.values, arrays.colour);
        let over_far = 1.0 / scale(shape.far / shape.core).max(1e-12);
        let over_core = 1.0 / shape.core;
        Ok(Self { shape, span, over_core, over_far, values, colour, drawing })
    }

    /// The form of its tables.
    pub fn shape(&self) -> &Shape {
        &self.shape
    }

    /// Where a scattered direction of these x, y and cosine z ≥ 0 is.
    #[inline(always)]
    pub(crate) fn spot(&self, placed: &Placed, xy: DVec2, z: f64) -> Spot {
        Spot::new(placed, xy, z, self.span, self.over_core)
    }

    /// Angle and radial coordinate of values, 0 to 1.
    #[inline(always)]
    pub(super) fn coordinates(&self, spot: &Spot) -> (f64, f64) {
        (spot.angle / self.span, (spot.scaled * self.over_far).min(1.0))
    }

    /// The blend of values, 1/sr.
    #[inline(always)]
    pub(crate) fn value(&self, nodes: &Stencil, spot: &Spot) -> f64 {
        let shape = &self.shape;
        if shape.angles == 0 {
            return 0.0;
        }
        self.read(spot).blend(&self.values, nodes) * shape.value_unit
    }

    /// Where values are read.
    #[inline(always)]
    pub(crate) fn read(&self, spot: &Spot) -> Read {
        let (a, t) = self.coordinates(spot);
        Read::new(a, t, self.shape.angles.max(1), self.shape.radii.max(1))
    }

    /// X and Z beside a value Y.
    pub(crate) fn value_xyz(&self, nodes: &Stencil, spot: &Spot) -> [f64; 3] {
        let shape = &self.shape;
        if shape.colour_angles == 0 || shape.angles == 0 {
            return [self.value(nodes, spot); 3];
        }
        let (a, t) = self.coordinates(spot);
        let read = self.read(spot);
        let tint = Read::new(a, t, shape.colour_angles, shape.colour_radii);
        let mut sum = [0.0; 3];
        for (node, weight) in nodes.iter() {
            let y = weight * read.at(&self.values, node, 1, 0);
            let ratio = |channel| tint.at(&self.colour, node, 2, channel) * COLOUR_UNIT;
            sum = [sum[0] + y * ratio(0), sum[1] + y, sum[2] + y * ratio(1)];
        }
        sum.map(|v| v * shape.value_unit)
    }

    /// x and y of a place drawn.
    #[inline(always)]
    pub(crate) fn direction(&self, placed: &Placed, drawn: &Drawn) -> DVec2 {
        let (e, _) = unit(drawn.angle);
        let v = placed.unstretched(e);
        let whole = scale(placed.reach(v) * self.over_core);
        placed.direction_at(v * distance(drawn.v * whole, self.shape.core))
    }

    /// The density per projected solid angle, of scattered directions of cosine z.
    #[inline(always)]
    pub(crate) fn density(&self, nodes: &Stencil, placed: &Placed, spot: &Spot, z: f64) -> f64 {
        let drawn = self.drawn(placed, spot, z);
        self.drawing.density(nodes, spot.angle, drawn.v) * drawn.over / drawn.under
    }

    /// Where densities are read.
    #[inline(always)]
    pub(crate) fn drawn(&self, placed: &Placed, spot: &Spot, z: f64) -> DrawnAt {
        let core = self.shape.core;
        // In the middle of the peak all angles are one.
        let middle = spot.length2 <= TINY;
        let along = if middle { placed.unstretched(DVec2::X) } else { spot.v };
        let (length2, sum) = if middle { (1.0, 1.0) } else { (spot.length2, spot.sum) };
        let reach = placed.reach(along) * if middle { 1.0 } else { spot.length };
        let whole = scale(reach * self.over_core);
        let length = spot.length.max(MIDDLE * core);
        let (area, per) = placed.area_over(spot.xy, z);
        DrawnAt {
            v: spot.scaled.max(MIDDLE) / whole,
            over: length2 * area,
            // α′ is (|x| + |y|)² / ρ².
            under: length * (length + core) * whole * (sum * sum) * per,
        }
    }
}

/// Where densities of a direction are read, and what makes them densities per projected solid angle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DrawnAt {
    pub(crate) v: f64,
    pub(crate) over: f64,
    pub(crate) under: f64,
}

/// Squares of distances below this are 0.
const TINY: f64 = 1e-200;

/// Four neighbours in a table and the weights between them.
pub(crate) struct Read {
    pub(crate) first: usize,
    /// From one angle to the next.
    pub(crate) next: usize,
    /// From one node to the next.
    pub(crate) size: usize,
    pub(crate) a: f64,
    pub(crate) t: f64,
}

impl Read {
    /// `a` and `t` from 0 to 1.
    #[inline(always)]
    pub(crate) fn new(a: f64, t: f64, angles: usize, radii: usize) -> Self {
        let (a, t) = (a * angles as f64, t * radii as f64);
        let (i, k) = (whole(a, angles - 1), whole(t, radii - 1));
        let next = radii + 1;
        let size = (angles + 1) * next;
        Self { first: i * next + k, next, size, a: a - i as f64, t: t - k as f64 }
    }

    /// Of one node, from a table with so many channels.
    #[inline(always)]
    pub(super) fn at(&self, table: &[Half], node: usize, channels: usize, channel: usize) -> f64 {
        let first = channels * (node * self.size + self.first) + channel;
        let get = |k: usize| table.get(first + channels * k).map_or(0.0, |h| h.value());
        self.mix([get(0), get(1), get(self.next), get(self.next + 1)])
    }

    /// Over all nodes.
    #[inline(always)]
    pub(crate) fn blend(&self, table: &[Half], nodes: &Stencil) -> f64 {
        let two = |at: usize| -> [f64; 2] {
            let found: Option<&[Half; 2]> = table.get(at..).and_then(<[Half]>::first_chunk);
            found.map_or([0.0; 2], |two| two.map(Half::value))
        };
        let of = |(node, weight): (usize, f64)| {
            let first = node * self.size + self.first;
            let ([a, b], [c, d]) = (two(first), two(first + self.next));
            weight * self.mix([a, b, c, d])
        };
        nodes.iter().fold(0.0, |sum, node| sum + of(node))
    }

    #[inline(always)]
    pub(crate) fn mix(&self, [a, b, c, d]: [f64; 4]) -> f64 {
        let low = a + self.t * (b - a);
        let high = c + self.t * (d - c);
        low + self.a * (high - low)
    }
}

/// Arrays as they are stored.
#[derive(Clone, Debug)]
pub(crate) struct Arrays {
    pub(crate) values: Words<Half>,
    pub(crate) colour: Words<Half>,
    pub(crate) density: Words<Half>,
    pub(crate) sums: Words<f32>,
    pub(crate) running: Words<f32>,
}
