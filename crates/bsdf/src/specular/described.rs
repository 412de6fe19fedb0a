//! A peak in files: what a header says of it, and the table of its curve.

use serde::{Deserialize, Serialize};

use super::{Curve, Law, Specular};
use crate::container::SideName;
use crate::{Result, Xyz};

/// A peak apart from the table of its coefficient.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Described {
    incident: SideName,
    scattered: SideName,
    linear: [[f64; 2]; 2],
    offset: [f64; 2],
    #[serde(default)]
    width_degrees: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    residual: Option<f64>,
}

impl Specular {
    /// What is said of the peak beside its table, whose shape and numbers [`Curve`] has.
    pub fn described(&self) -> Described {
        Described {
            incident: self.incident.into(),
            scattered: self.scattered.into(),
            linear: self.law.linear(),
            offset: self.law.offset().into(),
            width_degrees: self.width_degrees,
            residual: self.residual,
        }
    }

    /// The table's numbers, X, Y and Z fastest: rings × azimuths × 3.
    pub fn table(&self) -> impl Iterator<Item = f64> {
        self.coefficient.values().iter().flat_map(|c| [c.x, c.y, c.z])
    }

    /// The peak of a description and a table of (rings, azimuths, 3) numbers.
    ///
    /// Errors: argument, for what is no peak: see [`Law::affine`], [`Curve::new`], [`Specular::expect_sound`].
    pub fn from_described(
        described: &Described,
        [rings, azimuths]: [usize; 2],
        table: &[f64],
    ) -> Result<Self> {
        let values = table.as_chunks::<3>().0.iter().map(|[x, y, z]| Xyz::new(*x, *y, *z));
        let peak = Self {
            incident: described.incident.into(),
            scattered: described.scattered.into(),
            law: Law::affine(described.linear, described.offset)?,
            coefficient: Curve::new(rings, azimuths, values.collect())?,
            width_degrees: described.width_degrees,
            residual: described.residual.filter(|r| r.is_finite()),
        };
        peak.expect_sound()?;
        Ok(peak)
    }
}
