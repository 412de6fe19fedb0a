//! The continuous BSDF of one (incident side, scattered side) pair.

use std::collections::HashMap;

use bsdfkit::{DVec2, DVec3, Result, Side};
use bsdfkit_sphere::locate::Location;
use rayon::prelude::*;

use crate::interpolant::answer::distribution::{Corner, Distribution, UNSEEN};
use crate::interpolant::facet::facets::Facets;
use crate::interpolant::facet::refracted_lobe;
use crate::interpolant::family::assign::assigned;
use crate::interpolant::family::carried::Law;
use crate::interpolant::family::followed::FollowedPeaks;
use crate::interpolant::field::cells::Cells;
use crate::interpolant::field::energy::Energy;
use crate::interpolant::field::past_rim;
use crate::interpolant::incidence::fitted::FittedIncidence;
use crate::interpolant::mesh::incidence_mesh::{IncidenceMesh, Vertex};
use crate::interpolant::motion::cell_movers::{Moved, Movers};
use crate::interpolant::motion::edge_plan::EdgePlan;
use crate::interpolant::motion::hypothesis::Motion;
use crate::interpolant::motion::tracks::tracks;
use crate::lobe::frame::Frame;
use crate::lobe::{Lobe, LobeSet};
use crate::measurement::{Image, Symmetry};
use crate::source::{Followed, Slice, Source};

/// Fitted incidences, their mesh, and the plans along its edges.
#[derive(Clone, Debug)]
pub struct Component {
    /// Side of the incident directions.
    pub incident: Side,
    /// Side of the scattered directions.
    pub scattered: Side,
    /// Symmetry of the specimen.
    pub symmetry: Symmetry,
    /// How lobes move between incidences.
    pub motion: Motion,
    /// Small BSDF added to data and lobes before their ratio is taken, 1/sr.
    pub epsilon: f64,
    /// The measured incidences.
    pub incidences: Vec<FittedIncidence>,
    /// L1 to expect half-way between incidences; `None` where that was not looked for, or too few could be left out. See
    /// [`expected_between`](crate::validate::expected_between).
    pub expected_error: Option<f64>,
    mesh: IncidenceMesh,
    /// Lobes of every vertex that move, seen through its image.
    lobes: Vec<LobeSet>,
    /// Those that follow each of [`Motion::laws`].
    families: Vec<Vec<Vec<Lobe>>>,
    /// How each lobe of every vertex starts to move: gradients of its x and y. None if straight.
    tracks: Vec<Vec<[DVec3; 2]>>,
    /// Moving lobes of each triangle.
    triangles: Vec<Movers>,
    /// Triangles whose mirror image is no triangle, with the mirror.
    lopsided: HashMap<u32, Image>,
    /// Moving lobes of each edge of the outline (of a chain: of every edge).
    outline: HashMap<[u32; 2], Movers>,
    /// Plan of each edge of the mesh.
    plans: Vec<EdgePlan>,
    /// What transmitted peaks follow, if anything.
    facets: Facets,
    energy: Energy,
    /// The logarithm of the energy correction inside the mesh.
    inside: Cells,
}

/// A cell is joined along the other diagonal if its plan leaves so much less of the mass behind: a
/// margin against a choice by rounding.
const FEWER: f64 = 0.02;

impl Component {
    /// Meshes the fitted incidences and computes all plans.
    ///
    /// The energy between incidences is as the moved lobes give it, until
    /// [`balanced`](Self::balanced).
    pub fn new(
        incident: Side,
        scattered: Side,
        symmetry: Symmetry,
        motion: Motion,
        epsilon: f64,
        incidences: Vec<FittedIncidence>,
    ) -> Result<Self> {
        let by = |mesh: &IncidenceMesh, lobes: &[LobeSet]| {
            assigned(mesh, lobes, motion.frame, &motion.laws())
        };
        Self::with_families(incident, scattered, symmetry, motion, epsilon, incidences, by)
    }

    /// The same with transmitted peaks that follow facets.
    pub(crate) fn new_with_facets(
        incident: Side,
        scattered: Side,
        symmetry: Symmetry,
        motion: Motion,
        epsilon: f64,
        incidences: Vec<FittedIncidence>,
    ) -> Result<Self> {
        let new = Self::new(incident, scattered, symmetry, motion, epsilon, incidences);
        new.map(Self::with_facets)
    }

    /// The same where every lobe follows the one law of `motion`.
    pub(crate) fn of_one_family(
        incident: Side,
        scattered: Side,
        symmetry: Symmetry,
        motion: Motion,
        epsilon: f64,
        incidences: Vec<FittedIncidence>,
    ) -> Result<Self> {
        let by = |_: &IncidenceMesh, lobes: &[LobeSet]| {
            lobes.iter().map(|set| vec![Some(0); set.lobes.len()]).collect()
        };
        Self::with_families(incident, scattered, symmetry, motion, epsilon, incidences, by)
    }

