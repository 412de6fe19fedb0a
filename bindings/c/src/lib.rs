//! The C face of bsdfkit: what `include/bsdfkit.h` declares, and no physics.
//!
//! Every function reads its pointers, calls one of [`bsdfkit`] within [`guard`], and writes the
//! answer. Names, meanings and lifetimes are the header's.
#![allow(unsafe_code, reason = "pointers from C; each block says what the header asks of callers")]

mod batch;
mod component;
mod error;
mod frame;
mod handle;
mod matrix;
mod pointer;
mod query;
mod render;
mod spectra;
mod specular;
mod tree;

use std::ffi::{CStr, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// `BSDFKIT_ABI_VERSION` of the header.
const ABI_VERSION: u32 = match u32::from_str_radix(env!("BSDFKIT_ABI_VERSION"), 10) {
    Ok(version) => version,
    Err(_) => panic!("the header's version is a number"),
};

const VERSION: &CStr =
    match CStr::from_bytes_with_nul(concat!(env!("CARGO_PKG_VERSION"), "\0").as_bytes()) {
        Ok(version) => version,
        Err(_) => panic!("a version has no zero"),
    };

#[unsafe(no_mangle)]
extern "C" fn bsdfkit_abi_version() -> u32 {
    ABI_VERSION
}

#[unsafe(no_mangle)]
extern "C" fn bsdfkit_version() -> *const c_char {
    VERSION.as_ptr()
}

/// What `f` finds, or `fallback` for a null pointer (`None`) and for a panic: none may reach C.
fn guard<T>(fallback: T, f: impl FnOnce() -> Option<T>) -> T {
    // Queries change nothing, so a panic leaves nothing half done.
    catch_unwind(AssertUnwindSafe(f)).ok().flatten().unwrap_or(fallback)
}
