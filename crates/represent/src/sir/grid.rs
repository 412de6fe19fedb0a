//! The square grid that lobe centres live on: equal solid angles, not the projected ones of the tensor tree.

use bsdfkit_sphere::concentric::{disk_to_square, square_to_disk};
use bsdfkit_sphere::{DVec2, DVec3, Side};

/// A grid of `resolution`² cells of equal solid angle on one hemisphere.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    pub(super) resolution: u16,
    pub(super) side: Side,
}

impl Grid {
    /// Unit vector to the middle of a cell: concentric square → disk, then r² = 1 − |z|.
    pub(super) fn centre(self, cell: [u16; 2]) -> DVec3 {
        let n = f64::from(self.resolution);
        let d = square_to_disk(DVec2::new(
            (f64::from(cell[0]) + 0.5) / n,
            (f64::from(cell[1]) + 0.5) / n,
        ));
        let r2 = d.length_squared().min(1.0);
        let k = (2.0 - r2).sqrt();
        DVec3::new(d.x * k, d.y * k, self.side.sign() * (1.0 - r2))
    }

    /// The cell that a direction falls into, whatever its side.
    pub(super) fn cell(self, w: DVec3) -> [u16; 2] {
        let n = f64::from(self.resolution);
        let s = disk_to_square(w.truncate() / (1.0 + w.z.abs()).sqrt()) * n;
        [(s.x.min(n - 1.0)) as u16, (s.y.min(n - 1.0)) as u16]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cell_holds_its_own_centre() {
        for side in [Side::Front, Side::Back] {
            let grid = Grid { resolution: 256, side };
            for x in 0..256 {
                for y in 0..256 {
                    let w = grid.centre([x, y]);
                    assert!((w.length() - 1.0).abs() < 1e-14 && w.z * side.sign() > 0.0);
                    assert_eq!(grid.cell(w), [x, y]);
                }
            }
        }
    }

    #[test]
    fn cells_are_equal_in_solid_angle() {
        // Of N² cells, those with |z| > ½ must be half: the cap above z has solid angle 2π(1 − z).
        let grid = Grid { resolution: 512, side: Side::Front };
        let inside = (0..512)
            .flat_map(|x| (0..512).map(move |y| grid.centre([x, y])))
            .filter(|w| w.z > 0.5)
            .count();
        assert!((inside as f64 / (512.0 * 512.0) - 0.5).abs() < 1e-3, "{inside}");
    }
}
