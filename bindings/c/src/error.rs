//! Errors as C sees them: class and message, behind a pointer that may be null.

use std::ffi::{CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};

use bsdfkit::{ErrorClass, Result};

/// `bsdfkit_class`: 0 is success.
pub(crate) type Class = u32;

const OK: Class = 0;
const INTERNAL: Class = 5;

/// `bsdfkit_error`.
pub(crate) struct Error {
    class: Class,
    message: CString,
}

/// Up to its first zero, where C would end it too.
pub(crate) fn text(text: &str) -> CString {
    let end = text.find('\0').unwrap_or(text.len());
    CString::new(&text[..end]).unwrap_or_default()
}

impl From<bsdfkit::Error> for Error {
    fn from(error: bsdfkit::Error) -> Self {
        let class = match error.class() {
            ErrorClass::Io => 1,
            ErrorClass::Format => 2,
            ErrorClass::Argument => 3,
            ErrorClass::Limit => 4,
        };
        Self { class, message: text(&error.to_string()) }
    }
}

/// Does what may fail; returns what it made, or the class of the error, which goes to `error`.
///
/// Safety: `error` is null or may be written.
pub(crate) unsafe fn report<T>(
    error: *mut *mut Error,
    f: impl FnOnce() -> Result<T>,
) -> Result<T, Class> {
    let fault = match catch_unwind(AssertUnwindSafe(f)) {
        Ok(Ok(made)) => return Ok(made),
        Ok(Err(fault)) => Error::from(fault),
        Err(panic) => {
            let words = panic.downcast_ref::<&str>().copied();
            let words = words.or_else(|| panic.downcast_ref::<String>().map(String::as_str));
            let message = text(&format!("internal error: {}", words.unwrap_or("panic")));
            Error { class: INTERNAL, message }
        }
    };
    let class = fault.class;
    if !error.is_null() {
        // SAFETY: not null, hence writable by this function's contract.
        unsafe { error.write(Box::into_raw(Box::new(fault))) };
    }
    Err(class)
}

/// [`report`] of what makes nothing.
///
/// Safety: as [`report`].
pub(crate) unsafe fn class_of(error: *mut *mut Error, f: impl FnOnce() -> Result<()>) -> Class {
    // SAFETY: the same contract.
    match unsafe { report(error, f) } {
        Ok(()) => OK,
        Err(class) => class,
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_error_class(error: *const Error) -> Class {
    // SAFETY: null, or an error not yet freed.
    unsafe { error.as_ref() }.map_or(OK, |e| e.class)
}

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_error_message(error: *const Error) -> *const c_char {
    // SAFETY: null, or an error not yet freed.
    unsafe { error.as_ref() }.map_or(c"", |e| e.message.as_c_str()).as_ptr()
}

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_error_free(error: *mut Error) {
    if !error.is_null() {
        // SAFETY: made by `report`, and freed once.
        drop(unsafe { Box::from_raw(error) });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_an_error_of_its_own_class() {
        let mut error = std::ptr::null_mut();
        // SAFETY: the pointer is writable; what is freed was made here.
        unsafe {
            assert_eq!(class_of(&raw mut error, || panic!("lost {}", 1)), INTERNAL);
            assert_eq!((*error).message.as_c_str(), c"internal error: lost 1");
            bsdfkit_error_free(error);
            assert_eq!(class_of(std::ptr::null_mut(), || panic!("nobody asks")), INTERNAL);
        }
        assert_eq!(crate::guard(1, || panic!("in a query")), 1);
    }
}
