//! Light that goes all one way, as entries of a matrix.

use super::matrix::{KlemsMatrix, Role, basis_form};
use crate::klems::KlemsBasis;
use crate::{DVec2, DVec3, Error, Result};

/// Points along each side of an incident patch whose light is followed.
const POINTS: usize = 8;

/// Entries and what light from each incident direction that goes where `to` says, a share of it, adds to them, 1/sr.
pub(crate) fn deposits(
    (incident, scattered): (&KlemsBasis, &KlemsBasis),
    to: impl Fn(DVec3) -> Option<(DVec3, f64)>,
) -> Vec<(usize, f64)> {
    let mut row = vec![0.0; scattered.directions()];
    let mut all = Vec::new();
    for i in 0..incident.directions() {
        row.fill(0.0);
        for k in 0..POINTS * POINTS {
            let point = |k: usize| (k as f64 + 0.5) / POINTS as f64;
            let d = incident.direction_in(i, DVec2::new(point(k / POINTS), point(k % POINTS)));
            // Patches of incident light are numbered by its direction of travel.
            let Some((wo, share)) = to(DVec3::new(-d.x, -d.y, d.z)) else { continue };
            if let Some(o) = scattered.index(basis_form(wo, Role::Scattered)) {
                row[o] += share / (POINTS * POINTS) as f64;
            }
        }
        let lit = row.iter().enumerate().filter(|(_, share)| **share > 0.0);
        all.extend(
            lit.map(|(o, share)| (i * row.len() + o, share / scattered.projected_solid_angle(o))),
        );
    }
    all
}

impl KlemsMatrix {
    /// The matrix with `f` of entry and value in the place of some values, by channel: Y, X, Z.
    ///
    /// Errors: argument, for entries that it does not have, and for values that are negative or not finite.
    pub(crate) fn changed(&self, channels: [&[(usize, f64)]; 3], add: bool) -> Result<Self> {
        let change = |values: &[f32], entries: &[(usize, f64)]| -> Result<Vec<f32>> {
            let mut values = values.to_vec();
            for &(entry, value) in entries {
                let count = values.len();
                let place = values.get_mut(entry).ok_or_else(|| {
                    Error::argument(format!(
                        "matrix: expected entries below {count}, found {entry}"
                    ))
                })?;
                *place = if add { (f64::from(*place) + value) as f32 } else { value as f32 };
            }
            Ok(values)
        };
        let [y, x, z] = channels;
        let matrix = Self::new(
            self.incident().clone(),
            self.scattered().clone(),
            change(self.values(), y)?,
        )?;
        match self.chromatic() {
            Some([old_x, old_z]) => matrix.with_colour(change(old_x, x)?, change(old_z, z)?),
            None => Ok(matrix),
        }
    }
}
