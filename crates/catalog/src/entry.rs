//! One material of a catalogue: its record, its files, what they tell.

use std::path::Path;

use bsdfkit::limits::{open_file, read_file};
use bsdfkit::{Bsdf, Error, Lookup, Metadata, Result};
use bsdfkit_fit::deliver::{Kind, Order, Subject};
use bsdfkit_fit::open::{self, Access, Opened};
use bsdfkit_represent::Watch;
use serde::{Deserialize, Serialize};

use crate::exchange::bed::{self, Total};
use crate::facts::{Facts, form};
use crate::hash::Sha256;
use crate::look::Look;
use crate::name::file_slug;
use crate::record::Record;
use crate::scan::Group;

/// A material of a catalogue.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Entry {
    /// Its name in addresses, unique in its catalogue.
    pub id: String,
    /// What people say.
    #[serde(flatten)]
    pub record: Record,
    /// What its files tell.
    #[serde(flatten)]
    pub facts: Facts,
    /// What its record states of reflectance and transmittance.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub totals: Vec<Total>,
    /// Its files, the one to take first.
    pub files: Vec<StoredFile>,
}

/// A file of an entry.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StoredFile {
    /// A plain name for it.
    pub name: String,
    /// What it is: [`Content::name`](bsdfkit_fit::open::Content::name).
    pub content: String,
    /// How its values are stored.
    pub form: String,
    /// Its size.
    pub bytes: u64,
    /// What its bytes hash to.
    pub sha256: Sha256,
    /// Where it lies: in a site from its root on, in a library's folder from there on.
    pub path: String,
}

/// A sidecar file of more bytes is none: one of BiRD holds the measured points, too.
const LONGEST_SIDECAR: u64 = 1 << 26;

impl Entry {
    /// What it is called: its name, else its id.
    pub fn title(&self) -> &str {
        if self.record.name.is_empty() { &self.id } else { &self.record.name }
    }

    /// Reads all of a group; its id is given later.
    ///
    /// Errors: as the readers of its files and its sidecar, naming the file.
    pub(crate) fn read(folder: &Path, group: &Group) -> Result<(Self, Look)> {
        let (told, totals) = match &group.sidecar {
            Some(path) => read_sidecar(path)?,
            None => Default::default(),
        };
        let mut files = Vec::new();
        let mut best: Option<(usize, Facts, Bsdf)> = None;
        let mut own = Record::default();
        for path in &group.files {
            let read = ReadFile::new(folder, path)?;
            own = own.or(&read.record);
            files.push((read.order, read.file));
            if best.as_ref().is_none_or(|(rank, ..)| read.rank < *rank) {
                best = Some((read.rank, read.facts, read.bsdf));
            }
        }
        let (_, facts, bsdf) =
            best.ok_or_else(|| Error::format(format!("{}: expected a file", group.stem)))?;
        files.sort_by(|(a, f), (b, g)| (a, &f.name).cmp(&(b, &g.name)));
        let record = told.or(&own);
        let files = files.into_iter().map(|(_, file)| file).collect();
        Ok((Self { id: String::new(), record, facts, totals, files }, Look::of(&bsdf)?))
    }

    /// The BSDF that pictures and looks are taken of: the least coarse that is quick.
    ///
    /// Errors: as its reader.
    pub(crate) fn best(&self, folder: &Path) -> Result<Bsdf> {
        let ranked = self.files.iter().min_by_key(|file| rank(&file.form));
        let file = ranked.ok_or_else(|| Error::format(format!("{}: no file", self.id)))?;
        match open::open(&folder.join(&file.path), Access::InPlace)?.1 {
            // A picture asks for a million values: minutes of an interpolant, seconds of a tree of it.
            Opened::Interpolant(interpolant) => {
                let order = Order { max_leaves: Some(SKETCH), ..Order::new(Kind::TensorTree) };
                let subject = Subject::Continuous(&interpolant);
                let made = order.deliver(subject, Metadata::default(), &Watch::default())?;
                made.bsdf.with_lookup(Lookup::Smooth)
            }
            // Leaves are no part of a material: trees are read smoothly.
            stored @ Opened::Bsdf(..) => stored.into_bsdf().with_lookup(Lookup::Smooth),
        }
    }
}

/// Leaves of a tree that is made for a picture alone.
const SKETCH: usize = 20_000;

/// One file, read.
struct ReadFile {
    file: StoredFile,
    record: Record,
    facts: Facts,
    bsdf: Bsdf,
    rank: usize,
    order: usize,
}

impl ReadFile {
    fn new(folder: &Path, path: &Path) -> Result<Self> {
        let io = |e: std::io::Error| Error::io(path.display(), &e);
        let (sha256, bytes) = Sha256::of_reader(&mut open_file(path)?).map_err(io)?;
        let (content, opened) = open::open(path, Access::Checked)?;
        let (record, facts, form, bsdf) = match opened {
            Opened::Bsdf(bsdf, _) => {
                let record = Record::of_metadata(bsdf.metadata());
                (record, Facts::of_bsdf(&bsdf), form(&bsdf), *bsdf)
            }
            Opened::Interpolant(interpolant) => {
                let bsdf = interpolant.bsdf();
                let name = interpolant.name.clone().unwrap_or_default();
                let facts = Facts::of_interpolant(&interpolant, &bsdf);
                (Record { name, ..Record::default() }, facts, "interpolant".to_owned(), bsdf)
            }
        };
        let relative = path.strip_prefix(folder).unwrap_or(path);
        let parts = relative.iter().map(|part| part.to_str());
        let Some(parts) = parts.collect::<Option<Vec<&str>>>() else {
            return Err(Error::format("name of the file: expected UTF-8").context(path.display()));
        };
        let name = file_slug(parts.last().copied().unwrap_or_default());
        let (rank, order) = (rank(&form), content as usize);
        let (content, path) = (content.name().to_owned(), parts.join("/"));
        let file = StoredFile { name, content, form, bytes, sha256, path };
        Ok(Self { file, record, facts, bsdf, rank, order })
    }
}

/// The smaller, the better for pictures: stored directions before functions, which take long, and patches last.
fn rank(form: &str) -> usize {
    match form {
        form if form.contains("matrix") => 2,
        "interpolant" => 1,
        _ => 0,
    }
}

/// A record, and the totals that stand beside it.
///
/// Errors: naming the file.
fn read_sidecar(path: &Path) -> Result<(Record, Vec<Total>)> {
    let bytes = read_file(path, LONGEST_SIDECAR)?;
    let told = match String::from_utf8(bytes) {
        Err(_) => Err(Error::format("expected text in UTF-8")),
        Ok(text) if path.extension().is_some_and(|s| s == "json") => from_json(&text),
        Ok(text) => Record::from_toml(&text).map(|record| (record, Vec::new())),
    };
    told.map_err(|e| e.context(path.display()))
}

fn from_json(text: &str) -> Result<(Record, Vec<Total>)> {
    let value: serde_json::Value =
        serde_json::from_str(text).map_err(|e| Error::format(format!("JSON: {e}")))?;
    if bed::is_bed(&value) {
        return bed::read(&value).map(|read| (read.record, read.totals));
    }
    Record::from_value(value).map(|record| (record, Vec::new()))
}
