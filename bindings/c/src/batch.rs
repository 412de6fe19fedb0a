//! The five verbs, many queries: pointers and lengths around the slices of Rust.

use bsdfkit::{DVec2, DVec3, Error, Result, Xyz};

use crate::error::{self, Class, class_of};
use crate::handle::Handle;
use crate::pointer::{slice, slice_mut};
use crate::query::{Sample, selection};

/// Samples converted at a time: enough to share out to threads, little enough to stay in cache.
const CHUNK: usize = 1 << 16;

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_eval_many(
    bsdf: *const Handle,
    wi: *const f64,
    wi_count: usize,
    wo: *const f64,
    wo_count: usize,
    out: *mut f64,
    count: usize,
    error: *mut *mut error::Error,
) -> Class {
    // SAFETY: the header asks for an open handle and for arrays of the counts given, or null.
    unsafe {
        class_of(error, || {
            let (wi, wo) = (slice("wi", wi, wi_count)?, slice("wo", wo, wo_count)?);
            Handle::require(bsdf)?.eval_many(wi, wo, slice_mut("out", out, count)?)
        })
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_eval_xyz_many(
    bsdf: *const Handle,
    wi: *const f64,
    wi_count: usize,
    wo: *const f64,
    wo_count: usize,
    out: *mut f64,
    count: usize,
    error: *mut *mut error::Error,
) -> Class {
    // SAFETY: as above, with three doubles a result.
    unsafe {
        class_of(error, || {
            let (wi, wo) = (slice("wi", wi, wi_count)?, slice("wo", wo, wo_count)?);
            let out: &mut [Xyz] = slice_mut("out", out, count)?;
            Handle::require(bsdf)?.eval_xyz_many(wi, wo, out)
        })
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_pdf_many(
    bsdf: *const Handle,
    wi: *const f64,
    wi_count: usize,
    wo: *const f64,
    wo_count: usize,
    components: u32,
    out: *mut f64,
    count: usize,
    error: *mut *mut error::Error,
) -> Class {
    // SAFETY: the header asks for an open handle and for arrays of the counts given, or null.
    unsafe {
        class_of(error, || {
            let (wi, wo) = (slice("wi", wi, wi_count)?, slice("wo", wo, wo_count)?);
            let out = slice_mut("out", out, count)?;
            Handle::require(bsdf)?.pdf_many(wi, wo, selection(components), out)
        })
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_eval_pdf_many(
    bsdf: *const Handle,
    wi: *const f64,
    wi_count: usize,
    wo: *const f64,
    wo_count: usize,
    components: u32,
    out: *mut f64,
    count: usize,
    error: *mut *mut error::Error,
) -> Class {
    // SAFETY: as above, with two doubles a result.
    unsafe {
        class_of(error, || {
            let (wi, wo) = (slice("wi", wi, wi_count)?, slice("wo", wo, wo_count)?);
            let out: &mut [[f64; 2]] = slice_mut("out", out, count)?;
            Handle::require(bsdf)?.eval_pdf_many(wi, wo, selection(components), out)
        })
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_hemispherical_many(
    bsdf: *const Handle,
    wi: *const f64,
    wi_count: usize,
    components: u32,
    out: *mut f64,
    count: usize,
    error: *mut *mut error::Error,
) -> Class {
    // SAFETY: the header asks for an open handle and for arrays of the counts given, or null.
    unsafe {
        class_of(error, || {
            let (wi, out) = (slice("wi", wi, wi_count)?, slice_mut("out", out, count)?);
            let bsdf = Handle::require(bsdf)?;
            bsdf.directional_hemispherical_many(wi, selection(components), out)
        })
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_projected_solid_angle_many(
    bsdf: *const Handle,
    wi: *const f64,
    wi_count: usize,
    wo: *const f64,
    wo_count: usize,
    out: *mut f64,
    count: usize,
    error: *mut *mut error::Error,
) -> Class {
    // SAFETY: as above, with two doubles a result.
    unsafe {
        class_of(error, || {
            let wi = slice("wi", wi, wi_count)?;
            let wo = if wo.is_null() { None } else { Some(slice("wo", wo, wo_count)?) };
            let out: &mut [[f64; 2]] = slice_mut("out", out, count)?;
            Handle::require(bsdf)?.projected_solid_angle_many(wi, wo, out)
        })
    }
}

/// Fills `out` by chunks that `draw(wi, u, samples)` draws.
fn sample_in_chunks<U>(
    wi: &[DVec3],
    u: &[U],
    out: &mut [Sample],
    draw: impl Fn(&[DVec3], &[U], &mut [Option<bsdfkit::Sample>]) -> Result<()>,
) -> Result<()> {
    let count = out.len();
    for (name, found) in [("wi", wi.len()), ("u", u.len())] {
        if found != count && found != 1 {
            return Err(Error::argument(format!(
                "{name}: expected {count} elements (as many as results) or 1, found {found}"
            )));
        }
    }
    fn part<T>(all: &[T], first: usize, length: usize) -> &[T] {
        if all.len() == 1 { all } else { &all[first..first + length] }
    }
    let mut drawn = vec![None; count.min(CHUNK)];
    for (n, out) in out.chunks_mut(CHUNK).enumerate() {
        let (first, length) = (n * CHUNK, out.len());
        let drawn = &mut drawn[..length];
        draw(part(wi, first, length), part(u, first, length), drawn)?;
        for (out, sample) in out.iter_mut().zip(drawn) {
            *out = (*sample).into();
        }
    }
    Ok(())
}

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_sample_1_many(
    bsdf: *const Handle,
    wi: *const f64,
    wi_count: usize,
    u: *const f64,
    u_count: usize,
    components: u32,
    out: *mut Sample,
    count: usize,
    error: *mut *mut error::Error,
) -> Class {
    // SAFETY: the header asks for an open handle and for arrays of the counts given, or null.
    unsafe {
        class_of(error, || {
            let bsdf = Handle::require(bsdf)?;
            let (wi, u) = (slice("wi", wi, wi_count)?, slice::<f64, _>("u", u, u_count)?);
            sample_in_chunks(wi, u, slice_mut("out", out, count)?, |wi, u, out| {
                bsdf.sample_many(wi, u, selection(components), out)
            })
        })
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_sample_2_many(
    bsdf: *const Handle,
    wi: *const f64,
    wi_count: usize,
    u: *const f64,
    u_count: usize,
    components: u32,
    out: *mut Sample,
    count: usize,
    error: *mut *mut error::Error,
) -> Class {
    // SAFETY: as above, with two doubles a `u`.
    unsafe {
        class_of(error, || {
            let bsdf = Handle::require(bsdf)?;
            let (wi, u) = (slice("wi", wi, wi_count)?, slice::<DVec2, _>("u", u, u_count)?);
            sample_in_chunks(wi, u, slice_mut("out", out, count)?, |wi, u, out| {
                bsdf.sample2_many(wi, u, selection(components), out)
            })
        })
    }
}
