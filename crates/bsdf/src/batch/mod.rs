//! The five verbs over slices: what renderers and array languages call.
//!
//! Shapes: one result for each element of `out`. Each input has as many elements, or a single one
//! that counts for all. Errors: argument, for any other length; then nothing is written.
//!
//! Every result equals that of the single query, bit for bit, whatever the number of threads.
//! Cost: slices of at least [`PARALLEL`] results are shared out to rayon's current pool.

mod bands;
mod block;
mod runs;
mod totals;

use std::f64::consts::FRAC_1_PI;

use bsdfkit_sphere::concentric;

pub use self::block::PARALLEL;
use self::block::{BLOCK, Block, Input, Members, by_sides, fill, fill_each, pick};
use crate::canonical::Canonical;
use crate::component::{Component, Components, Part, Scatter};
use crate::lanes::{Lanes, Sense};
use crate::query::{Sample, choose_part, density, nan_if};
use crate::{Bsdf, DVec2, DVec3, Result, Side, Xyz};

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
        let on = |kind| selection.is_none_or(|c| c.selects(incident, transmitted, kind));
        let fields =
            if selection.is_some() { self.lambertian() } else { self.explicit_lambertian() };
        let lambertian = fields.get(incident, scattered).y * FRAC_1_PI;
        out.fill(if on(Scatter::Lambertian) { lambertian } else { 0.0 });
        if !on(Scatter::DirectionalDiffuse) {
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
        by_sides(all_wi, all_wo, |incident, scattered, members| {
            let sides = (incident, scattered);
            let Members::Some(numbers) = members else {
                return self.eval_block(sides, (all_wi, all_wo), selection, out);
            };
            let (wi, wo) = (wi.some(numbers), wo.some(numbers));
            let mut some = [0.0; BLOCK];
            let some = &mut some[..numbers.len()];
            self.eval_block(sides, (wi.lanes(), wo.lanes()), selection, some);
            for (&n, value) in numbers.iter().zip(some) {
                out[usize::from(n)] = *value;
            }
        });
        if !(wi.nan | wo.nan) {
            return;
        }
        for (n, out) in out.iter_mut().enumerate() {
            let nan = |w: Lanes<'_>| w.x[n].is_nan() | w.y[n].is_nan() | w.z[n].is_nan();
            *out = if nan(all_wi) | nan(all_wo) { f64::NAN } else { *out };
        }
    }

    /// Values of a selection and what is drawn from, of pairs that share their sides; but for NaN.
    fn both_block(
        &self,
        (incident, scattered): (Side, Side),
        (wi, wo): (Lanes<'_>, Lanes<'_>),
        components: Components,
        out: &mut [[f64; 2]],
    ) {
        let on = |lambertian| components.selects(incident, incident != scattered, lambertian);
        let lambertian = self.lambertian().get(incident, scattered).y * FRAC_1_PI;
        out.fill([if on(Scatter::Lambertian) { lambertian } else { 0.0 }; 2]);
        if !on(Scatter::DirectionalDiffuse) {
            return;
        }
        let (mut values, mut drawn) = ([0.0; BLOCK], [0.0; BLOCK]);
        let (values, drawn) = (&mut values[..out.len()], &mut drawn[..out.len()]);
        for (_, c, sense) in self.answering(incident, scattered) {
            if c.is_negligible() {
                continue;
            }
            let (distribution, floor) = (c.distribution(), c.floor().y);
            let apart = distribution.draws_apart();
            match (apart, sense) {
                (true, _) => distribution.values_and_drawn(wi, wo, sense, values, drawn),
                (false, Sense::Forward) => distribution.values(wi, wo, values),
                (false, Sense::Reverse) => distribution.values(wo, wi, values),
            }
            for ((out, value), drawn) in out.iter_mut().zip(&*values).zip(&*drawn) {
                let f = (value - floor).max(0.0);
                *out = [out[0] + f, out[1] + if apart { *drawn } else { f }];
            }
        }
    }

    /// The same of any pairs.
    fn both_mixed(&self, (wi, wo): (&Block, &Block), components: Components, out: &mut [[f64; 2]]) {
        let (all_wi, all_wo) = (wi.lanes(), wo.lanes());
        by_sides(all_wi, all_wo, |incident, scattered, members| {
            let sides = (incident, scattered);
            let Members::Some(numbers) = members else {
                return self.both_block(sides, (all_wi, all_wo), components, out);
            };
            let (wi, wo) = (wi.some(numbers), wo.some(numbers));
            let mut some = [[0.0; 2]; BLOCK];
            let some = &mut some[..numbers.len()];
            self.both_block(sides, (wi.lanes(), wo.lanes()), components, some);
            for (&n, both) in numbers.iter().zip(some) {
                out[usize::from(n)] = *both;
            }
        });
        if wi.nan | wo.nan {
            for (n, out) in out.iter_mut().enumerate() {
                *out = out.map(|found| nan_if(all_wi.at(n), all_wo.at(n), found));
            }
        }
    }

    /// [`Bsdf::sample`] or [`Bsdf::sample2`] of a block.
    fn sample_block<U: Canonical>(
        &self,
        wi: &Block,
        u: &[U],
        components: Components,
        out: &mut [Option<Sample>],
    ) {
        let all = wi.lanes();
        by_sides(all, all, |incident, _, members| match members {
            Members::All => self.sample_from(incident, wi, u, components, out),
            Members::Some(numbers) => {
                let some = wi.some(numbers);
                let some_u = pick(u, numbers);
                let mut samples = [None; BLOCK];
                let samples = &mut samples[..numbers.len()];
                self.sample_from(incident, &some, &some_u[..numbers.len()], components, samples);
                for (&n, sample) in numbers.iter().zip(samples) {
                    out[usize::from(n)] = *sample;
                }
            }
        });
    }

    /// [`Bsdf::sample`] or [`Bsdf::sample2`] of directions on one side.
    fn sample_from<U: Canonical>(
        &self,
        incident: Side,
        wi: &Block,
        u: &[U],
        components: Components,
        out: &mut [Option<Sample>],
    ) {
        let (count, lanes) = (out.len(), wi.lanes());
        let (mut parts, mut weight) = (Vec::new(), [0.0; BLOCK]);
        let of = |c: &Component, sense, totals: &mut [f64]| {
            c.distribution().totals(lanes, sense, c.floor().y, totals);
        };
        self.for_each_part(incident, components, count, of, |part, totals| {
            for (weight, total) in weight.iter_mut().zip(totals) {
                *weight += total;
            }
            parts.push((part, totals.to_vec()));
        });
        // The number of the part that each falls in, and what the choice leaves of `u`.
        let (mut chosen, mut rest) = ([None; BLOCK], [U::default(); BLOCK]);
        for n in 0..count {
            if !(wi.nan && lanes.at(n).is_nan() || u[n].has_nan()) {
                let totals = parts.iter().enumerate().map(|(p, (_, totals))| (p, totals[n]));
                if let Some((part, left)) = choose_part(totals, u[n].first(), weight[n]) {
                    (chosen[n], rest[n]) = (Some(part), u[n].with_first(left));
                }
            }
        }
        let mut wo = Block { length: count, z: [1.0; BLOCK], ..Block::EMPTY };
        for (p, (part, _)) in parts.iter().enumerate() {
            let (mut numbers, mut length) = ([0_u8; BLOCK], 0);
            for (n, chosen) in chosen[..count].iter().enumerate() {
                numbers[length] = n as u8;
                length += usize::from(*chosen == Some(p));
            }
            let numbers = &numbers[..length];
            let mut drawn = [None; BLOCK];
            let drawn = &mut drawn[..length];
            let rest = pick(&rest, numbers);
            self.draw_part(incident, *part, &wi.some(numbers), &rest[..length], drawn);
            let side = if self.crosses(*part) { incident.opposite() } else { incident };
            for (&n, disk) in numbers.iter().zip(drawn) {
                let n = usize::from(n);
                match disk {
                    Some(disk) => {
                        let w = concentric::disk_to_hemisphere(*disk, side);
                        (wo.x[n], wo.y[n], wo.z[n]) = (w.x, w.y, w.z);
                    }
                    None => chosen[n] = None,
                }
            }
        }
        let mut both = [[0.0; 2]; BLOCK];
        let both = &mut both[..count];
        self.both_mixed((wi, &wo), components, both);
        for (n, out) in out.iter_mut().enumerate() {
            let ([f, drawn], total) = (both[n], weight[n]);
            *out = chosen[n].and_then(|part| {
                let wo = wo.lanes().at(n);
                let weight = match self.varies() {
                    false => total,
                    true if drawn > 0.0 => total * f / drawn,
                    true => return None,
                };
                Some(Sample { wo, weight, pdf: drawn * wo.z.abs() / total, part: parts[part].0 })
            });
        }
    }

    /// Projections of directions drawn from one part, for directions on one side.
    fn draw_part<U: Canonical>(
        &self,
        incident: Side,
        part: Part,
        wi: &Block,
        u: &[U],
        out: &mut [Option<DVec2>],
    ) {
        match part {
            // Peaks of no width are drawn one by one.
            Part::Specular(_) => {}
            _ if out.is_empty() => {}
            Part::Component(index) => {
                let c = &self.components()[index];
                let sense = if c.incident == incident { Sense::Forward } else { Sense::Reverse };
                U::samples(u, c.distribution(), wi.lanes(), sense, c.floor().y, out);
            }
            Part::LambertianReflection | Part::LambertianTransmission => {
                for (disk, u) in out.iter_mut().zip(u) {
                    *disk = Some(concentric::square_to_disk(u.point()));
                }
            }
        }
    }
}

