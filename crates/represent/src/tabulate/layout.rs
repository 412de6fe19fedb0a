//! Where the cells of a tensor tree lie: rank, levels and directions.

use bsdfkit_sphere::concentric::{disk_to_hemisphere, square_to_disk};
use bsdfkit_sphere::{DVec2, DVec3, Side};

use bsdfkit::tree::Rank;

use super::mosaic::even_bits;

/// The cells of a tree of one rank.
///
/// Convention: child c of a node covers the upper half of dimension d iff bit d of c is set, so
/// c = incident child + incident children · scattered child; Z order numbers cells the same way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Layout(pub(super) Rank);

impl Layout {
    /// Cells that an incident cell splits into.
    pub(super) fn incident_children(self) -> usize {
        match self.0 {
            Rank::Three => 2,
            Rank::Four => 4,
        }
    }

    /// Incident cells of `level` that are used; rank 3 leaves the upper half empty.
    pub(super) fn incident_cells(self, level: u32) -> usize {
        match self.0 {
            Rank::Three => (1usize << level).div_ceil(2),
            Rank::Four => 1 << (2 * level),
        }
    }

    /// Which of an incident cell's four slices lie in its child cell `child`.
    pub(super) fn slices_in(self, child: usize) -> &'static [usize] {
        match self.0 {
            Rank::Three => [&[0, 1], &[2, 3]][child],
            Rank::Four => [&[0], &[1], &[2], &[3]][child],
        }
    }

    /// Slice by quadrant, so that every stratum of the incident and of the scattered cell has one
    /// of the four samples, and so have sums and differences of both (peaks follow the mirror or
    /// the straight-through direction: a pairing that keeps the difference would sample one point).
    pub(super) fn slice_of(self) -> [usize; 4] {
        match self.0 {
            Rank::Three => [0, 2, 3, 1],
            Rank::Four => [1, 3, 0, 2],
        }
    }

    /// Incident direction in the middle of incident cell `z` (Z order) of `level`.
    pub(super) fn middle(self, level: u32, z: usize, side: Side) -> DVec3 {
        let cells = f64::from(1u32 << level);
        match self.0 {
            Rank::Three => {
                let sin = (1.0 - 2.0 * (z as f64 + 0.5) / cells).clamp(0.0, 1.0);
                disk_to_hemisphere(DVec2::new(-sin, 0.0), side)
            }
            Rank::Four => {
                let corner =
                    DVec2::new(even_bits(z as u32).into(), even_bits(z as u32 >> 1).into());
                disk_to_hemisphere(-square_to_disk((corner + 0.5) / cells), side)
            }
        }
    }

    /// Incident direction of slice `slice` of incident cell `z` (Z order) of `level`.
    ///
    /// Convention: coordinates are of the travel direction; rank 3 has wi on −X and runs from
    /// grazing (0) to normal incidence (½).
    pub(super) fn incident(self, level: u32, z: usize, slice: usize, side: Side) -> DVec3 {
        let cells = f64::from(1u32 << level);
        match self.0 {
            Rank::Three => {
                let coordinate = (z as f64 + (slice as f64 + 0.5) * 0.25) / cells;
                let sin = (1.0 - 2.0 * coordinate).clamp(0.0, 1.0);
                disk_to_hemisphere(DVec2::new(-sin, 0.0), side)
            }
            Rank::Four => {
                let corner =
                    DVec2::new(even_bits(z as u32).into(), even_bits(z as u32 >> 1).into());
                let offset = DVec2::new((slice & 1) as f64, (slice >> 1) as f64) * 0.5 + 0.25;
                disk_to_hemisphere(-square_to_disk((corner + offset) / cells), side)
            }
        }
    }
}
