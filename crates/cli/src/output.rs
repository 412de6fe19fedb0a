//! OUT: what is written, in which form, and how a surface becomes it.

use std::path::{Path, PathBuf};

use bsdfkit::matrix::{KlemsBasis, KlemsMatrix};
use bsdfkit::tree::{Rank, TreeDistribution};
use bsdfkit::xml::{self, WriteOptions};
use bsdfkit::{Bsdf, Component, Error, Lambertian, Metadata, Result};
use bsdfkit_fit::interpolant::Encoding;
use bsdfkit_fit::tabulate::{
    self, Form, KlemsSettings, Progress, Reciprocity, Report, Source, Tabulated, TreeSettings,
    Watch,
};
use clap::builder::PossibleValue;
use clap::error::ErrorKind;
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches, ValueEnum, value_parser};
use serde_json::{Value, json};

use crate::component::leaves;
use crate::consumer::Consumer;
use crate::contents::contents;
use crate::progress::Bar;
use crate::stop::remark;
use crate::surface::Surface;

/// The form of an output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Tensor tree in XML.
    TensorTree,
    /// Klems matrix of 145 directions in XML.
    KlemsFull,
    /// Of 77.
    KlemsHalf,
    /// Of 41.
    KlemsQuarter,
    /// The interpolant itself.
    Interpolant,
}

impl Kind {
    /// As `--to` names it.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::TensorTree => "tensor-tree",
            Self::KlemsFull => "klems-full",
            Self::KlemsHalf => "klems-half",
            Self::KlemsQuarter => "klems-quarter",
            Self::Interpolant => "interpolant",
        }
    }

    pub(crate) fn basis(self) -> Option<KlemsBasis> {
        match self {
            Self::KlemsFull => Some(KlemsBasis::full()),
            Self::KlemsHalf => Some(KlemsBasis::half()),
            Self::KlemsQuarter => Some(KlemsBasis::quarter()),
            Self::TensorTree | Self::Interpolant => None,
        }
    }

    /// The suffix of files of this kind.
    fn suffix(self) -> &'static str {
        if self == Self::Interpolant { "safetensors" } else { "xml" }
    }
}

impl ValueEnum for Kind {
    fn value_variants<'a>() -> &'a [Self] {
        &[Self::TensorTree, Self::KlemsFull, Self::KlemsHalf, Self::KlemsQuarter, Self::Interpolant]
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.name()))
    }
}

/// A file to write.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Target {
    pub(crate) path: PathBuf,
    pub(crate) kind: Kind,
    /// Whose rules it keeps.
    pub(crate) consumer: Option<Consumer>,
    /// Whether a matrix stays one, as no `--to` says what it is to become.
    by_input: bool,
}

impl Target {
    fn new(path: PathBuf, Marks { to, consumer }: Marks) -> Result<Self, String> {
        let by_input = to.is_none() && consumer.is_some();
        let to = match consumer {
            Some(consumer) => Some(consumer.kind(to)?),
            None => to,
        };
        let suffix = path.extension().and_then(|s| s.to_str()).map(str::to_ascii_lowercase);
        let by_suffix = match suffix.as_deref() {
            Some("xml") => Some(Kind::TensorTree),
            Some("safetensors") => Some(Kind::Interpolant),
            _ => None,
        };
        let place = path.display();
        match (to, by_suffix) {
            (Some(kind), Some(found)) if kind.suffix() != found.suffix() => Err(format!(
                "{place}: expected a name ending in .{} for --to {}",
                kind.suffix(),
                kind.name()
            )),
            (None, None) => Err(format!(
                "{place}: expected a name ending in .xml (tensor tree) or .safetensors (interpolant), or --to before it"
            )),
            (Some(kind), _) | (None, Some(kind)) => Ok(Self { path, kind, consumer, by_input }),
        }
    }
}

