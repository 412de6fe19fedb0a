//! The library's four classes of errors as Python's exceptions.

use bsdfkit::{Error, ErrorClass};
use pyo3::PyErr;
use pyo3::import_exception;

import_exception!(bsdfkit._errors, IoError);
import_exception!(bsdfkit._errors, FormatError);
import_exception!(bsdfkit._errors, ArgumentError);
import_exception!(bsdfkit._errors, LimitError);

/// The exception of the same class and message.
pub(crate) fn raised(error: &Error) -> PyErr {
    let message = error.to_string();
    match error.class() {
        ErrorClass::Io => IoError::new_err(message),
        ErrorClass::Format => FormatError::new_err(message),
        ErrorClass::Argument => ArgumentError::new_err(message),
        ErrorClass::Limit => LimitError::new_err(message),
    }
}

/// An `ArgumentError`.
pub(crate) fn argument(message: impl Into<String>) -> PyErr {
    raised(&Error::argument(message))
}
