//! One layer: values and densities in its frame.

use serde::{Deserialize, Serialize};

use super::chart::{Chart, Fold, Stencil};
use super::drawing::{BLOCK, Drawing};
use super::frame::{Frame, Placed};
use super::polar::{angle, distance, scale};
use crate::words::{Word, Words};
use crate::{DVec2, Error, Result};

/// A number in \[0, 65504\] in two bytes: the bits of a half float.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(transparent)]
pub struct Half(pub(crate) u16);

impl Half {
    /// The nearest half; not finite or negative counts as 0, too large as the largest.
    pub(crate) fn of(value: f64) -> Self {
        let value = if value > 0.0 { value.min(65504.0) } else { 0.0 };
        Self(half::f16::from_f64(value).to_bits())
    }

    /// Its value, whatever the bits: finite and not negative.
    #[inline(always)]
    pub(crate) fn value(self) -> f64 {
        // Exponents differ by 112, and multiplying mends that for the smallest numbers, too.
        let scale = f32::from_bits((127 + 112) << 23);
        f64::from(f32::from_bits(u32::from(self.0 & 0x7fff) << 13) * scale)
    }
}

impl Word for Half {
    const BYTES: usize = 2;

    fn from_bytes(bytes: &[u8]) -> Self {
        bytes.first_chunk().map_or(Self(0), |b| Self(u16::from_le_bytes(*b)))
    }

    fn put(self, bytes: &mut Vec<u8>) {
        bytes.extend(self.0.to_le_bytes());
    }
}

/// The form of a layer's tables.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Shape {
    /// Where its peak goes.
    pub frame: Frame,
    /// Cells of values about the peak; 0 of a layer that is drawn from alone.
    pub angles: usize,
    /// Cells of values from the peak outward.
    pub radii: usize,
    /// Distance from the peak from which on cells widen in proportion to it.
    pub core: f64,
    /// Distance from the peak of the last values; beyond, they are those there.
    pub far: f64,
    /// Cells of colour about the peak; 0 for grey ones.
    pub colour_angles: usize,
    /// Cells of colour from the peak outward.
    pub colour_radii: usize,
    /// Cells of densities about the peak.
    pub drawn_angles: usize,
    /// Cells of densities from the peak to the horizon, a multiple of 4.
    pub drawn_radii: usize,
    /// 1/sr of values that count 1.
    pub value_unit: f64,
    /// Of densities that count 1.
    pub drawn_unit: f64,
}

impl Shape {
    /// Most cells along any coordinate.
    pub const MOST: usize = 1024;

    /// Errors: argument.
    pub fn check(&self) -> Result<()> {
        let sides = [
            ("angles", self.angles, 0),
            ("radii", self.radii, usize::from(self.angles > 0)),
            ("colour_angles", self.colour_angles, 0),
            ("colour_radii", self.colour_radii, usize::from(self.colour_angles > 0)),
            ("drawn_angles", self.drawn_angles, 1),
            ("drawn_radii", self.drawn_radii, BLOCK),
        ];
        for (name, found, least) in sides {
            if !(least..=Self::MOST).contains(&found) {
                let most = Self::MOST;
                return Err(Error::argument(format!(
                    "{name}: expected {least} to {most}, found {found}"
                )));
            }
        }
        if !self.drawn_radii.is_multiple_of(BLOCK) {
            let found = self.drawn_radii;
            return Err(Error::argument(format!(
                "drawn_radii: expected a multiple of {BLOCK}, found {found}"
            )));
        }
        let numbers = [
            ("core", self.core),
            ("far", self.far),
            ("value_unit", self.value_unit),
            ("drawn_unit", self.drawn_unit),
        ];
        if !(-2.0..=2.0).contains(&self.frame.factor) {
            let found = self.frame.factor;
            return Err(Error::argument(format!("factor: expected -2 to 2, found {found}")));
        }
        for (name, found) in numbers {
            if !(1e-12..=1e12).contains(&found) {
                return Err(Error::argument(format!(
                    "{name}: expected 1e-12 to 1e12, found {found}"
                )));
            }
        }
        Ok(())
    }

    /// Elements of each array: values, colour, density, sums, running sums.
    pub(crate) fn lengths(&self, nodes: usize) -> [Vec<usize>; 5] {
        let none = || vec![0];
        let drawn = self.drawn_angles + 1;
        [
            match self.angles {
                0 => none(),
                angles => vec![nodes, angles + 1, self.radii + 1],
            },
            match self.colour_angles {
                0 => none(),
                angles => vec![nodes, angles + 1, self.colour_radii + 1, 2],
            },
            vec![nodes, drawn, self.drawn_radii + 1],
            vec![nodes, drawn, self.drawn_radii / BLOCK + 1],
            vec![nodes, drawn],
        ]
    }

    /// The distance from the peak at a radial coordinate of values, 0 to 1.
    pub fn distance(&self, t: f64) -> f64 {
        distance(t * scale(self.far, self.core), self.core)
    }
}

