//! The five verbs over slices: what renderers and array languages call.
//!
//! Shapes: one result for each element of `out`. Each input has as many elements, or a single one
//! that counts for all. Errors: argument, for any other length; then nothing is written.
//!
//! Every result equals that of the single query, bit for bit, whatever the number of threads.
//! Cost: slices of at least [`PARALLEL`] results are shared out to rayon's current pool.

use std::f64::consts::FRAC_1_PI;
use std::ops::Range;

use bsdfkit_sphere::{concentric, hilbert};
use rayon::prelude::*;

use crate::component::{Components, Part};
use crate::distribution::{Lanes, Sense};
use crate::query::{Sample, choose_part, density, nan_if};
use crate::{Bsdf, DVec2, DVec3, Error, Result, Side, Xyz};

/// Results from which on several threads share the work: about a millisecond's worth.
pub const PARALLEL: usize = 1 << 14;

/// Results that one thread takes at a time. A guess: 0.1 ms outweighs handing it over.
const GRAIN: usize = 1 << 11;

/// Results that go through each step together; 256 fit numbers of 8 bits, and their coordinates the
/// first-level cache.
const BLOCK: usize = 256;

/// A slice with one element for each result, or one for all.
#[derive(Clone, Copy)]
struct Input<'a, T> {
    values: &'a [T],
    /// 1, or 0 when one element counts for all.
    step: usize,
}

impl<'a, T: Copy> Input<'a, T> {
    fn new(name: &str, values: &'a [T], results: usize) -> Result<Self> {
        match values.len() {
            found if found == results => Ok(Self { values, step: 1 }),
            1 => Ok(Self { values, step: 0 }),
            found => Err(Error::argument(format!(
                "{name}: expected {results} elements (as many as results) or 1, found {found}"
            ))),
        }
    }

    #[inline]
    fn at(&self, n: usize) -> T {
        self.values[n * self.step]
    }
}

impl Input<'_, DVec3> {
    fn block(&self, numbers: Range<usize>) -> Block {
        if self.step == 0 {
            return Block::of(std::iter::repeat_n(self.values[0], numbers.len()));
        }
        Block::of(self.values[numbers].iter().copied())
    }
}

/// Fills `out` block by block; `f` gets the numbers of a block's results, and the block.
fn fill<T: Send>(out: &mut [T], f: impl Fn(Range<usize>, &mut [T]) + Sync) {
    let fill_from = |first: usize, part: &mut [T]| {
        for (n, block) in part.chunks_mut(BLOCK).enumerate() {
            let first = first + n * BLOCK;
            f(first..first + block.len(), block);
        }
    };
    if out.len() < PARALLEL {
        fill_from(0, out);
    } else {
        out.par_chunks_mut(GRAIN).enumerate().for_each(|(n, part)| fill_from(n * GRAIN, part));
    }
}

/// Fills `out` result by result; `f` gets the number of a result.
fn fill_each<T: Send>(out: &mut [T], f: impl Fn(usize) -> T + Sync) {
    fill(out, |numbers, block| {
        for (n, result) in numbers.zip(block) {
            *result = f(n);
        }
    });
}

/// Up to [`BLOCK`] directions side by side.
struct Block {
    x: [f64; BLOCK],
    y: [f64; BLOCK],
    z: [f64; BLOCK],
    length: usize,
}

impl Block {
    fn of(directions: impl ExactSizeIterator<Item = DVec3>) -> Self {
        let length = directions.len();
        let mut block = Self { x: [0.0; BLOCK], y: [0.0; BLOCK], z: [0.0; BLOCK], length };
        for (n, w) in directions.enumerate().take(BLOCK) {
            (block.x[n], block.y[n], block.z[n]) = (w.x, w.y, w.z);
        }
        block
    }

    fn lanes(&self) -> Lanes<'_> {
        let n = self.length;
        Lanes { x: &self.x[..n], y: &self.y[..n], z: &self.z[..n] }
    }

    /// Those with the given numbers.
    fn some(&self, numbers: &[u8]) -> Self {
        let lanes = self.lanes();
        Self::of(numbers.iter().map(|&n| lanes.at(n.into())))
    }
}

