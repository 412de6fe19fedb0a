//! Outlines of the cells that a stored form answers by.

use bsdfkit::{Bsdf, DVec3, Side};
use bsdfkit_sphere::concentric::disk_to_hemisphere;

/// Outlines of leaves or patches on `side`: of each the number of its corners, then three numbers a corner, its direction.
pub(crate) fn outlines(bsdf: &Bsdf, wi: DVec3, side: Side) -> Vec<f32> {
    let mut flat = Vec::new();
    for cell in bsdf.cells(wi, side) {
        flat.push(cell.outline.len() as f32);
        let corners =
            cell.outline.iter().map(|&p| disk_to_hemisphere(p.clamp_length_max(1.0), side));
        flat.extend(corners.flat_map(|w| w.to_array()).map(|c| c as f32));
    }
    flat
}
