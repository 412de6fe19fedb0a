//! Peaks of no width in a container: their laws in the header, their curves as arrays.

use safetensors::Dtype;
use serde::{Deserialize, Serialize};

use super::SideName;
use super::load::Arrays as Loaded;
use super::save::Arrays as Saved;
use crate::specular::{Curve, Law, Specular};
use crate::{Error, Result, Xyz};

/// A peak, apart from its curve.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Described {
    incident: SideName,
    scattered: SideName,
    linear: [[f64; 2]; 2],
    offset: [f64; 2],
    #[serde(default)]
    width_degrees: f64,
}

fn array(k: usize) -> String {
    format!("specular.{k}.coefficient")
}

pub(super) fn save(arrays: &mut Saved, k: usize, peak: &Specular) -> Described {
    let [rings, azimuths] = peak.coefficient.shape();
    let values = peak.coefficient.values().iter().flat_map(|c| [c.x, c.y, c.z]);
    let bytes = values.flat_map(f64::to_le_bytes).collect();
    arrays.push(array(k), Dtype::F64, vec![rings, azimuths, 3], bytes);
    Described {
        incident: peak.incident.into(),
        scattered: peak.scattered.into(),
        linear: peak.law.linear(),
        offset: peak.law.offset().into(),
        width_degrees: peak.width_degrees,
    }
}

pub(super) fn load(arrays: &Loaded<'_>, k: usize, described: &Described) -> Result<Specular> {
    let name = array(k);
    let fault = |e: Error| Error::format(format!("{name}: {e}"));
    let (shape, values) = arrays.array(&name, Dtype::F64, 3, f64::from_le_bytes)?;
    if shape[2] != 3 {
        return Err(Error::format(format!("{name}: expected 3 channels, found {}", shape[2])));
    }
    let values = values.as_chunks::<3>().0.iter().map(|[x, y, z]| Xyz::new(*x, *y, *z)).collect();
    let peak = Specular {
        incident: described.incident.into(),
        scattered: described.scattered.into(),
        law: Law::affine(described.linear, described.offset).map_err(fault)?,
        coefficient: Curve::new(shape[0], shape[1], values).map_err(fault)?,
        width_degrees: described.width_degrees,
    };
    peak.expect_sound().map_err(fault)?;
    Ok(peak)
}
