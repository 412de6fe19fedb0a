//! `bsdf export`: a BSDF as the objects of another program's model, or for a database.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use bsdfkit::{Error, Result, replace_file};
use bsdfkit_catalog::Record;
use bsdfkit_catalog::exchange::{bed, bird};
use bsdfkit_fit::deliver::{Consumer, Kind, Order};
use bsdfkit_measure::ReadOptions;
use bsdfkit_represent::Watch;
use bsdfkit_represent::energyplus::{Form, Layer, Settings, Window};
use clap::{Args, Subcommand};
use serde_json::json;

use crate::files::load::load;
use crate::files::surface::Surface;
use crate::files::target::expect_writable;
use crate::terminal::stop::{Outcome, Verdict, remark};

const EXAMPLES: &str = "\
Examples:
  bsdf export energyplus film.xml -o window.idf
  bsdf export energyplus glass.xml shade.xml -o window.epJSON --gap 0.05";

/// Write a BSDF as the objects of another program's model, or for a database
#[derive(Args, Debug)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    program: Program,
}

#[derive(Subcommand, Debug)]
enum Program {
    Energyplus(EnergyPlus),
    Bird(Bird),
    Bed(Bed),
}

/// A measurement in the universal BRDF data format of the BiRD project (JSON)
///
/// Reflection of the front, all that the format holds, with what a record says; what neither knows is written as NA. `bsdf fit`
/// reads such files.
#[derive(Args, Debug)]
struct Bird {
    /// Files and folders of one measurement
    #[arg(required = true, value_name = "PATH")]
    paths: Vec<PathBuf>,
    /// File to write: *.brdf or *.json
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// What people say of the specimen: a record as catalogues have it, TOML or JSON
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
}

/// Totals of a BSDF as optical data of BED-JSON (buildingenvelopedata.org)
///
/// Directional-hemispherical reflectance and transmittance of the front, visible and solar. The format has no bidirectional
/// values in 1/sr.
#[derive(Args, Debug)]
struct Bed {
    /// BSDF or interpolant
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// File to write: *.json
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
}

/// A Construction:ComplexFenestrationState of EnergyPlus, with every object that it names
///
/// One layer, or a whole system given as one BSDF; two layers are put together, all reflections between them included. The
/// back of a file (z < 0; WINDOW's front) is outside.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
struct EnergyPlus {
    /// BSDFs or interpolants of one or two layers, the outermost first
    #[arg(required = true, value_name = "LAYER")]
    files: Vec<PathBuf>,
    /// File to write: *.idf or *.epJSON
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Name of the construction [default: that of OUT]
    #[arg(long)]
    name: Option<String>,
    /// Klems basis [default: that of a matrix, else klems-full]
    #[arg(long, value_name = "KIND")]
    to: Option<Kind>,
    /// Width of the air between two layers, metres
    #[arg(long, value_name = "METRES", default_value_t = 0.0127)]
    gap: f64,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(arguments: &Arguments) -> Outcome {
    match &arguments.program {
        Program::Energyplus(energyplus) => energyplus.run(),
        Program::Bird(bird) => bird.run(),
        Program::Bed(bed) => bed.run(),
    }
}

/// A record beside a file, as catalogues have it.
fn read_record(path: &Path) -> Result<Record> {
    let text = std::fs::read_to_string(path).map_err(|e| Error::io(path.display(), &e))?;
    let is_json = path.extension().is_some_and(|suffix| suffix.eq_ignore_ascii_case("json"));
    let record = if is_json { Record::from_json(&text) } else { Record::from_toml(&text) };
    record.map_err(|e| e.context(path.display()))
}

impl Bird {
    fn run(&self) -> Outcome {
        expect_writable(&self.output)?;
        let options = ReadOptions { incomplete: true, ..ReadOptions::default() };
        let measured = bsdfkit_measure::read(&self.paths, &options)?;
        let record = self.record.as_deref().map(read_record).transpose()?.unwrap_or_default();
        let mut bytes = Vec::new();
        let said = bird::write(&measured, &record, &mut bytes)?;
        written(&self.output, &bytes)?;
        remark("note", &said);
        Ok(Verdict::Good)
    }
}

impl Bed {
    fn run(&self) -> Outcome {
        expect_writable(&self.output)?;
        let input = load(&self.file)?;
        input.warn(&self.file);
        let mut bytes = Vec::new();
        let bsdf = match &input.surface {
            Surface::Stored(bsdf) => bed::write(bsdf, &mut bytes),
            Surface::Continuous(interpolant) => bed::write(&interpolant.bsdf(), &mut bytes),
        };
        bsdf?;
        written(&self.output, &bytes)?;
        Ok(Verdict::Good)
    }
}

fn written(path: &Path, bytes: &[u8]) -> Result<()> {
    replace_file(path, |to| to.write_all(bytes).map_err(|e| Error::io(path.display(), &e)))
}

impl EnergyPlus {
    fn form(&self) -> Result<Form> {
        let suffix = self.output.extension().and_then(|s| s.to_str()).map(str::to_ascii_lowercase);
        match suffix.as_deref() {
            Some("idf") => Ok(Form::Idf),
            Some("epjson") => Ok(Form::EpJson),
            _ => Err(Error::argument("expected a name ending in .idf or .epJSON")
                .context(self.output.display())),
        }
    }