/// Arrays of a layer.
#[derive(Clone, Debug)]
pub struct Layer {
    pub(crate) shape: Shape,
    /// Quarter turns covered: 4, or 2 where one half mirrors the other.
    pub(crate) span: f64,
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
        let over_far = 1.0 / scale(shape.far, shape.core).max(1e-12);
        Ok(Self { shape, span, over_far, values, colour, drawing })
    }

    /// The form of its tables.
    pub fn shape(&self) -> &Shape {
        &self.shape
    }

    /// The angle of a place as tables have it.
    #[inline(always)]
    pub(crate) fn angle(&self, q: DVec2) -> f64 {
        let q = if self.span < 4.0 { DVec2::new(q.x, q.y.abs()) } else { q };
        angle(q)
    }

    /// The radial coordinate of values, 0 to 1.
    #[inline(always)]
    pub(crate) fn radius(&self, q: DVec2) -> f64 {
        (scale(q.length(), self.shape.core) * self.over_far).min(1.0)
    }

    /// The blend of values, 1/sr.
    #[inline]
    pub(crate) fn value(&self, nodes: &Stencil, q: DVec2) -> f64 {
        let shape = &self.shape;
        if shape.angles == 0 {
            return 0.0;
        }
        let read = Read::new(self.angle(q) / self.span, self.radius(q), shape.angles, shape.radii);
        let table = (shape.angles + 1) * (shape.radii + 1);
        let values: &[Half] = &self.values;
        let of = |(node, weight): (usize, f64)| {
            let get =
                |k: usize| values.get(node * table + read.first + k).map_or(0.0, |h| h.value());
            let next = shape.radii + 1;
            weight * read.blend([get(0), get(1), get(next), get(next + 1)])
        };
        nodes.iter().map(of).sum::<f64>() * shape.value_unit
    }

    /// X and Z beside a value Y.
    #[inline]
    pub(crate) fn value_xyz(&self, nodes: &Stencil, q: DVec2) -> [f64; 3] {
        let shape = &self.shape;
        if shape.colour_angles == 0 || shape.angles == 0 {
            return [self.value(nodes, q); 3];
        }
        let (a, t) = (self.angle(q) / self.span, self.radius(q));
        let read = Read::new(a, t, shape.angles, shape.radii);
        let table = (shape.angles + 1) * (shape.radii + 1);
        let tint = Read::new(a, t, shape.colour_angles, shape.colour_radii);
        let tints = (shape.colour_angles + 1) * (shape.colour_radii + 1);
        let mut sum = [0.0; 3];
        for (node, weight) in nodes.iter() {
            let get = |k: usize| self.values.get(node * table + k).map_or(0.0, |h| h.value());
            let (k, next) = (read.first, shape.radii + 1);
            let y = weight * read.blend([get(k), get(k + 1), get(k + next), get(k + next + 1)]);
            let ratio = |channel: usize| {
                let get = |k: usize| {
                    let at = 2 * (node * tints + tint.first + k) + channel;
                    self.colour.get(at).map_or(0.0, |h| h.value())
                };
                let next = shape.colour_radii + 1;
                tint.blend([get(0), get(1), get(next), get(next + 1)]) * COLOUR_UNIT
            };
            sum = [sum[0] + y * ratio(0), sum[1] + y, sum[2] + y * ratio(1)];
        }
        sum.map(|v| v * shape.value_unit)
    }

    /// The density over the plane at a place.
    #[inline]
    pub(crate) fn density(&self, nodes: &Stencil, placed: &Placed, q: DVec2) -> f64 {
        let length = q.length();
        let e = if length > 0.0 { q / length } else { DVec2::X };
        let reach = placed.reach(e);
        let core = self.shape.core;
        let whole = scale(reach, core);
        let v = scale(length, core) / whole;
        // α′ without the root of `unit`.
        let sum = q.x.abs() + q.y.abs();
        let rate = if sum > 0.0 { sum * sum / (length * length) } else { 1.0 };
        let length = length.max(MIDDLE * core);
        let density = self.drawing.density(nodes, self.angle(q), v.max(MIDDLE / whole));
        density / (length * (length + core) * whole * rate)
    }
}

/// Four neighbours in a table and the weights between them.
struct Read {
    first: usize,
    a: f64,
    t: f64,
}

impl Read {
    /// `a` and `t` from 0 to 1.
    #[inline(always)]
    fn new(a: f64, t: f64, angles: usize, radii: usize) -> Self {
        let (a, t) = (a * angles as f64, t * radii as f64);
        let (i, k) = ((a as usize).min(angles - 1), (t as usize).min(radii - 1));
        Self { first: i * (radii + 1) + k, a: a - i as f64, t: t - k as f64 }
    }

    #[inline(always)]
    fn blend(&self, [a, b, c, d]: [f64; 4]) -> f64 {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_are_halves() {
        for bits in 0..=u16::MAX {
            let ours = Half(bits).value();
            assert!(ours.is_finite() && ours >= 0.0);
            let theirs = half::f16::from_bits(bits);
            if bits < 0x7c00 {
                assert_eq!(ours, theirs.to_f64(), "{bits}");
                assert_eq!(Half::of(ours).0, bits);
            }
        }
    }
}
