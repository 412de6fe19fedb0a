//! Peaks of no width in a container: their laws in the header, their curves as arrays.

use safetensors::Dtype;

use super::load::Arrays as Loaded;
use super::save::Arrays as Saved;
use crate::specular::{Described, Specular};
use crate::{Error, Result};

fn array(k: usize) -> String {
    format!("specular.{k}.coefficient")
}

pub(super) fn save(arrays: &mut Saved, k: usize, peak: &Specular) -> Described {
    let [rings, azimuths] = peak.coefficient.shape();
    let bytes = peak.table().flat_map(f64::to_le_bytes).collect();
    arrays.push(array(k), Dtype::F64, vec![rings, azimuths, 3], bytes);
    peak.described()
}

pub(super) fn load(arrays: &Loaded<'_>, k: usize, described: &Described) -> Result<Specular> {
    let name = array(k);
    let (shape, table) = arrays.array(&name, Dtype::F64, 3, f64::from_le_bytes)?;
    if shape[2] != 3 {
        return Err(Error::format(format!("{name}: expected 3 channels, found {}", shape[2])));
    }
    Specular::from_described(described, [shape[0], shape[1]], &table)
        .map_err(|e| Error::format(format!("{name}: {e}")))
}
