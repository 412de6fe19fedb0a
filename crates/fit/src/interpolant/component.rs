//! The continuous BSDF of one (incident side, scattered side) pair.

use std::collections::HashMap;

use bsdfkit::{DVec2, DVec3, Result, Side};
use bsdfkit_sphere::concentric::{disk_to_hemisphere, disk_to_square};
use bsdfkit_sphere::locate::Location;

use super::blend::local_gradient;
use super::displace::{Moved, Movers};
use super::energy::Energy;
use super::frame::FrameAt;
use super::incidence::FittedIncidence;
use super::mesh::{IncidenceMesh, Vertex};
use super::motion::Motion;
use super::plan::EdgePlan;
use crate::lobe::LobeSet;
use crate::measurement::{Image, Symmetry};
use crate::tabulate::{Peak, Slice, Source};

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
    mesh: IncidenceMesh,
    /// Lobes of every vertex, seen through its image.
    lobes: Vec<LobeSet>,
    /// How each lobe of every vertex starts to move: gradients of its x and y. None if straight.
    tracks: Vec<Vec<[DVec3; 2]>>,
    /// Moving lobes of each triangle.
    triangles: Vec<Movers>,
    /// Moving lobes of each edge of the outline (of a chain: of every edge).
    outline: HashMap<[u32; 2], Movers>,
    energy: Energy,
}

impl Component {
    /// Meshes the fitted incidences and computes all plans.
    pub fn new(
        incident: Side,
        scattered: Side,
        symmetry: Symmetry,
        motion: Motion,
        epsilon: f64,
        incidences: Vec<FittedIncidence>,
    ) -> Result<Self> {
        let mut component =
            Self::without_energy(incident, scattered, symmetry, motion, epsilon, incidences)?;
        component.energy = Energy::of(&component);
        Ok(component)
    }

    /// As [`Component::new`], with the energy correction that was stored.
    pub(super) fn restored(
        incident: Side,
        scattered: Side,
        symmetry: Symmetry,
        motion: Motion,
        epsilon: f64,
        incidences: Vec<FittedIncidence>,
        energy: Energy,
    ) -> Result<Self> {
        let component =
            Self::without_energy(incident, scattered, symmetry, motion, epsilon, incidences)?;
        Ok(Self { energy, ..component })
    }

    pub(super) fn energy(&self) -> &Energy {
        &self.energy
    }

    /// As [`Component::new`], leaving the energy between incidences as the moved lobes give it.
    pub(super) fn without_energy(
        incident: Side,
        scattered: Side,
        symmetry: Symmetry,
        motion: Motion,
        epsilon: f64,
        incidences: Vec<FittedIncidence>,
    ) -> Result<Self> {
        let directions: Vec<DVec3> = incidences.iter().map(|i| i.wi).collect();
        let mesh = IncidenceMesh::new(&directions, symmetry)?;
        let lobes: Vec<LobeSet> =
            mesh.vertices.iter().map(|v| incidences[v.incidence].image_lobes(v.image)).collect();
        let edges = mesh.topology.edges();
        let plans: Vec<EdgePlan> = edges
            .iter()
            .map(|&[a, b]| EdgePlan::between(&lobes[a as usize], &lobes[b as usize], motion.reach))
            .collect();
        let of: HashMap<[u32; 2], usize> = edges.iter().enumerate().map(|(k, &e)| (e, k)).collect();
        let directed = |a: u32, b: u32| match of.get(&[a, b]) {
            Some(&k) => plans[k].clone(),
            None => plans[of[&[b, a]]].reversed(),
        };
        let tracks = motion.curved.then(|| tracks(&mesh, &lobes, &plans)).unwrap_or_default();
        let triangles = mesh
            .topology
            .triangles()
            .iter()
            .map(|&[a, b, c]| {
                let corners = [a, b, c].map(|v| &lobes[v as usize]);
                let plans = [directed(a, b), directed(b, c), directed(c, a)];
                Movers::of_triangle(corners, [&plans[0], &plans[1], &plans[2]])
            })
            .collect();
        let outline = mesh
            .topology
            .boundary()
            .iter()
            .map(|&[a, b]| {
                let corners = [&lobes[a as usize], &lobes[b as usize]];
                ([a, b], Movers::of_edge(corners, &directed(a, b)))
            })
            .collect();
        Ok(Self {
            incident,
            scattered,
            symmetry,
            motion,
            epsilon,
            incidences,
            mesh,
            lobes,
            tracks,
            triangles,
            outline,
            energy: Energy::none(),
        })
    }