    /// `by`: the law of each vertex's lobes.
    fn with_families(
        incident: Side,
        scattered: Side,
        symmetry: Symmetry,
        motion: Motion,
        epsilon: f64,
        incidences: Vec<FittedIncidence>,
        by: impl Fn(&IncidenceMesh, &[LobeSet]) -> Vec<Vec<Option<u8>>>,
    ) -> Result<Self> {
        let directions: Vec<DVec3> = incidences.iter().map(|i| i.wi).collect();
        let mesh = IncidenceMesh::in_chart(&directions, symmetry, motion.chart)?;
        let all: Vec<LobeSet> =
            mesh.vertices.iter().map(|v| incidences[v.incidence].image_lobes(v.image)).collect();
        let laws = motion.laws();
        let of = by(&mesh, &all);
        let split = |(set, of): (LobeSet, &Vec<Option<u8>>)| {
            let mut families = vec![Vec::new(); laws.len()];
            let mut lobes = Vec::new();
            for (lobe, of) in set.lobes.into_iter().zip(of) {
                match of {
                    Some(law) => families[*law as usize].push(lobe),
                    None => lobes.push(lobe),
                }
            }
            (LobeSet { floor: set.floor, lobes }, families)
        };
        let (lobes, families): (Vec<LobeSet>, Vec<Vec<Vec<Lobe>>>) =
            all.into_iter().zip(&of).map(split).unzip();
        let frames: Vec<_> = mesh.vertices.iter().map(|v| motion.frame.at(v.wi)).collect();
        let plan = |[a, b]: [u32; 2]| {
            let sets = [&lobes[a as usize], &lobes[b as usize]];
            let ends = [a, b].map(|v| frames[v as usize]);
            EdgePlan::between(sets[0], sets[1], motion.reach).beneath(sets, ends)
        };
        // A peak that is missing at one corner of a cell is cut off there, not across the cell.
        let mesh =
            mesh.with_diagonals(|other, joined| plan(other).left < plan(joined).left - FEWER)?;
        let edges = mesh.topology.edges();
        let plans: Vec<EdgePlan> = edges.iter().map(|&e| plan(e)).collect();
        let tracks = if motion.curved { tracks(&mesh, &lobes, &plans) } else { Vec::new() };
        Ok(Self {
            incident,
            scattered,
            symmetry,
            motion,
            epsilon,
            incidences,
            expected_error: None,
            lobes,
            families,
            tracks,
            triangles: Vec::new(),
            lopsided: mesh.lopsided(symmetry),
            mesh,
            plans,
            outline: HashMap::new(),
            facets: Facets::default(),
            energy: Energy::none(),
            inside: Cells::default(),
        }
        .glued())
    }

    /// The same with the moving lobes of all cells made anew from the plans.
    fn glued(mut self) -> Self {
        let topology = &self.mesh.topology;
        let directed = |a: u32, b: u32| match topology.edge_between(a, b) {
            Some(k) if topology.edges()[k as usize] == [a, b] => self.plans[k as usize].clone(),
            Some(k) => self.plans[k as usize].reversed(),
            None => EdgePlan::default(),
        };
        let lobes = |v: u32| &self.lobes[v as usize];
        let triangle = |&[a, b, c]: &[u32; 3]| {
            let plans = [directed(a, b), directed(b, c), directed(c, a)];
            Movers::of_triangle([a, b, c].map(lobes), [&plans[0], &plans[1], &plans[2]])
        };
        let edge =
            |&[a, b]: &[u32; 2]| ([a, b], Movers::of_edge([a, b].map(lobes), &directed(a, b)));
        let triangles = topology.triangles().iter().map(triangle).collect();
        let outline = topology.boundary().iter().map(edge).collect();
        (self.triangles, self.outline) = (triangles, outline);
        self
    }

    /// The same with directional-hemispherical values interpolated between incidences.
    #[must_use]
    pub fn balanced(mut self) -> Self {
        let totals: Vec<f64> =
            self.incidences.par_iter().map(|i| self.at(i.wi).directional_hemispherical()).collect();
        for (i, total) in self.incidences.iter_mut().zip(&totals) {
            i.hemispherical = *total;
        }
        let cut = self.with_facets();
        let energy = Energy::of(&cut);
        cut.with_energy(energy)
    }

