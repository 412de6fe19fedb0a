//! Continuous BSDF → a component as files and renderers have it, in colour where there is colour.

use bsdfkit::matrix::KlemsBasis;
use bsdfkit::tree::TreeDistribution;
use bsdfkit::{Component, Distribution, Result, Xyz};
use bsdfkit_sphere::{DVec3, Side};

use super::klems::{KlemsSettings, MatrixReport, klems_matrix};
use super::missed::Missed;
use super::reciprocity::Reciprocity;
use super::render::{RenderReport, RenderSettings, render_table};
use super::tree::tensor_tree;
use super::tree_hues::tree_hues;
use super::tree_settings::{TreeReport, TreeSettings};
use crate::source::{Peak, Slice, Source};
use crate::watch::Watch;

/// What a continuous BSDF becomes.
#[derive(Clone, Debug, PartialEq)]
pub enum Form {
    /// Tensor trees: luminance, and u′ and v′ for three channels; of spectra hues of all leaves.
    Tree(TreeSettings),
    /// A matrix on one basis for both directions.
    Klems(KlemsBasis, KlemsSettings),
    /// The render form.
    Render(RenderSettings),
}

/// How a component came to its form.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Report {
    /// It had that form.
    Copied,
    /// What its luminance tree has cost.
    Tree(TreeReport),
    /// How well a matrix was averaged.
    Matrix(MatrixReport),
    /// What the render form has cost.
    Render(RenderReport),
}

impl Report {
    /// Whether reciprocal values were averaged.
    pub fn reciprocity(&self) -> bool {
        match self {
            Self::Copied | Self::Render(_) => false,
            Self::Tree(report) => report.reciprocity,
            Self::Matrix(report) => report.reciprocity,
        }
    }

    /// The target that was not reached.
    pub fn missed(&self) -> Option<Missed> {
        match self {
            Self::Copied | Self::Render(_) => None,
            Self::Tree(report) => report.missed,
            Self::Matrix(report) => report.missed,
        }
    }
}

/// A component in its form, and how it came to it.
#[derive(Clone, Debug)]
pub struct Tabulated {
    /// The component, of the source's pair of sides.
    pub component: Component,
    /// How it came to its form.
    pub report: Report,
}

impl Tabulated {
    pub(super) fn new(
        (incident, scattered): (Side, Side),
        distribution: impl Distribution,
        report: Report,
    ) -> Self {
        Self { component: Component::new(incident, scattered, distribution), report }
    }
}

/// Part of the luminance tree's values that each chromaticity tree may have: colour varies less
/// than luminance, and the eye sees it less finely. A guess. Samples are halved only, as the first
/// quarter of them is taken everywhere alike.
const CHROMATICITY_SHARE: usize = 4;

/// Largest error of a chromaticity tree in that of luminance: Z is a small difference of terms in
/// v′, so that 1 % of v′ may be 10 % of Z.
const CHROMATICITY_ERROR: f64 = 0.1;

/// Continuous BSDF → component; three channels are taken as luminance, X and Z.
///
/// Convention: all components of one XML file need the same rank: set [`TreeSettings::rank`]
/// where some sources are isotropic and others are not.
/// Errors: as [`tensor_tree`] and [`klems_matrix`].
pub fn component(source: &dyn Source, form: &Form, watch: &Watch<'_>) -> Result<Tabulated> {
    let sides = (source.incident(), source.scattered());
    match form {
        Form::Klems(basis, settings) => {
            let (matrix, report) = klems_matrix(source, basis, settings, watch)?;
            Ok(Tabulated::new(sides, matrix, Report::Matrix(report)))
        }
        Form::Render(settings) => {
            let (table, report) = render_table(source, settings, watch)?;
            Ok(Tabulated::new(sides, table, Report::Render(report)))
        }
        Form::Tree(settings) => {
            let (luminance, report) = tensor_tree(source, settings, watch)?;
            let distribution = if source.channels() == 3 && !report.negligible {
                let (leaves, samples) =
                    settings.budget(luminance.rank(), luminance.depth(), source.isotropic());
                let settings = TreeSettings {
                    rank: Some(luminance.rank()),
                    max_leaves: Some(leaves / CHROMATICITY_SHARE),
                    max_error: CHROMATICITY_ERROR * settings.max_error,
                    // As luminance: chromaticity varies too little to be judged by itself.
                    reciprocity: match report.reciprocity {
                        true => Reciprocity::On,
                        false => Reciprocity::Off,
                    },
                    max_samples: Some(samples / 2),
                    ..*settings
                };
                let of = |axis| -> Result<_> {
                    Ok(tensor_tree(&Chromaticity { source, axis }, &settings, watch)?.0)
                };
                TreeDistribution::with_chromaticity(luminance, of(0)?, of(1)?)?
            } else {
                TreeDistribution::new(luminance)
            };
            let hue = source.hue().filter(|_| settings.bands && !report.negligible);
            let distribution = match hue {
                Some(hue) => {
                    let hues = tree_hues(source, distribution.luminance(), hue, watch)?;
                    distribution.with_hues(hues)?
                }
                None => distribution,
            };
            Ok(Tabulated::new(sides, distribution, Report::Tree(report)))
        }
    }
}

/// u′ or v′ of a source of three channels, as a source of one.
struct Chromaticity<'a> {
    source: &'a dyn Source,
    /// 0 for u′, 1 for v′.
    axis: usize,
}

impl Source for Chromaticity<'_> {
    fn incident(&self) -> Side {
        self.source.incident()
    }

    fn scattered(&self) -> Side {
        self.source.scattered()
    }

    fn isotropic(&self) -> bool {
        self.source.isotropic()
    }

    fn is_measured(&self, wi: DVec3) -> bool {
        self.source.is_measured(wi)
    }

    fn slice<'a>(&'a self, wi: DVec3) -> Box<dyn Slice + 'a> {
        Box::new(ChromaticitySlice { colour: self.source.slice(wi), axis: self.axis })
    }
}

struct ChromaticitySlice<'a> {
    colour: Box<dyn Slice + 'a>,
    axis: usize,
}

impl Slice for ChromaticitySlice<'_> {
    fn eval(&self, wo: &[DVec3], out: &mut [f32]) {
        let mut values = vec![0.0f32; 3 * wo.len()];
        self.colour.eval(wo, &mut values);
        for (out, yxz) in out.iter_mut().zip(values.chunks_exact(3)) {
            let [y, x, z] = [0, 1, 2]
                .map(|c| if yxz[c].is_finite() { f64::from(yxz[c].max(0.0)) } else { 0.0 });
            let (u, v) = Xyz::new(x, y, z).uv();
            // Without luminance v′ would be 0, which files take for no colour.
            let (u, v) = if y > 0.0 { (u, v) } else { Xyz::grey(1.0).uv() };
            *out = [u, v][self.axis] as f32;
        }
    }

    fn peaks(&self, out: &mut Vec<Peak>) {
        self.colour.peaks(out);
    }
}
