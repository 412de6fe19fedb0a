//! What light does at a material, in few numbers that can be compared.

use bsdfkit::{Bsdf, Components, DVec3, Error, Result, Side};
use bsdfkit_sphere::concentric::hemisphere_to_square;
use bsdfkit_sphere::direction::from_degrees;
use half::f16;
use half::slice::HalfFloatSliceExt;

/// Cells along a side of the square of scattered directions: as large as a cone of 4° about the normal.
const CELLS: usize = 16;
/// Cells of the coarse look along a side.
const COARSE: usize = 4;
/// Directions drawn for each incident direction, along a Hilbert curve: a cell's share is off by two of them at most.
const DRAWS: usize = 1024;
/// Incident directions of each side: θ and φ in degrees.
const INCIDENT: [(f64, f64); 5] =
    [(0.0, 0.0), (30.0, 0.0), (30.0, 90.0), (60.0, 0.0), (60.0, 90.0)];
/// Numbers of one side of incidence.
const FINE_SIDE: usize = INCIDENT.len() * 2 * CELLS * CELLS;
const COARSE_SIDE: usize = INCIDENT.len() * 2 * COARSE * COARSE;
/// A side that scatters less than this of the light is not described.
const BLACK: f32 = 1e-4;

/// Where light from ten directions goes: five incident directions of each side (the normal, and 30° and 60° at two
/// azimuths), 16 × 16 cells of equal projected solid angle on either side; each number the share of the incident light.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    fine: Vec<f32>,
    coarse: Vec<f32>,
}

impl Look {
    /// How [`Look::distance`] is explained to readers of an index.
    pub const DISTANCE: &'static str = "mean over incident directions (normal, 30 and 60 degrees at azimuths 0 and 90) of \
         the L1 distance between scattered light, by 16 x 16 cells of equal projected solid angle on either side, as a share of \
         the incident light: 0 is alike, 2 is all light elsewhere";

    /// Of a BSDF, photopic.
    ///
    /// Accuracy: shares of cells to 2/1024 of what an incident direction scatters; totals of tables are exact.
    /// Cost: ten thousand samples, some milliseconds.
    ///
    /// Errors: format, for a damaged compiled file.
    pub fn of(bsdf: &Bsdf) -> Result<Self> {
        let mut fine = vec![0.0f32; 2 * FINE_SIDE];
        let u: Vec<f64> = (0..DRAWS).map(|k| (k as f64 + 0.5) / DRAWS as f64).collect();
        let rows = fine.chunks_exact_mut(2 * CELLS * CELLS);
        let incident = [Side::Front, Side::Back].into_iter().flat_map(|side| {
            INCIDENT.into_iter().map(move |(theta, phi)| {
                let w = from_degrees(theta, phi);
                DVec3::new(w.x, w.y, w.z * side.sign())
            })
        });
        let mut drawn = vec![None; DRAWS];
        for (wi, row) in incident.zip(rows) {
            bsdf.sample_many(&[wi], &u, Components::ALL, &mut drawn)?;
            for sample in drawn.iter().flatten().filter(|s| s.weight.is_finite()) {
                row[cell(sample.wo)] += (sample.weight / DRAWS as f64) as f32;
            }
        }
        Ok(Self::of_fine(fine))
    }

    fn of_fine(fine: Vec<f32>) -> Self {
        const STEP: usize = CELLS / COARSE;
        let mut coarse = vec![0.0; 2 * COARSE_SIDE];
        // STEP rows of cells are one of the coarse look.
        let rows = fine.chunks_exact(STEP * CELLS).zip(coarse.chunks_exact_mut(COARSE));
        for (cells, sums) in rows {
            for row in cells.chunks_exact(CELLS) {
                for (sum, cells) in sums.iter_mut().zip(row.chunks_exact(STEP)) {
                    *sum += cells.iter().sum::<f32>();
                }
            }
        }
        Self { fine, coarse }
    }

