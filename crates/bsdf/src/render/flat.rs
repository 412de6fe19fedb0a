//! The arrays of a table, for programs that read them in place: C, devices.

use super::chart::Chart;
use super::half::Half;
use super::layer::Layer;
use super::shape::Shape;
use super::table::RenderTable;

/// A table in luminance, but for its reverse, as the [container](crate::container) stores it.
#[derive(Clone, Debug)]
pub struct FlatRender<'a> {
    /// (nodes of `fine`, 1 + 6 layers): the total; of each layer its pose and factor.
    pub incidences: &'a [f32],
    /// Where the layers' tables have their nodes.
    pub chart: &'a Chart,
    /// Where `incidences` has its nodes.
    pub fine: &'a Chart,
    /// The layers.
    pub layers: Vec<FlatLayer<'a>>,
}

/// The arrays of a layer.
#[derive(Clone, Copy, Debug)]
pub struct FlatLayer<'a> {
    /// The form of its tables.
    pub shape: &'a Shape,
    /// (nodes, angles + 1, radii + 1).
    pub values: &'a [Half],
    /// (nodes, drawn_angles + 1, drawn_radii + 1).
    pub density: &'a [Half],
    /// (nodes, drawn_angles + 1, drawn_radii / 4 + 1).
    pub sums: &'a [f32],
    /// (nodes, drawn_angles + 1).
    pub running: &'a [f32],
}

impl RenderTable {
    /// Its arrays.
    pub fn flat(&self) -> FlatRender<'_> {
        fn layer(layer: &Layer) -> FlatLayer<'_> {
            let drawing = &layer.drawing;
            FlatLayer {
                shape: &layer.shape,
                values: &layer.values,
                density: &drawing.density,
                sums: &drawing.sums,
                running: &drawing.running,
            }
        }
        FlatRender {
            incidences: &self.incidences,
            chart: &self.chart,
            fine: &self.fine,
            layers: self.layers.iter().map(layer).collect(),
        }
    }
}
