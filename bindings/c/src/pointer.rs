//! Pointers from C → values and slices; a null one is `None` or an argument error.

use bsdfkit::{DVec2, DVec3, Error, Result};

/// Three doubles.
///
/// Safety: `v` is null or points to three doubles.
pub(crate) unsafe fn vector(v: *const f64) -> Option<DVec3> {
    // SAFETY: arrays of doubles are aligned alike whatever their length.
    unsafe { v.cast::<[f64; 3]>().as_ref() }.copied().map(DVec3::from_array)
}

/// Two doubles.
///
/// Safety: `v` is null or points to two doubles.
pub(crate) unsafe fn pair(v: *const f64) -> Option<DVec2> {
    // SAFETY: as in `vector`.
    unsafe { v.cast::<[f64; 2]>().as_ref() }.copied().map(DVec2::from_array)
}

/// Stores a result, unless nobody wants it.
///
/// Safety: `out` is null or may be written.
pub(crate) unsafe fn write<T>(out: *mut T, value: T) {
    if !out.is_null() {
        // SAFETY: not null, hence writable.
        unsafe { out.write(value) };
    }
}

fn check<T>(name: &str, null: bool, length: usize) -> Result<()> {
    if null {
        return Err(Error::argument(format!("{name}: expected {length} elements, found null")));
    }
    if length > isize::MAX as usize / size_of::<T>() {
        let text = format!("{name}: expected a count that fits memory, found {length}");
        return Err(Error::argument(text));
    }
    Ok(())
}

/// `length` elements at `data`, which `T` has the layout of.
///
/// Errors: argument: null (unless empty), or more than fits an address space.
/// Safety: `data` is null or points to that many elements, which nobody writes meanwhile.
pub(crate) unsafe fn slice<'a, T, U>(name: &str, data: *const U, length: usize) -> Result<&'a [T]> {
    if length == 0 {
        return Ok(&[]);
    }
    check::<T>(name, data.is_null(), length)?;
    // SAFETY: not null, and of a length that makes sense; the rest is this function's contract.
    Ok(unsafe { std::slice::from_raw_parts(data.cast(), length) })
}

/// `length` elements to write.
///
/// Errors: as [`slice`].
/// Safety: `data` is null or points to that many elements, which nobody else uses meanwhile.
pub(crate) unsafe fn slice_mut<'a, T, U>(
    name: &str,
    data: *mut U,
    length: usize,
) -> Result<&'a mut [T]> {
    if length == 0 {
        return Ok(&mut []);
    }
    check::<T>(name, data.is_null(), length)?;
    // SAFETY: as in `slice`.
    Ok(unsafe { std::slice::from_raw_parts_mut(data.cast(), length) })
}

/// What a function that can fail needs.
pub(crate) fn required<T>(name: &str, value: Option<T>) -> Result<T> {
    value.ok_or_else(|| Error::argument(format!("{name}: expected a pointer, found null")))
}
