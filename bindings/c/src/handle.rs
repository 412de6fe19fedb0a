//! The handle: a BSDF and its texts as C wants them.

use std::ffi::{CStr, CString, OsStr, c_char};
use std::ops::Deref;
use std::path::Path;

use bsdfkit::matrix::{KlemsBasis, KlemsMatrix};
use bsdfkit::{Bsdf, Error, Lookup, Result, Side};

use crate::error::{self, report, text};
use crate::guard;
use crate::pointer::{required, slice, write};

/// `bsdfkit_bsdf`.
pub(crate) struct Handle {
    bsdf: Bsdf,
    name: CString,
    manufacturer: CString,
    properties: Vec<(CString, CString)>,
    /// Of each component that is a matrix, the rings of its incident and of its scattered basis.
    rings: Vec<[Rings; 2]>,
}

/// Of each ring, inner to outer: the cosine of its outer bound, its number of azimuths.
pub(crate) type Rings = Vec<[f64; 2]>;

fn rings(basis: &KlemsBasis) -> Rings {
    let azimuths = basis.rings().iter().map(|ring| ring.patches as f64);
    azimuths.enumerate().map(|(r, azimuths)| [basis.ring_cosine(r), azimuths]).collect()
}

impl Handle {
    fn new(bsdf: Bsdf) -> Self {
        let metadata = bsdf.metadata();
        let matrices = bsdf.components().iter().map(|c| c.distribution().downcast_ref());
        let of = |matrix: &KlemsMatrix| [rings(matrix.incident()), rings(matrix.scattered())];
        Self {
            rings: matrices.map(|m| m.map(of).unwrap_or_default()).collect(),
            name: text(&metadata.name),
            manufacturer: text(&metadata.manufacturer),
            properties: metadata.properties.iter().map(|(k, v)| (text(k), text(v))).collect(),
            bsdf,
        }
    }

    /// The rings of the incident and of the scattered basis of a component that is a matrix.
    pub(crate) fn rings(&self, index: usize) -> Option<&[Rings; 2]> {
        self.rings.get(index)
    }

    /// What C handed in.
    ///
    /// Safety: `handle` is null, or open and not closed before the last use of the result.
    pub(crate) unsafe fn get<'a>(handle: *const Self) -> Option<&'a Self> {
        // SAFETY: this function's contract.
        unsafe { handle.as_ref() }
    }

    /// The same where null is an error.
    ///
    /// Safety: as [`Handle::get`].
    pub(crate) unsafe fn require<'a>(handle: *const Self) -> Result<&'a Self> {
        // SAFETY: the same contract.
        required("bsdf", unsafe { Self::get(handle) })
    }
}

impl Deref for Handle {
    type Target = Bsdf;

    fn deref(&self) -> &Bsdf {
        &self.bsdf
    }
}

/// Opens by `open`; null on failure.
///
/// Safety: as [`report`].
unsafe fn make(error: *mut *mut error::Error, open: impl FnOnce() -> Result<Bsdf>) -> *mut Handle {
    let handle = || Ok(Box::into_raw(Box::new(Handle::new(open()?))));
    // SAFETY: the same contract.
    unsafe { report(error, handle) }.unwrap_or(std::ptr::null_mut())
}

#[cfg(unix)]
fn file_name(path: &CStr) -> Result<&OsStr> {
    use std::os::unix::ffi::OsStrExt;
    Ok(OsStr::from_bytes(path.to_bytes()))
}

#[cfg(not(unix))]
fn file_name(path: &CStr) -> Result<&OsStr> {
    let utf8 = path.to_str().map_err(|e| Error::argument(format!("path: {e}")))?;
    Ok(OsStr::new(utf8))
}

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_open(
    path: *const c_char,
    error: *mut *mut error::Error,
) -> *mut Handle {
    let open = || {
        if path.is_null() {
            return Err(Error::argument("path: expected a string, found null"));
        }
        // SAFETY: the header asks for a string that ends with a zero.
        bsdfkit_fit::open::bsdf(Path::new(file_name(unsafe { CStr::from_ptr(path) })?))
    };
    // SAFETY: the header asks for a writable `error`, or null.
    unsafe { make(error, open) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_open_memory(
    bytes: *const u8,
    length: usize,
    error: *mut *mut error::Error,
) -> *mut Handle {
    // SAFETY: the header asks for `length` bytes, and for a writable `error`, or null.
    unsafe { make(error, || bsdfkit_fit::open::bsdf_from_bytes(slice("bytes", bytes, length)?)) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_open_smooth(
    bsdf: *const Handle,
    error: *mut *mut error::Error,
) -> *mut Handle {
    // SAFETY: the header asks for an open handle, or null.
    let open = || Bsdf::clone(unsafe { Handle::require(bsdf) }?).with_lookup(Lookup::Smooth);
    // SAFETY: the header asks for a writable `error`, or null.
    unsafe { make(error, open) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_close(bsdf: *mut Handle) {
    if !bsdf.is_null() {
        // SAFETY: made by `make`, and closed once, after all other calls.
        drop(unsafe { Box::from_raw(bsdf) });
    }
}

/// A text of the handle; null past the end.
///
/// Safety: as [`Handle::get`].
unsafe fn string(
    bsdf: *const Handle,
    which: impl FnOnce(&Handle) -> Option<&CString>,
) -> *const c_char {
    // SAFETY: the same contract.
    let found = unsafe { Handle::get(bsdf) }.and_then(which);
    found.map_or(std::ptr::null(), |text| text.as_ptr())
}

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_name(bsdf: *const Handle) -> *const c_char {
    // SAFETY: the header asks for an open handle, or null.
    unsafe { string(bsdf, |h| Some(&h.name)) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_manufacturer(bsdf: *const Handle) -> *const c_char {
    // SAFETY: the header asks for an open handle, or null.
    unsafe { string(bsdf, |h| Some(&h.manufacturer)) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_dimensions(bsdf: *const Handle, metres: *mut [f64; 3]) {
    // SAFETY: the header asks for an open handle, or null, and for three doubles, or null.
    unsafe {
        let size = guard([f64::NAN; 3], || {
            let metadata = Handle::get(bsdf)?.metadata();
            Some([metadata.width, metadata.height, metadata.thickness])
        });
        write(metres, size);
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_property_count(bsdf: *const Handle) -> usize {
    // SAFETY: the header asks for an open handle, or null.
    unsafe { Handle::get(bsdf) }.map_or(0, |h| h.properties.len())
}

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_property_key(bsdf: *const Handle, index: usize) -> *const c_char {
    // SAFETY: the header asks for an open handle, or null.
    unsafe { string(bsdf, |h| h.properties.get(index).map(|(key, _)| key)) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_property_value(bsdf: *const Handle, index: usize) -> *const c_char {
    // SAFETY: the header asks for an open handle, or null.
    unsafe { string(bsdf, |h| h.properties.get(index).map(|(_, value)| value)) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_lambertian(bsdf: *const Handle, xyz: *mut [[f64; 3]; 4]) {
    // SAFETY: the header asks for an open handle, or null, and for twelve doubles, or null.
    unsafe {
        let rows = guard([[f64::NAN; 3]; 4], || {
            let fields = Handle::get(bsdf)?.lambertian();
            let (front, back) = (Side::Front, Side::Back);
            let pairs = [(front, front), (back, back), (front, back), (back, front)];
            Some(pairs.map(|(incident, scattered)| {
                let c = fields.get(incident, scattered);
                [c.x, c.y, c.z]
            }))
        });
        write(xyz, rows);
    }
}
