//! A mesh of incidences, measured and chosen, and the errors to expect of it.

use bsdfkit::DVec3;

use crate::interpolant::Chart;
use crate::interpolant::mesh::incidence_mesh::IncidenceMesh;
use crate::validate::{ErrorModel, Gap, POWER};
use bsdfkit_measure::Symmetry;

/// Scattered light to expect at one incident direction, or the mean over some, in proportion.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Light {
    /// |f − f′| summed up.
    pub(super) misplaced: f64,
    /// f summed up.
    pub(super) all: f64,
}

impl Light {
    pub(super) fn plus(self, weight: f64, other: Self) -> Self {
        Self {
            misplaced: self.misplaced + weight * other.misplaced,
            all: self.all + weight * other.all,
        }
    }

    /// L1; 0 where there is no light.
    pub(super) fn l1(self) -> f64 {
        if self.all > 0.0 { self.misplaced / self.all } else { 0.0 }
    }
}

/// How errors grow with the width of a hole.
#[derive(Clone, Copy, Debug)]
pub(super) enum ErrorLaw<'a> {
    /// As leaving incidences out has shown.
    Measured(&'a ErrorModel),
    /// Nothing is measured yet: with the cosine of the incident direction to this power, and as
    /// much light everywhere. In the chart from beneath the width alone would say as much, and
    /// single directions would find their best places less often: of pairs on a chain, what is left
    /// misplaced was 11 % over the least.
    Assumed(f64),
}

/// Below this cosine, the assumed law grows no more.
const LEAST_COSINE: f64 = 0.1;

impl ErrorLaw<'_> {
    /// Light to expect at `wi` (front hemisphere) in a hole like `gap`.
    fn light(self, wi: DVec3, gap: Gap) -> Light {
        let width = gap.equivalent();
        match self {
            Self::Measured(model) => {
                let expected = model.across(wi, width);
                Light { misplaced: expected.l1 * expected.background, all: expected.background }
            }
            Self::Assumed(power) => {
                let rate = wi.z.max(LEAST_COSINE).powf(power);
                Light { misplaced: rate * width.powf(POWER), all: 1.0 }
            }
        }
    }
}

/// What has been measured of one component.
#[derive(Clone, Debug)]
pub(super) struct SurveyedComponent<'a> {
    pub(super) law: ErrorLaw<'a>,
    pub(super) symmetry: Symmetry,
    pub(super) chart: Chart,
    /// Incident directions, front hemisphere.
    pub(super) measured: Vec<DVec3>,
}

impl<'a> SurveyedComponent<'a> {
    /// As it will be when `chosen` is measured, too; `None` where there is nothing, or nothing that
    /// can be meshed.
    pub(super) fn with(&self, chosen: &[DVec3]) -> Option<State<'a>> {
        let mut incidences = self.measured.clone();
        incidences.extend(chosen.iter().map(|&wi| self.symmetry.fold(wi).0));
        if incidences.is_empty() {
            return None;
        }
        let mesh = IncidenceMesh::in_chart(&incidences, self.symmetry, self.chart).ok()?;
        Some(State { law: self.law, symmetry: self.symmetry, mesh })
    }
}

/// Incidences measured and chosen, and the errors to expect of them.
#[derive(Clone, Debug)]
pub(super) struct State<'a> {
    law: ErrorLaw<'a>,
    symmetry: Symmetry,
    mesh: IncidenceMesh,
}

impl State<'_> {
    /// Light to expect at `wi`.
    pub(super) fn light(&self, wi: DVec3) -> Light {
        self.law.light(self.symmetry.fold(wi).0, self.gap(wi))
    }

    /// The hole that `wi` lies in.
    pub(super) fn gap(&self, wi: DVec3) -> Gap {
        Gap::at(&self.mesh, self.symmetry, wi)
    }

    /// Chord from `wi` to the nearest incidence or image of one.
    pub(super) fn distance_to_nearest(&self, wi: DVec3) -> f64 {
        let (folded, _) = self.symmetry.fold(wi);
        self.mesh.vertices.iter().map(|v| v.wi.distance(folded)).fold(f64::MAX, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dark_directions_count_by_their_light() {
        let bright = Light { misplaced: 0.1, all: 1.0 };
        let dark = Light { misplaced: 0.02, all: 0.01 };
        let both = Light::default().plus(1.0, bright).plus(1.0, dark);
        assert!((both.l1() - 0.12 / 1.01).abs() < 1e-12);
        let unequal = Light::default().plus(3.0, bright).plus(1.0, dark);
        assert!((unequal.l1() - 0.32 / 3.01).abs() < 1e-12);
        assert_eq!(Light::default().l1(), 0.0);
    }
}
