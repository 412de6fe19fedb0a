//! What a planned component has at one incident direction.

use bsdfkit::{DVec2, DVec3};
use bsdfkit_sphere::locate::Location;

use crate::interpolant::answer::distribution::{Corner, Distribution, on_disk};
use crate::interpolant::component::planned::Planned;
use crate::interpolant::family::carried::Law;
use crate::interpolant::field::past_rim;
use crate::interpolant::mesh::incidence_mesh::ON_MESH;
use crate::interpolant::motion::cell_movers::Movers;
use crate::interpolant::motion::edge_plan::EdgePlan;
use bsdfkit_measure::Image;

/// What is asked of an incident direction.
#[derive(Clone, Copy)]
pub(super) struct Asked<'a> {
    /// The energy correction at an incident direction (folded), given its nearest point of the mesh and where that lies.
    pub(super) energy: &'a dyn Fn(DVec3, DVec3, Location) -> f64,
    /// Only what is seen in this direction; `None`: everything.
    pub(super) toward: Option<DVec3>,
}

impl Planned {
    /// Whether an incident direction lies inside the mesh of measured ones.
    pub(crate) fn is_measured(&self, wi: DVec3) -> bool {
        let (folded, _) = self.fitted.symmetry.fold(DVec3::new(wi.x, wi.y, wi.z.abs()));
        match self.mesh.locate(folded) {
            Location::Inside { .. } => true,
            Location::Outside { distance, .. } => distance < ON_MESH,
        }
    }

    /// The scattered distribution of incident direction `wi`, with the energy that moved lobes happen to have.
    pub(crate) fn at(&self, wi: DVec3) -> Distribution<'_> {
        self.asked(wi, Asked { energy: &|_, _, _| 1.0, toward: None })
    }

    /// The scattered distribution of incident direction `wi`.
    pub(super) fn asked(&self, wi: DVec3, what: Asked<'_>) -> Distribution<'_> {
        let wi = DVec3::new(wi.x, wi.y, wi.z.abs());
        let (folded, fold) = self.fitted.symmetry.fold(wi);
        let location = self.mesh.locate(folded);
        let mut distribution = self.brought((location, folded), folded, fold, what);
        if self.motion.onward != 0.0 && matches!(location, Location::Outside { .. }) {
            let rim = self.mesh.between(&location.weights(&self.mesh.topology));
            if let Some(inner) = past_rim::inner(self.mesh.chart, rim, folded) {
                let (scale, within) = (distribution.scale, self.mesh.locate(inner));
                let inner = self.brought((within, inner), folded, fold, what);
                let inner = Distribution { scale, ..inner };
                distribution.inner = Some((self.motion.onward, Box::new(inner)));
            }
        }
        distribution
    }

    /// What the mesh has at `location`, that of `from` or nearest to it, brought to `folded`.
    fn brought(
        &self,
        (location, from): (Location, DVec3),
        folded: DVec3,
        fold: Image,
        what: Asked<'_>,
    ) -> Distribution<'_> {
        let mut distribution = self.in_cell(location, folded, fold, what);
        if let Location::Inside { triangle, .. } = location
            && let Some(&mirror) = self.lopsided.get(&triangle)
        {
            let location = self.mesh.locate(mirror.apply(from));
            let twin = self.in_cell(location, mirror.apply(folded), mirror.after(fold), what);
            distribution.twin = Some(Box::new(twin));
        }
        distribution
    }

    /// The share of what its lobes would scatter at `wi` (folded) that is above the horizon.
    pub(crate) fn visible_share(&self, wi: DVec3) -> f64 {
        let everything = Asked { energy: &|_, _, _| 1.0, toward: None };
        self.in_cell(self.mesh.locate(wi), wi, Image::IDENTITY, everything).visible_share()
    }

    /// The point of the mesh with these weights.
    fn on_mesh(&self, corners: [u32; 3], lambda: [f64; 3]) -> DVec3 {
        self.mesh.between(&[0, 1, 2].map(|k| (corners[k], lambda[k])))
    }

    /// The corners of the cell at `location`, their weights, and the lobes that move in it.
    pub(super) fn cell(&self, location: Location) -> ([u32; 3], [f64; 3], Option<&Movers>) {
        match location {
            Location::Inside { triangle, barycentric } => {
                let t = self.mesh.topology.triangles()[triangle as usize];
                (t, barycentric, Some(&self.triangles[triangle as usize]))
            }
            Location::Outside { edge: [a, b], fraction, .. } => {
                ([a, b, a], [1.0 - fraction, fraction, 0.0], self.outline.get(&[a, b]))
            }
        }
    }

    /// What the mesh has at `location`, brought to `folded`.
    fn in_cell(
        &self,
        location: Location,
        folded: DVec3,
        fold: Image,
        what: Asked<'_>,
    ) -> Distribution<'_> {
        let (corners, lambda, movers) = self.cell(location);
        let sets = corners.map(|v| &self.lobes[v as usize]);
        let on_mesh = self.on_mesh(corners, lambda);
        let frame = self.motion.frame.at(folded);
        let near = what.toward.map(|wo| frame.forward(on_disk(fold.apply(wo))));
        let bend = |k: usize, lobe: usize| {
            let v = corners[k] as usize;
            let Some(&[x, y]) = self.tracks.get(v).and_then(|t| t.get(lobe)) else {
                return DVec2::ZERO;
            };
            let along = on_mesh - self.mesh.vertices[v].wi;
            DVec2::new(x.dot(along), y.dot(along))
        };
        let mut moved = match movers {
            Some(m) => m.at(sets, lambda, &bend, near),
            None => Movers::of_edge([sets[0], sets[0]], &EdgePlan::staying(sets[0])).at(
                [sets[0]; 3],
                [1.0, 0.0, 0.0],
                &|_, _| DVec2::ZERO,
                near,
            ),
        };
        moved.extend(self.facets.moved(&self.lobes, (corners, lambda), (folded, &frame), near));
        let floor = (0..3).map(|k| lambda[k] * sets[k].floor).sum();
        let corner = |k: usize| {
            let v = &self.mesh.vertices[corners[k] as usize];
            let incidence = &self.fitted.incidences[v.incidence];
            let frame = &self.frames[corners[k] as usize];
            let reflects = self.fitted.incident == self.fitted.scattered;
            let families = &self.families[corners[k] as usize];
            let back = v.image.inverse();
            Corner { back, families, ..Corner::new(incidence, frame, lambda[k], reflects) }
        };
        let mut laws = Vec::with_capacity(self.laws.len());
        for (number, (law, at)) in self.laws.iter().enumerate() {
            let lobes = corners.map(|v| self.families[v as usize][number].as_slice());
            laws.push(Law::new(law.at(folded), corners.map(|v| &at[v as usize]), lobes, lambda));
        }
        Distribution {
            fold,
            scale: (what.energy)(folded, on_mesh, location),
            frame,
            floor,
            epsilon: self.fitted.epsilon,
            moved,
            corners: [0, 1, 2].map(corner),
            spectra: self.fitted.spectra.as_deref(),
            laws,
            twin: None,
            inner: None,
        }
    }
}
