//! A file written, and what is said of it.

use bsdfkit::matrix::KlemsMatrix;
use bsdfkit::tree::TreeDistribution;
use bsdfkit::xml::{self, WriteOptions};
use bsdfkit::{Bsdf, Component, Error, Metadata, Result, container};
use bsdfkit_fit::deliver::{Consumer, Delivered, Kind};
use bsdfkit_represent::rgl::Channels;
use bsdfkit_represent::tabulate::Report;
use bsdfkit_represent::{Progress, Watch};
use serde_json::{Value, json};

use crate::files::component::leaves;
use crate::files::surface::Surface;
use crate::files::tabulation::Tabulation;
use crate::files::target::Target;
use crate::terminal::progress::Bar;
use crate::terminal::stop::remark;

/// What was written.
pub(crate) struct Written {
    /// Bytes of the file.
    pub(crate) bytes: u64,
    /// How each component came to its form.
    reports: Vec<Report>,
    /// Whether a coloured component was tabulated, in luminance.
    pub(crate) loses_colour: bool,
    /// What was left out or made up.
    pub(crate) said: Vec<String>,
}

impl Written {
    /// What was left out or made up, on standard error.
    pub(crate) fn remark(&self, target: &Target) {
        let colour = self.loses_colour.then_some("luminance only");
        let said = colour.into_iter().chain(self.said.iter().map(String::as_str));
        let place = target.path.display();
        let notes: Vec<String> = said.map(|text| format!("{place}: {text}")).collect();
        remark("note", &notes);
    }

    /// One line for a person.
    pub(crate) fn line(&self, target: &Target) -> String {
        let megabytes = self.bytes as f64 / 1e6;
        let mut line =
            format!("{}: {}, {megabytes:.2} MB", target.path.display(), target.kind.name());
        if self.copied() > 0 {
            line += &format!(", {} components copied", self.copied());
        }
        for report in &self.reports {
            if let Report::Tree(tree) = report {
                line += &match tree.negligible {
                    true => ", negligible: 1 leaf".into(),
                    false => format!(", {} leaves, added L1 {:.4}", tree.leaves, tree.error),
                };
            }
            if let Report::Render(table) = report {
                let (nodes, layers, error) = (table.nodes, table.layers, table.error);
                line += &format!(", {nodes} nodes, {layers} layers, added L1 {error:.4}");
            }
            line += if report.reciprocity() { ", reciprocal" } else { "" };
            if let Some(missed) = report.missed() {
                line += &format!(" ({missed})");
            }
        }
        line
    }

    /// The same for a program.
    pub(crate) fn json(&self, target: &Target) -> Value {
        let missed = |report: &Report| report.missed().map(|missed| missed.to_string());
        let tree = |report: &Report| match report {
            Report::Tree(t) => Some(json!({
                "leaves": t.leaves, "added_l1": t.error, "reciprocal": t.reciprocity,
                "negligible": t.negligible, "missed": missed(report)
            })),
            _ => None,
        };
        let matrix = |report: &Report| match report {
            Report::Matrix(m) => Some(json!({
                "averaging_l1": m.error, "reciprocal": m.reciprocity, "missed": missed(report)
            })),
            _ => None,
        };
        let table = |report: &Report| match report {
            Report::Render(t) => Some(json!({
                "bytes": t.bytes, "nodes": t.nodes, "layers": t.layers, "added_l1": t.error
            })),
            _ => None,
        };
        json!({
            "file": target.path.display().to_string(),
            "kind": target.kind.name(),
            "bytes": self.bytes,
            "components_copied": self.copied(),
            "notes": self.said,
            "trees": self.reports.iter().filter_map(tree).collect::<Vec<_>>(),
            "render": self.reports.iter().filter_map(table).collect::<Vec<_>>(),
            "matrices": self.reports.iter().filter_map(matrix).collect::<Vec<_>>(),
        })
    }

    /// Components copied value by value.
    pub(crate) fn copied(&self) -> usize {
        self.reports.iter().filter(|report| **report == Report::Copied).count()
    }
}