    /// The L1 distance of two: [`Look::DISTANCE`]; `None` where no side scatters light of both.
    ///
    /// Convention: specimens are compared as they lie; one that is turned looks different.
    pub fn distance(&self, other: &Self) -> Option<f64> {
        l1(&self.fine, &other.fine, self.common(other))
    }

    /// At most [`Look::distance`], for a sixteenth of its cost.
    pub(crate) fn least_distance(&self, other: &Self) -> Option<f64> {
        l1(&self.coarse, &other.coarse, self.common(other))
    }

    /// Which sides scatter light of both.
    fn common(&self, other: &Self) -> [bool; 2] {
        let (a, b) = (self.sides(), other.sides());
        [a[0] && b[0], a[1] && b[1]]
    }

    fn sides(&self) -> [bool; 2] {
        let total = |k: usize| self.coarse[k * COARSE_SIDE..][..COARSE_SIDE].iter().sum::<f32>();
        [total(0) > BLACK, total(1) > BLACK]
    }

    /// [`Look::distance`] of one that is kept as [`Look::to_bytes`]; `buffer` is for its numbers.
    ///
    /// Errors: format.
    pub(crate) fn distance_of_bytes(
        &self,
        bytes: &[u8],
        buffer: &mut Vec<f32>,
    ) -> Result<Option<f64>> {
        expect_length(bytes)?;
        buffer.clear();
        buffer.extend(bytes.as_chunks::<2>().0.iter().map(|b| f16::from_le_bytes(*b).to_f32()));
        let own = self.sides();
        let lit = |k: usize| buffer[k * FINE_SIDE..][..FINE_SIDE].iter().sum::<f32>() > BLACK;
        Ok(l1(&self.fine, buffer, [own[0] && lit(0), own[1] && lit(1)]))
    }

    /// As half floats.
    pub(crate) fn to_bytes(&self) -> Vec<u8> {
        self.fine.iter().flat_map(|v| f16::from_f32(*v).to_le_bytes()).collect()
    }

    /// From [`Look::to_bytes`].
    ///
    /// Errors: format.
    pub(crate) fn from_bytes(bytes: &[u8]) -> Result<Self> {
        expect_length(bytes)?;
        let pairs = bytes.chunks_exact(2).map(|b| f16::from_le_bytes([b[0], b[1]]));
        let halves: Vec<f16> = pairs.collect();
        let mut fine = vec![0.0; halves.len()];
        halves.convert_to_f32_slice(&mut fine);
        Ok(Self::of_fine(fine))
    }
}

/// Errors: format.
fn expect_length(bytes: &[u8]) -> Result<()> {
    if bytes.len() == 4 * FINE_SIDE {
        return Ok(());
    }
    let text = format!("look: expected {} bytes, found {}", 4 * FINE_SIDE, bytes.len());
    Err(Error::format(text))
}

fn l1(a: &[f32], b: &[f32], sides: [bool; 2]) -> Option<f64> {
    let half = a.len() / 2;
    let side = |k: usize| {
        let (a, b) = (&a[k * half..][..half], &b[k * half..][..half]);
        // Eight sums, which processors add at once.
        let mut sums = [0.0f32; 8];
        for (a, b) in a.chunks_exact(8).zip(b.chunks_exact(8)) {
            for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
                *sum += (a - b).abs();
            }
        }
        f64::from(sums.iter().sum::<f32>()) / INCIDENT.len() as f64
    };
    let distances: Vec<f64> = (0..2).filter(|&k| sides[k]).map(side).collect();
    (!distances.is_empty()).then(|| distances.iter().sum::<f64>() / distances.len() as f64)
}

