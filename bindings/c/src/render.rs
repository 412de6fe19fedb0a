//! A render form's arrays, for devices.

use bsdfkit::render::{FlatLayer, FlatRender, Fold, FrameKind, RenderTable};
use bsdfkit::{Error, Side};

use crate::component;
use crate::error::{self, Class, class_of};
use crate::handle::Handle;
use crate::pointer::{required, write};

/// `BSDFKIT_RENDER_LAYERS`.
const LAYERS: usize = 16;

/// `bsdfkit_render_layer`.
#[repr(C)]
#[derive(Clone, Copy)]
struct Layer {
    values: *const u16,
    density: *const u16,
    sums: *const f32,
    running: *const f32,
    slopes: u32,
    angles: u32,
    radii: u32,
    drawn_angles: u32,
    drawn_radii: u32,
    factor: f64,
    core: f64,
    outermost: f64,
    value_unit: f64,
    drawn_unit: f64,
}

impl Layer {
    const NONE: Self = Self {
        values: std::ptr::null(),
        density: std::ptr::null(),
        sums: std::ptr::null(),
        running: std::ptr::null(),
        slopes: 0,
        angles: 0,
        radii: 0,
        drawn_angles: 0,
        drawn_radii: 0,
        factor: 0.0,
        core: 0.0,
        outermost: 0.0,
        value_unit: 0.0,
        drawn_unit: 0.0,
    };
}

impl From<&FlatLayer<'_>> for Layer {
    fn from(flat: &FlatLayer<'_>) -> Self {
        let shape = flat.shape;
        Self {
            values: flat.values.as_ptr().cast(),
            density: flat.density.as_ptr().cast(),
            sums: flat.sums.as_ptr(),
            running: flat.running.as_ptr(),
            slopes: u32::from(shape.frame.kind == FrameKind::Slopes),
            angles: shape.angles as u32,
            radii: shape.radii as u32,
            drawn_angles: shape.drawn_angles as u32,
            drawn_radii: shape.drawn_radii as u32,
            factor: shape.frame.factor,
            core: shape.core,
            outermost: shape.far,
            value_unit: shape.value_unit,
            drawn_unit: shape.drawn_unit,
        }
    }
}

/// `bsdfkit_render`.
#[repr(C)]
struct Render {
    incidences: *const f32,
    layers: [Layer; LAYERS],
    layer_count: u32,
    fold: u32,
    intervals: u32,
    fine_intervals: u32,
    grazing: f64,
    incident: f64,
    scattered: f64,
}

/// `bsdfkit_fold`.
fn fold(fold: Fold) -> u32 {
    Fold::ALL.iter().position(|f| *f == fold).unwrap_or_default() as u32
}

impl Render {
    fn new(flat: &FlatRender<'_>, incident: Side, scattered: Side) -> Self {
        let mut layers = [Layer::NONE; LAYERS];
        layers.iter_mut().zip(&flat.layers).for_each(|(to, from)| *to = from.into());
        Self {
            incidences: flat.incidences.as_ptr(),
            layers,
            layer_count: flat.layers.len() as u32,
            fold: fold(flat.chart.fold()),
            intervals: flat.chart.intervals() as u32,
            fine_intervals: flat.fine.intervals() as u32,
            grazing: flat.chart.grazing(),
            incident: incident.sign(),
            scattered: scattered.sign(),
        }
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn bsdfkit_render_at(
    bsdf: *const Handle,
    index: usize,
    out: *mut Render,
    error: *mut *mut error::Error,
) -> Class {
    // SAFETY: the header asks for an open handle, a writable `out` and `error`, or null for each.
    unsafe {
        class_of(error, || {
            let component = component::at(Handle::require(bsdf)?, index)?;
            let Some(table) = component.distribution().downcast_ref::<RenderTable>() else {
                return Err(Error::argument(format!("component {index}: expected a render form")));
            };
            required("out", (!out.is_null()).then_some(()))?;
            write(out, Render::new(&table.flat(), component.incident, component.scattered));
            Ok(())
        })
    }
}
