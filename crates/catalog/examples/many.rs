//! A catalogue of many synthetic materials: what reading, a site and searches cost.
//!
//! `cargo run --release -p bsdfkit-catalog --example many -- FOLDER [COUNT]` makes FOLDER/library and FOLDER/site.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};
use std::time::Instant;

use bsdfkit::matrix::{KlemsBasis, KlemsMatrix};
use bsdfkit::{Bsdf, Component, Error, Lambertian, Metadata, Result, Side, xml};
use bsdfkit_catalog::{Library, Look, Query, Record, site};
use bsdfkit_represent::Watch;
use bsdfkit_sphere::sequence::plastic;

const CLASSES: [&str; 5] = ["paint", "metal", "fabric", "glazing", "film"];

/// Diffuse and about the mirror direction, in shares that follow an even sequence.
fn material(k: usize) -> Result<Bsdf> {
    let basis = KlemsBasis::quarter();
    let n = basis.directions();
    let share = plastic(k + 1);
    let (diffuse, peak) = (0.8 * share.x, 0.9 * (1.0 - share.x) * share.y);
    let value = |i: usize| {
        let about = if i / n == i % n { peak / basis.projected_solid_angle(i % n) } else { 0.0 };
        (diffuse / PI + about) as f32
    };
    let matrix = KlemsMatrix::new(basis.clone(), basis.clone(), (0..n * n).map(value).collect())?;
    let scattered = if k.is_multiple_of(3) { Side::Back } else { Side::Front };
    let component = Component::new(Side::Front, scattered, matrix);
    Ok(Bsdf::new(Metadata::default(), vec![component], Lambertian::default()))
}

fn write(folder: &Path, count: usize) -> Result<()> {
    let io = |e: std::io::Error| Error::io(folder.display(), &e);
    std::fs::create_dir_all(folder).map_err(io)?;
    for k in 0..count {
        xml::write(&material(k)?, folder.join(format!("m{k:05}.xml")), &Default::default())?;
        let record = Record {
            name: format!("Material {k} {}", ["smooth", "rough", "woven", "cast"][k % 4]),
            maker: format!("Maker {}", k % 37),
            class: CLASSES[k % CLASSES.len()].to_owned(),
            licence: "CC0-1.0".to_owned(),
            ..Record::default()
        };
        let json = serde_json::to_string(&record).unwrap_or_default();
        std::fs::write(folder.join(format!("m{k:05}.json")), json).map_err(io)?;
    }
    Ok(())
}

fn timed<T>(what: &str, work: impl FnOnce() -> Result<T>) -> Result<T> {
    let start = Instant::now();
    let made = work()?;
    println!("{what}: {:.3} s", start.elapsed().as_secs_f64());
    Ok(made)
}

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let folder = PathBuf::from(arguments.next().unwrap_or_else(|| "build/many".to_owned()));
    let count = arguments.next().and_then(|n| n.parse().ok()).unwrap_or(2000);
    let (library, place) = (folder.join("library"), folder.join("site"));
    let watch = Watch::default();
    timed("write the library", || write(&library, count))?;
    let opened = timed("read it the first time", || Library::open(&library, &watch))?;
    println!("{} entries, {} faults", opened.entries().len(), opened.faults().len());
    drop(opened);
    let mut opened = timed("read it again", || Library::open(&library, &watch))?;
    let options = site::Options { title: "Many".to_owned(), skip_faulty: false };
    timed("site, pictures drawn", || site::build(&mut opened, &place, &options, &watch))?;
    timed("site, pictures kept", || site::build(&mut opened, &place, &options, &watch))?;
    let words = vec!["woven".to_owned(), "maker:maker".to_owned()];
    let found = timed("search by words", || {
        Query { words: words.clone(), like: None }.of(&opened).map(|found| found.len())
    })?;
    println!("{found} found");
    let like = Some(Look::of(&material(7)?)?);
    timed("search by look", || Query { words: Vec::new(), like }.of(&opened).map(|f| f.len()))?;
    Ok(())
}
