//! Which way lobes set out: first-order motion at the vertices, from the plans of their edges.

use bsdfkit::{DVec2, DVec3};

use crate::interpolant::mesh::incidence_mesh::IncidenceMesh;
use crate::interpolant::motion::edge_plan::EdgePlan;
use crate::lobe::LobeSet;

/// Second-degree terms of the local fit are held back by this share: decides where neighbours
/// lie on too few sides. Doubling it flattens gradients at the rim slightly.
const RIDGE: f64 = 1e-3;

/// Gradients of the centres of all lobes: where a vertex's plans take each lobe on average, as a
/// second-degree function of the incident direction.
pub(crate) fn tracks(
    mesh: &IncidenceMesh,
    lobes: &[LobeSet],
    plans: &[EdgePlan],
) -> Vec<Vec<[DVec3; 2]>> {
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

/// Gradient at `centre`, tangent to the sphere, of the second-degree polynomial through it that
/// fits `around` (place, value, confidence) best, with weights confidence/distance².
fn local_gradient(centre: (DVec3, f64), around: &[(DVec3, f64, f64)]) -> DVec3 {
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
