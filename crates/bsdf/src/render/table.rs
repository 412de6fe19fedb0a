//! The tables of a pair of sides.

use super::chart::Chart;
use super::frame::Pose;
use super::hues::Hues;
use super::known::{Known, LAYER, columns};
use super::layer::Layer;
use crate::words::Words;
use crate::{DVec3, Distribution, Error, Result, Sense};

/// A function of two directions in the render form.
///
/// Immutable, shared by any number of threads.
///
/// Accuracy: totals are interpolated between nodes of a finer chart, as the factor is that gives each incidence its
/// energy. Cost: a value reads four numbers a node and layer, of three nodes (two of isotropic materials).
#[derive(Clone, Debug)]
pub struct RenderTable {
    pub(crate) chart: Chart,
    /// Where `incidences` has its nodes.
    pub(crate) fine: Chart,
    pub(crate) layers: Vec<Layer>,
    /// (nodes of `fine`, 1 + 6 layers): the total; of each layer its pose and what its values are multiplied by.
    pub(crate) incidences: Words<f32>,
    pub(crate) largest_total: f64,
    pub(crate) smallest_cell: f64,
    /// From the scattered direction to the incident one: totals and samples.
    pub(crate) reverse: Option<Box<RenderTable>>,
    pub(crate) hues: Option<Hues>,
}

/// How many times as many intervals the finer chart has.
pub(crate) const FINER: usize = 2;

/// Most layers.
pub(crate) const MOST_LAYERS: usize = 16;

impl RenderTable {
    /// A table of these layers, and `poses` of each at the nodes of the finer chart. All factors are 1, totals 0: see
    /// [`RenderTable::with_energy`].
    ///
    /// Errors: argument, for shapes that do not fit.
    pub fn new(chart: Chart, layers: Vec<Layer>, poses: &[Vec<Pose>]) -> Result<Self> {
        let fine = chart.refined(FINER).nodes();
        if poses.len() != layers.len() || poses.iter().any(|p| p.len() != fine) {
            let found: Vec<usize> = poses.iter().map(Vec::len).collect();
            return Err(Error::argument(format!(
                "poses: expected {fine} of each of {} layers, found {found:?}",
                layers.len(),
            )));
        }
        let mut incidences = Vec::with_capacity(fine * columns(layers.len()));
        for node in 0..fine {
            incidences.push(0.0);
            for poses in poses {
                incidences.extend(poses[node].numbers());
                incidences.push(1.0);
            }
        }
        Self::of_incidences(chart, layers, incidences)
    }

    fn of_incidences(chart: Chart, layers: Vec<Layer>, incidences: Vec<f32>) -> Result<Self> {
        let totals = incidences.iter().step_by(columns(layers.len()));
        let largest = f64::from(totals.fold(0.0_f32, |most, total| most.max(*total)));
        let mut table = Self::of_arrays(chart, layers, incidences.into(), largest, 0.0)?;
        table.smallest_cell = table.smallest();
        Ok(table)
    }

    pub(crate) fn of_arrays(
        chart: Chart,
        layers: Vec<Layer>,
        incidences: Words<f32>,
        largest_total: f64,
        smallest_cell: f64,
    ) -> Result<Self> {
        let fine = chart.refined(FINER);
        if !(1..=MOST_LAYERS).contains(&layers.len()) {
            return Err(Error::argument(format!(
                "layers: expected 1 to {MOST_LAYERS}, found {}",
                layers.len()
            )));
        }
        let (expected, found) = (columns(layers.len()) * fine.nodes(), incidences.len());
        if expected != found {
            return Err(Error::argument(format!(
                "incidences: expected {expected} elements, found {found}"
            )));
        }
        let sound = |v: f64| (0.0..=1e12).contains(&v);
        if !sound(largest_total) || !sound(smallest_cell) {
            return Err(Error::argument(format!(
                "largest total, smallest cell: expected finite numbers, found {largest_total} and {smallest_cell}"
            )));
        }
        let (reverse, hues) = (None, None);
        Ok(Self { chart, fine, layers, incidences, largest_total, smallest_cell, reverse, hues })
    }

