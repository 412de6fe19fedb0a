//! Fitted incidences with a mesh, and with every lobe's way between them.

use std::collections::HashMap;

use bsdfkit::{DVec3, Error, Result};

use crate::interpolant::component::fitted::Fitted;
use crate::interpolant::facet::facets::Facets;
use crate::interpolant::family::assign::assigned;
use crate::interpolant::family::carried::Standing;
use crate::interpolant::mesh::incidence_mesh::{IncidenceMesh, Vertex};
use crate::interpolant::motion::cell_movers::Movers;
use crate::interpolant::motion::edge_plan::EdgePlan;
use crate::interpolant::motion::hypothesis::Motion;
use crate::interpolant::motion::tracks::tracks;
use crate::lobe::LobeSet;
use bsdfkit_measure::Image;
use bsdfkit_measure::frame::{Frame, FrameAt};

/// What moves between fitted incidences, and how: the second step. It answers as a component does, with the energy that
/// moved lobes happen to have.
#[derive(Clone, Debug)]
pub(crate) struct Planned {
    pub(crate) fitted: Fitted,
    /// How lobes move between incidences.
    pub(crate) motion: Motion,
    pub(crate) mesh: IncidenceMesh,
    /// Lobes of every vertex that move, seen through its image.
    pub(super) lobes: Vec<LobeSet>,
    /// Those that follow each of [`Motion::laws`].
    pub(super) families: Vec<Vec<Vec<Standing>>>,
    /// The frame at every vertex.
    pub(super) frames: Vec<FrameAt>,
    /// Each of the laws, and as it is at every vertex.
    pub(super) laws: Vec<(Frame, Vec<FrameAt>)>,
    /// How each lobe of every vertex starts to move: gradients of its x and y. None if straight.
    pub(super) tracks: Vec<Vec<[DVec3; 2]>>,
    /// Moving lobes of each triangle.
    pub(super) triangles: Vec<Movers>,
    /// Moving lobes of each edge of the outline (of a chain: of every edge).
    pub(super) outline: HashMap<[u32; 2], Movers>,
    /// Triangles whose mirror image is no triangle, with the mirror.
    pub(super) lopsided: HashMap<u32, Image>,
    /// What transmitted peaks follow, if anything.
    pub(super) facets: Facets,
}

/// Which lobes have laws of their own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Peaks {
    /// All follow the first law of the motion.
    Alike,
    /// Each the law or the facet that its neighbours show; without one, plans carry it.
    Apart,
}

/// A cell is joined along the other diagonal if its plan leaves so much less of the mass behind: a
/// margin against a choice by rounding.
const FEWER: f64 = 0.02;

impl Planned {
    /// Meshes the fitted incidences, tells laws and facets apart, and plans along every edge.
    ///
    /// Errors: format where incidences cannot be meshed; argument where they have neither one channel nor three, or
    /// not the coefficients that spectra need.
    pub(crate) fn new(fitted: Fitted, motion: Motion, peaks: Peaks) -> Result<Self> {
        let Fitted { scattered, incident, symmetry, .. } = fitted;
        let mesh = IncidenceMesh::in_chart(&fitted.directions(), symmetry, motion.chart)?;
        if fitted.incidences.iter().any(|i| ![1, 3].contains(&i.details.len())) {
            let expected = "component: expected 1 channel or 3 at every incidence";
            return Err(Error::argument(expected.to_owned()));
        }
        let rank = fitted.spectra.as_ref().map_or(0, |spectra| spectra.rank());
        if let Some(i) = fitted.incidences.iter().find(|i| i.coefficients.len() != rank) {
            let found = i.coefficients.len();
            let expected =
                format!("component: expected {rank} coefficients of spectra at every incidence");
            return Err(Error::argument(format!("{expected}, found {found}")));
        }
        let at_vertices = |frame: Frame| mesh.vertices.iter().map(|v| frame.at(v.wi)).collect();
        let frames: Vec<FrameAt> = at_vertices(motion.frame);
        let laws: Vec<(Frame, Vec<FrameAt>)> =
            motion.laws().into_iter().map(|law| (law, at_vertices(law))).collect();
        let (lobes, families) = by_law(&fitted, &mesh, motion, &frames, peaks);
        let plan = |edge: [u32; 2], free: &dyn Fn(u32, usize) -> bool| {
            let sets = edge.map(|v| &lobes[v as usize]);
            let free = edge.map(|v| move |lobe: usize| free(v, lobe));
            EdgePlan::among(sets, &free, motion.reach)
                .beneath(sets, edge.map(|v| frames[v as usize]))
        };
        // A peak that is missing at one corner of a cell is cut off there, not across the cell.
        let left = |edge| plan(edge, &|_, _| true).left;
        let mesh = mesh.with_diagonals(|other, joined| left(other) < left(joined) - FEWER)?;
        let facets = if incident == scattered {
            Facets::default()
        } else {
            let energy = |v: &Vertex| fitted.incidences[v.incidence].hemispherical;
            let energy: Vec<f64> = mesh.vertices.iter().map(energy).collect();
            Facets::of(&mesh, &lobes, &energy, motion.frame)
        };
        let free = |v: u32, lobe: usize| !facets.rules(v, lobe as u16);
        let plans: Vec<EdgePlan> = mesh.topology.edges().iter().map(|&e| plan(e, &free)).collect();
        let tracks = if motion.curved { tracks(&mesh, &lobes, &plans) } else { Vec::new() };
        let (triangles, outline) = glued(&mesh, &lobes, &plans);
        let lopsided = mesh.lopsided(symmetry);
        Ok(Self {
            fitted,
            motion,
            mesh,
            lobes,
            families,
            frames,
            laws,
            tracks,
            triangles,
            outline,
            lopsided,
            facets,
        })
    }