    /// Measured incidences and their images.
    pub(super) fn vertices(&self) -> &[Vertex] {
        &self.mesh.vertices
    }

    pub(super) fn mesh(&self) -> &IncidenceMesh {
        &self.mesh
    }

    /// Whether an incident direction lies inside the mesh of measured ones.
    pub fn is_measured(&self, wi: DVec3) -> bool {
        let (folded, _) = self.symmetry.fold(DVec3::new(wi.x, wi.y, wi.z.abs()));
        match self.mesh.locate(folded) {
            Location::Inside { .. } => true,
            Location::Outside { distance, .. } => distance < 1e-9,
        }
    }

    /// Incident directions at which the interpolant differs most from its vertices (middles of
    /// edges and triangles, and some past the rim); one of each symmetric family.
    pub(super) fn probes(&self) -> Vec<DVec3> {
        let position = |v: u32| self.mesh.vertices[v as usize].wi.truncate();
        let mut probes: Vec<DVec3> = Vec::new();
        let mut add = |p: DVec2| {
            let wi = disk_to_hemisphere(p, Side::Front);
            let (folded, _) = self.symmetry.fold(wi);
            if probes.iter().all(|w| w.distance(folded) > 1e-3) {
                probes.push(folded);
            }
        };
        for &[a, b] in self.mesh.topology.edges() {
            add((position(a) + position(b)) * 0.5);
        }
        for t in self.mesh.topology.triangles() {
            add(t.iter().map(|&v| position(v)).sum::<DVec2>() / 3.0);
        }
        for &[a, b] in self.mesh.topology.boundary() {
            for p in [position(a), position(b), (position(a) + position(b)) * 0.5] {
                let r = p.length();
                let outward = disk_to_hemisphere(p * (1.0 + 1e-3 * (1.0 - r)), Side::Front);
                if r < 0.05 || self.is_measured(outward) {
                    continue; // a chain's inner edges
                }
                for share in [0.33, 0.67, 0.95] {
                    let out = r + share * (1.0 - r);
                    add(p * (out / r));
                }
            }
        }
        probes
    }

    /// The scattered distribution of incident direction `wi`.
    pub fn at(&self, wi: DVec3) -> Distribution<'_> {
        let wi = DVec3::new(wi.x, wi.y, wi.z.abs());
        let (folded, fold) = self.symmetry.fold(wi);
        let (corners, lambda, movers) = match self.mesh.locate(folded) {
            Location::Inside { triangle, barycentric } => {
                let t = self.mesh.topology.triangles()[triangle as usize];
                (t, barycentric, Some(&self.triangles[triangle as usize]))
            }
            Location::Outside { edge: [a, b], fraction, .. } => {
                ([a, b, a], [1.0 - fraction, fraction, 0.0], self.outline.get(&[a, b]))
            }
        };
        let sets = corners.map(|v| &self.lobes[v as usize]);
        let on_mesh: DVec2 =
            (0..3).map(|k| lambda[k] * self.mesh.vertices[corners[k] as usize].wi.truncate()).sum();
        let on_mesh = disk_to_hemisphere(on_mesh, Side::Front);
        let bend = |k: usize, lobe: usize| {
            let v = corners[k] as usize;
            let Some(&[x, y]) = self.tracks.get(v).and_then(|t| t.get(lobe)) else {
                return DVec2::ZERO;
            };
            let along = on_mesh - self.mesh.vertices[v].wi;
            DVec2::new(x.dot(along), y.dot(along))
        };
        let moved = match movers {
            Some(m) => m.at(sets, lambda, &bend),
            None => Movers::of_edge([sets[0], sets[0]], &EdgePlan::between(sets[0], sets[0], 1.0))
                .at([sets[0]; 3], [1.0, 0.0, 0.0], &|_, _| DVec2::ZERO),
        };
        let floor = (0..3).map(|k| lambda[k] * sets[k].floor).sum();
        let corner = |k: usize| {
            let v = &self.mesh.vertices[corners[k] as usize];
            Corner {
                weight: lambda[k],
                frame: self.motion.frame.at(v.wi),
                back: v.image.inverse(),
                incidence: &self.incidences[v.incidence],
            }
        };
        Distribution {
            fold,
            scale: self.energy.factor(folded),
            frame: self.motion.frame.at(folded),
            floor,
            epsilon: self.epsilon,
            moved,
            corners: [0, 1, 2].map(corner),
        }
    }
}