/// What stands before an `-o` and is meant for it alone.
#[derive(Clone, Copy, Debug, Default)]
struct Marks {
    to: Option<Kind>,
    consumer: Option<Consumer>,
}

/// One option of [`Marks`].
#[derive(Clone, Copy, Debug)]
enum Mark {
    To(Kind),
    For(Consumer),
}

impl std::fmt::Display for Mark {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::To(kind) => write!(f, "--to {}", kind.name()),
            Self::For(consumer) => write!(f, "--for {}", consumer.name()),
        }
    }
}

/// Every `-o`, each with the `--to` and the `--for` that stand before it.
#[derive(Clone, Debug)]
pub(crate) struct Targets(pub(crate) Vec<Target>);

impl Args for Targets {
    fn augment_args(command: Command) -> Command {
        let output = Arg::new("output")
            .short('o')
            .long("output")
            .value_name("OUT")
            .help("File to write: .xml is a tensor tree, .safetensors an interpolant; may be repeated")
            .value_parser(value_parser!(PathBuf))
            .action(ArgAction::Append)
            .required(true);
        let to = Arg::new("to")
            .long("to")
            .value_name("KIND")
            .help("Form of the next -o, instead of what its suffix says")
            .value_parser(value_parser!(Kind))
            .action(ArgAction::Append);
        let consumer = Arg::new("for")
            .long("for")
            .value_name("PROGRAM")
            .help("Program that reads the next -o: decides its form, bands and directions; what it lacks or leaves out is said")
            .value_parser(value_parser!(Consumer))
            .action(ArgAction::Append);
        command.arg(output).arg(to).arg(consumer)
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for Targets {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let indices = |id| matches.indices_of(id).into_iter().flatten();
        let outputs = matches.get_many::<PathBuf>("output").into_iter().flatten();
        let mut outputs: Vec<(usize, &PathBuf)> = indices("output").zip(outputs).collect();
        let kinds = matches.get_many::<Kind>("to").into_iter().flatten().map(|k| Mark::To(*k));
        let consumers = matches.get_many::<Consumer>("for").into_iter().flatten();
        let consumers = consumers.map(|c| Mark::For(*c));
        let kinds: Vec<(usize, Mark)> = indices("to").zip(kinds).collect();
        let consumers: Vec<(usize, Mark)> = indices("for").zip(consumers).collect();
        outputs.sort_unstable_by_key(|o| o.0);
        let mut marks = Vec::new();
        for mut one in [kinds, consumers] {
            if let ([(_, _)], [(at, _)]) = (&outputs[..], &mut one[..]) {
                *at = 0; // one of each: the order cannot be mistaken
            }
            marks.extend(one);
        }
        marks.sort_by_key(|m| m.0);
        pair(&outputs, &marks)
            .map(Self)
            .map_err(|text| clap::Error::raw(ErrorKind::ValueValidation, text + "\n"))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

/// Each output with what stands between it and the output before.
fn pair(outputs: &[(usize, &PathBuf)], marks: &[(usize, Mark)]) -> Result<Vec<Target>, String> {
    let mut left = marks.iter().copied().peekable();
    let mut targets: Vec<Target> = Vec::new();
    for &(at, path) in outputs {
        let mut here = Marks::default();
        while let Some((_, mark)) = left.next_if(|&(k, _)| k < at) {
            let other = match mark {
                Mark::To(kind) => here.to.replace(kind).map(Mark::To),
                Mark::For(consumer) => here.consumer.replace(consumer).map(Mark::For),
            };
            if let Some(other) = other {
                return Err(format!("{other} and {mark} stand before one -o"));
            }
        }
        if targets.iter().any(|t| t.path == *path) {
            return Err(format!("{}: named by two -o", path.display()));
        }
        targets.push(Target::new(path.clone(), here)?);
    }
    match left.next() {
        Some((_, mark)) => Err(format!("{mark} has no -o after it")),
        None => Ok(targets),
    }
}

impl Targets {
    /// The same where the input decides what is best for a program.
    pub(crate) fn settled(&self, surface: &Surface) -> Vec<Target> {
        let settle = |target: &Target| match target.consumer.filter(|_| target.by_input) {
            Some(consumer) => Target { kind: consumer.kind_of(surface), ..target.clone() },
            None => target.clone(),
        };
        self.0.iter().map(settle).collect()
    }

    /// Finds out before the work whether the files can be written after it.
    ///
    /// Errors: io.
    pub(crate) fn expect_writable(&self) -> Result<()> {
        self.0.iter().try_for_each(|t| expect_writable(&t.path))
    }
}

/// Whether a file can be made at `path`.
///
/// Errors: io.
pub(crate) fn expect_writable(path: &Path) -> Result<()> {
    let io = |e: &std::io::Error| Error::io(path.display(), e);
    if path.is_dir() {
        return Err(io(&std::io::ErrorKind::IsADirectory.into()));
    }
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    tempfile::tempfile_in(folder).map(drop).map_err(|e| io(&e))
}

/// Most leaves of a tree.
const MAX_LEAVES: u64 = TreeSettings::MOST_LEAVES as u64;

/// How trees are tabulated and interpolants stored.
#[derive(Args, Clone, Debug)]
pub(crate) struct Tabulation {
    /// Share of the scattered light that the tree may put in a wrong place (L1), beyond what its
    /// source does: the smallest such tree; what is not reached is said [default: 0.01]
    #[arg(long, value_name = "E")]
    max_error: Option<f64>,
    /// Most values in a tree, 7 bytes each: the best such tree [default: 3000000 for anisotropic
    /// and 60000 for isotropic materials, 1000000 for an isotropic component beside an anisotropic
    /// one; with --max-error 16777216]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=MAX_LEAVES))]
    max_leaves: Option<u64>,
    /// Deepest level of the tree: its leaves are at least 2^-N wide
    #[arg(long, value_name = "N")]
    max_depth: Option<u32>,
    /// Average f(wi, wo) and f(wo, wi) of reflection: auto in trees made of measurements and interpolants,
    /// where both agree
    #[arg(long, value_name = "WHEN", default_value = "auto")]
    reciprocity: When,
    /// Interpolants in a tenth to a half of the space, within 2 % of their values
    #[arg(long)]
    compact: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum When {
    Auto,
    On,
    Off,
}

impl Tabulation {
    fn encoding(&self) -> Encoding {
        if self.compact { Encoding::Compact } else { Encoding::Plain }
    }

    fn form(&self, kind: Kind, rank: Rank, reflects: bool) -> Form {
        match kind.basis() {
            None => Form::Tree(self.settings(rank, reflects)),
            Some(basis) => {
                let reciprocal = self.reciprocity == When::On && reflects;
                Form::Klems(basis, KlemsSettings { reciprocal, ..KlemsSettings::default() })
            }
        }
    }

    fn settings(&self, rank: Rank, reflects: bool) -> TreeSettings {
        let usual = TreeSettings::default();
        TreeSettings {
            rank: Some(rank),
            max_error: self.max_error.unwrap_or(usual.max_error),
            max_leaves: self
                .max_leaves
                .or(self.max_error.map(|_| MAX_LEAVES))
                .map(|n| n as usize)
                .or(usual.max_leaves),
            max_depth: self.max_depth.or(usual.max_depth),
            reciprocity: match self.reciprocity {
                When::On if reflects => Reciprocity::On,
                When::Auto => Reciprocity::Auto,
                // Only reflection has both directions in one component.
                When::On | When::Off => Reciprocity::Off,
            },
            ..usual
        }
    }
}

/// What the specimen is called, for outputs in XML.
#[derive(Args, Clone, Debug)]
pub(crate) struct Labels {
    /// Name of the material [default: as the input names it]
    #[arg(long)]
    name: Option<String>,
    /// Who makes it
    #[arg(long)]
    manufacturer: Option<String>,
    /// Thickness in metres
    #[arg(long, value_name = "METRES")]
    thickness: Option<f64>,
    /// Any other field of the material, as ThermalConductivity=0.2 or TIR=0; may be repeated
    #[arg(long, value_name = "FIELD=VALUE")]
    property: Vec<String>,
}

impl Labels {
    /// `metadata` with what was given.
    ///
    /// Errors: argument, for a thickness that is none.
    pub(crate) fn over(&self, mut metadata: Metadata) -> Result<Metadata> {
        if let Some(name) = &self.name {
            metadata.name.clone_from(name);
        }
        if let Some(manufacturer) = &self.manufacturer {
            metadata.manufacturer.clone_from(manufacturer);
        }
        if let Some(thickness) = self.thickness {
            if !(thickness.is_finite() && thickness >= 0.0) {
                return Err(Error::argument(format!(
                    "thickness: expected metres of at least 0, found {thickness}"
                )));
            }
            metadata.thickness = thickness;
        }
        for property in &self.property {
            let Some((key, value)) = property.split_once('=') else {
                return Err(Error::argument(format!(
                    "property: expected FIELD=VALUE, found {property:?}"
                )));
            };
            // These have elements of their own.
            if ["Name", "Manufacturer", "Thickness", "Width", "Height"].contains(&key) {
                return Err(Error::argument(format!(
                    "property: expected a field without an option of its own, found {key} (--name, --manufacturer, --thickness)"
                )));
            }
            metadata.properties.retain(|(k, _)| k != key);
            metadata.properties.push((key.to_owned(), value.to_owned()));
        }
        Ok(metadata)
    }
}

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
            Report::Copied | Report::Matrix(_) => None,
        };
        let matrix = |report: &Report| match report {
            Report::Matrix(m) => Some(json!({
                "averaging_l1": m.error, "reciprocal": m.reciprocity, "missed": missed(report)
            })),
            Report::Copied | Report::Tree(_) => None,
        };
        json!({
            "file": target.path.display().to_string(),
            "kind": target.kind.name(),
            "bytes": self.bytes,
            "components_copied": self.copied(),
            "notes": self.said,
            "trees": self.reports.iter().filter_map(tree).collect::<Vec<_>>(),
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
    let written = targets.iter().any(|t| t.kind != Kind::Interpolant) && !fields.is_empty();
    written.then(|| {
        format!(
            "not known, written as placeholders: {} (--name, --manufacturer, --thickness and --property FIELD=VALUE set them)",
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
        _ => {
            let bsdf =
                contents(target, surface, metadata, tabulation, &mut written).map_err(place)?;
            let usual = WriteOptions::default();
            let digits = match written.copied() {
                0 => usual.digits,
                _ => exact_digits(&all(&bsdf), usual.digits),
            };
            xml::write(&bsdf, path, &WriteOptions { digits, ..usual })?;
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

/// The visible band of `surface` in the form `kind`.
pub(crate) fn assembled(
    kind: Kind,
    surface: &Surface,
    metadata: &Metadata,
    tabulation: &Tabulation,
    written: &mut Written,
) -> Result<Bsdf> {
    let bar = Bar::new(kind.name());
    let report = |progress: Progress| bar.report(progress);
    let watch = Watch { progress: Some(&report), cancel: None };
    let mut components = Vec::new();
    let mut keep = |made: Tabulated| {
        written.reports.push(made.report);
        components.push(made.component);
    };
    let explicit = match surface {
        Surface::Stored(bsdf) => {
            let rank = common_rank(bsdf.components().iter().map(tabulate::is_isotropic));
            for component in bsdf.components() {
                let form = tabulation.form(kind, rank, !component.is_transmission());
                keep(tabulate::stored(component, &form, &watch)?);
            }
            *bsdf.explicit_lambertian()
        }
        Surface::Continuous(interpolant) => {
            let rank = common_rank(interpolant.components.iter().map(Source::isotropic));
            for part in &interpolant.components {
                let form = tabulation.form(kind, rank, part.incident() == part.scattered());
                keep(tabulate::component(part, &form, &watch)?);
            }
            Lambertian::default()
        }
    };
    if let Surface::Stored(bsdf) = surface {
        let coloured = |c: &Component| c.distribution().is_coloured();
        let mut pairs = bsdf.components().iter().zip(&components);
        written.loses_colour = pairs.any(|(old, new)| coloured(old) && !coloured(new));
    }
    Ok(Bsdf::new(metadata.clone(), components, explicit))
}

/// One file holds trees of one rank.
fn common_rank(mut isotropic: impl Iterator<Item = bool>) -> Rank {
    if isotropic.all(|isotropic| isotropic) { Rank::Three } else { Rank::Four }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(clap::Parser)]
    struct Line {
        #[command(flatten)]
        targets: Targets,
    }

    fn parse(line: &str) -> Result<Vec<(String, Kind)>, String> {
        let words = std::iter::once("x").chain(line.split(' '));
        let line = <Line as clap::Parser>::try_parse_from(words).map_err(|e| e.to_string())?;
        let name = |t: Target| (t.path.display().to_string(), t.kind);
        Ok(line.targets.0.into_iter().map(name).collect())
    }

    #[test]
    fn a_program_decides_the_form() {
        let line = "--for window -o w.xml --for radiance -o r.xml -o t.xml --for energyplus --to klems-quarter -o e.xml";
        let kinds: Vec<Kind> = parse(line).unwrap().into_iter().map(|t| t.1).collect();
        assert_eq!(
            kinds,
            [Kind::KlemsFull, Kind::TensorTree, Kind::TensorTree, Kind::KlemsQuarter]
        );
        assert_eq!(parse("-o a.xml --for window").unwrap()[0].1, Kind::KlemsFull);
        assert_eq!(parse("-o a.xml --to klems-half --for radiance").unwrap()[0].1, Kind::KlemsHalf);
    }

    #[test]
    fn a_kind_is_of_the_next_output() {
        let line = "-o a.safetensors -o b.xml --to klems-full -o c.xml -o d.XML";
        let kinds: Vec<Kind> = parse(line).unwrap().into_iter().map(|t| t.1).collect();
        assert_eq!(kinds, [Kind::Interpolant, Kind::TensorTree, Kind::KlemsFull, Kind::TensorTree]);
        assert_eq!(parse("-o a.xml --to klems-half").unwrap()[0].1, Kind::KlemsHalf);
        assert_eq!(parse("--to klems-quarter -o any").unwrap()[0].1, Kind::KlemsQuarter);
    }

    #[test]
    fn contradictions_are_refused() {
        let refused = |line, words: &str| {
            let message = parse(line).unwrap_err();
            assert!(message.contains(words), "{line}: {message}");
        };
        refused("-o a.txt", "expected a name ending in .xml");
        refused("--to klems-full -o a.safetensors", "ending in .xml for --to klems-full");
        refused("--to interpolant -o a.xml", "ending in .safetensors");
        refused("-o a.xml -o a.xml", "named by two -o");
        refused("-o a.xml -o b.xml --to klems-full", "has no -o after it");
        refused("--to klems-full --to klems-half -o b.xml", "stand before one -o");
        refused("--to sphere -o b.xml", "possible values");
        refused("--for window --to tensor-tree -o b.xml", "--for window reads klems-full");
        refused("--for energyplus --to interpolant -o b.safetensors", "found --to interpolant");
        refused("--for radiance -o b.safetensors", "ending in .xml");
        refused("--for window --for radiance -o b.xml", "stand before one -o");
        refused("-o a.xml -o b.xml --for window", "--for window has no -o after it");
        refused("--for dialux -o b.xml", "possible values");
    }
}
