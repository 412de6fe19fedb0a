//! Searches: by words, by look, or both.

use bsdfkit::{Error, Result};

use crate::entry::Entry;
use crate::library::Library;
use crate::look::Look;

/// What is looked for.
#[derive(Clone, Debug, Default)]
pub struct Query {
    /// Words that must all occur, or begin a word that does, in any field or, as `maker:acme`, in one.
    pub words: Vec<String>,
    /// What it should look like: the nearest come first.
    pub like: Option<Look>,
}

/// An entry that was found.
#[derive(Clone, Copy, Debug)]
pub struct Found<'a> {
    /// The entry.
    pub entry: &'a Entry,
    /// [`Look::distance`] from what was asked for.
    pub distance: Option<f64>,
}

/// Fields that words can be asked of.
const FIELDS: [&str; 10] = [
    "name",
    "maker",
    "class",
    "instrument",
    "date",
    "licence",
    "doi",
    "notes",
    "symmetry",
    "components",
];

impl Query {
    /// What of a library fits: the nearest first where a look is asked for, else what fits the words best, else all by
    /// their files' names.
    ///
    /// Errors: argument: an unknown field; io.
    pub fn of<'a>(&self, library: &'a Library) -> Result<Vec<Found<'a>>> {
        let entries = library.entries();
        let numbers = match self.expression()? {
            Some(expression) => library.matching(&expression)?,
            None => (0..entries.len()).collect(),
        };
        let found = |k: usize, distance| Found { entry: &entries[k], distance };
        let Some(like) = &self.like else {
            return Ok(numbers.into_iter().map(|k| found(k, None)).collect());
        };
        let distances = library.distances(like)?;
        let near = |k: usize| distances.get(k)?.map(|d| found(k, Some(d)));
        let mut all: Vec<Found<'a>> = numbers.into_iter().filter_map(near).collect();
        all.sort_by(|a, b| {
            a.distance.unwrap_or(f64::MAX).total_cmp(&b.distance.unwrap_or(f64::MAX))
        });
        Ok(all)
    }

    /// In the language of SQLite's FTS5; `None`: no words.
    fn expression(&self) -> Result<Option<String>> {
        let mut parts = Vec::new();
        for word in self.words.iter().filter(|w| !w.trim().is_empty()) {
            let quoted = |text: &str| format!("\"{}\"*", text.replace('"', "\"\""));
            match word.split_once(':') {
                Some((field, text)) if FIELDS.contains(&field) => {
                    parts.push(format!("{field} : {}", quoted(text)));
                }
                Some((field, _))
                    if !field.is_empty() && field.chars().all(|c| c.is_ascii_lowercase()) =>
                {
                    let names = FIELDS.join(", ");
                    let text =
                        format!("search: expected one of the fields {names}, found {field:?}");
                    return Err(Error::argument(text));
                }
                _ => parts.push(quoted(word)),
            }
        }
        // The column of files' names counts, too.
        Ok((!parts.is_empty()).then(|| parts.join(" AND ")))
    }
}
