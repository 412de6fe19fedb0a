//! Directional-hemispherical values of many directions.

use super::block::{BLOCK, Block, Input, Members, by_sides, fill, fill_each, share_out};
use crate::component::{Component, Components, Part, Scatter};
use crate::lanes::{Lanes, Sense};
use crate::matrix::{BothSides, KlemsBasis, OneSide};
use crate::query::nan_if;
use crate::{Bsdf, DVec3, Result, Side};

/// Results from which it pays to ask for the value of each patch first: four times as many.
const BY_PATCH: usize = 1 << 10;

impl Bsdf {
    /// [`Bsdf::directional_hemispherical`] of many incident directions.
    ///
    /// Cost: 2.5 ns each of matrices, 16 ns of trees.
    pub fn directional_hemispherical_many(
        &self,
        wi: &[DVec3],
        components: Components,
        out: &mut [f64],
    ) -> Result<()> {
        let wi = Input::new("wi", wi, out.len())?;
        if self.prepares() {
            self.each_run(wi, components, out, |selected, w, _| nan_if(w, w, selected.total()));
            return Ok(());
        }
        if !self.specular().is_empty() {
            fill_each(out, |n| self.directional_hemispherical(wi.at(n), components));
            return Ok(());
        }
        if wi.step == 1
            && out.len() >= BY_PATCH
            && let Some(sides) = self.by_patch(components)
        {
            share_out(out, |first, out| {
                let otherwise = |w| self.directional_hemispherical(w, components);
                sides.fill(&wi.values[first..first + out.len()], otherwise, out);
            });
            return Ok(());
        }
        fill(out, Block::empty, |block, numbers, out| {
            wi.read(numbers, block);
            self.totals(block, components, out);
            for (n, out) in out.iter_mut().enumerate().filter(|_| block.nan) {
                *out = nan_if(block.lanes().at(n), DVec3::ZERO, *out);
            }
        });
        Ok(())
    }

    /// Directional-hemispherical values by patch, where all components on a side have one basis.
    fn by_patch(&self, components: Components) -> Option<BothSides<'_>> {
        let one = |side| self.one_side(side, components);
        Some(BothSides { front: one(Side::Front)?, back: one(Side::Back)? })
    }

    fn one_side(&self, incident: Side, components: Components) -> Option<OneSide<'_>> {
        let mut found: Option<(&KlemsBasis, f64)> = None;
        for scattered in [incident, incident.opposite()] {
            let on =
                components.selects(incident, scattered != incident, Scatter::DirectionalDiffuse);
            for (_, c, sense) in self.answering(incident, scattered).filter(|_| on) {
                if !c.is_negligible() {
                    let patches = c.distribution().patches(sense)?;
                    if *found.get_or_insert(patches) != patches {
                        return None;
                    }
                }
            }
        }
        let mut values = [0.0; BLOCK];
        let values = values.get_mut(..found.map_or(1, |(basis, _)| basis.directions()))?;
        self.sum_of_parts(incident, components, values, |c, sense, totals| {
            c.distribution().totals_by_patch(sense, c.floor().y, totals);
        });
        match found {
            Some((basis, sign)) => OneSide::by_patch(basis, sign, values),
            None => Some(OneSide::Constant(values[0])),
        }
    }

    /// [`Bsdf::directional_hemispherical`] of a block, but for NaN.
    pub(super) fn totals(&self, wi: &Block, components: Components, out: &mut [f64]) {
        let all = wi.lanes();
        by_sides(all, all, |incident, _, members| match members {
            Members::All => self.totals_from(incident, all, components, out),
            Members::Some(numbers) => {
                let mut some = [0.0; BLOCK];
                let some = &mut some[..numbers.len()];
                self.totals_from(incident, wi.some(numbers).lanes(), components, some);
                for (&n, total) in numbers.iter().zip(some) {
                    out[usize::from(n)] = *total;
                }
            }
        });
    }

    /// [`Bsdf::directional_hemispherical`] of directions on one side, but for NaN.
    fn totals_from(&self, incident: Side, wi: Lanes<'_>, components: Components, out: &mut [f64]) {
        self.sum_of_parts(incident, components, out, |c, sense, totals| {
            c.distribution().totals(wi, sense, c.floor().y, totals);
        });
    }

    /// Totals of all parts on one side; `of` finds those of a component.
    fn sum_of_parts(
        &self,
        incident: Side,
        components: Components,
        out: &mut [f64],
        of: impl Fn(&Component, Sense, &mut [f64]),
    ) {
        out.fill(0.0);
        self.for_each_part(incident, components, out.len(), of, |_, totals| {
            for (sum, total) in out.iter_mut().zip(totals) {
                *sum += total;
            }
        });
    }

    /// Calls `f` with up to [`BLOCK`] totals of each part on one side, in the order of
    /// [`Bsdf::sample`], but for Lambertian parts that scatter nothing; `of` finds those of a
    /// component.
    pub(super) fn for_each_part(
        &self,
        incident: Side,
        components: Components,
        count: usize,
        of: impl Fn(&Component, Sense, &mut [f64]),
        mut f: impl FnMut(Part, &[f64]),
    ) {
        let sides = [incident, incident.opposite()];
        let on = |s: Side, kind| components.selects(incident, s != incident, kind);
        let mut totals = [0.0; BLOCK];
        let totals = &mut totals[..count];
        let lambertian = [Part::LambertianReflection, Part::LambertianTransmission];
        for (scattered, part) in sides.into_iter().zip(lambertian) {
            let field = self.lambertian().get(incident, scattered).y;
            if on(scattered, Scatter::Lambertian) && field > 0.0 {
                totals.fill(field);
                f(part, totals);
            }
        }
        for scattered in sides.into_iter().filter(|s| on(*s, Scatter::DirectionalDiffuse)) {
            for (index, c, sense) in self.answering(incident, scattered) {
                if !c.is_negligible() {
                    of(c, sense, totals);
                    f(Part::Component(index), totals);
                }
            }
        }
    }
}
