//! A matrix's arrays, for devices.

use bsdfkit::matrix::KlemsMatrix;
use bsdfkit::{Error, Side};

use crate::component;
use crate::error::{self, Class, class_of};
use crate::handle::Handle;
use crate::pointer::{required, write};

/// `bsdfkit_matrix`.
#[repr(C)]
struct Matrix {
    values: *const f32,
    incident_rings: *const [f64; 2],
    scattered_rings: *const [f64; 2],
    incident_count: u32,
    scattered_count: u32,
    rows: u32,
    columns: u32,
    constant: f64,
    incident: f64,
    scattered: f64,
}

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_matrix_at(
    bsdf: *const Handle,
    index: usize,
    out: *mut Matrix,
    error: *mut *mut error::Error,
) -> Class {
    // SAFETY: the header asks for an open handle, a writable `out` and `error`, or null for each.
    unsafe {
        class_of(error, || {
            let handle = Handle::require(bsdf)?;
            let component = component::at(handle, index)?;
            let matrix = component.distribution().downcast_ref::<KlemsMatrix>();
            let (Some(matrix), Some([incident, scattered])) = (matrix, handle.rings(index)) else {
                return Err(Error::argument(format!("component {index}: expected a matrix")));
            };
            required("out", (!out.is_null()).then_some(()))?;
            let matrix = Matrix {
                values: matrix.values().as_ptr(),
                incident_rings: incident.as_ptr(),
                scattered_rings: scattered.as_ptr(),
                incident_count: incident.len() as u32,
                scattered_count: scattered.len() as u32,
                rows: matrix.incident().directions() as u32,
                columns: matrix.scattered().directions() as u32,
                constant: component.floor().y,
                incident: Side::sign(component.incident),
                scattered: Side::sign(component.scattered),
            };
            write(out, matrix);
            Ok(())
        })
    }
}
