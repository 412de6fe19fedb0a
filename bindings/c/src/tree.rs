//! A tree's arrays, for devices.

use bsdfkit::tree::TreeDistribution;
use bsdfkit::{Error, Side};

use crate::component;
use crate::error::{self, Class, class_of};
use crate::handle::Handle;
use crate::pointer::{required, write};

/// `bsdfkit_tree`.
#[repr(C)]
struct Tree {
    slots: *const u32,
    index: *const u32,
    slices: *const u32,
    records: *const u32,
    lengths: [u64; 4],
    root: u32,
    rank: u32,
    constant: f64,
    incident: f64,
    scattered: f64,
}

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_tree_at(
    bsdf: *const Handle,
    index: usize,
    out: *mut Tree,
    error: *mut *mut error::Error,
) -> Class {
    // SAFETY: the header asks for an open handle, a writable `out` and `error`, or null for each.
    unsafe {
        class_of(error, || {
            let component = component::at(Handle::require(bsdf)?, index)?;
            let distribution = component.distribution();
            let Some(tree) = distribution.downcast_ref::<TreeDistribution>() else {
                return Err(Error::argument(format!("component {index}: expected a tree")));
            };
            required("out", (!out.is_null()).then_some(()))?;
            let flat = tree.flat();
            let arrays = [flat.slots, flat.index, flat.slices, flat.records];
            let [slots, index, slices, records] = arrays.map(<[u32]>::as_ptr);
            let tree = Tree {
                slots,
                index,
                slices,
                records,
                lengths: arrays.map(|array| array.len() as u64),
                root: flat.root,
                rank: tree.luminance().rank().dimensions(),
                constant: component.floor().y,
                incident: Side::sign(component.incident),
                scattered: Side::sign(component.scattered),
            };
            write(out, tree);
            Ok(())
        })
    }
}
