//! Continuous BSDF → the render form: tables at nodes of incident directions, in frames that move with the peaks.

mod build;
mod choose;
mod fold;
mod plan;
mod probe;
mod settings;

pub use settings::{RenderReport, RenderSettings};

use bsdfkit::Result;
use bsdfkit::render::RenderTable;

use crate::source::Source;
use crate::watch::Watch;

/// Continuous BSDF → the render form, all channels of it.
///
/// Meaning: of some frames those are taken whose blends come nearest to the source between nodes, and as many nodes as
/// `settings` allow for.
/// Errors: limit, when cancelled. Cost: about a million values of the source.
pub fn render_table(
    source: &dyn Source,
    settings: &RenderSettings,
    watch: &Watch<'_>,
) -> Result<(RenderTable, RenderReport)> {
    let fold = fold::of(source);
    let plan = choose::plan(source, fold, settings, watch)?;
    let table = build::table(source, &plan, watch)?;
    let report = choose::report(source, &table);
    Ok((table, report))
}