    fn run(&self) -> Outcome {
        let form = self.form()?;
        expect_writable(&self.output)?;
        let (mut layers, mut notes, mut kind) = (Vec::new(), Vec::new(), self.to);
        for file in &self.files {
            let input = load(file)?;
            input.warn(file);
            let subject = input.surface.subject();
            let own = match kind {
                Some(kind) => Consumer::EnergyPlus.kind(Some(kind))?,
                None => Consumer::EnergyPlus.kind_of(subject),
            };
            // What is further inside has the basis of the first.
            kind = Some(own);
            let order = Order { consumer: Some(Consumer::EnergyPlus), ..Order::new(own) };
            let place = |e: Error| e.context(file.display());
            let metadata = input.metadata();
            let made =
                order.deliver(subject, metadata.clone(), &Watch::default()).map_err(place)?;
            let layer = Layer::new(&made.bsdf, &metadata).map_err(place)?;
            // Of the whole window it is said below.
            let said =
                made.said.into_iter().filter(|note| !note.starts_with("EnergyPlus transposes"));
            notes.extend(said.map(|note| format!("{}: {note}", file.display())));
            if !layer.assumed().is_empty() {
                let fields = layer.assumed().join(", ");
                notes.push(format!("{}: not known, assumed: {fields}", file.display()));
            }
            layers.push(layer);
        }
        let stem = self.output.file_stem().and_then(|s| s.to_str()).unwrap_or("window");
        let name = self.name.clone().unwrap_or_else(|| stem.to_owned());
        let window = Window::new(&layers, &Settings { name: name.clone(), gap: self.gap })?;
        let percent = 100.0 * window.transposed;
        notes.push(format!(
            "the sun's beam passes T, light of sky and ground its transpose: {percent:.2} % of that differs (‖T − Tᵀ‖ / 2 ‖T‖)"
        ));
        window.write(&self.output, form)?;
        remark("note", &notes);
        let directions = window.transmittance.len();
        let normal = window.transmittance[0];
        let mut out = io::stdout().lock();
        if self.json {
            let line = json!({
                "file": self.output.display().to_string(), "construction": name, "objects": window.objects().len(),
                "directions": directions, "solar_transmittance_normal": normal,
                "transposed": window.transposed, "notes": notes
            });
            writeln!(out, "{line}")?;
        } else {
            let objects = window.objects().len();
            writeln!(
                out,
                "{}: construction {name:?}, {} layers, {objects} objects, {directions} directions, solar transmittance {normal:.4} at normal incidence",
                self.output.display(),
                layers.len()
            )?;
        }
        Ok(Verdict::Good)
    }
}
