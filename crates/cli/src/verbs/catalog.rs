//! `bsdf catalog`: sites of BSDFs, searches in folders of them, verified downloads.

use std::io::{self, Write};
use std::path::PathBuf;

use bsdfkit_catalog::get::{Cache, Choice, MOST_BYTES, get};
use bsdfkit_catalog::{Library, Look, Query, site};
use bsdfkit_fit::open;
use bsdfkit_represent::{Progress, Watch};
use clap::{Args, Subcommand};
use serde_json::json;

use crate::terminal::progress::Bar;
use crate::terminal::stop::{Outcome, Verdict, remark};
use crate::terminal::table::Table;

const EXAMPLES: &str = "\
Examples:
  bsdf catalog build materials/ -o site --title 'Our materials'
  bsdf catalog search --in materials/ aluminium maker:acme
  bsdf catalog search --in materials/ --like sample.xml
  bsdf catalog get https://example.org/site/materials/fabric.html -o .";

/// Publish BSDFs as a static site, search folders of them, fetch and verify them
///
/// A material is all files of one name (fabric.xml, fabric.safetensors, fabric.klems-full.xml) with a record beside them, fabric.toml
/// or fabric.json: name, maker, class, instrument, date, licence (SPDX), doi, notes. What it does not say is taken from the files.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    deed: Deed,
}

#[derive(Subcommand, Debug)]
enum Deed {
    Build(Build),
    Search(Search),
    Get(Get),
}

