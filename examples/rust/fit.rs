//! From measurements to a file that renderers load, in Rust: read, fit, ask, tabulate, write.
//!
//! `cargo run --release -p bsdfkit-examples --bin fit -- MEASUREMENTS OUT.xml`

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use bsdfkit::component::name_of_sides;
use bsdfkit::xml::{self, WriteOptions};
use bsdfkit::{Components, DVec3, Error, Metadata, Result};
use bsdfkit_fit::deliver::{Kind, Order, Subject};
use bsdfkit_fit::interpolant::{FitSettings, Interpolant};
use bsdfkit_measure::ReadOptions;
use bsdfkit_represent::Watch;

fn run(measurements: &Path, out: &Path) -> Result<()> {
    // Which file belongs to which sides, and which symmetry the specimen has, is in the data.
    let measured = bsdfkit_measure::read(&[measurements.to_owned()], &ReadOptions::default())?;
    for m in &measured {
        let (sides, incidences) = (name_of_sides(m.incident, m.scattered), m.incidences.len());
        println!("{sides}: {incidences} incidences, {} points, {}", m.points(), m.symmetry);
    }

    // A continuous function of both directions, and what it errs by where nothing was measured.
    let watch = Watch::default();
    let interpolant = Interpolant::fit(&measured, &FitSettings::default(), &watch)?;

    // Any BSDF answers the same five verbs. Directions point away from the surface.
    let bsdf = interpolant.bsdf();
    let wi = DVec3::new(-2.0, 3.0, 6.0) / 7.0;
    let total = bsdf.directional_hemispherical(wi, Components::ALL);
    println!("scattered of light from {wi:.3}: {:.1} %", 100.0 * total);
    let sample = bsdf
        .sample(wi, 0.5, Components::ALL)
        .ok_or_else(|| Error::argument("expected light to be scattered, found none"))?;
    println!(
        "drawn {:.3}: f {:.4} 1/sr, pdf {:.4} 1/sr, weight {:.3}",
        sample.wo,
        bsdf.eval(wi, sample.wo),
        sample.pdf,
        sample.weight
    );

    // Means over the cells of a table, in the XML of WINDOW and Radiance.
    let metadata = Metadata { name: "example".into(), ..Metadata::default() };
    let subject = Subject::Continuous(&interpolant);
    let table = Order::new(Kind::KlemsQuarter).deliver(subject, metadata, &watch)?.bsdf;
    xml::write(&table, out, &WriteOptions::default())?;

    // What the file says is what was fitted, as far as its patches of some 20 degrees go.
    let tabulated = xml::read(out)?.directional_hemispherical(wi, Components::ALL);
    println!("{}: {:.1} %", out.display(), 100.0 * tabulated);
    if (tabulated / total - 1.0).abs() > 0.1 {
        return Err(Error::argument(format!("expected {total} in the file, found {tabulated}")));
    }
    Ok(())
}

fn main() -> ExitCode {
    let arguments: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    let Ok([measurements, out]) = <[PathBuf; 2]>::try_from(arguments) else {
        eprintln!("usage: fit MEASUREMENTS OUT.xml");
        return ExitCode::FAILURE;
    };
    match run(&measurements, &out) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("fit: {error}");
            ExitCode::FAILURE
        }
    }
}
