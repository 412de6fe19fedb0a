//! A stored component → another form: cells regrouped, what they hold kept.

use std::f64::consts::PI;

use bsdfkit::matrix::{KlemsBasis, KlemsMatrix};
use bsdfkit::reciprocity::reciprocal_mean;
use bsdfkit::render::RenderTable;
use bsdfkit::tree::{Rank, TensorTree, TreeDistribution};
use bsdfkit::{Component, DVec3, NEGLIGIBLE_TOTAL, Result, Side};

use super::cells::{TreeCell, mean};
use super::component::{Form, Report, Tabulated, component};
use super::klems::MatrixReport;
use super::reciprocity::{Reciprocity, exchanged_mean, no_reflection};
use super::tree::tensor_tree;
use super::tree_settings::{TreeReport, TreeSettings};
use super::{recut, regroup, steps};
use crate::source::{Slice, Source};
use crate::watch::Watch;

/// Stored component → `form`, in luminance but for matrices of matrices, which keep their colour.
///
/// Meaning: what has the form already stays as it is, a tree unless `max_leaves` or `max_depth` is
/// set. Other values are means over the new cells: exact between matrices, from trees of rank 4 and
/// to them; sampled from trees of rank 3 to rank 4. Reciprocal values are averaged on request alone
/// ([`Reciprocity::On`], `reciprocal`), as [`reciprocal`] does: a file that is not reciprocal keeps
/// its totals.
/// Errors: as [`component`]; argument, as [`reciprocal`].
/// Cost: up to 3 s; sampled ones as [`tensor_tree`].
pub fn stored(source: &Component, form: &Form, watch: &Watch<'_>) -> Result<Tabulated> {
    let asked = match form {
        Form::Tree(settings) => settings.reciprocity == Reciprocity::On,
        Form::Klems(_, settings) => settings.reciprocal,
        Form::Render(_) => false,
    };
    let averaged = if asked { Some(reciprocal(source, watch)?) } else { None };
    let source = averaged.as_ref().unwrap_or(source);
    let mut made = match form {
        Form::Tree(settings) => tree_of(source, settings, watch)?,
        Form::Klems(basis, _) => matrix_of(source, basis, form, watch)?,
        Form::Render(_) if source.distribution().downcast_ref::<RenderTable>().is_some() => {
            Tabulated { component: source.clone(), report: Report::Copied }
        }
        Form::Render(_) => component(&Stored::coloured(source), form, watch)?,
    };
    match (&mut made.report, form) {
        (Report::Tree(report), _) => report.reciprocity = asked,
        (Report::Matrix(report), _) => report.reciprocity = asked,
        (report @ Report::Copied, Form::Klems(..)) if asked => {
            *report = Report::Matrix(MatrixReport { reciprocity: true, ..MatrixReport::default() });
        }
        (report @ Report::Copied, Form::Tree(_)) if asked => {
            let tree = luminance(&made.component).map(TreeReport::exact);
            *report = tree.map_or(Report::Copied, |tree| {
                Report::Tree(TreeReport { reciprocity: true, ..tree })
            });
        }
        (Report::Copied | Report::Render(_), _) => {}
    }
    Ok(made)
}

/// Without averaging.
fn matrix_of(
    source: &Component,
    basis: &KlemsBasis,
    form: &Form,
    watch: &Watch<'_>,
) -> Result<Tabulated> {
    let distribution = source.distribution();
    let made = match (distribution.downcast_ref::<KlemsMatrix>(), luminance(source)) {
        (Some(m), _) if m.incident() == basis && m.scattered() == basis => {
            return Ok(Tabulated { component: source.clone(), report: Report::Copied });
        }
        (Some(matrix), _) => regroup::of_matrix(matrix, basis)?,
        (None, Some(tree)) if tree.rank() == Rank::Four => regroup::of_tree(tree, basis)?,
        (None, Some(tree)) => regroup::of_isotropic_tree(tree, basis)?,
        (None, None) => return component(&Stored::grey(source), form, watch),
    };
    let report = Report::Matrix(MatrixReport::default());
    Ok(Tabulated::new((source.incident, source.scattered), made, report))
}

/// Whether f depends on azimuths only by their difference because of how it is stored: as a tree of rank 3, or so folded.
pub fn is_isotropic(source: &Component) -> bool {
    let render = source.distribution().downcast_ref::<RenderTable>();
    luminance(source).is_some_and(|tree| tree.rank() == Rank::Three)
        || render.is_some_and(|table| table.chart().fold().is_isotropic())
}