/// Make a static site of a folder: cards, pictures, downloads, checksums, index.json
#[derive(Args, Debug)]
struct Build {
    /// Folder of BSDFs and records
    folder: PathBuf,
    /// Folder of the site: new, empty, or an older site, which is replaced
    #[arg(short, long, value_name = "SITE")]
    output: PathBuf,
    /// Title of the site
    #[arg(long, default_value = "Catalogue of materials")]
    title: String,
    /// Leave out what cannot be read
    #[arg(long)]
    skip_faulty: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Search a folder by words and by look
///
/// Words must all occur, or begin words that do, in any field; `maker:acme` in that one. With --like the nearest come first, by the
/// share of light that goes elsewhere (0 to 2, a mean over incident directions). What was read is kept in the folder's index.
#[derive(Args, Debug)]
struct Search {
    /// Words, or FIELD:WORD
    words: Vec<String>,
    /// Folder of BSDFs and records
    #[arg(long = "in", value_name = "DIR", default_value = ".")]
    folder: PathBuf,
    /// A file that what is found should look like
    #[arg(long, value_name = "FILE")]
    like: Option<PathBuf>,
    /// Print so many at most
    #[arg(long, value_name = "N", default_value_t = 20)]
    most: usize,
    /// Print JSON, one object a line
    #[arg(long)]
    json: bool,
}

/// Fetch files of a site, verify their hashes, keep them in a cache
///
/// Prints where they lie.
#[derive(Args, Debug)]
struct Get {
    /// Page of a material, SITE#ID, or FILE#sha256=HASH; of a web host or of this machine
    address: String,
    /// Copy what was fetched here
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// The file of this name instead of the first
    #[arg(long, value_name = "NAME", conflicts_with = "all")]
    file: Option<String>,
    /// All files of the material
    #[arg(long)]
    all: bool,
    /// The cache, instead of what BSDFKIT_CACHE names or the system's
    #[arg(long, value_name = "DIR")]
    cache: Option<PathBuf>,
    /// Refuse larger files
    #[arg(long, value_name = "BYTES", default_value_t = MOST_BYTES)]
    most_bytes: u64,
    /// Print JSON, one object a file
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(arguments: &Arguments) -> Outcome {
    match &arguments.deed {
        Deed::Build(arguments) => build(arguments),
        Deed::Search(arguments) => search(arguments),
        Deed::Get(arguments) => fetch(arguments),
    }
}

fn build(arguments: &Build) -> Outcome {
    let mut library = opened(&arguments.folder)?;
    let options = site::Options {
        title: arguments.title.clone(),
        skip_faulty: arguments.skip_faulty,
        viewer: bsdfkit_viewer::page().ok(),
    };
    let bar = Bar::new("pictures");
    let report = |progress: Progress| bar.report(progress);
    let watch = Watch { progress: Some(&report), cancel: None };
    let built = site::build(&mut library, &arguments.output, &options, &watch)?;
    drop(bar);
    let place = arguments.output.display();
    let mut out = io::stdout().lock();
    if arguments.json {
        let site = place.to_string();
        let report = json!({"site": site, "materials": built.entries, "files": built.files, "bytes": built.bytes, "left_out": library.faults().len()});
        writeln!(out, "{report}")?;
    } else {
        let megabytes = built.bytes as f64 / 1e6;
        let (entries, files) = (built.entries, built.files);
        writeln!(out, "{place}: {entries} materials, {files} files, {megabytes:.1} MB")?;
    }
    Ok(Verdict::Good)
}

fn search(arguments: &Search) -> Outcome {
    let library = opened(&arguments.folder)?;
    let look = |path: &PathBuf| Look::of(&open::bsdf(path)?).map_err(|e| e.context(path.display()));
    let like = arguments.like.as_ref().map(look).transpose()?;
    let query = Query { words: arguments.words.clone(), like };
    let found = query.of(&library)?;
    let mut out = io::stdout().lock();
    if arguments.json {
        for found in found.iter().take(arguments.most) {
            let mut object = json!(found.entry);
            object["distance"] = json!(found.distance);
            writeln!(out, "{object}")?;
        }
        return Ok(Verdict::Good);
    }
    let mut table = Table::new(["distance", "name", "maker", "class", "licence", "file"]);
    for found in found.iter().take(arguments.most) {
        let record = &found.entry.record;
        let words = [found.entry.title(), &record.maker, &record.class, &record.licence];
        let [name, maker, class, licence] = words.map(str::to_owned);
        let distance = found.distance.map_or(String::new(), |d| format!("{d:.3}"));
        let file = found.entry.files.first().map_or(String::new(), |f| f.path.clone());
        table.row([distance, name, maker, class, licence, file]);
    }
    table.print(&mut out, 0)?;
    if found.len() > arguments.most {
        writeln!(out, "and {} more", found.len() - arguments.most)?;
    }
    Ok(Verdict::Good)
}

fn fetch(arguments: &Get) -> Outcome {
    let choice = match &arguments.file {
        Some(name) => Choice::Named(name.clone()),
        None if arguments.all => Choice::All,
        None => Choice::First,
    };
    let cache = match &arguments.cache {
        Some(folder) => Cache { folder: folder.clone(), most_bytes: arguments.most_bytes },
        None => Cache { most_bytes: arguments.most_bytes, ..Cache::usual()? },
    };
    let mut out = io::stdout().lock();
    for got in get(&arguments.address, &choice, &cache)? {
        let path = match &arguments.output {
            Some(folder) => got.copy_into(folder)?,
            None => got.path.clone(),
        };
        if arguments.json {
            let path = path.display().to_string();
            let report = json!({"path": path, "sha256": got.sha256, "cached": got.cached});
            writeln!(out, "{report}")?;
        } else {
            writeln!(out, "{}", path.display())?;
        }
    }
    Ok(Verdict::Good)
}

/// A folder's library; what cannot be read is told.
fn opened(folder: &std::path::Path) -> Outcome<Library> {
    let bar = Bar::new("materials");
    let report = |progress: Progress| bar.report(progress);
    let library = Library::open(folder, &Watch { progress: Some(&report), cancel: None })?;
    drop(bar);
    let faults: Vec<_> = library.faults().iter().map(|fault| &fault.error).collect();
    remark("cannot be read", &faults);
    Ok(library)
}