impl Bsdf {
    /// [`Bsdf::eval`] of many pairs: f(wi, wo), 1/sr.
    pub fn eval_many(&self, wi: &[DVec3], wo: &[DVec3], out: &mut [f64]) -> Result<()> {
        let (wi, wo) = (Input::new("wi", wi, out.len())?, Input::new("wo", wo, out.len())?);
        if self.prepares() {
            self.eval_runs(wi, wo, out, |f| f.y);
            return Ok(());
        }
        fill(out, Block::pair, |(a, b), numbers, out| {
            wi.read(numbers.clone(), a);
            wo.read(numbers, b);
            self.eval_mixed((a, b), None, out);
        });
        Ok(())
    }

    /// [`Bsdf::eval_xyz`] of many pairs: f(wi, wo) in colour, 1/sr.
    pub fn eval_xyz_many(&self, wi: &[DVec3], wo: &[DVec3], out: &mut [Xyz]) -> Result<()> {
        let (wi, wo) = (Input::new("wi", wi, out.len())?, Input::new("wo", wo, out.len())?);
        if self.prepares() {
            self.eval_runs(wi, wo, out, |f| f);
            return Ok(());
        }
        fill_each(out, |n| self.eval_xyz(wi.at(n), wo.at(n)));
        Ok(())
    }