/// Gradients of the centres of all lobes: where a vertex's plans take each lobe on average, as a
/// second-degree function of the incident direction.
fn tracks(mesh: &IncidenceMesh, lobes: &[LobeSet], plans: &[EdgePlan]) -> Vec<Vec<[DVec3; 2]>> {
    // Per vertex and lobe: where a neighbour is, the mean place of the partners, and the mass kept.
    type Partner = (DVec3, DVec2, f64);
    let mut partners: Vec<Vec<Vec<Partner>>> =
        lobes.iter().map(|set| vec![Vec::new(); set.lobes.len()]).collect();
    for (&[a, b], plan) in mesh.topology.edges().iter().zip(plans) {
        for (from, to, plan) in [(a, b, plan.clone()), (b, a, plan.reversed())] {
            let (from, to) = (from as usize, to as usize);
            let mut sums = vec![(DVec2::ZERO, 0.0); lobes[from].lobes.len()];
            for p in &plan.pairs {
                if let (Some(i), Some(j)) = (p.from, p.to) {
                    let sum = &mut sums[i as usize];
                    sum.0 += p.start * lobes[to].lobes[j as usize].mean;
                    sum.1 += p.start;
                }
            }
            for (i, (place, mass)) in sums.into_iter().enumerate() {
                if mass > 0.0 {
                    let kept = mass / lobes[from].lobes[i].mass.max(1e-300);
                    partners[from][i].push((mesh.vertices[to].wi, place / mass, kept));
                }
            }
        }
    }
    let gradients = |v: usize, i: usize| {
        let centre = mesh.vertices[v].wi;
        let mean = lobes[v].lobes[i].mean;
        [0, 1].map(|axis| {
            let around: Vec<(DVec3, f64, f64)> =
                partners[v][i].iter().map(|&(w, place, kept)| (w, place[axis], kept)).collect();
            local_gradient((centre, mean[axis]), &around)
        })
    };
    (0..lobes.len()).map(|v| (0..lobes[v].lobes.len()).map(|i| gradients(v, i)).collect()).collect()
}

/// A corner of the cell that holds the query.
struct Corner<'a> {
    weight: f64,
    frame: FrameAt,
    /// From the corner to its measured incidence.
    back: Image,
    incidence: &'a FittedIncidence,
}

/// The interpolated scattering of one incident direction.
pub struct Distribution<'a> {
    fold: Image,
    scale: f64,
    frame: FrameAt,
    floor: f64,
    epsilon: f64,
    moved: Vec<Moved>,
    corners: [Corner<'a>; 3],
}

/// Lobes are cut at this exponent: exp(−16) of the peak.
const CUT: f64 = 32.0;