    /// The directional-hemispherical value at a vertex.
    pub(crate) fn hemispherical(&self, vertex: u32) -> f64 {
        self.fitted.incidences[self.mesh.vertices[vertex as usize].incidence].hemispherical
    }
}

/// The lobes of every vertex: those that plans or facets carry, and those of each law.
fn by_law(
    fitted: &Fitted,
    mesh: &IncidenceMesh,
    motion: Motion,
    frames: &[FrameAt],
    peaks: Peaks,
) -> (Vec<LobeSet>, Vec<Vec<Vec<Standing>>>) {
    let all: Vec<LobeSet> =
        mesh.vertices.iter().map(|v| fitted.incidences[v.incidence].image_lobes(v.image)).collect();
    let laws = motion.laws();
    let of = match peaks {
        Peaks::Alike => all.iter().map(|set| vec![Some(0); set.lobes.len()]).collect(),
        Peaks::Apart => assigned(mesh, &all, motion.frame, &laws),
    };
    let split = |((set, of), frame): ((LobeSet, Vec<Option<u8>>), &FrameAt)| {
        let mut families = vec![Vec::new(); laws.len()];
        let mut lobes = Vec::new();
        for (lobe, of) in set.lobes.into_iter().zip(of) {
            match of {
                Some(law) => families[law as usize].push(Standing::new(lobe, frame)),
                None => lobes.push(lobe),
            }
        }
        (LobeSet { floor: set.floor, lobes }, families)
    };
    all.into_iter().zip(of).zip(frames).map(split).unzip()
}

/// The moving lobes of triangles and of the outline, put together from plans along edges.
fn glued(
    mesh: &IncidenceMesh,
    lobes: &[LobeSet],
    plans: &[EdgePlan],
) -> (Vec<Movers>, HashMap<[u32; 2], Movers>) {
    let topology = &mesh.topology;
    let directed = |a: u32, b: u32| match topology.edge_between(a, b) {
        Some(k) if topology.edges()[k as usize] == [a, b] => plans[k as usize].clone(),
        Some(k) => plans[k as usize].reversed(),
        None => EdgePlan::default(),
    };
    let lobes = |v: u32| &lobes[v as usize];
    let triangle = |&[a, b, c]: &[u32; 3]| {
        let plans = [directed(a, b), directed(b, c), directed(c, a)];
        Movers::of_triangle([a, b, c].map(lobes), [&plans[0], &plans[1], &plans[2]])
    };
    let edge = |&[a, b]: &[u32; 2]| ([a, b], Movers::of_edge([a, b].map(lobes), &directed(a, b)));
    let triangles = topology.triangles().iter().map(triangle).collect();
    (triangles, topology.boundary().iter().map(edge).collect())
}