    /// The same with the energy correction that was stored.
    pub(crate) fn with_energy(self, energy: Energy) -> Self {
        let inside = Cells::through(&self.mesh, |wi| energy.logarithm(wi));
        Self { energy, inside, ..self }
    }

    pub(crate) fn energy(&self) -> &Energy {
        &self.energy
    }

    /// Measured incidences and their images.
    pub(crate) fn vertices(&self) -> &[Vertex] {
        &self.mesh.vertices
    }

    pub(crate) fn mesh(&self) -> &IncidenceMesh {
        &self.mesh
    }

    /// The same with transmitted peaks that follow facets; needs the directional-hemispherical values.
    pub(crate) fn with_facets(mut self) -> Self {
        let of = |v: &Vertex| self.incidences[v.incidence].hemispherical;
        let energy: Vec<f64> = self.mesh.vertices.iter().map(of).collect();
        if self.incident != self.scattered {
            self.facets = Facets::of(&self.mesh, &self.lobes, &energy, self.motion.frame);
        }
        if self.facets.is_empty() {
            return self;
        }
        let plan = |&edge: &[u32; 2]| {
            let sets = edge.map(|v| &self.lobes[v as usize]);
            let ends = edge.map(|v| self.motion.frame.at(self.mesh.vertices[v as usize].wi));
            self.facets.plan(&self.lobes, edge, self.motion.reach).beneath(sets, ends)
        };
        self.plans = self.mesh.topology.edges().iter().map(plan).collect();
        self.glued()
    }

    /// The share of a vertex's energy that follows facets.
    pub(crate) fn following(&self, vertex: u32) -> f64 {
        self.of_followers(vertex).0 / self.hemispherical(vertex).max(1e-300)
    }

    /// The energy of a vertex's lobes that follow facets, and their mass above the horizon.
    fn of_followers(&self, vertex: u32) -> (f64, f64) {
        let set = &self.lobes[vertex as usize];
        let at = self.motion.frame.at(self.mesh.vertices[vertex as usize].wi);
        let mut following = 0.0;
        let families = self.families[vertex as usize].iter().flatten();
        let mut all = std::f64::consts::PI * set.floor
            + families.map(|l| l.mass * refracted_lobe::visible(l, &at)).sum::<f64>();
        for (i, lobe) in set.lobes.iter().enumerate() {
            let visible = lobe.mass * refracted_lobe::visible(lobe, &at);
            all += visible;
            if self.facets.rules(vertex, i as u16) {
                following += visible;
            }
        }
        (self.hemispherical(vertex) * following / all.max(1e-300), following)
    }

    /// At `wi` (folded): the energy that follows facets.
    pub(crate) fn on_facets(&self, wi: DVec3) -> f64 {
        let (corners, lambda, _) = self.cell(self.mesh.locate(wi));
        let at = self.motion.frame.at(wi);
        let visible = |m: &Moved| m.lobe.mass * refracted_lobe::visible(&m.lobe, &at);
        let follow: f64 = self.followers((corners, lambda), wi).iter().map(visible).sum();
        // What the measured energy is of the lobes' own.
        let (mut seen, mut all) = (0.0, 0.0);
        for k in 0..3 {
            let (energy, mass) = self.of_followers(corners[k]);
            if mass > 0.0 {
                seen += lambda[k] * energy / mass;
                all += lambda[k];
            }
        }
        if all > 0.0 { follow * seen / all } else { 0.0 }
    }

    /// The share of what its lobes would scatter at `wi` (folded) that is above the horizon.
    pub(crate) fn visible_share(&self, wi: DVec3) -> f64 {
        self.in_cell(self.mesh.locate(wi), wi, Image::IDENTITY).visible_share()
    }

    /// The directional-hemispherical value at a vertex.
    pub(crate) fn hemispherical(&self, vertex: u32) -> f64 {
        self.incidences[self.mesh.vertices[vertex as usize].incidence].hemispherical
    }

    /// The lobes at `wi` that follow facets, from the corners of its cell with these weights.
    fn followers(&self, cell: ([u32; 3], [f64; 3]), wi: DVec3) -> Vec<Moved> {
        self.facets.moved((&self.mesh, &self.lobes, self.motion.frame), cell, wi)
    }

    /// The point of the mesh with these weights.
    fn on_mesh(&self, corners: [u32; 3], lambda: [f64; 3]) -> DVec3 {
        self.mesh.between(&[0, 1, 2].map(|k| (corners[k], lambda[k])))
    }

