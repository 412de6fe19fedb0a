//! Continuous BSDF → the render form: tables at nodes of incident directions, in frames that move with the peaks.

mod build;
mod choose;
mod fold;
mod plan;
mod probe;
mod reversed;
mod settings;
mod stretch;
mod subject;

pub use settings::{RenderReport, RenderSettings};

use bsdfkit::Result;
use bsdfkit::render::RenderTable;

use self::subject::Subject;
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
    let mut subject = Subject::new(source);
    let plan = choose::plan(&mut subject, settings, watch)?;
    let mut table = build::table(&subject, &plan, watch)?;
    if settings.reverse {
        let reverse = reversed::table(&table, source, settings, watch)?;
        table = table.with_reverse(reverse);
    }
    let report = choose::report(&subject, &plan, &table);
    Ok((table, report))
}