/// The cell of a scattered direction, the front's first.
fn cell(wo: DVec3) -> usize {
    let square = hemisphere_to_square(wo);
    let at = |x: f64| ((x * CELLS as f64) as usize).min(CELLS - 1);
    let side = usize::from(Side::of(wo) == Side::Back);
    (side * CELLS + at(square.y)) * CELLS + at(square.x)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_1_SQRT_2;

    use bsdfkit::matrix::{KlemsBasis, KlemsMatrix};
    use bsdfkit::{Component, Lambertian, Metadata, Xyz};

    use super::*;

    fn lambertian(reflectance: f64, transmittance: f64) -> Bsdf {
        let parts = Lambertian {
            reflection_front: Xyz::grey(reflectance),
            transmission_front: Xyz::grey(transmittance),
            ..Lambertian::default()
        };
        Bsdf::new(Metadata::default(), Vec::new(), parts)
    }

    /// All light into the mirror direction's patch, or straight on.
    fn mirror(scattered: Side) -> Bsdf {
        let basis = KlemsBasis::full();
        let n = basis.directions();
        let omega = |k: usize| basis.projected_solid_angle(k);
        let values = (0..n * n)
            .map(|k| if k / n == k % n { (0.9 / omega(k % n)) as f32 } else { 0.0 })
            .collect();
        let matrix = KlemsMatrix::new(basis.clone(), basis.clone(), values).unwrap();
        let component = Component::new(Side::Front, scattered, matrix);
        Bsdf::new(Metadata::default(), vec![component], Lambertian::default())
    }

    #[test]
    fn distances_known_in_closed_form() {
        let look = |bsdf: &Bsdf| Look::of(bsdf).unwrap();
        let distance = |a: &Bsdf, b: &Bsdf| look(a).distance(&look(b));
        // |0.8 − 0.5| in every cell of the front.
        let d = distance(&lambertian(0.8, 0.0), &lambertian(0.5, 0.0)).unwrap();
        assert!((d - 0.3).abs() < 5e-3, "{d}");
        // All of one is where none of the other is.
        let d = distance(&lambertian(0.8, 0.0), &lambertian(0.0, 0.5)).unwrap();
        assert!((d - 1.3).abs() < 5e-3, "{d}");
        let d = distance(&mirror(Side::Front), &mirror(Side::Back)).unwrap();
        assert!((d - 1.8).abs() < 5e-3, "{d}");
        // A mirror and white paint share little.
        let d = distance(&mirror(Side::Front), &lambertian(0.9, 0.0)).unwrap();
        assert!((1.5..1.8).contains(&d), "{d}");
        assert_eq!(distance(&lambertian(0.0, 0.0), &lambertian(0.5, 0.0)), None);
    }

    #[test]
    fn the_coarse_distance_is_no_more_than_the_fine_one() {
        let all =
            [mirror(Side::Front), mirror(Side::Back), lambertian(0.8, 0.1), lambertian(0.1, 0.4)];
        let looks: Vec<Look> = all.iter().map(|b| Look::of(b).unwrap()).collect();
        for a in &looks {
            assert_eq!(a.distance(a), Some(0.0));
            for b in &looks {
                let (least, distance) = (a.least_distance(b).unwrap(), a.distance(b).unwrap());
                assert!(least <= distance + 1e-6, "{least} {distance}");
            }
            let kept = Look::from_bytes(&a.to_bytes()).unwrap();
            assert!(kept.distance(a).unwrap() < 1e-3);
            for b in &looks {
                let of_bytes = b.distance_of_bytes(&a.to_bytes(), &mut Vec::new()).unwrap();
                assert_eq!(of_bytes, b.distance(&kept));
            }
        }
    }

    #[test]
    fn cells_are_of_equal_projected_solid_angle() {
        // 45° of the polar angle holds half of it.
        let inside = DVec3::new(FRAC_1_SQRT_2 - 1e-9, 0.0, FRAC_1_SQRT_2);
        assert!(cell(inside) < CELLS * CELLS);
        assert!(cell(DVec3::new(0.0, 0.0, -1.0)) >= CELLS * CELLS);
        let white = Look::of(&lambertian(1.0, 0.0)).unwrap();
        let mean = 1.0 / (CELLS * CELLS) as f32;
        assert!(white.fine[..CELLS * CELLS].iter().all(|v| (v - mean).abs() < 2.0 / DRAWS as f32));
    }
}