    /// [`Bsdf::eval_components`] of many pairs, 1/sr.
    pub fn eval_components_many(
        &self,
        wi: &[DVec3],
        wo: &[DVec3],
        components: Components,
        out: &mut [f64],
    ) -> Result<()> {
        let (wi, wo) = (Input::new("wi", wi, out.len())?, Input::new("wo", wo, out.len())?);
        if self.prepares() {
            self.each_run(wi, components, out, |selected, w, n| {
                let wo = wo.at(n);
                nan_if(w, wo, selected.eval(wo))
            });
            return Ok(());
        }
        fill(out, Block::pair, |(a, b), numbers, out| {
            wi.read(numbers.clone(), a);
            wo.read(numbers, b);
            self.eval_mixed((a, b), Some(components), out);
        });
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
        if self.prepares() {
            self.each_run(wi, components, out, |selected, w, n| {
                let wo = wo.at(n);
                nan_if(w, wo, selected.pdf(wo))
            });
            return Ok(());
        }
        if !self.specular().is_empty() {
            fill_each(out, |n| self.pdf(wi.at(n), wo.at(n), components));
            return Ok(());
        }
        fill(out, Block::pair, |(a, b), numbers, out| {
            wi.read(numbers.clone(), a);
            wo.read(numbers, b);
            let (mut both, mut totals) = ([[0.0; 2]; BLOCK], [0.0; BLOCK]);
            let (both, totals) = (&mut both[..out.len()], &mut totals[..out.len()]);
            self.both_mixed((a, b), components, both);
            self.totals(a, components, totals);
            for (n, out) in out.iter_mut().enumerate() {
                *out = density(both[n][1], b.lanes().z[n], totals[n]);
            }
        });
        Ok(())
    }

