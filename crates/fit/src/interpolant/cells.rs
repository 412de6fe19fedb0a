//! A number over the incidence mesh that bends at its edges as the moved lobes do.

use bsdfkit::{DVec2, DVec3, Side};
use bsdfkit_sphere::concentric::disk_to_hemisphere;
use bsdfkit_sphere::locate::Location;

use super::mesh::IncidenceMesh;

/// Zero at the vertices, given in the middles of edges and triangles, of second degree along edges
/// and of third inside triangles: continuous, and free to bend where two cells meet.
#[derive(Clone, Debug, Default)]
pub(super) struct Cells {
    /// In the middle of each edge of the mesh.
    edges: Vec<f64>,
    /// In the middle of each triangle, less what its edges make of it.
    triangles: Vec<f64>,
}

impl Cells {
    /// The number that is as `value` in all middles.
    pub(super) fn through(mesh: &IncidenceMesh, value: impl Fn(DVec3) -> f64) -> Self {
        let middle = |corners: &[u32]| {
            let at = |&v: &u32| mesh.vertices[v as usize].wi.truncate();
            let sum: DVec2 = corners.iter().map(at).sum();
            value(disk_to_hemisphere(sum / corners.len() as f64, Side::Front))
        };
        let topology = &mesh.topology;
        let edges: Vec<f64> = topology.edges().iter().map(|e| middle(e)).collect();
        let bare = Self { triangles: vec![0.0; topology.triangles().len()], edges };
        let over = |(k, corners): (usize, &[u32; 3])| {
            let location = Location::Inside { triangle: k as u32, barycentric: [1.0 / 3.0; 3] };
            middle(corners) - bare.at(mesh, location)
        };
        let triangles = topology.triangles().iter().enumerate().map(over).collect();
        Self { triangles, ..bare }
    }

    /// The number at `location`; outside the mesh, at the nearest point of it. 0 if none was given.
    pub(super) fn at(&self, mesh: &IncidenceMesh, location: Location) -> f64 {
        let edge = |a: u32, b: u32| {
            let index = mesh.topology.edge_between(a, b);
            index.and_then(|k| self.edges.get(k as usize)).copied().unwrap_or(0.0)
        };
        match location {
            Location::Inside { triangle, barycentric: l } => {
                let corners = mesh.topology.triangles()[triangle as usize];
                let along =
                    |(i, j): (usize, usize)| 4.0 * l[i] * l[j] * edge(corners[i], corners[j]);
                let over = self.triangles.get(triangle as usize).copied().unwrap_or(0.0);
                [(0, 1), (1, 2), (2, 0)].map(along).iter().sum::<f64>()
                    + 27.0 * l[0] * l[1] * l[2] * over
            }
            Location::Outside { edge: [a, b], fraction, .. } => {
                4.0 * fraction * (1.0 - fraction) * edge(a, b)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measurement::Symmetry;
    use bsdfkit_sphere::direction::from_degrees;

    #[test]
    fn values_in_the_middles_are_met_and_edges_are_continuous() {
        let mut wi = vec![DVec3::Z];
        for t in [20.0, 45.0, 70.0] {
            wi.extend((0..8).map(|p| from_degrees(t, f64::from(p) * 45.0 + t)));
        }
        let mesh = IncidenceMesh::new(&wi, Symmetry::None).expect("mesh");
        let value = |w: DVec3| (3.0 * w.x).sin() + w.x * w.y;
        let cells = Cells::through(&mesh, value);
        let at = |p: DVec2| cells.at(&mesh, mesh.locate(disk_to_hemisphere(p, Side::Front)));
        let place = |v: u32| mesh.vertices[v as usize].wi.truncate();
        for t in mesh.topology.triangles() {
            let middle = t.iter().map(|&v| place(v)).sum::<DVec2>() / 3.0;
            assert!((at(middle) - value(disk_to_hemisphere(middle, Side::Front))).abs() < 1e-12);
        }
        for &[a, b] in mesh.topology.edges() {
            let across = (place(b) - place(a)).perp() * 1e-9;
            let middle = 0.5 * (place(a) + place(b));
            assert!((at(middle) - value(disk_to_hemisphere(middle, Side::Front))).abs() < 1e-6);
            for share in [0.0, 0.2, 0.7] {
                let p = place(a).lerp(place(b), share);
                assert!((at(p + across) - at(p - across)).abs() < 1e-6);
            }
            assert!(at(place(a)).abs() < 1e-9);
        }
    }
}
