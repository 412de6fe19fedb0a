//! Spectra in the container: wavelengths, offset and basis as rows of one array.

use bsdfkit::Result;
use bsdfkit::spectrum::{Bands, Basis};
use safetensors::Dtype;

use crate::interpolant::file::arrays::{Array, Arrays};

/// Its name in the file.
const NAME: &str = "spectra";

/// The array of `spectra`.
pub(crate) fn stored(spectra: &Basis) -> (&'static str, Array) {
    let rows = [spectra.bands().nanometres(), spectra.offset()];
    let values = rows.into_iter().flatten().chain(spectra.rows().iter().flatten()).copied();
    (NAME, Array::f64(&[2 + spectra.rank(), spectra.bands().count()], values))
}

/// The spectra of a component that has some. `error`: what the header says of it.
pub(crate) fn restored(arrays: &Arrays<'_>, error: Option<f64>) -> Result<Option<Basis>> {
    let Some(error) = error else { return Ok(None) };
    let (shape, bytes) = arrays.bytes(NAME, Dtype::F64, 2)?;
    let values: Vec<f64> = bytes
        .chunks_exact(8)
        .map(|c| f64::from_le_bytes(c.try_into().unwrap_or_default()))
        .collect();
    let mut rows = values.chunks_exact(shape[1].max(1)).map(<[f64]>::to_vec);
    let wrong = || {
        let expected = "rows of finite numbers: wavelengths, offset and 1 to 6 of the basis";
        arrays.wrong(NAME, expected, &format!("{shape:?}"))
    };
    let (bands, offset) = rows.next().zip(rows.next()).ok_or_else(wrong)?;
    let bands = Bands::new(bands).map_err(|e| e.context(format!("{}.{NAME}", arrays.prefix)))?;
    let error = Some(error).filter(|e| e.is_finite()).ok_or_else(wrong)?;
    Basis::new(bands, offset, rows.collect(), error).map(Some).ok_or_else(wrong)
}
