//! What is stored, in figures.

use bsdfkit::matrix::KlemsMatrix;
use bsdfkit::render::RenderTable;
use bsdfkit::tree::{Rank, TreeDistribution};
use bsdfkit::{Error, Result, Side};
use bsdfkit_fit::interpolant::Continuous;

use crate::error::{self, Class, class_of};
use crate::handle::Handle;
use crate::pointer::{required, write};

/// `bsdfkit_component`.
#[derive(Default)]
#[repr(C)]
struct Component {
    incident: u32,
    scattered: u32,
    representation: u32,
    coloured: u32,
    values: u64,
    depth: u32,
    incident_directions: u32,
    scattered_directions: u32,
    negligible: u32,
    constant: [f64; 3],
    smallest_cell: f64,
}

fn side(side: Side) -> u32 {
    match side {
        Side::Front => 16,
        Side::Back => 32,
    }
}

impl From<&bsdfkit::Component> for Component {
    fn from(c: &bsdfkit::Component) -> Self {
        let (distribution, floor) = (c.distribution(), c.floor());
        let common = Self {
            incident: side(c.incident),
            scattered: side(c.scattered),
            coloured: distribution.is_coloured().into(),
            negligible: c.is_negligible().into(),
            constant: [floor.x, floor.y, floor.z],
            smallest_cell: distribution.min_projected_solid_angle(),
            ..Self::default()
        };
        if let Some(tree) = distribution.downcast_ref::<TreeDistribution>() {
            let tree = tree.luminance();
            let representation = match tree.rank() {
                Rank::Three => 3,
                Rank::Four => 4,
            };
            let values = tree.leaf_count() as u64;
            Self { representation, values, depth: tree.depth(), ..common }
        } else if let Some(matrix) = distribution.downcast_ref::<KlemsMatrix>() {
            Self {
                representation: 2,
                values: matrix.values().len() as u64,
                incident_directions: matrix.incident().directions() as u32,
                scattered_directions: matrix.scattered().directions() as u32,
                ..common
            }
        } else if let Some(table) = distribution.downcast_ref::<RenderTable>() {
            let (values, nodes) = (table.bytes() as u64, table.chart().nodes() as u32);
            Self { representation: 5, values, incident_directions: nodes, ..common }
        } else if let Some(continuous) = distribution.downcast_ref::<Continuous>() {
            let incident_directions = continuous.part().incidences() as u32;
            Self { representation: 1, incident_directions, ..common }
        } else {
            common
        }
    }
}

/// A component by its number.
///
/// Errors: argument: there is none.
pub(crate) fn at(bsdf: &Handle, index: usize) -> Result<&bsdfkit::Component> {
    let components = bsdf.components();
    components.get(index).ok_or_else(|| {
        let count = components.len();
        Error::argument(format!("index: expected one below {count}, found {index}"))
    })
}

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_component_count(bsdf: *const Handle) -> usize {
    // SAFETY: the header asks for an open handle, or null.
    unsafe { Handle::get(bsdf) }.map_or(0, |h| h.components().len())
}

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_component_at(
    bsdf: *const Handle,
    index: usize,
    out: *mut Component,
    error: *mut *mut error::Error,
) -> Class {
    // SAFETY: the header asks for an open handle, a writable `out` and `error`, or null for each.
    unsafe {
        class_of(error, || {
            let component = at(Handle::require(bsdf)?, index)?;
            required("out", (!out.is_null()).then_some(()))?;
            write(out, component.into());
            Ok(())
        })
    }
}