    /// The corners of the cell at `location`, their weights, and the lobes that move in it.
    fn cell(&self, location: Location) -> ([u32; 3], [f64; 3], Option<&Movers>) {
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

    /// Whether an incident direction lies inside the mesh of measured ones.
    pub fn is_measured(&self, wi: DVec3) -> bool {
        let (folded, _) = self.symmetry.fold(DVec3::new(wi.x, wi.y, wi.z.abs()));
        match self.mesh.locate(folded) {
            Location::Inside { .. } => true,
            Location::Outside { distance, .. } => distance < 1e-9,
        }
    }

    /// The scattered distribution of incident direction `wi`.
    ///
    /// Cost: 5–50 µs, then 0.2–0.5 µs a value, and half of that where a [`Slice`](crate::source::Slice) takes many;
    /// past the rim of the mesh twice that.
    pub fn at(&self, wi: DVec3) -> Distribution<'_> {
        let wi = DVec3::new(wi.x, wi.y, wi.z.abs());
        let (folded, fold) = self.symmetry.fold(wi);
        let rim = self.mesh.between(&self.mesh.locate(folded).weights(&self.mesh.topology));
        let mut distribution = self.brought(folded, folded, fold);
        if self.motion.onward != 0.0
            && let Some(inner) = past_rim::inner(self.mesh.chart, rim, folded)
        {
            let scale = distribution.scale;
            let inner = Distribution { scale, ..self.brought(inner, folded, fold) };
            distribution.inner = Some((self.motion.onward, Box::new(inner)));
        }
        distribution
    }

    /// What the mesh has at `from`, or nearest to it, brought to `folded`.
    fn brought(&self, from: DVec3, folded: DVec3, fold: Image) -> Distribution<'_> {
        let location = self.mesh.locate(from);
        let mut distribution = self.in_cell(location, folded, fold);
        if let Location::Inside { triangle, .. } = location
            && let Some(&mirror) = self.lopsided.get(&triangle)
        {
            let location = self.mesh.locate(mirror.apply(from));
            let twin = self.in_cell(location, mirror.apply(folded), mirror.after(fold));
            distribution.twin = Some(Box::new(twin));
        }
        distribution
    }

    /// The energy correction at `folded`. Inside the mesh it bends at the edges of cells, where the
    /// moved lobes' energy does, so that their product hardly bends; past the rim it is smooth.
    fn scale(&self, folded: DVec3, on_mesh: DVec3, location: Location) -> f64 {
        let past = match location {
            Location::Inside { .. } => 0.0,
            Location::Outside { .. } => {
                self.energy.logarithm(folded) - self.energy.logarithm(on_mesh)
            }
        };
        Energy::factor(self.inside.at(&self.mesh, location) + past)
    }

    /// What the mesh has at `location`, brought to `folded`.
    fn in_cell(&self, location: Location, folded: DVec3, fold: Image) -> Distribution<'_> {
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
            None => Movers::of_edge([sets[0], sets[0]], &EdgePlan::between(sets[0], sets[0], 1.0))
                .at([sets[0]; 3], [1.0, 0.0, 0.0], &|_, _| DVec2::ZERO),
        };
        moved.extend(self.followers((corners, lambda), folded));
        let floor = (0..3).map(|k| lambda[k] * sets[k].floor).sum();
        let corner = |k: usize| {
            let v = &self.mesh.vertices[corners[k] as usize];
            Corner {
                weight: lambda[k],
                frame: self.motion.frame.at(v.wi),
                back: v.image.inverse(),
                incidence: &self.incidences[v.incidence],
                families: &self.families[corners[k] as usize],
                per_limit: 1.0
                    / (1.0 - self.incidences[v.incidence].limit.powi(2)).max(1e-6).sqrt(),
                unseen: if self.incident == self.scattered { UNSEEN } else { 1.0 },
            }
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
            scale: self.scale(folded, on_mesh, location),
            frame: self.motion.frame.at(folded),
            floor,
            epsilon: self.epsilon,
            moved,
            corners: [0, 1, 2].map(corner),
            laws,
            twin: None,
            inner: None,
        }
    }
}

impl Source for Component {
    fn incident(&self) -> Side {
        self.incident
    }

    fn scattered(&self) -> Side {
        self.scattered
    }

    fn isotropic(&self) -> bool {
        self.symmetry == Symmetry::Isotropic
    }

    fn channels(&self) -> usize {
        self.incidences.first().map_or(1, |i| i.details.len())
    }

    fn is_measured(&self, wi: DVec3) -> bool {
        Component::is_measured(self, wi)
    }

    fn slice<'a>(&'a self, wi: DVec3) -> Box<dyn Slice + 'a> {
        Box::new(self.at(wi))
    }

    fn followed(&self, chart: &bsdfkit::render::Chart) -> Option<Box<dyn Followed + '_>> {
        Some(Box::new(FollowedPeaks::of(self, chart)))
    }
}