/// The fields of files in XML that hold placeholders, in one sentence.
pub(crate) fn placeholders(metadata: &Metadata, targets: &[Target]) -> Option<String> {
    let fields = xml::placeholders(metadata);
    let xml = |t: &Target| !t.is_container() && t.kind.channels().is_none();
    let written = targets.iter().any(xml) && !fields.is_empty();
    written.then(|| {
        format!(
            "not known, written as placeholders: {} (--name, --manufacturer, --thickness, --width, --height and --property FIELD=VALUE set them)",
            fields.join(", ")
        )
    })
}

/// Digits that keep every bit of copied values: the usual ones if the values came with no more.
fn exact_digits(components: &[Component], usual: usize) -> usize {
    let kept = |v: f32| format!("{v:.*e}", usual - 1).parse() == Ok(v);
    let all = |component: &Component| {
        let distribution = component.distribution();
        if let Some(matrix) = distribution.downcast_ref::<KlemsMatrix>() {
            let colour = matrix.chromatic().into_iter().flatten().flatten();
            matrix.values().iter().chain(colour).all(|&v| kept(v))
        } else if let Some(trees) = distribution.downcast_ref::<TreeDistribution>() {
            let colour = trees.chromaticity().into_iter().flatten();
            [trees.luminance()].into_iter().chain(colour).all(|t| leaves(t).all(kept))
        } else {
            true
        }
    };
    if components.iter().all(all) { usual } else { 9 }
}

/// Writes `surface` to `target`.
///
/// Errors: argument where the surface cannot take that form; io; limit.
pub(crate) fn write(
    target: &Target,
    surface: &Surface,
    metadata: &Metadata,
    tabulation: &Tabulation,
) -> Result<Written> {
    let path = &target.path;
    let place = |e: Error| e.context(path.display());
    let mut written =
        Written { bytes: 0, reports: Vec::new(), loses_colour: false, said: Vec::new() };
    match (target.kind, surface) {
        (Kind::Interpolant, Surface::Continuous(interpolant)) => {
            let name = Some(metadata.name.clone()).filter(|n| !n.is_empty());
            let mut interpolant = interpolant.clone();
            interpolant.name = name;
            interpolant.save(path, tabulation.encoding())?;
        }
        (Kind::Interpolant, Surface::Stored(_)) => {
            return Err(place(Error::argument(
                "an interpolant is made of measurements: a tree or a matrix has only cells; for a file that opens faster use `bsdf compile`",
            )));
        }
        (kind, _) if kind.channels().is_some() => {
            let bar = Bar::new(kind.name());
            let report = |progress: Progress| bar.report(progress);
            let watch = Watch { progress: Some(&report), cancel: None };
            let channels = kind.channels().unwrap_or(Channels::Rgb);
            written.said = surface.subject().write_rgl(metadata, channels, path, &watch)?;
        }
        _ => {
            let bar = Bar::new(target.kind.name());
            let report = |progress: Progress| bar.report(progress);
            let watch = Watch { progress: Some(&report), cancel: None };
            let order = tabulation.order(target);
            let delivered =
                order.deliver(surface.subject(), metadata.clone(), &watch).map_err(place)?;
            let Delivered { bsdf, reports, loses_colour, mut said } = delivered;
            if target.consumer.is_none() {
                said.extend(Consumer::hint(&bsdf, target.kind));
            }
            written = Written { reports, loses_colour, said, ..written };
            let usual = WriteOptions::default();
            let digits = match written.copied() {
                0 => usual.digits,
                _ => exact_digits(&all(&bsdf), usual.digits),
            };
            if target.is_container() {
                container::save(&bsdf, path)?;
            } else {
                xml::write(&bsdf, path, &WriteOptions { digits, ..usual })?;
            }
        }
    }
    written.bytes = std::fs::metadata(path).map_err(|e| Error::io(path.display(), &e))?.len();
    Ok(written)
}

/// The components of every band.
fn all(bsdf: &Bsdf) -> Vec<Component> {
    let further = bsdf.bands().iter().flat_map(|b| &b.components);
    bsdf.components().iter().chain(further).cloned().collect()
}
