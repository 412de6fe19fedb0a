//! The five verbs, one query each.

use bsdfkit::{Components, Part};

use crate::guard;
use crate::handle::Handle;
use crate::pointer::{pair, vector, write};

/// `bsdfkit_sample`.
#[derive(Clone, Copy)]
#[repr(C)]
pub(crate) struct Sample {
    wo: [f64; 3],
    weight: f64,
    pdf: f64,
    part: i64,
}

impl From<Option<bsdfkit::Sample>> for Sample {
    fn from(sample: Option<bsdfkit::Sample>) -> Self {
        match sample {
            None => Self { wo: [0.0; 3], weight: 0.0, pdf: 0.0, part: -3 },
            Some(sample) => Self {
                wo: sample.wo.to_array(),
                weight: sample.weight,
                pdf: sample.pdf,
                part: match sample.part {
                    Part::LambertianReflection => -1,
                    Part::LambertianTransmission => -2,
                    Part::Component(index) => index as i64,
                    Part::Specular(index) => -4 - index as i64,
                },
            },
        }
    }
}

/// The header's flags; those it does not know are dropped.
pub(crate) fn selection(flags: u32) -> Components {
    Components::from_bits(flags as u8)
}

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_eval(bsdf: *const Handle, wi: *const f64, wo: *const f64) -> f64 {
    // SAFETY: the header asks for an open handle and for three doubles each, or null.
    let (bsdf, wi, wo) = unsafe { (Handle::get(bsdf), vector(wi), vector(wo)) };
    guard(f64::NAN, || Some(bsdf?.eval(wi?, wo?)))
}

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_eval_xyz(
    bsdf: *const Handle,
    wi: *const f64,
    wo: *const f64,
    xyz: *mut [f64; 3],
) {
    // SAFETY: the header asks for an open handle and for three doubles each, or null.
    unsafe {
        let (bsdf, wi, wo) = (Handle::get(bsdf), vector(wi), vector(wo));
        let colour = guard([f64::NAN; 3], || {
            let c = bsdf?.eval_xyz(wi?, wo?);
            Some([c.x, c.y, c.z])
        });
        write(xyz, colour);
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_pdf(
    bsdf: *const Handle,
    wi: *const f64,
    wo: *const f64,
    components: u32,
) -> f64 {
    // SAFETY: the header asks for an open handle and for three doubles each, or null.
    let (bsdf, wi, wo) = unsafe { (Handle::get(bsdf), vector(wi), vector(wo)) };
    guard(f64::NAN, || Some(bsdf?.pdf(wi?, wo?, selection(components))))
}

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_eval_pdf(
    bsdf: *const Handle,
    wi: *const f64,
    wo: *const f64,
    components: u32,
    out: *mut [f64; 2],
) {
    // SAFETY: the header asks for an open handle and for that many doubles each, or null.
    unsafe {
        let (bsdf, wi, wo) = (Handle::get(bsdf), vector(wi), vector(wo));
        let found =
            guard([f64::NAN; 2], || Some(bsdf?.eval_pdf(wi?, wo?, selection(components)).into()));
        write(out, found);
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_hemispherical(
    bsdf: *const Handle,
    wi: *const f64,
    components: u32,
) -> f64 {
    // SAFETY: the header asks for an open handle and for three doubles, or null.
    let (bsdf, wi) = unsafe { (Handle::get(bsdf), vector(wi)) };
    guard(f64::NAN, || Some(bsdf?.directional_hemispherical(wi?, selection(components))))
}

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_projected_solid_angle(
    bsdf: *const Handle,
    wi: *const f64,
    wo: *const f64,
    range: *mut [f64; 2],
) {
    // SAFETY: the header asks for an open handle and for that many doubles each, or null.
    unsafe {
        let (bsdf, wi, wo) = (Handle::get(bsdf), vector(wi), vector(wo));
        let found = guard([f64::NAN; 2], || Some(bsdf?.projected_solid_angle(wi?, wo).into()));
        write(range, found);
    }
}

/// Stores a sample; whether there is one.
///
/// Safety: `out` is null or may be written.
unsafe fn store(out: *mut Sample, sample: Option<bsdfkit::Sample>) -> i32 {
    // SAFETY: the same contract.
    unsafe { write(out, sample.into()) };
    sample.is_some().into()
}

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_sample_1(
    bsdf: *const Handle,
    wi: *const f64,
    u: f64,
    components: u32,
    out: *mut Sample,
) -> i32 {
    // SAFETY: the header asks for an open handle, three doubles, a writable `out`, or null.
    unsafe {
        let (bsdf, wi) = (Handle::get(bsdf), vector(wi));
        let sample = guard(None, || Some(bsdf?.sample(wi?, u, selection(components))));
        store(out, sample)
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_sample_2(
    bsdf: *const Handle,
    wi: *const f64,
    u: *const f64,
    components: u32,
    out: *mut Sample,
) -> i32 {
    // SAFETY: the header asks for an open handle, three and two doubles, a writable `out`, or null.
    unsafe {
        let (bsdf, wi, u) = (Handle::get(bsdf), vector(wi), pair(u));
        let sample = guard(None, || Some(bsdf?.sample2(wi?, u?, selection(components))));
        store(out, sample)
    }
}
