//! Which way lobes set out: first-order motion at the vertices, from the plans of their edges.

use bsdfkit::{DVec2, DVec3};

use crate::interpolant::field::blend::local_gradient;
use crate::interpolant::mesh::incidence_mesh::IncidenceMesh;
use crate::interpolant::motion::edge_plan::EdgePlan;
use crate::lobe::LobeSet;

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
