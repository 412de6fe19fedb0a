//! The mesh of incidences and their symmetric images.

use std::collections::{BTreeSet, HashMap, HashSet};

use bsdfkit::{DVec2, DVec3, Error, Result};
use bsdfkit_sphere::delaunay::Triangulation;
use bsdfkit_sphere::locate::{Location, Locator};

use crate::interpolant::mesh::chart::Chart;
use bsdfkit_measure::symmetry::ON_MIRROR;
use bsdfkit_measure::{Image, Symmetry};

/// A vertex: a measured incidence seen through a symmetry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex {
    /// Index of the incidence.
    pub incidence: usize,
    /// What takes the measured incidence here.
    pub image: Image,
    /// Incident direction, front hemisphere.
    pub wi: DVec3,
}

/// Delaunay mesh over measured incidences and their images.
///
/// Laid out straight-edged in a [`Chart`].
/// Normal incidence, when it was not measured, is inside the mesh as soon as images surround it.
#[derive(Clone, Debug)]
pub struct IncidenceMesh {
    /// Vertices: the measured incidences first.
    pub vertices: Vec<Vertex>,
    /// Triangles and edges.
    pub topology: Triangulation,
    /// Where its edges are straight.
    pub chart: Chart,
    /// Where the vertices are in the chart.
    places: Vec<DVec2>,
    locator: Locator,
    /// Triangles that [`peeled`] took from the outline.
    pub(crate) notches: Vec<[u32; 3]>,
}

/// What is so near to the mesh, in its chart, lies on it.
pub(crate) const ON_MESH: f64 = 1e-9;

impl IncidenceMesh {
    /// Meshes `incidences` (front hemisphere) under `symmetry`, laid out in the disk.
    ///
    /// An isotropic set becomes a chain in the plane of azimuth 0, closed through the normal.
    pub fn new(incidences: &[DVec3], symmetry: Symmetry) -> Result<Self> {
        Self::in_chart(incidences, symmetry, Chart::Disk)
    }

    /// The same, laid out in `chart`.
    pub fn in_chart(incidences: &[DVec3], symmetry: Symmetry, chart: Chart) -> Result<Self> {
        let mut vertices: Vec<Vertex> = Vec::new();
        for (incidence, &wi) in incidences.iter().enumerate() {
            let (wi, image) = match symmetry {
                Symmetry::Isotropic => symmetry.fold(wi),
                _ => (wi, Image::IDENTITY),
            };
            vertices.push(Vertex { incidence, image, wi });
        }
        let measured = vertices.len();
        let images = match symmetry {
            Symmetry::Isotropic => Symmetry::Rotational180.images(),
            _ => symmetry.images(),
        };
        for k in 0..measured {
            let v = vertices[k];
            for &image in &images[1..] {
                let wi = image.apply(v.wi);
                if vertices.iter().all(|o| o.wi.distance(wi) > ON_MIRROR) {
                    let image = image.after(v.image);
                    vertices.push(Vertex { incidence: v.incidence, image, wi });
                }
            }
        }
        let directions: Vec<DVec3> = vertices.iter().map(|v| v.wi).collect();
        let lifted: Vec<DVec3> = directions.iter().map(|&w| chart.lifted(w)).collect();
        let topology = Triangulation::new(&lifted)
            .map_err(|e| Error::format(format!("incident directions cannot be meshed: {e}")))?;
        let (topology, notches) = peeled(topology, &directions, chart);
        let locator = locator(&topology, &directions, chart)?;
        let places = directions.iter().map(|&w| chart.place(w)).collect();
        Ok(Self { vertices, topology, chart, places, locator, notches })
    }

    /// The same with the diagonals of grid cells as `prefers` has them; see
    /// [`Triangulation::with_diagonals`].
    pub fn with_diagonals(
        mut self,
        prefers: impl FnMut([u32; 2], [u32; 2]) -> bool,
    ) -> Result<Self> {
        let directions: Vec<DVec3> = self.vertices.iter().map(|v| v.wi).collect();
        let lifted: Vec<DVec3> = directions.iter().map(|&w| self.chart.lifted(w)).collect();
        self.topology = self.topology.with_diagonals(&lifted, prefers);
        let more;
        (self.topology, more) = peeled(self.topology, &directions, self.chart);
        self.notches.extend(more);
        self.locator = locator(&self.topology, &directions, self.chart)?;
        Ok(self)
    }

    /// Where an incident direction (front hemisphere) lies in the mesh.
    pub fn locate(&self, wi: DVec3) -> Location {
        self.locator.locate(self.chart.place(wi))
    }

    /// Where a vertex is in the chart.
    pub fn place(&self, vertex: u32) -> DVec2 {
        self.places[vertex as usize]
    }

    /// The direction that lies between vertices with these weights.
    pub fn between(&self, weights: &[(u32, f64)]) -> DVec3 {
        self.chart.direction(weights.iter().map(|&(v, weight)| weight * self.place(v)).sum())
    }

