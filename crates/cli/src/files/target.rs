//! OUT: the files to write, each with the form and the program that it is for.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use bsdfkit::{Error, Result};
use bsdfkit_fit::deliver::{Consumer, Kind};
use bsdfkit_represent::rgl::{self, Channels};
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::error::ErrorKind;
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches, value_parser};

use crate::files::surface::Surface;

/// The suffix of files of a kind.
fn suffix_of(kind: Kind) -> &'static str {
    match kind {
        kind if kind.is_container() => "safetensors",
        Kind::RglRgb | Kind::RglSpectral => "bsdf",
        _ => "xml",
    }
}

/// A parser of one of these names.
fn named<T: FromStr<Err = Error> + Clone + Send + Sync + 'static, const N: usize>(
    names: [&'static str; N],
) -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(names).try_map(|name| name.parse::<T>())
}

/// A parser of programs' names, those built on them among the aliases.
fn consumer_parser() -> impl TypedValueParser<Value = Consumer> {
    let names = Consumer::ALL.map(|c| PossibleValue::new(c.name()).aliases(c.others()));
    PossibleValuesParser::new(names).try_map(|name| name.parse::<Consumer>())
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
    /// Whether the file is a container; else XML, or RGL's.
    pub(crate) fn is_container(&self) -> bool {
        let by_name = self.path.extension().is_some_and(|s| s.eq_ignore_ascii_case("safetensors"));
        self.kind.is_container() || self.kind == Kind::TensorTree && by_name
    }

    fn new(path: PathBuf, Marks { to, consumer }: Marks) -> Result<Self, String> {
        let by_input = to.is_none() && consumer.is_some();
        let to = match consumer {
            Some(consumer) => Some(consumer.kind(to).map_err(|e| format!("--for {e}"))?),
            None => to,
        };
        let suffix = path.extension().and_then(|s| s.to_str()).map(str::to_ascii_lowercase);
        let by_suffix = match suffix.as_deref() {
            Some("xml") => Some(Kind::TensorTree),
            Some("safetensors") => Some(Kind::Interpolant),
            Some("bsdf") => rgl::channels_of(&path).map(|channels| match channels {
                Channels::Rgb => Kind::RglRgb,
                Channels::Spectral => Kind::RglSpectral,
            }),
            _ => None,
        };
        let place = path.display();
        match (to, by_suffix) {
            // Programs read XML alone.
            (Some(kind @ Kind::TensorTree), Some(Kind::Interpolant)) if consumer.is_none() => {
                Ok(Self { path, kind, consumer, by_input })
            }
            (Some(kind), Some(found)) if suffix_of(kind) != suffix_of(found) => Err(format!(
                "{place}: expected a name ending in .{} for --to {}",
                suffix_of(kind),
                kind.name()
            )),
            (None, None) => Err(format!(
                "{place}: expected a name ending in .xml (tensor tree), .safetensors (interpolant), _rgb.bsdf or _spec.bsdf (RGL's tables), or --to before it"
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
            .help("File to write: .xml is a tensor tree, .safetensors an interpolant, _rgb.bsdf and _spec.bsdf RGL's tables of reflection from the front; may be repeated")
            .value_parser(value_parser!(PathBuf))
            .action(ArgAction::Append)
            .required(true);
        let to = Arg::new("to")
            .long("to")
            .value_name("KIND")
            .help("Form of the next -o, instead of what its suffix says")
            .value_parser(named::<Kind, 8>(Kind::ALL.map(Kind::name)))
            .action(ArgAction::Append);
        let consumer = Arg::new("for")
            .long("for")
            .value_name("PROGRAM")
            .help("Program that reads the next -o: decides its form, bands and directions; what it lacks or leaves out is said. frads and pywincalc read what window does, honeybee and mitsuba what radiance does")
            .value_parser(consumer_parser())
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
            Some(consumer) => {
                Target { kind: consumer.kind_of(surface.subject()), ..target.clone() }
            }
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
        // A compiled tree, which keeps a spectrum.
        let line = "--to tensor-tree -o a.safetensors";
        assert_eq!(parse(line).unwrap()[0].1, Kind::TensorTree);
        assert_eq!(parse("-o a_rgb.bsdf").unwrap()[0].1, Kind::RglRgb);
        assert_eq!(parse("-o a_spec.BSDF").unwrap()[0].1, Kind::RglSpectral);
        assert_eq!(parse("--to rgl-rgb -o a.bsdf").unwrap()[0].1, Kind::RglRgb);
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
        refused("-o a.bsdf", "_rgb.bsdf or _spec.bsdf");
        refused("--for radiance -o a_rgb.bsdf", "ending in .xml for --to tensor-tree");
        refused("--to klems-full -o a.safetensors", "ending in .xml for --to klems-full");
        refused("--to interpolant -o a.xml", "ending in .safetensors");
        refused("-o a.xml -o a.xml", "named by two -o");
        refused("-o a.xml -o b.xml --to klems-full", "has no -o after it");
        refused("--to klems-full --to klems-half -o b.xml", "stand before one -o");
        refused("--to sphere -o b.xml", "possible values");
        refused("--for window --to tensor-tree -o b.xml", "--for window reads klems-full");
        refused("--for energyplus --to interpolant -o b.safetensors", "found interpolant");
        refused("--for radiance -o b.safetensors", "ending in .xml");
        refused("--for window --for radiance -o b.xml", "stand before one -o");
        refused("-o a.xml -o b.xml --for window", "--for window has no -o after it");
        refused("--for dialux -o b.xml", "possible values");
    }
}
