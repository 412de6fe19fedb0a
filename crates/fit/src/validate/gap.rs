//! How far an incident direction is from the incidences that it is interpolated from.

use bsdfkit::DVec3;

use crate::interpolant::mesh::IncidenceMesh;
use crate::measurement::Symmetry;

/// How many times the way past the rim counts: errors of extrapolation grow with the way at once, not with
/// its square. Outermost incidences of a rough dielectric and fritted glass, left out, erred 2.5 times as
/// much as holes between incidences let expect; 2.1 is what this stands for. Of 0 and 1.5 to 4 in proposals before
/// anything is measured: at 0 rims are never closed, the others are alike.
const OUTSIDE: f64 = 1.5;

/// The hole of the mesh at one incident direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Gap {
    /// Root of Σ λᵥ d² over the corners v of its cell, d their distance in the chart: what the error of
    /// linear interpolation grows with, zero at the measured incidences and continuous between them.
    pub(crate) width: f64,
    /// Chord to the farthest corner that has a weight.
    pub(crate) reach: f64,
    /// Distance in the chart to the nearest direction inside the mesh: what is extrapolated, zero inside.
    pub(crate) outside: f64,
}

impl Gap {
    /// Of the mesh at `wi` (front hemisphere).
    pub(crate) fn at(mesh: &IncidenceMesh, symmetry: Symmetry, wi: DVec3) -> Self {
        let (folded, _) = symmetry.fold(wi);
        let (mut square, mut reach) = (0.0, 0.0f64);
        let corners = mesh.locate(folded).weights(&mesh.topology);
        for &(v, weight) in &corners {
            let corner = mesh.vertices[v as usize].wi;
            square += weight * mesh.chart.distance(corner, folded).powi(2);
            if weight > 1e-9 {
                reach = reach.max(corner.distance(folded));
            }
        }
        let outside = mesh.chart.distance(mesh.between(&corners), folded);
        Self { width: square.sqrt(), reach, outside }
    }

    /// The width of a hole inside the mesh across which as much is to be expected.
    pub(crate) fn equivalent(self) -> f64 {
        self.width.hypot(OUTSIDE * self.outside)
    }
}