/// Calls `f(incident, scattered, numbers)` for each pair of sides that occurs, with its members.
fn by_sides(wi: Lanes<'_>, wo: Lanes<'_>, mut f: impl FnMut(Side, Side, &[u8])) {
    let sides = [Side::Front, Side::Back];
    for (incident, scattered) in sides.into_iter().flat_map(|i| sides.map(|s| (i, s))) {
        let (mut numbers, mut count) = ([0_u8; BLOCK], 0);
        for n in 0..wo.len() {
            // Written in any case, kept if it belongs: no branch.
            numbers[count] = n as u8;
            let is = |z: f64, side| (z > 0.0) == (side == Side::Front);
            count += usize::from(is(wi.z[n], incident) && is(wo.z[n], scattered));
        }
        if count > 0 {
            f(incident, scattered, &numbers[..count]);
        }
    }
}

impl Bsdf {
    /// Values of pairs that share their sides, as [`Bsdf::eval`] finds them but for NaN; or, of a
    /// selection, as [`Bsdf::eval_components`] does.
    fn eval_block(
        &self,
        (incident, scattered): (Side, Side),
        (wi, wo): (Lanes<'_>, Lanes<'_>),
        selection: Option<Components>,
        out: &mut [f64],
    ) {
        let transmitted = incident != scattered;
        let on =
            |lambertian| selection.is_none_or(|c| c.selects(incident, transmitted, lambertian));
        let fields =
            if selection.is_some() { self.lambertian() } else { self.explicit_lambertian() };
        let lambertian = fields.get(incident, scattered).y * FRAC_1_PI;
        out.fill(if on(true) { lambertian } else { 0.0 });
        if !on(false) {
            return;
        }
        let mut values = [0.0; BLOCK];
        let values = &mut values[..out.len()];
        for (_, c, sense) in self.answering(incident, scattered) {
            match (selection, c.is_negligible()) {
                (None, true) => values.fill(c.floor().y),
                (Some(_), true) => continue,
                (_, false) => {
                    let (stored_wi, stored_wo) = match sense {
                        Sense::Forward => (wi, wo),
                        Sense::Reverse => (wo, wi),
                    };
                    c.distribution().values(stored_wi, stored_wo, values);
                }
            }
            let floor = if selection.is_some() { c.floor().y } else { f64::NEG_INFINITY };
            for (sum, value) in out.iter_mut().zip(&*values) {
                *sum += if selection.is_some() { (value - floor).max(0.0) } else { *value };
            }
        }
    }

    /// Values of any pairs.
    fn eval_mixed(
        &self,
        (wi, wo): (&Block, &Block),
        selection: Option<Components>,
        out: &mut [f64],
    ) {
        let (all_wi, all_wo) = (wi.lanes(), wo.lanes());
        by_sides(all_wi, all_wo, |incident, scattered, numbers| {
            let sides = (incident, scattered);
            if numbers.len() == out.len() {
                return self.eval_block(sides, (all_wi, all_wo), selection, out);
            }
            let (wi, wo) = (wi.some(numbers), wo.some(numbers));
            let mut some = [0.0; BLOCK];
            let some = &mut some[..numbers.len()];
            self.eval_block(sides, (wi.lanes(), wo.lanes()), selection, some);
            for (&n, value) in numbers.iter().zip(some) {
                out[usize::from(n)] = *value;
            }
        });
        for (n, out) in out.iter_mut().enumerate() {
            let nan = |w: Lanes<'_>| w.x[n].is_nan() | w.y[n].is_nan() | w.z[n].is_nan();
            *out = if nan(all_wi) | nan(all_wo) { f64::NAN } else { *out };
        }
    }

    /// [`Bsdf::directional_hemispherical`] of a block, but for NaN.
    fn totals(&self, wi: &Block, components: Components, out: &mut [f64]) {
        let all = wi.lanes();
        by_sides(all, all, |incident, _, numbers| {
            let some;
            let lanes = if numbers.len() == out.len() {
                all
            } else {
                some = wi.some(numbers);
                some.lanes()
            };
            let parts = self.parts_from(incident, lanes, components);
            for (k, &n) in numbers.iter().enumerate() {
                out[usize::from(n)] = parts.iter().map(|(_, totals)| totals[k]).sum();
            }
        });
    }

