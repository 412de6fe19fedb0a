//! The five verbs: eval, pdf, directional hemispherical, projected solid angle, sample.

use std::f64::consts::{FRAC_1_PI, PI};

use bsdfkit_sphere::concentric;

use crate::canonical::Canonical;
use crate::component::{Component, Components, Part, Scatter};
use crate::distribution::Prepared;
use crate::lanes::Sense;
use crate::specular::SpecularPeak;
use crate::unit::{BELOW_ONE, choose};
use crate::{Bsdf, DVec2, DVec3, Side, Xyz};

/// A total below this scatters nothing: the reference library's constant.
const BLACK: f64 = 1e-6;

/// Parts whose totals a sample keeps: those of two components on each side, and Lambertian ones.
const FEW: usize = 6;

/// A drawn direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// The scattered direction.
    pub wo: DVec3,
    /// f |cos θo| / pdf of the selected components, dimensionless. Of tables it is the same for every u:
    /// [`Bsdf::directional_hemispherical`] of the same selection. Of what is drawn by a table
    /// near it (an interpolant, the render form) it varies about that.
    pub weight: f64,
    /// Density of `wo` over solid angle, 1/sr: [`Bsdf::pdf`] of the same selection. Of a peak of no width
    /// ([`Part::Specular`]) the probability with which it is drawn, dimensionless; no other technique draws it.
    pub pdf: f64,
    /// The part that `u` fell in.
    pub part: Part,
}

/// The selected parts for one incident direction.
pub(crate) struct Selected<'a> {
    bsdf: &'a Bsdf,
    wi: DVec3,
    side: Side,
    components: Components,
    /// By number of the component; empty where all are tables.
    prepared: Vec<Option<Box<dyn Prepared + 'a>>>,
    /// Peaks of no width.
    peaks: Vec<SpecularPeak>,
}

