//! Peaks of no width.

use bsdfkit::SpecularPeak;

use crate::guard;
use crate::handle::Handle;
use crate::pointer::vector;
use crate::query::selection;

/// `bsdfkit_peak`.
#[repr(C)]
pub(crate) struct Peak {
    wo: [f64; 3],
    coefficient: [f64; 3],
    index: u64,
}

impl From<SpecularPeak> for Peak {
    fn from(peak: SpecularPeak) -> Self {
        let c = peak.coefficient;
        Self { wo: peak.wo.to_array(), coefficient: [c.x, c.y, c.z], index: peak.index as u64 }
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_specular_count(bsdf: *const Handle) -> usize {
    // SAFETY: the header asks for an open handle, or null.
    unsafe { Handle::get(bsdf) }.map_or(0, |h| h.specular().len())
}

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_specular_peaks(
    bsdf: *const Handle,
    wi: *const f64,
    components: u32,
    out: *mut Peak,
    capacity: usize,
) -> usize {
    // SAFETY: the header asks for an open handle and three doubles, or null.
    let (bsdf, wi) = unsafe { (Handle::get(bsdf), vector(wi)) };
    let peaks = guard(Vec::new(), || {
        Some(bsdf?.specular_peaks(wi?, selection(components)).collect::<Vec<_>>())
    });
    let room = if out.is_null() { 0 } else { capacity };
    for (k, peak) in peaks.iter().take(room).enumerate() {
        // SAFETY: the header asks for `capacity` writable elements, or null.
        unsafe { out.add(k).write((*peak).into()) };
    }
    peaks.len()
}