impl Distribution<'_> {
    /// Luminance f in 1/sr at scattered direction `wo` (its side is not looked at).
    pub fn eval(&self, wo: DVec3) -> f64 {
        let mut value = [0.0];
        self.eval_channels(wo, &mut value);
        value[0]
    }

    /// Where the lobes are on the square of scattered directions (of the folded frame), with the
    /// least and greatest extent of one standard deviation there; those below the horizon left out.
    pub(super) fn extents(&self) -> Vec<(DVec2, f64, f64)> {
        let place = |q: DVec2| {
            let (u, z) = self.frame.inverse(q);
            (z > 0.0).then(|| disk_to_square(u))
        };
        let extent = |m: &Moved| {
            let centre = place(m.lobe.mean)?;
            let root = m.lobe.covariance.sqrt();
            let (mut least, mut most) = (f64::MAX, 0.0f64);
            for axis in [DVec2::X, DVec2::Y] {
                let d = root.apply(axis);
                let (a, b) = (place(m.lobe.mean + d), place(m.lobe.mean - d));
                let r = a.or(b).map_or(1.0, |p| p.distance(centre));
                least = least.min(r);
                most = most.max(r);
            }
            Some((centre, least, most))
        };
        self.moved.iter().filter_map(extent).collect()
    }

    /// A direction of the folded frame as the caller sees it.
    pub(super) fn unfolded(&self, w: DVec3) -> DVec3 {
        self.fold.inverse().apply(w)
    }

    /// f of the first `out.len()` channels, luminance first.
    pub fn eval_channels(&self, wo: DVec3, out: &mut [f64]) {
        let u = self.fold.apply(wo).truncate();
        let r2 = u.length_squared();
        let u = if r2 > 0.99999 { u * (0.99999 / r2).sqrt() } else { u };
        let q = self.frame.forward(u);
        let density = self.frame.density(u);
        let mut sum = 0.0;
        let mut places = [DVec2::ZERO; 3];
        for m in &self.moved {
            let d = q - m.lobe.mean;
            let e = m.precision.quadratic(d);
            if e < CUT {
                let g = m.peak * (-0.5 * e).exp();
                sum += g;
                for (place, (centre, map)) in places.iter_mut().zip(&m.maps) {
                    *place += g * (*centre + map.apply(d));
                }
            }
        }
        // The floor does not move: it maps every direction to itself.
        let still = self.floor * density + 1e-12;
        out.fill(0.0);
        for (corner, place) in self.corners.iter().zip(places) {
            if corner.weight > 0.0 {
                let q = (place + still * corner.frame.forward(u)) / (sum + still);
                let (v, z) = corner.frame.inverse(q);
                let v = if z > 0.0 { v } else { v * (0.9999 / v.length().max(1e-12)) };
                let v = corner.back.apply(v.extend(0.0)).truncate();
                for (log, detail) in out.iter_mut().zip(&corner.incidence.details) {
                    *log += corner.weight * detail.log_at(v);
                }
            }
        }
        let model = self.floor + sum / density + self.epsilon;
        for value in out {
            *value = self.scale * (model * value.exp() - self.epsilon).max(0.0);
        }
    }
}

/// Share of the moved mass below which a lobe is no peak to be looked for: missed, it costs that.
const PEAK_MASS: f64 = 1e-3;

impl Slice for Distribution<'_> {
    fn eval(&self, wo: &[DVec3], out: &mut [f32]) {
        let channels = self.corners[0].incidence.details.len();
        let mut values = vec![0.0; channels];
        for (out, &w) in out.chunks_exact_mut(channels).zip(wo) {
            self.eval_channels(w, &mut values);
            for (o, v) in out.iter_mut().zip(&values) {
                *o = *v as f32;
            }
        }
    }

    /// The moved lobes that carry mass and lie above the horizon; long ones in several places
    /// along their axis.
    fn peaks(&self, out: &mut Vec<Peak>) {
        let total: f64 = self.moved.iter().map(|m| m.lobe.mass).sum();
        let back = self.fold.inverse();
        for m in self.moved.iter().filter(|m| m.lobe.mass > PEAK_MASS * total) {
            let (mean, c) = (m.lobe.mean, m.lobe.covariance);
            let half = 0.5 * c.trace();
            let wide = (half + (half * half - c.determinant()).max(0.0).sqrt()).sqrt();
            let narrow = c.determinant().max(0.0).sqrt() / wide;
            let angle = 0.5 * (2.0 * c.xy).atan2(c.xx - c.yy);
            let along = DVec2::new(angle.cos(), angle.sin());
            // From one to seven places, two narrow deviations apart.
            let steps = (0.75 * wide / narrow).min(3.0) as i32;
            for step in -steps..=steps {
                let q = mean + along * (2.0 * narrow * f64::from(step));
                let (u, z) = self.frame.inverse(q);
                if z > 0.0 {
                    let scale = |axis: DVec2| {
                        let moved = self.frame.inverse(q + axis * (0.1 * narrow)).0;
                        10.0 * (moved - u).length()
                    };
                    let radius = scale(along).min(scale(along.perp()));
                    out.push(Peak { direction: back.apply(u.extend(z)), radius });
                }
            }
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
}
