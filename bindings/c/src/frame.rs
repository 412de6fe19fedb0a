//! The specimen's axes in the world.

use bsdfkit::{DVec3, Error};

use crate::error::{self, Class, class_of};
use crate::guard;
use crate::pointer::{required, vector, write};

/// `bsdfkit_frame`.
#[repr(C)]
struct Frame {
    x: [f64; 3],
    y: [f64; 3],
    z: [f64; 3],
}

impl From<&Frame> for bsdfkit_sphere::Frame {
    fn from(frame: &Frame) -> Self {
        let [x, y, z] = [frame.x, frame.y, frame.z].map(DVec3::from_array);
        Self { x, y, z }
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_frame_new(
    normal: *const f64,
    up: *const f64,
    out: *mut Frame,
    error: *mut *mut error::Error,
) -> Class {
    // SAFETY: the header asks for three doubles each, a writable `out` and `error`, or null.
    unsafe {
        class_of(error, || {
            let normal = required("normal", vector(normal))?;
            let up = required("up", vector(up))?;
            required("out", (!out.is_null()).then_some(()))?;
            let frame = bsdfkit_sphere::Frame::new(normal, up).ok_or_else(|| {
                Error::argument(format!(
                    "frame: expected two vectors that are not parallel, found {normal} and {up}"
                ))
            })?;
            let [x, y, z] = [frame.x, frame.y, frame.z].map(|axis| axis.to_array());
            write(out, Frame { x, y, z });
            Ok(())
        })
    }
}

/// Safety: pointers are null, or readable and writable as the header asks.
unsafe fn map(
    frame: *const Frame,
    from: *const f64,
    to: *mut [f64; 3],
    f: impl FnOnce(bsdfkit_sphere::Frame, DVec3) -> DVec3,
) {
    // SAFETY: this function's contract; `from` is read before `to` is written.
    unsafe {
        let (frame, from) = (frame.as_ref(), vector(from));
        write(to, guard([f64::NAN; 3], || Some(f(frame?.into(), from?).to_array())));
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_to_local(
    frame: *const Frame,
    world: *const f64,
    local: *mut [f64; 3],
) {
    // SAFETY: the header asks for a frame and for three doubles each, or null.
    unsafe { map(frame, world, local, |frame, w| frame.to_local(w)) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_to_world(
    frame: *const Frame,
    local: *const f64,
    world: *mut [f64; 3],
) {
    // SAFETY: the header asks for a frame and for three doubles each, or null.
    unsafe { map(frame, local, world, |frame, w| frame.to_world(w)) }
}
