//! The render form ↔ arrays.

use safetensors::Dtype;
use serde::{Deserialize, Serialize};

use super::hue;
use super::load::{Arrays, format_of};
use super::save::Arrays as Written;
use crate::render::{self, Chart, Fold, Half, Hues, Layer, RenderTable, Shape};
use crate::words::{Word, Words};
use crate::{Error, Result};

/// What is said of a table apart from its arrays.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Described {
    fold: Fold,
    intervals: usize,
    grazing: f64,
    layers: Vec<Shape>,
    largest_total: f64,
    smallest_cell: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    reverse: Option<Box<Described>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    hues: Option<DescribedHues>,
}

/// What is said of a table's spectra.
#[derive(Debug, Serialize, Deserialize)]
struct DescribedHues {
    /// Cells about the peak and outward, of each layer.
    sizes: Vec<[usize; 2]>,
    #[serde(flatten)]
    hue: hue::Described,
}

/// Writes a table's arrays under names that begin with `name`.
pub(super) fn save(arrays: &mut Written, name: &str, table: &RenderTable) -> Described {
    let (nodes, fine) = (table.chart.nodes(), table.fine.nodes());
    let columns = table.incidences.len() / fine.max(1);
    let incidences = format!("{name}.incidences");
    arrays.words(incidences, Dtype::F32, vec![fine, columns], &table.incidences);
    for (k, layer) in table.layers.iter().enumerate() {
        let name = |array: &str| format!("{name}.layer.{k}.{array}");
        let [values, colour, density, sums, running] = layer.shape.lengths(nodes);
        let drawing = &layer.drawing;
        if layer.shape.angles > 0 {
            arrays.words(name("values"), Dtype::F16, values, &layer.values);
        }
        if layer.shape.colour_angles > 0 {
            arrays.words(name("colour"), Dtype::F16, colour, &layer.colour);
        }
        arrays.words(name("density"), Dtype::F16, density, &drawing.density);
        arrays.words(name("sums"), Dtype::F32, sums, &drawing.sums);
        arrays.words(name("running"), Dtype::F32, running, &drawing.running);
    }
    let hues = table.hues.as_ref().map(|hues| {
        for (k, (layer, size)) in hues.layers.iter().zip(&hues.sizes).enumerate() {
            let shape = hues.shape(nodes, *size);
            arrays.words(format!("{name}.layer.{k}.hue"), Dtype::F16, shape, layer);
        }
        DescribedHues { sizes: hues.sizes.clone(), hue: hue::save(arrays, name, &hues.hue) }
    });
    let reverse = table.reverse.as_ref();
    Described {
        fold: table.chart.fold(),
        intervals: table.chart.intervals(),
        grazing: table.chart.grazing,
        layers: table.layers.iter().map(|l| l.shape).collect(),
        largest_total: table.largest_total,
        smallest_cell: table.smallest_cell,
        reverse: reverse.map(|r| Box::new(save(arrays, &format!("{name}.reverse"), r))),
        hues,
    }
}

/// Deepest nesting: a table and its reverse.
const DEEPEST: usize = 2;

/// Errors: format.
pub(super) fn load(arrays: &Arrays<'_>, name: &str, described: &Described) -> Result<RenderTable> {
    nested(arrays, name, described, DEEPEST)
}

fn nested(
    arrays: &Arrays<'_>,
    name: &str,
    described: &Described,
    deepest: usize,
) -> Result<RenderTable> {
    let fault = |e: Error| format_of(name, &e);
    let chart =
        Chart::new(described.fold, described.intervals, described.grazing).map_err(fault)?;
    let layers = described.layers.iter().enumerate();
    let layers =
        layers.map(|(k, shape)| layer(arrays, &format!("{name}.layer.{k}"), &chart, shape));
    let layers = layers.collect::<Result<Vec<_>>>()?;
    let incidences = floats(arrays, &format!("{name}.incidences"), 2)?;
    let (largest, smallest) = (described.largest_total, described.smallest_cell);
    let mut table =
        RenderTable::of_arrays(chart, layers, incidences, largest, smallest).map_err(fault)?;
    // Opened in place, nothing is read before it is asked for.
    if arrays.file.is_none() {
        table.expect_sound_energy().map_err(fault)?;
    }
    if let Some(hues) = &described.hues {
        let hue = hue::load(arrays, name, &hues.hue)?;
        let layers =
            (0..hues.sizes.len()).map(|k| halves(arrays, &format!("{name}.layer.{k}.hue"), 4));
        let layers = layers.collect::<Result<_>>()?;
        table = table.with_hues(Hues { hue, sizes: hues.sizes.clone(), layers }).map_err(fault)?;
    }
    if let Some(reverse) = &described.reverse {
        if deepest <= 1 {
            return Err(Error::format(format!("{name}: expected no reverse of a reverse")));
        }
        let reverse = nested(arrays, &format!("{name}.reverse"), reverse, deepest - 1)?;
        table = table.with_reverse(reverse);
    }
    Ok(table)
}

fn layer(arrays: &Arrays<'_>, name: &str, chart: &Chart, shape: &Shape) -> Result<Layer> {
    let named = |array: &str| format!("{name}.{array}");
    let empty = Words::from(Vec::new());
    let values = match shape.angles {
        0 => empty.clone(),
        _ => halves(arrays, &named("values"), 3)?,
    };
    let colour = match shape.colour_angles {
        0 => empty,
        _ => halves(arrays, &named("colour"), 4)?,
    };
    let all = render::Arrays {
        values,
        colour,
        density: halves(arrays, &named("density"), 3)?,
        sums: amounts(arrays, &named("sums"), 3)?,
        running: amounts(arrays, &named("running"), 2)?,
    };
    Layer::of_arrays(chart, *shape, all).map_err(|e| format_of(name, &e))
}

fn halves(arrays: &Arrays<'_>, name: &str, rank: usize) -> Result<Words<Half>> {
    arrays.numbers(name, Dtype::F16, rank, |h: &Half| h.0 < 0x7c00)
}

fn floats(arrays: &Arrays<'_>, name: &str, rank: usize) -> Result<Words<f32>> {
    arrays.numbers(name, Dtype::F32, rank, |v: &f32| v.is_finite())
}

fn amounts(arrays: &Arrays<'_>, name: &str, rank: usize) -> Result<Words<f32>> {
    arrays.numbers(name, Dtype::F32, rank, |v: &f32| v.is_finite() && *v >= 0.0)
}

impl Arrays<'_> {
    /// An array left in the file; where there is none, copied and looked through for what is not `sound`.
    fn numbers<T: Word>(
        &self,
        name: &str,
        dtype: Dtype,
        rank: usize,
        sound: impl Fn(&T) -> bool,
    ) -> Result<Words<T>> {
        let (_, place) = self.place(name, dtype, rank)?;
        if let Some(file) = self.file {
            return Ok(Words::in_place(file, place));
        }
        let words = Words::copied(&self.bytes[place]);
        match words.iter().position(|word| !sound(word)) {
            None => Ok(words),
            Some(at) => Err(Error::format(format!(
                "{name}: expected finite numbers of at least 0, found another at {at}"
            ))),
        }
    }
}
