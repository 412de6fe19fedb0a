//! One component as it would be with more incidences.

use bsdfkit::{DVec3, Result};

use crate::interpolant::Component;
use crate::interpolant::mesh::IncidenceMesh;
use crate::measurement::Symmetry;
use crate::validate::{ErrorModel, Gap};

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

/// How much wider a hole counts for the way past the rim: errors of extrapolation grow with the way
/// at once, not with its square. Of 0, 1.5, 2 and 3; at 0 rims are never closed.
const OUTSIDE: f64 = 2.0;

/// Incidences measured and proposed, and the errors to expect of them.
#[derive(Clone, Debug)]
pub(super) struct State<'a> {
    model: &'a ErrorModel,
    symmetry: Symmetry,
    incidences: Vec<DVec3>,
    mesh: IncidenceMesh,
}

impl<'a> State<'a> {
    pub(super) fn new(whole: &Component, model: &'a ErrorModel) -> Result<Self> {
        let incidences: Vec<DVec3> = whole.incidences.iter().map(|i| i.wi).collect();
        Ok(Self {
            model,
            symmetry: whole.symmetry,
            mesh: IncidenceMesh::new(&incidences, whole.symmetry)?,
            incidences,
        })
    }

    /// With one more incidence; `None` where it cannot be meshed.
    pub(super) fn with(&self, wi: DVec3) -> Option<Self> {
        let mut incidences = self.incidences.clone();
        incidences.push(self.symmetry.fold(wi).0);
        let mesh = IncidenceMesh::new(&incidences, self.symmetry).ok()?;
        Some(Self { mesh, incidences, ..*self })
    }

    /// Light to expect at `wi`.
    pub(super) fn expected(&self, wi: DVec3) -> Light {
        let gap = Gap::at(&self.mesh, self.symmetry, wi);
        let expected = self.model.across(wi, gap.width.hypot(OUTSIDE * gap.outside));
        Light { misplaced: expected.l1 * expected.background, all: expected.background }
    }

    /// Chord from `wi` to the nearest incidence or image of one.
    pub(super) fn room(&self, wi: DVec3) -> f64 {
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