/// Without averaging.
fn tree_of(source: &Component, settings: &TreeSettings, watch: &Watch<'_>) -> Result<Tabulated> {
    let sides = (source.incident, source.scattered);
    let rank = settings.rank.unwrap_or(if is_isotropic(source) { Rank::Three } else { Rank::Four });
    let made =
        |(tree, report)| Tabulated::new(sides, TreeDistribution::new(tree), Report::Tree(report));
    let one_leaf = luminance(source).is_some_and(|tree| tree.depth() == 0);
    if !one_leaf && source.distribution().max_total(0.0) <= NEGLIGIBLE_TOTAL {
        let tree = TensorTree::constant(rank, mean_value(source) as f32)?;
        let report = TreeReport::negligible(&tree);
        return Ok(made((tree, report)));
    }
    let distribution = source.distribution();
    match (distribution.downcast_ref::<KlemsMatrix>(), luminance(source)) {
        (Some(matrix), _) => steps::tree_of(matrix, settings, watch).map(made),
        (None, Some(tree)) if tree.rank() == rank => {
            if settings.max_leaves.is_none() && settings.max_depth.is_none() {
                return Ok(Tabulated { component: source.clone(), report: Report::Copied });
            }
            recut::recut(tree, settings).map(made)
        }
        _ => {
            let settings = TreeSettings { reciprocity: Reciprocity::Off, ..*settings };
            component(&Stored::grey(source), &Form::Tree(settings), watch)
        }
    }
}

/// ½ (f(ωi, ωo) + f(ωo, ωi)) of a stored reflection, in the form that it has.
///
/// Meaning: exact; trees lose their colour, and those of rank 3 are sampled anew. The mean of all
/// values is kept, the total of one incidence is not.
/// Errors: argument for a transmission, which has its reverse in another component, for bases that
/// differ, and for patches that have no mirror image about the normal.
pub fn reciprocal(source: &Component, watch: &Watch<'_>) -> Result<Component> {
    if source.is_transmission() {
        return Err(no_reflection());
    }
    let sides = (source.incident, source.scattered);
    if let Some(matrix) = source.distribution().downcast_ref::<KlemsMatrix>() {
        return Ok(Component::new(sides.0, sides.1, exchanged_mean(matrix)?));
    }
    let tree = match luminance(source) {
        Some(tree) if tree.rank() == Rank::Four => reciprocal_mean(tree, tree)?,
        _ => {
            let settings = TreeSettings { reciprocity: Reciprocity::On, ..TreeSettings::default() };
            tensor_tree(&Stored::grey(source), &settings, watch)?.0
        }
    };
    Ok(Component::new(sides.0, sides.1, TreeDistribution::new(tree)))
}

fn luminance(source: &Component) -> Option<&TensorTree> {
    let tree = source.distribution().downcast_ref::<TreeDistribution>();
    tree.map(TreeDistribution::luminance)
}

/// Mean f over both hemispheres.
fn mean_value(source: &Component) -> f64 {
    if let Some(matrix) = source.distribution().downcast_ref::<KlemsMatrix>() {
        let n = matrix.scattered().directions();
        let omega = |k: usize| {
            let incident = matrix.incident().projected_solid_angle(k / n);
            incident * matrix.scattered().projected_solid_angle(k % n)
        };
        let values = matrix.values().iter().enumerate();
        return values.map(|(k, &value)| f64::from(value) * omega(k)).sum::<f64>() / (PI * PI);
    }
    luminance(source).map_or(0.0, |tree| mean(tree, tree.root(), TreeCell::WHOLE))
}

/// A stored component as a continuous BSDF, to be sampled.
pub(super) struct Stored<'a> {
    component: &'a Component,
    channels: usize,
}

impl<'a> Stored<'a> {
    /// Luminance alone.
    fn grey(component: &'a Component) -> Self {
        Self { component, channels: 1 }
    }

    /// With its colour, where it has one.
    pub(super) fn coloured(component: &'a Component) -> Self {
        let channels = if component.distribution().is_coloured() { 3 } else { 1 };
        Self { component, channels }
    }
}

impl Source for Stored<'_> {
    fn incident(&self) -> Side {
        self.component.incident
    }

    fn scattered(&self) -> Side {
        self.component.scattered
    }

    fn isotropic(&self) -> bool {
        is_isotropic(self.component)
    }

    fn channels(&self) -> usize {
        self.channels
    }

    fn slice<'a>(&'a self, wi: DVec3) -> Box<dyn Slice + 'a> {
        Box::new(StoredSlice { of: self, wi })
    }
}

struct StoredSlice<'a> {
    of: &'a Stored<'a>,
    wi: DVec3,
}

impl Slice for StoredSlice<'_> {
    fn eval(&self, wo: &[DVec3], out: &mut [f32]) {
        let distribution = self.of.component.distribution();
        for (values, &w) in out.chunks_exact_mut(self.of.channels).zip(wo) {
            match values {
                [y, x, z] => {
                    let f = distribution.value_xyz(self.wi, w);
                    (*y, *x, *z) = (f.y as f32, f.x as f32, f.z as f32);
                }
                values => values.fill(distribution.value(self.wi, w) as f32),
            }
        }
    }
}
