//! How far an incident direction is from the incidences that it is interpolated from.

use bsdfkit::DVec3;

use crate::interpolant::mesh::incidence_mesh::IncidenceMesh;
use bsdfkit_measure::Symmetry;

/// Share of the mean below which errors do not shrink with f. Doubled, intervals of bright
/// directions widen; a guess between a tenth, chosen, and a thousandth, with which they are twice
/// as wide.
pub(super) const BACKGROUND: f64 = 0.1;

/// The hole of the mesh at one incident direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Gap {
    /// Root of Σ λᵥ d² over the corners v of its cell, d their distance in the chart: what the
    /// error of linear interpolation grows with, zero at the measured incidences and continuous
    /// between them.
    pub(crate) width: f64,
    /// Chord to the farthest corner that has a weight.
    pub(crate) reach: f64,
    /// Distance in the chart to the nearest direction inside the mesh: what is extrapolated, zero
    /// inside.
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

    /// The width of a hole inside the mesh across which as much error is to be expected.
    ///
    /// The width already has the way past the rim in it once, by the distances of the corners; with
    /// `outside` beside it that way counts √2 times. Extrapolation errs by a whole second
    /// difference, the middle of a cell by half of one.
    pub(crate) fn equivalent(self) -> f64 {
        self.width.hypot(self.outside)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interpolant::Chart;
    use bsdfkit_sphere::direction::from_degrees;

    #[test]
    fn the_way_past_the_rim_counts_more_than_the_width_of_a_hole() {
        let chain = [0.0, 20.0, 40.0].map(|t| from_degrees(t, 0.0));
        let mesh = IncidenceMesh::in_chart(&chain, Symmetry::Isotropic, Chart::Disk).expect("mesh");
        let at = |t: f64| Gap::at(&mesh, Symmetry::Isotropic, from_degrees(t, 0.0));
        let inside = at(30.0);
        assert!(inside.outside < 1e-9 && (inside.equivalent() - inside.width).abs() < 1e-9);
        assert!(at(20.0).equivalent() < 1e-6, "{:?}", at(20.0));
        // Past it, the last incidence alone is as far as the way.
        let past = at(55.0);
        assert!((past.width - past.outside).abs() < 1e-6, "{past:?}");
        assert!((past.equivalent() / past.width - 2f64.sqrt()).abs() < 1e-6, "{past:?}");
    }
}