    /// [`Bsdf::eval_pdf`] of many pairs: \[value, density\], 1/sr.
    pub fn eval_pdf_many(
        &self,
        wi: &[DVec3],
        wo: &[DVec3],
        components: Components,
        out: &mut [[f64; 2]],
    ) -> Result<()> {
        let (wi, wo) = (Input::new("wi", wi, out.len())?, Input::new("wo", wo, out.len())?);
        if self.prepares() {
            self.each_run(wi, components, out, |selected, w, n| {
                let wo = wo.at(n);
                selected.eval_pdf(wo).map(|found| nan_if(w, wo, found))
            });
            return Ok(());
        }
        if !self.specular().is_empty() {
            fill_each(out, |n| self.eval_pdf(wi.at(n), wo.at(n), components).into());
            return Ok(());
        }
        fill(out, Block::pair, |(a, b), numbers, out| {
            wi.read(numbers.clone(), a);
            wo.read(numbers, b);
            let mut totals = [0.0; BLOCK];
            let totals = &mut totals[..out.len()];
            self.both_mixed((a, b), components, out);
            self.totals(a, components, totals);
            for (n, out) in out.iter_mut().enumerate() {
                out[1] = density(out[1], b.lanes().z[n], totals[n]);
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
        if self.prepares() {
            self.each_run(wi, Components::ALL, out, |selected, w, n| {
                let wo = wo.map(|wo| wo.at(n));
                match w.is_nan() || wo.is_some_and(DVec3::is_nan) {
                    true => [f64::NAN; 2],
                    false => selected.projected_solid_angle(wo).into(),
                }
            });
            return Ok(());
        }
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
        self.draw_many(wi, u, components, out)
    }

    /// [`Bsdf::sample2`] of many incident directions, each with its own `u`.
    pub fn sample2_many(
        &self,
        wi: &[DVec3],
        u: &[DVec2],
        components: Components,
        out: &mut [Option<Sample>],
    ) -> Result<()> {
        self.draw_many(wi, u, components, out)
    }

    fn draw_many<U: Canonical>(
        &self,
        wi: &[DVec3],
        u: &[U],
        components: Components,
        out: &mut [Option<Sample>],
    ) -> Result<()> {
        let (wi, u) = (Input::new("wi", wi, out.len())?, Input::new("u", u, out.len())?);
        if self.prepares() {
            self.each_run(wi, components, out, |selected, w, n| {
                if w.is_nan() { None } else { selected.sample(u.at(n)) }
            });
            return Ok(());
        }
        if !self.specular().is_empty() {
            fill_each(out, |n| self.draw(wi.at(n), u.at(n), components));
            return Ok(());
        }
        fill(out, Block::empty, |block, numbers, out| {
            wi.read(numbers.clone(), block);
            if u.step == 1 {
                return self.sample_block(block, &u.values[numbers], components, out);
            }
            self.sample_block(block, &[u.values[0]; BLOCK][..out.len()], components, out);
        });
        Ok(())
    }
}