    /// The incidences on the outline, in order; of a chain the last.
    pub fn outermost(&self) -> Vec<usize> {
        let far = |v: &u32| self.place(*v).length();
        let mut rim: Vec<u32> = self.topology.boundary().iter().flatten().copied().collect();
        if self.topology.is_chain() {
            rim = rim.into_iter().max_by(|a, b| far(a).total_cmp(&far(b))).into_iter().collect();
        }
        let of = rim.into_iter().map(|v| self.vertices[v as usize].incidence);
        of.collect::<BTreeSet<usize>>().into_iter().collect()
    }

    /// The triangles whose mirror image under `symmetry` is no triangle of the mesh, with the mirror:
    /// cells that straddle a mirror on which nothing was measured have only one diagonal.
    pub fn lopsided(&self, symmetry: Symmetry) -> HashMap<u32, Image> {
        let key = |mut t: [u32; 3]| {
            t.sort_unstable();
            t
        };
        let all: HashSet<[u32; 3]> = self.topology.triangles().iter().map(|&t| key(t)).collect();
        let at = |wi: DVec3| {
            let near = |v: &Vertex| v.wi.distance(wi) < ON_MIRROR;
            self.vertices.iter().position(near).map(|v| v as u32)
        };
        let mut lopsided = HashMap::new();
        for image in symmetry.images().iter().skip(1) {
            let twin: Vec<Option<u32>> =
                self.vertices.iter().map(|v| at(image.apply(v.wi))).collect();
            for (k, t) in self.topology.triangles().iter().enumerate() {
                let mirrored = t.map(|v| twin[v as usize].unwrap_or(v));
                if !all.contains(&key(mirrored)) {
                    lopsided.entry(k as u32).or_insert(*image);
                }
            }
        }
        lopsided
    }
}

/// Triangles of the rim that are flatter than 135 degrees join incidences past others that lie between them.
const FLAT_RIM: f64 = -0.7;

/// Of incidences that answer to the profile angle, the mesh without those triangles of its convex outline that join incidences
/// across the profile angles of others.
fn peeled(
    topology: Triangulation,
    directions: &[DVec3],
    chart: Chart,
) -> (Triangulation, Vec<[u32; 3]>) {
    if !matches!(chart, Chart::Profile { .. }) {
        return (topology, Vec::new());
    }
    let places: Vec<DVec2> = directions.iter().map(|&w| chart.place(w)).collect();
    let all = topology.triangles().to_vec();
    let topology = topology.without_flat_rim(&places, FLAT_RIM);
    let left: HashSet<[u32; 3]> = topology.triangles().iter().copied().collect();
    (topology, all.into_iter().filter(|t| !left.contains(t)).collect())
}

fn locator(topology: &Triangulation, directions: &[DVec3], chart: Chart) -> Result<Locator> {
    let positions: Vec<_> = directions.iter().map(|&w| chart.place(w)).collect();
    Locator::new(topology, &positions)
        .ok_or_else(|| Error::format("incident directions must be finite".to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use bsdfkit_sphere::direction::from_degrees;

    fn quarter() -> Vec<DVec3> {
        let mut w = vec![DVec3::Z];
        for t in [20.0, 40.0, 60.0] {
            for p in [0.0, 30.0, 60.0, 90.0] {
                w.push(from_degrees(t, p));
            }
        }
        w
    }

    #[test]
    fn images_close_the_circle_without_doubles() {
        let mesh = IncidenceMesh::new(&quarter(), Symmetry::Quadrilateral).expect("mesh");
        assert_eq!(mesh.vertices.len(), 1 + 3 * 12);
        for v in &mesh.vertices {
            assert!(v.image.apply(quarter()[v.incidence]).distance(v.wi) < 1e-12);
        }
    }

    #[test]
    fn outermost_are_those_of_the_last_polar_angle() {
        let mesh = IncidenceMesh::new(&quarter(), Symmetry::Quadrilateral).expect("mesh");
        assert_eq!(mesh.outermost(), [9, 10, 11, 12]);
        let chain = [50.0, 70.0, 10.0].map(|t| from_degrees(t, 45.0));
        let mesh = IncidenceMesh::new(&chain, Symmetry::Isotropic).expect("mesh");
        assert_eq!(mesh.outermost(), [1]);
    }

    #[test]
    fn normal_incidence_is_inside_when_images_surround_it() {
        let mesh = IncidenceMesh::new(&quarter()[1..], Symmetry::Quadrilateral).expect("mesh");
        assert!(matches!(mesh.locate(DVec3::Z), Location::Inside { .. }));
    }

    #[test]
    fn isotropic_sets_make_a_chain_through_the_normal() {
        let w = [from_degrees(10.0, 45.0), from_degrees(50.0, 45.0)];
        let mesh = IncidenceMesh::new(&w, Symmetry::Isotropic).expect("mesh");
        assert!(mesh.topology.is_chain());
        assert_eq!(mesh.vertices.len(), 4);
        let Location::Outside { distance, fraction, .. } = mesh.locate(DVec3::Z) else {
            panic!("a chain has no inside")
        };
        assert!(distance < 1e-12 && (fraction - 0.5).abs() < 1e-9);
    }
}