    /// [`Bsdf::sample`] of a block.
    fn sample_block(
        &self,
        wi: &Block,
        u: impl Iterator<Item = f64>,
        components: Components,
        out: &mut [Option<Sample>],
    ) {
        let mut numbers_of_u = [0.0; BLOCK];
        for (to, u) in numbers_of_u.iter_mut().zip(u) {
            *to = u;
        }
        let u = &numbers_of_u[..out.len()];
        let all = wi.lanes();
        out.fill(None);
        by_sides(all, all, |incident, _, numbers| {
            let some = wi.some(numbers);
            let mut some_u = [0.0; BLOCK];
            for (to, &n) in some_u.iter_mut().zip(numbers) {
                *to = u[usize::from(n)];
            }
            let mut samples = [None; BLOCK];
            let samples = &mut samples[..numbers.len()];
            self.sample_from(incident, &some, &some_u[..numbers.len()], components, samples);
            for (&n, sample) in numbers.iter().zip(samples) {
                out[usize::from(n)] = *sample;
            }
        });
    }

    /// [`Bsdf::sample`] of directions on one side.
    fn sample_from(
        &self,
        incident: Side,
        wi: &Block,
        u: &[f64],
        components: Components,
        out: &mut [Option<Sample>],
    ) {
        let count = out.len();
        // Each part's totals, in the order of `u`, and what is left of `u` after it.
        let parts = self.parts_from(incident, wi.lanes(), components);
        let weight: Vec<f64> =
            (0..count).map(|n| parts.iter().map(|(_, totals)| totals[n]).sum()).collect();
        let mut chosen = [None; BLOCK];
        let lanes = wi.lanes();
        for n in 0..count {
            if !lanes.at(n).is_nan() && !u[n].is_nan() {
                let totals = parts.iter().map(|(part, totals)| (*part, totals[n]));
                chosen[n] = choose_part(totals, u[n], weight[n]);
            }
        }
        let mut disks = [None; BLOCK];
        for (part, _) in &parts {
            let (mut numbers, mut length) = ([0_u8; BLOCK], 0);
            let mut rest = [0.0; BLOCK];
            for (n, c) in chosen[..count].iter().enumerate() {
                if let Some((_, u)) = c.filter(|(chosen, _)| chosen == part) {
                    (numbers[length], rest[length]) = (n as u8, u);
                    length += 1;
                }
            }
            let (numbers, rest) = (&numbers[..length], &rest[..length]);
            let mut drawn = [None; BLOCK];
            let drawn = &mut drawn[..length];
            match part {
                Part::Component(index) if length > 0 => {
                    let c = &self.components()[*index];
                    let sense =
                        if c.incident == incident { Sense::Forward } else { Sense::Reverse };
                    let some = wi.some(numbers);
                    let distribution = c.distribution();
                    distribution.samples(some.lanes(), sense, c.floor().y, rest, drawn);
                }
                _ => {
                    for (disk, u) in drawn.iter_mut().zip(rest) {
                        *disk = Some(concentric::square_to_disk(hilbert::unfold(*u)));
                    }
                }
            }
            for (&n, disk) in numbers.iter().zip(drawn) {
                disks[usize::from(n)] = *disk;
            }
        }
        let direction = |n: usize| {
            let ((part, _), disk) = (chosen[n]?, disks[n]?);
            let side = if self.crosses(part) { incident.opposite() } else { incident };
            Some((part, concentric::disk_to_hemisphere(disk, side)))
        };
        let wo = Block::of((0..count).map(|n| direction(n).map_or(DVec3::Z, |(_, wo)| wo)));
        let mut values = [0.0; BLOCK];
        let values = &mut values[..count];
        self.eval_mixed((wi, &wo), Some(components), values);
        for (n, out) in out.iter_mut().enumerate() {
            *out = direction(n).map(|(part, wo)| {
                let pdf = values[n] * wo.z.abs() / weight[n];
                Sample { wo, weight: weight[n], pdf, part }
            });
        }
    }

    /// Totals of each part for directions on one side, in the order of [`Bsdf::sample`].
    fn parts_from(
        &self,
        incident: Side,
        wi: Lanes<'_>,
        components: Components,
    ) -> Vec<(Part, Vec<f64>)> {
        let sides = [incident, incident.opposite()];
        let on = |s: Side, lambertian| components.selects(incident, s != incident, lambertian);
        let field = |s| if on(s, true) { self.lambertian().get(incident, s).y } else { 0.0 };
        let mut parts = vec![
            (Part::LambertianReflection, vec![field(sides[0]); wi.len()]),
            (Part::LambertianTransmission, vec![field(sides[1]); wi.len()]),
        ];
        for scattered in sides.into_iter().filter(|s| on(*s, false)) {
            for (index, c, sense) in self.answering(incident, scattered) {
                if !c.is_negligible() {
                    let mut totals = vec![0.0; wi.len()];
                    c.distribution().totals(wi, sense, c.floor().y, &mut totals);
                    parts.push((Part::Component(index), totals));
                }
            }
        }
        parts
    }
}