    /// Reads all totals and factors of layers.
    ///
    /// Errors: argument, where one is negative or no number.
    pub(crate) fn expect_sound_energy(&self) -> Result<()> {
        for record in self.incidences.chunks_exact(columns(self.layers.len())) {
            let factors = record[1..].chunks_exact(LAYER).map(|layer| layer[LAYER - 1]);
            let wrong = |v: &f32| !(v.is_finite() && *v >= 0.0);
            if let Some(found) = std::iter::once(record[0]).chain(factors).find(wrong) {
                return Err(Error::argument(format!(
                    "incidences: expected totals and factors of at least 0, found {found}"
                )));
            }
        }
        Ok(())
    }

    /// The same with these totals at the nodes of the finer chart, and factors of each layer there: (nodes, layers).
    ///
    /// Errors: argument, for numbers that do not fit.
    pub fn with_energy(self, totals: &[f32], factors: &[f32]) -> Result<Self> {
        let Self { chart, fine, layers, incidences, reverse, hues, .. } = self;
        let (nodes, count) = (fine.nodes(), layers.len());
        if (totals.len(), factors.len()) != (nodes, nodes * count) {
            return Err(Error::argument(format!(
                "energy: expected {nodes} totals and {count} factors of each, found {} and {}",
                totals.len(),
                factors.len()
            )));
        }
        let mut incidences = incidences.to_vec();
        let records = incidences.chunks_exact_mut(columns(count));
        for ((record, total), factors) in records.zip(totals).zip(factors.chunks_exact(count)) {
            record[0] = *total;
            let layers = record[1..].chunks_exact_mut(LAYER);
            layers.zip(factors).for_each(|(layer, factor)| layer[LAYER - 1] = *factor);
        }
        Ok(Self { reverse, hues, ..Self::of_incidences(chart, layers, incidences)? })
    }

    /// The same with tables for the opposite direction of travel, whose values are not asked for.
    #[must_use]
    pub fn with_reverse(self, reverse: Self) -> Self {
        Self { reverse: Some(Box::new(reverse)), ..self }
    }

    /// Bytes of all arrays.
    pub fn bytes(&self) -> usize {
        let layer = |l: &Layer| {
            let halves = l.values.len() + l.colour.len() + l.drawing.density.len();
            2 * halves + 4 * (l.drawing.sums.len() + l.drawing.running.len())
        };
        let reverse = self.reverse.as_ref().map_or(0, |r| r.bytes());
        let hues = self.hues.as_ref().map_or(0, Hues::bytes);
        self.layers.iter().map(layer).sum::<usize>() + 4 * self.incidences.len() + reverse + hues
    }

    /// Where the nodes of incident directions are.
    pub fn chart(&self) -> &Chart {
        &self.chart
    }

    /// The layers, the sum of which are values.
    pub fn layers(&self) -> &[Layer] {
        &self.layers
    }

    /// Tables for the opposite direction of travel.
    pub fn reverse(&self) -> Option<&Self> {
        self.reverse.as_deref()
    }

    /// The chart that energy and poses are stored on.
    pub fn fine(&self) -> &Chart {
        &self.fine
    }

    /// What each layer adds to a value, its factor left out: `add` is told the number of the layer, and that.
    pub fn layer_values(&self, wi: DVec3, wo: DVec3, mut add: impl FnMut(usize, f64)) {
        let known = Known::new(self, wi);
        let (xy, z) = known.turned(wo);
        for (n, layer) in self.layers.iter().enumerate() {
            let (placed, _) = known.placed(n, layer);
            add(n, layer.value(&known.nodes, &layer.spot(&placed, xy, z)));
        }
    }

    fn smallest(&self) -> f64 {
        let step = (self.chart.nodes() / 32).max(1);
        let nodes = (0..self.chart.nodes()).step_by(step);
        let of =
            |node| self.projected_solid_angle(self.chart.direction(node), None, Sense::Forward);
        nodes.filter_map(of).fold(std::f64::consts::PI, |least, (low, _)| least.min(low))
    }
}
