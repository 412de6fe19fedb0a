//! Second-order interpolation of a number given at the vertices of the incidence mesh.

use bsdfkit::DVec3;

use crate::interpolant::mesh::incidence_mesh::IncidenceMesh;

/// Values and gradients at the vertices.
///
/// Inside a triangle: s(ω) = Σ λᵥ (sᵥ + ½ gᵥ·(ω − ωᵥ)), exact for functions of second degree and
/// continuous across edges. Past the rim it goes on with the rim's gradient.
pub(crate) struct Blend {
    values: Vec<f64>,
    gradients: Vec<DVec3>,
}

/// Second-degree terms of the local fit are held back by this share: decides where neighbours
/// lie on too few sides. Doubling it flattens gradients at the rim slightly.
const RIDGE: f64 = 1e-3;

impl Blend {
    /// `values`: one a vertex. Gradients are those of the second-degree polynomial fitted to the
    /// neighbours and their neighbours, never across the edges in `cliffs`.
    pub(crate) fn new(mesh: &IncidenceMesh, values: Vec<f64>, cliffs: &[[u32; 2]]) -> Self {
        let n = mesh.vertices.len();
        let mut near: Vec<Vec<usize>> = vec![Vec::new(); n];
        for &[a, b] in mesh.topology.edges().iter().filter(|e| !cliffs.contains(e)) {
            near[a as usize].push(b as usize);
            near[b as usize].push(a as usize);
        }
        let gradient = |v: usize| {
            let mut around: Vec<usize> = near[v].clone();
            around.extend(near[v].iter().flat_map(|&k| near[k].iter().copied()));
            around.sort_unstable();
            around.dedup();
            around.retain(|&k| k != v);
            let at = |k: usize| (mesh.vertices[k].wi, values[k], 1.0);
            let around: Vec<_> = around.into_iter().map(at).collect();
            local_gradient((mesh.vertices[v].wi, values[v]), &around)
        };
        let gradients = (0..n).map(gradient).collect();
        Self { values, gradients }
    }

    /// s at `wi`, given the vertices and weights of the nearest point of the mesh, `on_mesh`.
    pub(crate) fn at(
        &self,
        mesh: &IncidenceMesh,
        corners: &[(u32, f64)],
        on_mesh: DVec3,
        wi: DVec3,
    ) -> f64 {
        corners
            .iter()
            .map(|&(v, weight)| {
                let v = v as usize;
                let inside = 0.5 * self.gradients[v].dot(on_mesh - mesh.vertices[v].wi);
                weight * (self.values[v] + inside + self.gradients[v].dot(wi - on_mesh))
            })
            .sum()
    }
}

/// Gradient at `centre`, tangent to the sphere, of the second-degree polynomial through it that
/// fits `around` (place, value, confidence) best, with weights confidence/distance².
pub(crate) fn local_gradient(centre: (DVec3, f64), around: &[(DVec3, f64, f64)]) -> DVec3 {
    let normal = centre.0;
    let s = normal.any_orthonormal_vector();
    let t = normal.cross(s);
    let (mut a, mut b) = ([[0.0f64; 5]; 5], [0.0f64; 5]);
    for &(w, value, confidence) in around {
        let d = w - normal;
        let (x, y) = (d.dot(s), d.dot(t));
        let weight = confidence / (x * x + y * y).max(1e-9);
        let row = [x, y, x * x, x * y, y * y];
        for i in 0..5 {
            for j in 0..5 {
                a[i][j] += weight * row[i] * row[j];
            }
            b[i] += weight * row[i] * (value - centre.1);
        }
    }
    let first = (a[0][0] + a[1][1]).max(1e-12);
    let second = (a[2][2] + a[3][3] + a[4][4]).max(1e-12);
    for i in 0..5 {
        a[i][i] += if i < 2 { 1e-6 * first } else { RIDGE * second };
    }
    // Gaussian elimination; the ridge makes it positive definite.
    for k in 0..5 {
        for r in k + 1..5 {
            let f = a[r][k] / a[k][k];
            for c in k..5 {
                a[r][c] -= f * a[k][c];
            }
            b[r] -= f * b[k];
        }
    }
    for k in (0..5).rev() {
        let known: f64 = (k + 1..5).map(|j| a[k][j] * b[j]).sum();
        b[k] = (b[k] - known) / a[k][k];
    }
    let gradient = b[0] * s + b[1] * t;
    if gradient.is_finite() { gradient } else { DVec3::ZERO }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measurement::Symmetry;
    use bsdfkit_sphere::direction::from_degrees;
    use bsdfkit_sphere::locate::Location;

    #[test]
    fn second_degree_functions_are_nearly_reproduced() {
        let mut wi = vec![DVec3::Z];
        for t in [15.0, 30.0, 45.0, 60.0, 75.0] {
            for p in 0..12 {
                wi.push(from_degrees(t, f64::from(p) * 30.0));
            }
        }
        let mesh = IncidenceMesh::new(&wi, Symmetry::None).expect("mesh");
        let f = |w: DVec3| 0.5 + 0.2 * w.x * w.y + 0.3 * w.z - 0.1 * w.z * w.z;
        let blend = Blend::new(&mesh, wi.iter().map(|&w| f(w)).collect(), &[]);
        for (t, p) in [(22.0, 17.0), (37.5, 105.0), (52.5, 15.0), (66.0, 200.0)] {
            let w = from_degrees(t, p);
            let location = mesh.locate(w);
            assert!(matches!(location, Location::Inside { .. }));
            let weights = location.weights(&mesh.topology);
            let s = blend.at(&mesh, &weights, w, w);
            let linear: f64 = weights.iter().map(|&(v, l)| l * f(wi[v as usize])).sum();
            let (error, plain) = ((s - f(w)).abs(), (linear - f(w)).abs());
            assert!(error < 0.5 * plain + 2e-3, "{t} {p}: {error} {plain}");
        }
    }
}
