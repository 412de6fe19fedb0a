//! Continuous BSDF → Klems matrix, by converged quadrature over both patches. [WKB14 §2.4]

use std::sync::atomic::AtomicUsize;

use bsdfkit::matrix::{KlemsBasis, KlemsMatrix};
use bsdfkit::{Error, Result};
use bsdfkit_sphere::{DVec2, DVec3, Side};
use rayon::prelude::*;

use super::mosaic::{Mosaic, Sampling, even_bits};
use super::source::Source;
use super::watch::Watch;

/// How well a matrix is averaged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KlemsSettings {
    /// Change of an incidence's distribution, as a share of its flux, below which four times as
    /// many incident directions are not tried.
    pub tolerance: f64,
}

impl Default for KlemsSettings {
    /// 1 % of the flux: the result is then four times as good.
    fn default() -> Self {
        Self { tolerance: 0.01 }
    }
}

/// Each incident patch is cut into 4^level cells with a slice at the centre.
const INCIDENT_LEVELS: std::ops::RangeInclusive<u32> = 1..=4;

/// Values per incident patch beyond which no finer level is begun: 20 M for Klems full.
const MOST_PER_PATCH: usize = 150_000;

/// Continuous BSDF → Klems matrix on `basis` for both directions.
///
/// Meaning: each value is the mean of f over the projected solid angles of both patches.
/// Accuracy: rows to about a quarter of the tolerance in L1.
/// Errors: argument for a tolerance that is not positive, or a basis that stops short of grazing
/// incidence; limit when cancelled.
/// Cost: Klems full: 2 k to 40 k slices, 1.5 M to 15 M values; the same at any number of threads.
pub fn klems_matrix(
    source: &dyn Source,
    basis: &KlemsBasis,
    settings: &KlemsSettings,
    watch: &Watch<'_>,
) -> Result<KlemsMatrix> {
    if !(settings.tolerance > 0.0) {
        return Err(Error::argument(format!(
            "Klems matrix: expected a tolerance above 0, found {}",
            settings.tolerance
        )));
    }
    let n = basis.directions();
    let done = AtomicUsize::new(0);
    let rows = (0..n)
        .into_par_iter()
        .map(|patch| {
            let row = row(source, basis, patch, settings.tolerance, watch)?;
            watch.finished(&done, n);
            Ok(row)
        })
        .collect::<Result<Vec<_>>>()?;
    KlemsMatrix::new(basis.clone(), basis.clone(), rows.into_iter().flatten().collect())
}

/// Means of f over each scattered patch, for one incident patch.
fn row(
    source: &dyn Source,
    basis: &KlemsBasis,
    patch: usize,
    tolerance: f64,
    watch: &Watch<'_>,
) -> Result<Vec<f32>> {
    let n = basis.directions();
    let mut last: Option<Vec<f64>> = None;
    let mut spent = 0;
    // Patches start with 16 samples until a level has found nothing to refine in them.
    let mut watched = vec![true; n];
    for level in INCIDENT_LEVELS {
        let slices = 1u32 << (2 * level);
        let mut row = vec![0.0; n];
        let mut varies = vec![false; n];
        let before = spent;
        for z in 0..slices {
            watch.check()?;
            let mosaic = mosaic(source, basis, patch, level, z, tolerance, &watched);
            spent += mosaic.spent();
            for (k, value) in row.iter_mut().enumerate() {
                *value += mosaic.mean_of(k) / f64::from(slices);
                varies[k] |= mosaic.varies_in_root(k);
            }
        }
        watched = varies;
        let flux: f64 =
            row.iter().enumerate().map(|(k, v)| v * basis.projected_solid_angle(k)).sum();
        let change = last.map_or(f64::INFINITY, |last| {
            let changes = row.iter().zip(&last).enumerate();
            changes.map(|(k, (a, b))| (a - b).abs() * basis.projected_solid_angle(k)).sum()
        });
        let next = spent + 4 * (spent - before);
        last = Some(row);
        if change <= tolerance * flux || next > MOST_PER_PATCH {
            break;
        }
    }
    Ok(last.unwrap_or_default().into_iter().map(|v| v as f32).collect())
}

/// Share of the tolerance that a scattered cell may vary: the errors of many cells cancel.
const CELL_SHARE: f64 = 0.1;

fn mosaic(
    source: &dyn Source,
    basis: &KlemsBasis,
    patch: usize,
    level: u32,
    z: u32,
    tolerance: f64,
    watched: &[bool],
) -> Mosaic {
    let corner = DVec2::new(even_bits(z).into(), even_bits(z >> 1).into());
    // Incident patches are of travel directions.
    let travel = basis.direction_in(patch, (corner + 0.5) / f64::from(1u32 << level));
    let slice =
        source.slice(to_side(DVec3::new(-travel.x, -travel.y, travel.z), source.incident()));
    Mosaic::sample(
        [&*slice; 4],
        &Sampling {
            place: &|k, point| to_side(basis.direction_in(k, point), source.scattered()),
            roots: basis.directions(),
            measure: &|k| basis.projected_solid_angle(k) / std::f64::consts::PI,
            forced: &|k| watched[k],
            start: 0,
            deepest: 7,
            stratified: u32::MAX,
            slice_of: [0, 1, 2, 3],
            channels: source.channels(),
            threshold: CELL_SHARE * tolerance,
            most: MOST_PER_PATCH,
        },
    )
}

fn to_side(w: DVec3, side: Side) -> DVec3 {
    DVec3::new(w.x, w.y, side.sign() * w.z)
}
