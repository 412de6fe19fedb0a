//! Continuous BSDF → the render form: tables at nodes of incident directions, in frames that move with the peaks.

mod build;
mod choose;
mod fold;
mod plan;
mod probe;
mod reversed;
mod settings;
mod stretch;
mod track;

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
    let mut table = build::table(source, &plan, watch)?;
    if settings.reverse {
        let reversed = reversed::Reversed::new(&table, source);
        let few = RenderSettings { max_bytes: settings.max_bytes / 3, ..*settings };
        let plan = choose::plan(&reversed, fold::of(&reversed), &few, watch)?.without_values();
        let reverse = build::table(&reversed, &plan, watch)?;
        table = table.with_reverse(reverse);
    }
    let report = choose::report(source, &plan, &table);
    Ok((table, report))
}
