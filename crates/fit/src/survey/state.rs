//! One component as it would be with more incidences.

use bsdfkit::{DVec3, Result};

use crate::interpolant::Component;
use crate::interpolant::mesh::IncidenceMesh;
use crate::measurement::Symmetry;
use crate::validate::{ErrorModel, Gap};

/// Incidences measured and proposed, and the errors to expect of them.
#[derive(Clone, Debug)]
pub(super) struct State<'a> {
    model: &'a ErrorModel,
    symmetry: Symmetry,
    /// How much this component counts: its share of the scattered light.
    pub(super) weight: f64,
    incidences: Vec<DVec3>,
    mesh: IncidenceMesh,
}

impl<'a> State<'a> {
    pub(super) fn new(whole: &Component, model: &'a ErrorModel) -> Result<Self> {
        let incidences: Vec<DVec3> = whole.incidences.iter().map(|i| i.wi).collect();
        let light: f64 = whole.incidences.iter().map(|i| i.hemispherical.max(0.0)).sum();
        Ok(Self {
            model,
            symmetry: whole.symmetry,
            weight: light / incidences.len().max(1) as f64,
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

    /// L1 to expect at `wi`.
    pub(super) fn expected(&self, wi: DVec3) -> f64 {
        let gap = Gap::at(&self.mesh, self.symmetry, wi);
        self.model.across(wi, gap.width).l1
    }

    /// Chord from `wi` to the nearest incidence or image of one.
    pub(super) fn room(&self, wi: DVec3) -> f64 {
        let (folded, _) = self.symmetry.fold(wi);
        self.mesh.vertices.iter().map(|v| v.wi.distance(folded)).fold(f64::MAX, f64::min)
    }
}
