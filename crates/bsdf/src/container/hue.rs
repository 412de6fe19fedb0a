//! How bands follow from luminance and hue ↔ one array and what is said beside it.

use safetensors::Dtype;
use serde::{Deserialize, Serialize};

use super::load::{Arrays as Loaded, format_of};
use super::save::Arrays as Saved;
use crate::spectrum::{Bands, Basis, Hue};
use crate::{Error, Result};

/// What is said of spectra apart from their arrays.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Described {
    /// Relative L1 of the basis.
    error: f64,
    /// Where f is less (1/sr), hue fades.
    epsilon: f64,
    /// Of each coefficient the least and the length of its range.
    range: Vec<[f64; 2]>,
}

fn array(name: &str) -> String {
    format!("{name}.spectra")
}

/// Rows: wavelengths, weights of the luminance, offset, basis.
pub(super) fn save(arrays: &mut Saved, name: &str, hue: &Hue) -> Described {
    let basis = hue.basis();
    let rows = [basis.bands().nanometres(), hue.weights(), basis.offset()];
    let rows = rows.into_iter().chain(basis.rows().iter().map(Vec::as_slice));
    let bytes = rows.flatten().flat_map(|v| v.to_le_bytes()).collect();
    arrays.push(array(name), Dtype::F64, vec![3 + basis.rank(), basis.bands().count()], bytes);
    Described { error: basis.error(), epsilon: hue.epsilon(), range: hue.range().to_vec() }
}

/// Errors: format.
pub(super) fn load(arrays: &Loaded<'_>, name: &str, described: &Described) -> Result<Hue> {
    let name = array(name);
    let fault = |e: Error| format_of(&name, &e);
    let (shape, values) = arrays.array(&name, Dtype::F64, 2, f64::from_le_bytes)?;
    let mut rows = values.chunks_exact(shape[1].max(1)).map(<[f64]>::to_vec);
    let wrong = || {
        Error::format(format!(
            "{name}: expected rows of finite numbers: wavelengths, weights, offset and 1 to {} of the basis, found {shape:?}",
            Basis::MOST
        ))
    };
    let mut row = || rows.next().ok_or_else(wrong);
    let (bands, weights, offset) = (row()?, row()?, row()?);
    let bands = Bands::new(bands).map_err(fault)?;
    let basis = Basis::new(bands, offset, rows.collect(), described.error).ok_or_else(wrong)?;
    let hue = Hue::new(basis, weights, described.epsilon).map_err(fault)?;
    hue.with_range(described.range.clone()).map_err(fault)
}
