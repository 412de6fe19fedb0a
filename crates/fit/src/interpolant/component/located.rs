//! What a planned component has at one incident direction.

use bsdfkit::{DVec2, DVec3};
use bsdfkit_sphere::locate::Location;

use crate::interpolant::answer::distribution::{Corner, Distribution};
use crate::interpolant::component::planned::Planned;
use crate::interpolant::family::carried::Law;
use crate::interpolant::field::past_rim;
use crate::interpolant::motion::cell_movers::{Moved, Movers};
use crate::interpolant::motion::edge_plan::EdgePlan;
use crate::lobe::frame::Frame;
use crate::measurement::Image;

/// The energy correction at an incident direction (folded), given its nearest point of the mesh and where that lies.
pub(crate) type Scale<'a> = &'a dyn Fn(DVec3, DVec3, Location) -> f64;

impl Planned {
    /// Whether an incident direction lies inside the mesh of measured ones.
    pub(crate) fn is_measured(&self, wi: DVec3) -> bool {
        let (folded, _) = self.fitted.symmetry.fold(DVec3::new(wi.x, wi.y, wi.z.abs()));
        match self.mesh.locate(folded) {
            Location::Inside { .. } => true,
            Location::Outside { distance, .. } => distance < 1e-9,
        }
    }

    /// The scattered distribution of incident direction `wi`, with the energy that moved lobes happen to have.
    pub(crate) fn at(&self, wi: DVec3) -> Distribution<'_> {
        self.scaled_at(wi, &|_, _, _| 1.0)
    }

    /// The same with an energy correction.
    pub(crate) fn scaled_at(&self, wi: DVec3, energy: Scale<'_>) -> Distribution<'_> {
        let wi = DVec3::new(wi.x, wi.y, wi.z.abs());
        let (folded, fold) = self.fitted.symmetry.fold(wi);
        let rim = self.mesh.between(&self.mesh.locate(folded).weights(&self.mesh.topology));
        let mut distribution = self.brought(folded, folded, fold, energy);
        if self.motion.onward != 0.0
            && let Some(inner) = past_rim::inner(self.mesh.chart, rim, folded)
        {
            let scale = distribution.scale;
            let inner = Distribution { scale, ..self.brought(inner, folded, fold, energy) };
            distribution.inner = Some((self.motion.onward, Box::new(inner)));
        }
        distribution
    }

    /// What the mesh has at `from`, or nearest to it, brought to `folded`.
    fn brought(
        &self,
        from: DVec3,
        folded: DVec3,
        fold: Image,
        energy: Scale<'_>,
    ) -> Distribution<'_> {
        let location = self.mesh.locate(from);
        let mut distribution = self.in_cell(location, folded, fold, energy);
        if let Location::Inside { triangle, .. } = location
            && let Some(&mirror) = self.lopsided.get(&triangle)
        {
            let location = self.mesh.locate(mirror.apply(from));
            let twin = self.in_cell(location, mirror.apply(folded), mirror.after(fold), energy);
            distribution.twin = Some(Box::new(twin));
        }
        distribution
    }

    /// The share of what its lobes would scatter at `wi` (folded) that is above the horizon.
    pub(crate) fn visible_share(&self, wi: DVec3) -> f64 {
        self.in_cell(self.mesh.locate(wi), wi, Image::IDENTITY, &|_, _, _| 1.0).visible_share()
    }

    /// The lobes at `wi` that follow facets, from the corners of its cell with these weights.
    pub(super) fn followers(&self, cell: ([u32; 3], [f64; 3]), wi: DVec3) -> Vec<Moved> {
        self.facets.moved((&self.mesh, &self.lobes, self.motion.frame), cell, wi)
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
        energy: Scale<'_>,
    ) -> Distribution<'_> {
        let (corners, lambda, movers) = self.cell(location);
        let sets = corners.map(|v| &self.lobes[v as usize]);
        let on_mesh = self.on_mesh(corners, lambda);
        let bend = |k: usize, lobe: usize| {
            let v = corners[k] as usize;
            let Some(&[x, y]) = self.tracks.get(v).and_then(|t| t.get(lobe)) else {
                return DVec2::ZERO;
            };
            let along = on_mesh - self.mesh.vertices[v].wi;
            DVec2::new(x.dot(along), y.dot(along))
        };
        let mut moved = match movers {
            Some(m) => m.at(sets, lambda, &bend),
            None => Movers::of_edge([sets[0], sets[0]], &EdgePlan::staying(sets[0])).at(
                [sets[0]; 3],
                [1.0, 0.0, 0.0],
                &|_, _| DVec2::ZERO,
            ),
        };
        moved.extend(self.followers((corners, lambda), folded));
        let floor = (0..3).map(|k| lambda[k] * sets[k].floor).sum();
        let corner = |k: usize| {
            let v = &self.mesh.vertices[corners[k] as usize];
            let incidence = &self.fitted.incidences[v.incidence];
            let frame = self.motion.frame.at(v.wi);
            let reflects = self.fitted.incident == self.fitted.scattered;
            let families = &self.families[corners[k] as usize];
            let back = v.image.inverse();
            Corner { back, families, ..Corner::new(incidence, frame, lambda[k], reflects) }
        };
        let at = |k: usize, law: Frame| law.at(self.mesh.vertices[corners[k] as usize].wi);
        let law = |(number, law): (usize, Frame)| {
            let frames = [0, 1, 2].map(|k| at(k, self.motion.frame));
            let lobes = corners.map(|v| self.families[v as usize][number].as_slice());
            Law::new(law.at(folded), [0, 1, 2].map(|k| at(k, law)), frames, lobes, lambda)
        };
        let laws: Vec<Law> = self.motion.laws().into_iter().enumerate().map(law).collect();
        Distribution {
            fold,
            scale: energy(folded, on_mesh, location),
            frame: self.motion.frame.at(folded),
            floor,
            epsilon: self.fitted.epsilon,
            moved,
            corners: [0, 1, 2].map(corner),
            laws,
            twin: None,
            inner: None,
        }
    }
}
