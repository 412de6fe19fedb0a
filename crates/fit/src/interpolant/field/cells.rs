//! A number over the incidence mesh that bends at its edges as the moved lobes do.

use bsdfkit::DVec3;
use bsdfkit_sphere::locate::Location;

use crate::interpolant::mesh::incidence_mesh::IncidenceMesh;

/// Zero at the vertices, given at the quarters of edges and in the middles of triangles, of fourth degree:
/// continuous, and free to bend where two cells meet.
#[derive(Clone, Debug, Default)]
pub(crate) struct Cells {
    /// Along each edge of the mesh.
    edges: Vec<Arch>,
    /// Of each triangle.
    triangles: Vec<Over>,
}

/// What there is over a triangle.
#[derive(Clone, Copy, Debug, Default)]
struct Over {
    /// Along its three sides, from corner to corner.
    sides: [Arch; 3],
    /// In its middle, less what the sides make of it.
    middle: f64,
}

impl Over {
    fn at(&self, l: [f64; 3]) -> f64 {
        let along = |(side, [i, j]): (&Arch, [usize; 2])| side.at([l[i], l[j]]);
        let sides = self.sides.iter().zip([[0, 1], [1, 2], [2, 0]]).map(along).sum::<f64>();
        sides + 27.0 * l[0] * l[1] * l[2] * self.middle
    }
}

/// Shares of the way along an edge at which the number is given.
pub(crate) const QUARTERS: [f64; 3] = [0.25, 0.5, 0.75];

/// 4 λₐ λ_b (c₀ + c₁ (λ_b − λₐ) + c₂ (λ_b − λₐ)²) along the edge a–b. With its middle alone given, energy was
/// off by 3 % half-way between there and a measured incidence where much of a peak is below the horizon.
#[derive(Clone, Copy, Debug, Default)]
struct Arch([f64; 3]);

impl Arch {
    /// Through the values at the [`QUARTERS`].
    fn through([first, middle, last]: [f64; 3]) -> Self {
        Self([middle, (last - first) / 0.75, 4.0 * ((first + last) / 1.5 - middle)])
    }

    fn at(&self, [a, b]: [f64; 2]) -> f64 {
        let [c0, c1, c2] = self.0;
        let d = b - a;
        4.0 * a * b * (c0 + d * (c1 + d * c2))
    }

    fn reversed(self) -> Self {
        let [c0, c1, c2] = self.0;
        Self([c0, -c1, c2])
    }
}

impl Cells {
    /// The number that is as `value` at all quarters of edges and in all middles of triangles.
    pub(crate) fn through(mesh: &IncidenceMesh, value: impl Fn(DVec3) -> f64) -> Self {
        let middle = |corners: &[u32; 3]| value(mesh.between(&corners.map(|v| (v, 1.0 / 3.0))));
        let arch = |&[a, b]: &[u32; 2]| {
            Arch::through(
                QUARTERS.map(|share| value(mesh.between(&[(a, 1.0 - share), (b, share)]))),
            )
        };
        let topology = &mesh.topology;
        let edges = topology.edges().iter().map(arch).collect();
        let bare = Self { triangles: Vec::new(), edges };
        let over = |corners: &[u32; 3]| {
            let [a, b, c] = *corners;
            let sides = [[a, b], [b, c], [c, a]].map(|ends| bare.along(mesh, ends));
            let flat = Over { sides, middle: 0.0 };
            Over { middle: middle(corners) - flat.at([1.0 / 3.0; 3]), ..flat }
        };
        let triangles = topology.triangles().iter().map(over).collect();
        Self { triangles, ..bare }
    }

    /// Along an edge of the mesh, from `a` to `b`.
    fn along(&self, mesh: &IncidenceMesh, [a, b]: [u32; 2]) -> Arch {
        let index = mesh.topology.edge_between(a, b).map_or(usize::MAX, |k| k as usize);
        let arch = self.edges.get(index).copied().unwrap_or_default();
        if mesh.topology.edges().get(index) == Some(&[a, b]) { arch } else { arch.reversed() }
    }

    /// The number at `location`; outside the mesh, at the nearest point of it. 0 if none was given.
    pub(crate) fn at(&self, mesh: &IncidenceMesh, location: Location) -> f64 {
        match location {
            Location::Inside { triangle, barycentric } => {
                self.triangles.get(triangle as usize).map_or(0.0, |over| over.at(barycentric))
            }
            Location::Outside { edge, fraction, .. } => {
                self.along(mesh, edge).at([1.0 - fraction, fraction])
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bsdfkit::{DVec2, Side};
    use bsdfkit_measure::Symmetry;
    use bsdfkit_sphere::concentric::disk_to_hemisphere;
    use bsdfkit_sphere::direction::from_degrees;

    #[test]
    fn values_given_are_met_and_edges_are_continuous() {
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
            for p in QUARTERS.map(|share| place(a).lerp(place(b), share)) {
                assert!((at(p) - value(disk_to_hemisphere(p, Side::Front))).abs() < 1e-6);
            }
            for share in [0.0, 0.2, 0.7] {
                let p = place(a).lerp(place(b), share);
                assert!((at(p + across) - at(p - across)).abs() < 1e-6);
            }
            assert!(at(place(a)).abs() < 1e-9);
        }
    }
}
