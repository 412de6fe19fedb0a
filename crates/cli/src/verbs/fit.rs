//! `bsdf fit`: goniophotometer files in, a BSDF that any renderer loads out.

use std::io::{self, BufWriter, Write};
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use bsdfkit::{Bsdf, Components, DVec3, Error, Metadata, Side};
use bsdfkit_fit::Cache;
use bsdfkit_fit::interpolant::{FitSettings, Interpolant, Part};
use bsdfkit_measure::{Measurement, ReadOptions, Symmetry, SymmetryKind, components};
use bsdfkit_represent::{Progress, Source, Watch};
use bsdfkit_sphere::direction::from_degrees;
use clap::Args;
use serde_json::{Map, json};

use crate::files::component::{self, name};
use crate::files::instrument::Instrument;
use crate::files::labels::Labels;
use crate::files::output::{self, Written, placeholders};
use crate::files::surface::Surface;
use crate::files::tabulation::Tabulation;
use crate::files::target::Targets;
use crate::files::told;
use crate::terminal::progress::Bar;
use crate::terminal::spent;
use crate::terminal::stop::{Outcome, Verdict, remark};
use crate::terminal::table::Table;

const EXAMPLES: &str = "\
Examples:
  bsdf fit measurements/ -o material.xml
  bsdf fit measurements/ -o material.safetensors -o tree.xml --to klems-full -o klems.xml
  bsdf fit 450nm=blue/ 550nm=green/ 650nm=red/ -o paint.safetensors
  bsdf fit measurements/ --cache ~/.cache/bsdfkit -o material.xml
  bsdf fit front/*.txt back/*.txt -o glass.xml --symmetry isotropic --name 'Glass 12'";

/// Fit a BSDF to goniophotometer files
///
/// Reads Mountain files (pab-opto) and tables with columns theta_i, phi_i, theta_o, phi_o, value;
/// sorts them into reflection and transmission, front and back; fits one interpolant to all and
/// writes it in each form asked for. Every OUT is written under another name, then renamed.
///
/// Names are known in most spellings (theta_in, theta_r, brdf), with units (theta_i [rad]); values
/// under DSF or CCBSDF contain the cosine. Columns are parted by blanks, tabs, semicolons or commas;
/// decimal commas, UTF-16 and Latin-1 are read. Whatever was guessed is a note.
///
/// Of other formats RGL's tensors, MERL, Zemax, LightTools, ASTM E1392 and E2387, FRED, RPC Photonics, Cornell, ALTA and BiRD are
/// read, known by their content.
///
/// Prints the error at the incidences (fit error), the one to expect between them (between: incidences left out and
/// predicted from the others, as `bsdf validate` does for all), and totals; ~ marks those that are extrapolated.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// Files and folders of one specimen; 550nm=PATH: measured at this wavelength, one of several
    #[arg(required = true, value_name = "PATH")]
    paths: Vec<PathBuf>,
    #[command(flatten)]
    targets: Targets,
    /// isotropic, quadrilateral, bilateral, bilateral-x, bilateral-y, rotational180 or none
    /// [default: what the incidences show]
    #[arg(long, value_name = "S")]
    symmetry: Option<SymmetryKind>,
    /// Leave out points further than this from the normal; auto: keep all that were measured
    #[arg(long, value_name = "DEG|auto", default_value = "auto")]
    grazing_limit: GrazingLimit,
    #[command(flatten)]
    instrument: Instrument,
    /// The specimen was mounted back to front
    #[arg(long)]
    reversed: bool,
    #[command(flatten)]
    tabulation: Tabulation,
    #[command(flatten)]
    labels: Labels,
    /// Keep finished stages in this folder: a fit that was stopped, however, goes on where it was, to the same bits
    #[arg(long, value_name = "DIR")]
    cache: Option<PathBuf>,
    /// Most gigabytes in that folder; what was longest not used goes first
    #[arg(long, value_name = "GB", default_value_t = 2.0, requires = "cache", value_parser = gigabytes)]
    cache_size: f64,
    /// Most gigabytes of memory: components are read and fitted one after the other, and a set of which one does not fit is
    /// refused before anything is fitted
    #[arg(long, value_name = "GB", default_value_t = 4.0, value_parser = gigabytes)]
    memory: f64,
    /// Threads to work with [default: one a processor]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug)]
enum GrazingLimit {
    Auto,
    Degrees(f64),
}

impl FromStr for GrazingLimit {
    type Err = Error;

    fn from_str(text: &str) -> bsdfkit::Result<Self> {
        let refused = || {
            Error::argument(format!(
                "expected auto or degrees above 0 and at most 90, found {text:?}"
            ))
        };
        match text {
            "auto" => Ok(Self::Auto),
            _ => match text.parse::<f64>() {
                Ok(degrees) if degrees > 0.0 && degrees <= 90.0 => Ok(Self::Degrees(degrees)),
                _ => Err(refused()),
            },
        }
    }
}

/// A size of a cache.
pub(crate) fn gigabytes(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(size) if size > 0.0 && size <= 1e6 => Ok(size),
        _ => Err(format!("expected gigabytes above 0, found {text:?}")),
    }
}

/// A fitted component and what it cost.
struct Fitted {
    symmetry: Symmetry,
    points: usize,
    time: Duration,
}

pub(crate) fn run(arguments: &Arguments) -> Outcome {
    arguments.targets.expect_writable()?;
    if let Some(threads) = arguments.threads {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.into());
        pool.build_global().map_err(|e| Error::argument(format!("threads: {e}")))?;
    }
    let start = Instant::now();
    let cache = arguments.cache.as_deref();
    let cache = cache.map(|folder| Cache::open(folder, (arguments.cache_size * 1e9) as u64));
    let (cache, signature) = (cache.transpose()?.map(Arc::new), arguments.instrument.signature()?);
    let settings = FitSettings { cache, signature, ..FitSettings::default() };
    let mut interpolant = Interpolant::default();
    let mut fitted = Vec::new();
    let reading: Mutex<Option<Bar>> = Mutex::default();
    let bar = || reading.lock().unwrap_or_else(PoisonError::into_inner);
    let heard = |done, total| {
        bar().get_or_insert_with(|| Bar::new("reading")).report(Progress { done, total });
        Ok(())
    };
    for measurement in components(&arguments.paths, &arguments.reading()?, &heard)? {
        *bar() = None;
        let measurement = prepared(measurement?, arguments.grazing_limit)?;
        let began = Instant::now();
        let (symmetry, points) = (measurement.symmetry, measurement.points());
        interpolant.join(fit(measurement, &settings)?);
        fitted.push(Fitted { symmetry, points, time: began.elapsed() });
    }
    let mut comments = vec![format!("bsdfkit {}: bsdf fit", env!("CARGO_PKG_VERSION"))];
    comments.extend(interpolant.components.iter().filter_map(component::coverage));
    comments.extend(interpolant.components.iter().filter_map(component::between));
    comments.extend(interpolant.specular.iter().map(component::peak));
    let spectra: Vec<String> =
        interpolant.components.iter().filter_map(component::spectrum).collect();
    remark("note", &spectra);
    comments.extend(spectra);
    let metadata = Metadata {
        name: interpolant.name.clone().unwrap_or_default(),
        comments,
        ..Metadata::default()
    };
    let metadata = arguments.labels.over(metadata)?;
    let surface = Surface::Continuous(interpolant);
    let mut written = Vec::new();
    for target in &arguments.targets.0 {
        let one = output::write(target, &surface, &metadata, &arguments.tabulation)?;
        one.remark(target);
        written.push(one);
    }
    remark("note", placeholders(&metadata, &arguments.targets.0).as_slice());
    print(arguments, &surface, &fitted, &written, start.elapsed())
}

impl Arguments {
    /// How files are read.
    fn reading(&self) -> bsdfkit::Result<ReadOptions> {
        let usual = ReadOptions::default();
        let options = ReadOptions { symmetry: self.symmetry, reversed: self.reversed, ..usual };
        options.within((self.memory * 1e9) as u64)
    }
}

/// Cut at grazing, its notes told, and found to be enough.
fn prepared(mut m: Measurement, grazing_limit: GrazingLimit) -> bsdfkit::Result<Measurement> {
    let place = name(m.incident, m.scattered);
    if let GrazingLimit::Degrees(degrees) = grazing_limit {
        let dropped = m.cut_grazing(degrees).map_err(|e| e.context(&place))?;
        m.notes.push(format!("{dropped} points beyond {degrees} degrees left out"));
    }
    let notes: Vec<String> = m.notes.iter().map(|n| format!("{place}: {n}")).collect();
    remark("note", &notes);
    m.expect_enough().map_err(|e| e.context(&place))?;
    told::warn_scant(&place, &m);
    Ok(m)
}

fn fit(measurement: Measurement, settings: &FitSettings) -> bsdfkit::Result<Interpolant> {
    let place = name(measurement.incident, measurement.scattered);
    let bar = Bar::new(place.as_str());
    let report = |progress: Progress| bar.report(progress);
    let watch = Watch { progress: Some(&report), cancel: None };
    Interpolant::fit_owned(vec![measurement], settings, &watch).map_err(|e| e.context(place))
}

/// Polar angles of the table.
const TABLE_DEGREES: [f64; 3] = [0.0, 30.0, 60.0];

/// A component's row of figures.
struct Figures {
    component: String,
    symmetry: String,
    incidences: usize,
    points: usize,
    lobes: usize,
    /// Mean over incidences.
    fit_error: f64,
    /// Mean between incidences.
    expected_error: Option<f64>,
    /// Totals, and whether they are extrapolated.
    hemispherical: [(f64, bool); 3],
    /// Share of the hemisphere seen, least over the incidences.
    seen: f64,
    seconds: f64,
}

impl Figures {
    fn of(part: &Part, fitted: &Fitted, bsdf: &Bsdf) -> Self {
        let (mut lobes, mut error, mut incidences) = (0, 0.0, 0);
        let (mut expected_error, mut seen) = (None, 1.0);
        if let Part::Transported(component) = part {
            expected_error = component.expected_error;
            seen = component.extent().seen;
            incidences = component.incidences().len();
            lobes = component.incidences().iter().map(|i| i.lobes.lobes.len()).sum();
            error = component.incidences().iter().map(|i| i.fit_error).sum();
        }
        let (incident, scattered) = (part.incident(), part.scattered());
        let way = match incident == scattered {
            true => Components::REFLECTION,
            false => Components::TRANSMISSION,
        };
        let total = |theta: f64| {
            let wi = from_degrees(theta, 0.0);
            let wi = if incident == Side::Front { wi } else { DVec3::new(wi.x, wi.y, -wi.z) };
            (bsdf.directional_hemispherical(wi, way), told::extrapolated(part, wi))
        };
        Self {
            component: name(incident, scattered),
            symmetry: fitted.symmetry.to_string(),
            incidences,
            points: fitted.points,
            lobes,
            fit_error: error / incidences.max(1) as f64,
            expected_error,
            seen,
            hemispherical: TABLE_DEGREES.map(total),
            seconds: fitted.time.as_secs_f64(),
        }
    }
}

fn print(
    arguments: &Arguments,
    surface: &Surface,
    fitted: &[Fitted],
    written: &[Written],
    elapsed: Duration,
) -> Outcome {
    let Surface::Continuous(interpolant) = surface else { return Ok(Verdict::Good) };
    for part in &interpolant.components {
        if let Part::Transported(component) = part {
            told::warn_expected(&name(component.incident(), component.scattered()), component);
        }
    }
    let parts = interpolant.components.iter().zip(fitted);
    let bsdf = surface.bsdf();
    let figures: Vec<Figures> = parts.map(|(p, f)| Figures::of(p, f, &bsdf)).collect();
    let outputs = arguments.targets.0.iter().zip(written);
    let mut out = BufWriter::new(io::stdout().lock());
    if arguments.json {
        let component = |f: &Figures| {
            json!({
                "component": f.component, "symmetry": f.symmetry, "incidences": f.incidences,
                "points": f.points, "lobes": f.lobes, "fit_error": f.fit_error,
                "expected_error": f.expected_error, "seen": f.seen,
                "hemispherical_0_30_60_degrees": f.hemispherical.map(|h| h.0),
                "extrapolated_0_30_60_degrees": f.hemispherical.map(|h| h.1), "seconds": f.seconds
            })
        };
        let report = json!({
            "components": figures.iter().map(component).collect::<Vec<_>>(),
            "specular": interpolant.specular.iter().map(|s| json!(
                component::specular(s).into_iter().map(|(k, v)| (k.to_owned(), v)).collect::<Map<_, _>>()
            )).collect::<Vec<_>>(),
            "outputs": outputs.map(|(target, w)| w.json(target)).collect::<Vec<_>>(),
            "seconds": elapsed.as_secs_f64(),
            "cpu_seconds": spent::cpu_seconds(), "peak_bytes": spent::peak_bytes(),
        });
        writeln!(out, "{report}")?;
    } else {
        let mut table = Table::new([
            "component",
            "symmetry",
            "incidences",
            "points",
            "lobes",
            "fit error",
            "between",
            "0°",
            "30°",
            "60°",
            "time s",
        ]);
        for f in &figures {
            let [a, b, c] = f.hemispherical.map(|(h, extrapolated)| told::total(h, extrapolated));
            let between = told::expected(f.expected_error);
            let (error, seconds) = (format!("{:.4}", f.fit_error), format!("{:.2}", f.seconds));
            let counts = [f.incidences, f.points, f.lobes].map(|n| n.to_string());
            let [incidences, points, lobes] = counts;
            let (component, symmetry) = (f.component.clone(), f.symmetry.clone());
            table.row([
                component, symmetry, incidences, points, lobes, error, between, a, b, c, seconds,
            ]);
        }
        table.print(&mut out, 0)?;
        for peak in &interpolant.specular {
            writeln!(out, "{}", component::peak(peak))?;
        }
        for (target, w) in outputs {
            writeln!(out, "{}", w.line(target))?;
        }
        writeln!(out, "{:.1} s", elapsed.as_secs_f64())?;
    }
    out.flush()?;
    Ok(Verdict::Good)
}
