//! Where energy is looked at between incidences and past them.

use bsdfkit::{DVec3, Side};
use bsdfkit_sphere::concentric::disk_to_hemisphere;

use crate::interpolant::component::planned::Planned;
use crate::interpolant::field::cells::QUARTERS;

impl Planned {
    /// Incident directions at which the interpolant differs most from its vertices (quarters of
    /// edges, middles of triangles, and some past the rim); one of each symmetric family.
    pub(crate) fn probes(&self) -> Vec<DVec3> {
        let mesh = &self.mesh;
        let mut probes: Vec<DVec3> = Vec::new();
        let mut add = |wi: DVec3| {
            let (folded, _) = self.fitted.symmetry.fold(wi);
            if probes.iter().all(|w| w.distance(folded) > 1e-3) {
                probes.push(folded);
            }
        };

        for &[a, b] in mesh.topology.edges() {
            QUARTERS.iter().for_each(|&share| add(mesh.between(&[(a, 1.0 - share), (b, share)])));
        }
        for t in mesh.topology.triangles() {
            add(mesh.between(&t.map(|v| (v, 1.0 / 3.0))));
        }
        for t in &mesh.notches {
            add(mesh.between(&t.map(|v| (v, 1.0 / 3.0))));
            for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                QUARTERS
                    .iter()
                    .for_each(|&share| add(mesh.between(&[(a, 1.0 - share), (b, share)])));
            }
        }
        for &[a, b] in mesh.topology.boundary() {
            for share in [0.0, 1.0].into_iter().chain(QUARTERS) {
                let p = mesh.between(&[(a, 1.0 - share), (b, share)]).truncate();
                let r = p.length();
                let outward = disk_to_hemisphere(p * (1.0 + 1e-3 * (1.0 - r)), Side::Front);
                if r < 0.05 || self.is_measured(outward) {
                    continue; // a chain's inner edges
                }
                // Ever closer together: most changes near the horizon, and f goes on changing (`past_rim.rs`).
                let steps = ((1.0 - r) / 0.1).ceil().clamp(4.0, 8.0);
                for k in 1..=steps as usize {
                    let out = 1.0 - (1.0 - r) * (1.0 - 0.98 * k as f64 / steps).powi(2);
                    add(disk_to_hemisphere(p * (out / r), Side::Front));
                }
            }
        }
        probes
    }
}
