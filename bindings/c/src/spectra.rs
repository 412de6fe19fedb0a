//! Bands of spectral measurements.

use std::ffi::{CStr, c_char};

use bsdfkit::spectrum::{Bands, View};
use bsdfkit::{Bsdf, Error, Result};

use crate::error::{self, Class, class_of};
use crate::handle::Handle;
use crate::pointer::{slice, slice_mut, write};
use crate::query::selection;

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_wavelengths(bsdf: *const Handle, count: *mut usize) -> *const f64 {
    // SAFETY: the header asks for an open handle and a writable `count`, or null.
    unsafe {
        let bands = Handle::get(bsdf).and_then(|h| h.wavelengths());
        write(count, bands.map_or(0, Bands::count));
        bands.map_or(std::ptr::null(), |bands| bands.nanometres().as_ptr())
    }
}

/// Doubles of so many results.
fn doubles(bsdf: &Bsdf, count: usize) -> Result<usize> {
    Ok(count.saturating_mul(bsdf.expect_wavelengths()?.count()))
}

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_eval_bands_many(
    bsdf: *const Handle,
    wi: *const f64,
    wi_count: usize,
    wo: *const f64,
    wo_count: usize,
    out: *mut f64,
    count: usize,
    error: *mut *mut error::Error,
) -> Class {
    // SAFETY: the header asks for an open handle and for arrays of the counts given, or null; of `out` a double a band and result.
    unsafe {
        class_of(error, || {
            let bsdf = Handle::require(bsdf)?;
            let (wi, wo) = (slice("wi", wi, wi_count)?, slice("wo", wo, wo_count)?);
            bsdf.eval_bands_many(wi, wo, slice_mut("out", out, doubles(bsdf, count)?)?)
        })
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_hemispherical_bands_many(
    bsdf: *const Handle,
    wi: *const f64,
    wi_count: usize,
    components: u32,
    out: *mut f64,
    count: usize,
    error: *mut *mut error::Error,
) -> Class {
    // SAFETY: as above.
    unsafe {
        class_of(error, || {
            let bsdf = Handle::require(bsdf)?;
            let out = slice_mut("out", out, doubles(bsdf, count)?)?;
            let wi = slice("wi", wi, wi_count)?;
            bsdf.directional_hemispherical_bands_many(wi, selection(components), out)
        })
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_view_weights(
    view: *const c_char,
    wavelengths: *const f64,
    count: usize,
    out: *mut f64,
    rows: *mut usize,
    error: *mut *mut error::Error,
) -> Class {
    // SAFETY: the header asks for a string that ends with a zero, for arrays of `count` and 3 * `count` doubles and a writable
    // `rows`, or null.
    unsafe {
        class_of(error, || {
            if view.is_null() {
                return Err(Error::argument("view: expected a string, found null"));
            }
            let name = CStr::from_ptr(view).to_str();
            let view: View = name.map_err(|e| Error::argument(format!("view: {e}")))?.parse()?;
            let bands = Bands::new(slice::<f64, _>("wavelengths", wavelengths, count)?.to_vec())?;
            let weights = view.weights(&bands)?;
            let out: &mut [f64] = slice_mut("out", out, 3 * count)?;
            for (out, row) in out.chunks_exact_mut(count).zip(weights.rows()) {
                out.copy_from_slice(row);
            }
            write(rows, weights.rows().len());
            Ok(())
        })
    }
}