impl Bsdf {
    /// f(wi, wo), photopic, 1/sr: no cosine. Peaks of no width are left out, in every verb that asks for a pair of
    /// directions: they have no value ([`Bsdf::specular_peaks`]).
    ///
    /// Invalid: NaN in, NaN out. z = 0 counts as back.
    ///
    /// Differs from: the reference multiplies what it looks up by a factor within ±3e-4.
    pub fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        let (incident, scattered) = (Side::of(wi), Side::of(wo));
        let mut f = self.explicit_lambertian().get(incident, scattered).y * FRAC_1_PI;
        for (_, c, sense) in self.answering(incident, scattered) {
            f += if c.is_negligible() { c.floor().y } else { value(c, sense, wi, wo) };
        }
        nan_if(wi, wo, f)
    }

    /// f(wi, wo) in colour, 1/sr; its Y equals [`Bsdf::eval`]. Grey data have X = Y = Z.
    pub fn eval_xyz(&self, wi: DVec3, wo: DVec3) -> Xyz {
        let (incident, scattered) = (Side::of(wi), Side::of(wo));
        let mut f = self.explicit_lambertian().get(incident, scattered) * FRAC_1_PI;
        for (_, c, sense) in self.answering(incident, scattered) {
            f += match sense {
                _ if c.is_negligible() => c.floor(),
                Sense::Forward => c.distribution().value_xyz(wi, wo),
                Sense::Reverse => c.distribution().value_xyz(wo, wi),
            };
        }
        f * nan_if(wi, wo, 1.0)
    }

    /// f(wi, wo) of the selected components alone, photopic, 1/sr.
    ///
    /// The constant part of each component counts as Lambertian.
    pub fn eval_components(&self, wi: DVec3, wo: DVec3, components: Components) -> f64 {
        nan_if(wi, wo, self.selected(wi, components).eval(wo))
    }

    /// Density with which [`Bsdf::sample`] draws `wo`, 1/sr (solid angle): of tables f |cos θo| /
    /// total. Selected peaks of no width are in the total, not in f: the density integrates to the probability with
    /// which none of them is drawn.
    ///
    /// Accuracy: each level of a tree rounds its share of the total to 6e-8. Invalid: NaN in, NaN
    /// out; 0 when nothing is scattered.
    pub fn pdf(&self, wi: DVec3, wo: DVec3, components: Components) -> f64 {
        nan_if(wi, wo, self.selected(wi, components).pdf(wo))
    }

    /// [`Bsdf::eval_components`] and [`Bsdf::pdf`] at once, for little more than one of them: what multiple importance
    /// sampling asks of a direction that came from elsewhere.
    pub fn eval_pdf(&self, wi: DVec3, wo: DVec3, components: Components) -> (f64, f64) {
        self.selected(wi, components).eval_pdf(wo).map(|found| nan_if(wi, wo, found)).into()
    }

    /// ∫ f |cos θo| dωo over the selected components, peaks of no width included: dimensionless, photopic.
    #[doc(alias = "DHR")]
    #[doc(alias = "DHT")]
    #[doc(alias = "albedo")]
    pub fn directional_hemispherical(&self, wi: DVec3, components: Components) -> f64 {
        nan_if(wi, wi, self.selected(wi, components).total())
    }

    /// Projected solid angle of the stored cells, sr: (smallest, largest).
    ///
    /// With `wo`: of the cells that the pair falls in. Without: of all cells that light from
    /// `wi` can reach. π where nothing but Lambertian parts is stored.
    pub fn projected_solid_angle(&self, wi: DVec3, wo: Option<DVec3>) -> (f64, f64) {
        if wi.is_nan() || wo.is_some_and(DVec3::is_nan) {
            return (f64::NAN, f64::NAN);
        }
        self.selected(wi, Components::ALL).projected_solid_angle(wo)
    }

    /// Draws a scattered direction with density [`Bsdf::pdf`]; `None` when nothing is scattered.
    ///
    /// One number `u` in \[0, 1) decides all: first the part (Lambertian reflection, Lambertian
    /// transmission, the other reflecting components, the other transmitting ones, peaks of no width; each takes an
    /// interval as long as its total), then by what remains of it the direction, along a Hilbert
    /// curve. So stratified u give stratified directions. [WKB14 §2.4]
    ///
    /// Invalid: `None` for NaN; `u` outside \[0, 1) is clamped.
    pub fn sample(&self, wi: DVec3, u: f64, components: Components) -> Option<Sample> {
        self.draw(wi, u, components)
    }

    /// Draws a scattered direction from two numbers, each in \[0, 1): density and weight as
    /// [`Bsdf::sample`], other directions.
    ///
    /// The first decides the part, as there. Then the square of scattered directions is warped
    /// level by level, rows by one number and columns by the other (of a matrix, rings and
    /// azimuths): points stratified in the square give directions stratified in two dimensions.
    /// Source: [CJAJ05].
    ///
    /// Accuracy: with one point in each of 23 × 23 strata, or of 16 × 16 shifted at random, the
    /// variance of a mean is 1.5 to 5 times less than by [`Bsdf::sample`] of `hilbert::fold(u)`;
    /// strata that are 2^k × 2^k squares are better folded (1.4 to 3 times less). Either way it is
    /// 7 to 60 times less than of random points.
    ///
    /// Invalid: `None` for NaN; `u` outside the square is clamped to it.
    pub fn sample2(&self, wi: DVec3, u: DVec2, components: Components) -> Option<Sample> {
        self.draw(wi, u, components)
    }

    pub(crate) fn draw(
        &self,
        wi: DVec3,
        u: impl Canonical,
        components: Components,
    ) -> Option<Sample> {
        if wi.is_nan() {
            return None;
        }
        self.selected(wi, components).sample(u)
    }

    /// Whether a part's light crosses the surface.
    pub(crate) fn crosses(&self, part: Part) -> bool {
        match part {
            Part::LambertianReflection => false,
            Part::LambertianTransmission => true,
            Part::Component(index) => self.components()[index].is_transmission(),
            Part::Specular(index) => self.specular()[index].is_transmission(),
        }
    }

    /// The selected parts for one incident direction.
    pub(crate) fn selected(&self, wi: DVec3, components: Components) -> Selected<'_> {
        let side = Side::of(wi);
        let mut prepared = Vec::new();
        if self.prepares() && !wi.is_nan() {
            prepared.resize_with(self.components().len(), || None);
            for scattered in [side, side.opposite()] {
                if components.selects(side, scattered != side, Scatter::DirectionalDiffuse) {
                    for (i, c, sense) in self.answering(side, scattered) {
                        prepared[i] = c.distribution().prepare(wi, sense);
                    }
                }
            }
        }
        let peaks = match self.specular().is_empty() {
            true => Vec::new(),
            false => self.specular_peaks(wi, components).collect(),
        };
        Selected { bsdf: self, wi, side, components, prepared, peaks }
    }

    /// Components that answer for light from `incident` to `scattered`, and in which sense.
    ///
    /// Convention: a component stored for that pair of sides answers as it is; where there is none,
    /// transmission stored for the opposite travel direction answers with the two vectors
    /// exchanged (Helmholtz reciprocity, without an index of refraction).
    pub(crate) fn answering(
        &self,
        incident: Side,
        scattered: Side,
    ) -> impl Iterator<Item = (usize, &Component, Sense)> {
        let (pair, sense) = if self.is_reversed(incident, scattered) {
            ((scattered, incident), Sense::Reverse)
        } else {
            ((incident, scattered), Sense::Forward)
        };
        let stored = self.components().iter().enumerate();
        stored
            .filter(move |(_, c)| (c.incident, c.scattered) == pair)
            .map(move |(i, c)| (i, c, sense))
    }
}

