//! A static site of a library: pages, pictures, files and an index that programs read.
//!
//! `index.html` (cards and filters), `materials/ID.html`, `pictures/ID.png`, `files/ID/NAME`, `index.json`, one style sheet
//! and one script, and the viewer where there is one. All addresses are relative; no page asks any other host for anything. Everything that comes from a record
//! is escaped, and a content security policy forbids scripts but that one.

mod cards;
mod html;
mod material;
mod nearest;
mod write;

use serde::{Deserialize, Serialize};

use crate::entry::Entry;

pub use write::{Built, Options, build};

/// Name of a site's index, from its root.
pub const INDEX: &str = "index.json";
/// Name of the viewer's page, from a site's root.
pub(crate) const VIEWER: &str = "viewer.html";
/// What an index says that it is.
pub(crate) const FORMAT: &str = "bsdfkit-catalog";
/// Version of the index; of another one nothing is read.
pub(crate) const VERSION: u32 = 1;

/// What `index.json` holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SiteIndex {
    /// `bsdfkit-catalog`.
    pub format: String,
    /// 1.
    pub version: u32,
    /// Title of the catalogue.
    pub title: String,
    /// What wrote it.
    pub made_by: String,
    /// What [`Similar::distance`] means.
    pub distance: String,
    /// All materials.
    pub entries: Vec<SiteEntry>,
}

/// A material of a site; addresses are from its root on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SiteEntry {
    /// Record, facts and files.
    #[serde(flatten)]
    pub entry: Entry,
    /// Its page.
    pub page: String,
    /// Its picture.
    pub picture: String,
    /// What looks most like it, the nearest first.
    pub similar: Vec<Similar>,
}

/// A material that looks like another.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Similar {
    /// Its id.
    pub id: String,
    /// How far they are apart: [`Look::distance`](crate::Look::distance).
    pub distance: f64,
}
