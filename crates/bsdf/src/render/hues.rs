//! Spectra of a table: coefficients of hue beside each layer's values.

use super::chart::{Chart, Stencil};
use super::half::Half;
use super::layer::{Layer, Read};
use super::spot::Spot;
use super::table::{MOST_LAYERS, RenderTable};
use crate::spectrum::{Basis, Hue};
use crate::words::Words;
use crate::{Error, Result};

/// Coefficients of hue in the frames of a table's layers, of one basis.
///
/// Where layers and nodes are blended, what is brighter says more. Adding up their bands instead would wash out a hue that turns between
/// nodes: energy of a band up to 1.7 % off, not 1.2 % (pearl paint).
#[derive(Clone, Debug)]
pub struct Hues {
    pub(crate) hue: Hue,
    /// Cells about the peak and outward, of each layer.
    pub(crate) sizes: Vec<[usize; 2]>,
    /// Of each layer (nodes, angles + 1, radii + 1, rank), from 0 to 1.
    pub(crate) layers: Vec<Words<Half>>,
}

impl Hues {
    /// Those of layers that have so many cells about the peak and outward; `contents`: of each the coefficients as [`Hue::tell`] tells them,
    /// (nodes, angles + 1, radii + 1, rank).
    ///
    /// Errors: argument, where a coefficient is not finite.
    pub fn new(hue: Hue, sizes: Vec<[usize; 2]>, contents: &[Vec<f64>]) -> Result<Self> {
        let hue = hue.of_all(contents.iter().map(Vec::as_slice))?;
        let rank = hue.basis().rank();
        let half = |(n, v): (usize, &f64)| Half::of(hue.stored(n % rank, *v));
        let layer = |content: &Vec<f64>| {
            Words::from(content.iter().enumerate().map(half).collect::<Vec<_>>())
        };
        let layers = contents.iter().map(layer).collect();
        Ok(Self { hue, sizes, layers })
    }

    /// Elements of the array of a layer of that size.
    pub(crate) fn shape(&self, nodes: usize, size: [usize; 2]) -> Vec<usize> {
        vec![nodes, size[0] + 1, size[1] + 1, self.hue.basis().rank()]
    }

    /// Errors: argument, unless there are arrays of the sizes for each of the table's layers.
    pub(crate) fn check(&self, chart: &Chart, layers: usize) -> Result<()> {
        let expected =
            |size: &[usize; 2]| self.shape(chart.nodes(), *size).iter().product::<usize>();
        let fits = self.sizes.len() == layers
            && self.layers.len() == layers
            && self.sizes.iter().flatten().all(|n| (1..=super::shape::Shape::MOST).contains(n))
            && self.sizes.iter().zip(&self.layers).all(|(s, l)| expected(s) == l.len());
        if fits {
            return Ok(());
        }
        let found: Vec<usize> = self.layers.iter().map(|l| l.len()).collect();
        Err(Error::argument(format!(
            "hues: expected arrays of (nodes, angles + 1, radii + 1, rank) for each of {layers} layers, found {found:?} elements of {:?} cells",
            self.sizes
        )))
    }

    /// How bands follow from luminance and coefficients.
    pub fn hue(&self) -> &Hue {
        &self.hue
    }

    /// Adds what a layer says to `sums`: luminance, and the coefficients times that.
    pub(super) fn add(
        &self,
        number: usize,
        layer: &Layer,
        factor: f64,
        (nodes, spot): (&Stencil, &Spot),
        sums: &mut [f64; 1 + Basis::MOST],
    ) {
        let (Some([angles, radii]), Some(table)) =
            (self.sizes.get(number), self.layers.get(number))
        else {
            return;
        };
        if layer.shape.angles == 0 {
            return;
        }
        let (a, t) = layer.coordinates(spot);
        let (read, tint) = (layer.read(spot), Read::new(a, t, *angles, *radii));
        let rank = self.hue.basis().rank();
        for (node, weight) in nodes.iter() {
            let y = weight * factor * layer.shape.value_unit * read.at(&layer.values, node, 1, 0);
            sums[0] += y;
            for (k, sum) in sums[1..].iter_mut().take(rank).enumerate() {
                *sum += y * tint.at(table, node, rank, k);
            }
        }
    }

    /// f of all bands of such sums, 1/sr.
    pub(super) fn bands(&self, sums: &[f64; 1 + Basis::MOST], out: &mut [f64]) {
        let mut stored = [0.0; Basis::MOST];
        let y = sums[0];
        if y > 0.0 {
            stored.iter_mut().zip(&sums[1..]).for_each(|(s, sum)| *s = sum / y);
        }
        self.hue.bands(y, &stored[..self.hue.basis().rank()], out);
    }

    /// Bytes of all arrays.
    pub(super) fn bytes(&self) -> usize {
        self.layers.iter().map(|l| 2 * l.len()).sum()
    }
}

impl RenderTable {
    /// The same with spectra beside its values.
    ///
    /// Errors: argument, for arrays that do not fit.
    pub fn with_hues(self, hues: Hues) -> Result<Self> {
        hues.check(&self.chart, self.layers.len().min(MOST_LAYERS))?;
        Ok(Self { hues: Some(hues), ..self })
    }

    /// Its spectra.
    pub fn hues(&self) -> Option<&Hues> {
        self.hues.as_ref()
    }
}