impl Selected<'_> {
    /// Selected parts with their totals, in the order of `u`.
    fn parts(&self) -> impl Iterator<Item = (Part, f64)> {
        let sides = [self.side, self.side.opposite()];
        let lambertian = sides.into_iter().map(|scattered| {
            let transmitted = scattered != self.side;
            let on = self.components.selects(self.side, transmitted, Scatter::Lambertian);
            let field = self.bsdf.lambertian().get(self.side, scattered).y;
            let part =
                if transmitted { Part::LambertianTransmission } else { Part::LambertianReflection };
            (part, if on { field } else { 0.0 })
        });
        let others = sides.into_iter().flat_map(|scattered| self.others(scattered));
        let others = others.map(|(i, c, sense)| {
            let total = match self.prepared(i) {
                Some(prepared) => prepared.total(),
                None => c.distribution().total(self.wi, sense, c.floor().y),
            };
            (Part::Component(i), total)
        });
        let peaks = self.peaks.iter().map(|p| (Part::Specular(p.index), p.coefficient.y));
        lambertian.chain(others).chain(peaks)
    }

    fn prepared(&self, component: usize) -> Option<&dyn Prepared> {
        self.prepared.get(component)?.as_deref()
    }

    /// Selected components to `scattered`, for their non-Lambertian part.
    fn others(&self, scattered: Side) -> impl Iterator<Item = (usize, &Component, Sense)> {
        let transmitted = scattered != self.side;
        let on = self.components.selects(self.side, transmitted, Scatter::DirectionalDiffuse);
        self.bsdf.answering(self.side, scattered).filter(move |(_, c, _)| on && !c.is_negligible())
    }

    pub(crate) fn total(&self) -> f64 {
        self.parts().map(|(_, total)| total).sum()
    }

    /// Density of [`Selected::sample`], 1/sr of solid angle.
    pub(crate) fn pdf(&self, wo: DVec3) -> f64 {
        density(self.drawn(wo), wo.z, self.total())
    }

    /// [`Bsdf::eval_pdf`], but for NaN.
    pub(crate) fn eval_pdf(&self, wo: DVec3) -> [f64; 2] {
        let (f, drawn) = self.eval_and_drawn(wo);
        [f, density(drawn, wo.z, self.total())]
    }

    /// Draws a direction with density [`Selected::pdf`]; `None` for NaN, and when nothing is
    /// scattered.
    pub(crate) fn sample(&self, u: impl Canonical) -> Option<Sample> {
        if u.has_nan() {
            return None;
        }
        let (part, rest, total) = self.choose(u.first())?;
        if let Part::Specular(index) = part {
            let peak = self.peaks.iter().find(|p| p.index == index)?;
            let pdf = peak.coefficient.y / total;
            return Some(Sample { wo: peak.wo, weight: total, pdf, part });
        }
        let wo = self.draw(part, u.with_first(rest))?;
        let (f, drawn) = self.eval_and_drawn(wo);
        let pdf = drawn * wo.z.abs() / total;
        let weight = match self.bsdf.varies() {
            false => total,
            true if drawn > 0.0 => total * f / drawn,
            true => return None,
        };
        Some(Sample { wo, weight, pdf, part })
    }

    /// [`Bsdf::projected_solid_angle`].
    pub(crate) fn projected_solid_angle(&self, wo: Option<DVec3>) -> (f64, f64) {
        let sides = [self.side, self.side.opposite()];
        let asked = sides.into_iter().filter(|s| wo.is_none_or(|wo| Side::of(wo) == *s));
        let mut range = (f64::INFINITY, 0.0_f64);
        for (i, c, sense) in asked.flat_map(|s| self.bsdf.answering(self.side, s)) {
            if c.is_negligible() {
                continue;
            }
            let found = match self.prepared(i) {
                Some(prepared) => Some(prepared.projected_solid_angle(wo)),
                None => c.distribution().projected_solid_angle(self.wi, wo, sense),
            };
            if let Some((low, high)) = found {
                range = (range.0.min(low), range.1.max(high));
            }
        }
        if range.1 > 0.0 { range } else { (PI, PI) }
    }

    /// The part that `u` falls in, what remains of `u`, and the total of all parts.
    fn choose(&self, u: f64) -> Option<(Part, f64, f64)> {
        // Kept, as far as they are few: a total costs more than the memory it is kept in.
        let mut kept = [(Part::LambertianReflection, 0.0); FEW];
        let (mut count, mut weight) = (0, 0.0);
        for part in self.parts() {
            if let Some(kept) = kept.get_mut(count) {
                *kept = part;
            }
            weight += part.1;
            count += 1;
        }
        let chosen = match kept.get(..count) {
            Some(parts) => choose_part(parts.iter().copied(), u, weight),
            None => choose_part(self.parts(), u, weight),
        };
        chosen.map(|(part, rest)| (part, rest, weight))
    }

    /// [`Bsdf::eval_components`], but for NaN.
    pub(crate) fn eval(&self, wo: DVec3) -> f64 {
        let floor = |c: &Component| c.floor().y;
        let of = |prepared: &dyn Prepared| (prepared.value(wo), 0.0);
        self.sum(wo, of, |c, sense| ((value(c, sense, self.wi, wo) - floor(c)).max(0.0), 0.0)).0
    }

    /// The density per projected solid angle of what is drawn, times the total: f of tables.
    fn drawn(&self, wo: DVec3) -> f64 {
        let of = |prepared: &dyn Prepared| (0.0, prepared.drawn(wo));
        let table = |c: &Component, sense| match c.distribution().draws_apart() {
            true => (0.0, c.distribution().drawn(self.wi, wo, sense)),
            false => (0.0, (value(c, sense, self.wi, wo) - c.floor().y).max(0.0)),
        };
        self.sum(wo, of, table).1
    }

    /// [`Selected::eval`] and [`Selected::drawn`].
    fn eval_and_drawn(&self, wo: DVec3) -> (f64, f64) {
        let of = |prepared: &dyn Prepared| (prepared.value(wo), prepared.drawn(wo));
        self.sum(wo, of, |c, sense| {
            if c.distribution().draws_apart() {
                let (f, drawn) = c.distribution().value_and_drawn(self.wi, wo, sense);
                ((f - c.floor().y).max(0.0), drawn)
            } else {
                let f = (value(c, sense, self.wi, wo) - c.floor().y).max(0.0);
                (f, f)
            }
        })
    }

    /// The sums over all parts of two things, `of` what is prepared, and of tables.
    fn sum(
        &self,
        wo: DVec3,
        of: impl Fn(&dyn Prepared) -> (f64, f64),
        table: impl Fn(&Component, Sense) -> (f64, f64),
    ) -> (f64, f64) {
        let scattered = Side::of(wo);
        let mut sums = (0.0, 0.0);
        if self.components.selects(self.side, scattered != self.side, Scatter::Lambertian) {
            let lambertian = self.bsdf.lambertian().get(self.side, scattered).y * FRAC_1_PI;
            sums = (lambertian, lambertian);
        }
        for (i, c, sense) in self.others(scattered) {
            let found = match self.prepared(i) {
                Some(prepared) => of(prepared),
                None => table(c, sense),
            };
            sums = (sums.0 + found.0, sums.1 + found.1);
        }
        sums
    }

    fn draw(&self, part: Part, u: impl Canonical) -> Option<DVec3> {
        let disk = match part {
            Part::LambertianReflection | Part::LambertianTransmission => {
                concentric::square_to_disk(u.point())
            }
            Part::Component(index) => {
                let c = &self.bsdf.components()[index];
                let sense = if c.incident == self.side { Sense::Forward } else { Sense::Reverse };
                match self.prepared(index) {
                    Some(prepared) => prepared.sample(u.folded())?,
                    None => u.sample(c.distribution(), self.wi, sense, c.floor().y)?,
                }
            }
            Part::Specular(_) => return None,
        };
        let side = if self.bsdf.crosses(part) { self.side.opposite() } else { self.side };
        Some(concentric::disk_to_hemisphere(disk, side))
    }
}

#[inline]
fn value(c: &Component, sense: Sense, wi: DVec3, wo: DVec3) -> f64 {
    match sense {
        Sense::Forward => c.distribution().value(wi, wo),
        Sense::Reverse => c.distribution().value(wo, wi),
    }
}

/// The part whose interval `u` falls in, and where in it; `None` when nothing is scattered.
#[inline]
pub(crate) fn choose_part<P>(
    parts: impl Iterator<Item = (P, f64)>,
    u: f64,
    weight: f64,
) -> Option<(P, f64)> {
    if weight.is_nan() || weight <= BLACK {
        return None;
    }
    choose(parts, u.clamp(0.0, BELOW_ONE) * weight)
}

/// f |cos θo| / total; 0 when nothing is scattered.
#[inline]
pub(crate) fn density(f: f64, z: f64, total: f64) -> f64 {
    if total > BLACK || f.is_nan() { f * z.abs() / total } else { 0.0 }
}

#[inline]
pub(crate) fn nan_if(wi: DVec3, wo: DVec3, value: f64) -> f64 {
    if wi.is_nan() || wo.is_nan() { f64::NAN } else { value }
}