impl Bsdf {
    /// [`Bsdf::eval`] of many pairs: f(wi, wo), 1/sr.
    pub fn eval_many(&self, wi: &[DVec3], wo: &[DVec3], out: &mut [f64]) -> Result<()> {
        let (wi, wo) = (Input::new("wi", wi, out.len())?, Input::new("wo", wo, out.len())?);
        fill(out, |numbers, out| {
            self.eval_mixed((&wi.block(numbers.clone()), &wo.block(numbers)), None, out);
        });
        Ok(())
    }

    /// [`Bsdf::eval_xyz`] of many pairs: f(wi, wo) in colour, 1/sr.
    pub fn eval_xyz_many(&self, wi: &[DVec3], wo: &[DVec3], out: &mut [Xyz]) -> Result<()> {
        let (wi, wo) = (Input::new("wi", wi, out.len())?, Input::new("wo", wo, out.len())?);
        fill_each(out, |n| self.eval_xyz(wi.at(n), wo.at(n)));
        Ok(())
    }

    /// [`Bsdf::pdf`] of many pairs, 1/sr.
    pub fn pdf_many(
        &self,
        wi: &[DVec3],
        wo: &[DVec3],
        components: Components,
        out: &mut [f64],
    ) -> Result<()> {
        let (wi, wo) = (Input::new("wi", wi, out.len())?, Input::new("wo", wo, out.len())?);
        fill(out, |numbers, out| {
            let (wi, wo) = (wi.block(numbers.clone()), wo.block(numbers));
            self.eval_mixed((&wi, &wo), Some(components), out);
            let mut totals = [0.0; BLOCK];
            let totals = &mut totals[..out.len()];
            self.totals(&wi, components, totals);
            for ((out, total), z) in out.iter_mut().zip(totals).zip(wo.lanes().z) {
                *out = density(*out, *z, *total);
            }
        });
        Ok(())
    }

    /// [`Bsdf::directional_hemispherical`] of many incident directions.
    pub fn directional_hemispherical_many(
        &self,
        wi: &[DVec3],
        components: Components,
        out: &mut [f64],
    ) -> Result<()> {
        let wi = Input::new("wi", wi, out.len())?;
        fill(out, |numbers, out| {
            let wi = wi.block(numbers);
            self.totals(&wi, components, out);
            for (n, out) in out.iter_mut().enumerate() {
                *out = nan_if(wi.lanes().at(n), DVec3::ZERO, *out);
            }
        });
        Ok(())
    }

    /// [`Bsdf::projected_solid_angle`] of many directions or pairs: \[smallest, largest\], sr.
    pub fn projected_solid_angle_many(
        &self,
        wi: &[DVec3],
        wo: Option<&[DVec3]>,
        out: &mut [[f64; 2]],
    ) -> Result<()> {
        let results = out.len();
        let wi = Input::new("wi", wi, results)?;
        let wo = wo.map(|wo| Input::new("wo", wo, results)).transpose()?;
        fill_each(out, |n| self.projected_solid_angle(wi.at(n), wo.map(|wo| wo.at(n))).into());
        Ok(())
    }

    /// [`Bsdf::sample`] of many incident directions, each with its own `u`.
    pub fn sample_many(
        &self,
        wi: &[DVec3],
        u: &[f64],
        components: Components,
        out: &mut [Option<Sample>],
    ) -> Result<()> {
        let (wi, u) = (Input::new("wi", wi, out.len())?, Input::new("u", u, out.len())?);
        fill(out, |numbers, out| {
            let u = numbers.clone().map(|n| u.at(n));
            self.sample_block(&wi.block(numbers.clone()), u, components, out);
        });
        Ok(())
    }

    /// [`Bsdf::sample2`] of many incident directions, each with its own `u`.
    pub fn sample2_many(
        &self,
        wi: &[DVec3],
        u: &[DVec2],
        components: Components,
        out: &mut [Option<Sample>],
    ) -> Result<()> {
        let (wi, u) = (Input::new("wi", wi, out.len())?, Input::new("u", u, out.len())?);
        fill(out, |numbers, out| {
            let u = numbers.clone().map(|n| hilbert::fold(u.at(n)));
            self.sample_block(&wi.block(numbers.clone()), u, components, out);
        });
        Ok(())
    }
}
