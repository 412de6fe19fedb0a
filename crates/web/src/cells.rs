//! Outlines of the cells that a stored form answers by.

use bsdfkit::{Bsdf, DVec3, Side};

/// Outlines of leaves or patches on `side`: of each the number of its corners, then three numbers a corner, its direction.
pub(crate) fn outlines(bsdf: &Bsdf, wi: DVec3, side: Side) -> Vec<f32> {
    let mut flat = Vec::new();
    // More than can be drawn are not drawn.
    for cell in bsdf.cells(wi, side).unwrap_or_default() {
        flat.push(cell.outline.len() as f32);
        flat.extend(cell.outline.iter().flat_map(DVec3::to_array).map(|c| c as f32));
    }
    flat
}
