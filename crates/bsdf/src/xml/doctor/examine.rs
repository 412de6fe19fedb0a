//! Everything that is found in one file.

use std::fmt;

use super::blocks::{self, Outline};
use super::catalogue::kind;
use super::kind::Kind;
use super::program::Program;
use super::{description, file, form, light, words};
use crate::xml::Limits;
use crate::xml::decode::decode;
use crate::xml::document::{Document, Node};
use crate::xml::read::read_document;
use crate::xml::report::Report;
use crate::{Bsdf, Error, foreign};

/// Something found, and where.
#[derive(Clone, Debug)]
pub struct Finding {
    /// What kind of thing it is.
    pub kind: &'static Kind,
    /// Line and path of the element, or the side; empty for the whole file.
    pub place: String,
    /// What was found there, and what was expected.
    pub text: String,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.place.as_str() {
            "" => write!(f, "{}: {}", self.kind.code, self.text),
            place => write!(f, "{}: {place}: {}", self.kind.code, self.text),
        }
    }
}

impl Finding {
    /// Whether it matters to whoever uses that program, or any at all.
    pub fn matters(&self, program: Option<Program>) -> bool {
        self.kind.matters(program)
    }
}

/// What was found in one file.
#[derive(Debug)]
pub struct Examination {
    /// In the order of the catalogue's families.
    pub findings: Vec<Finding>,
    /// What the file holds, where it can be read as it is.
    pub bsdf: Option<Bsdf>,
    /// Why it cannot.
    pub error: Option<Error>,
}

/// Findings as they come.
#[derive(Debug, Default)]
pub(super) struct Findings(pub(super) Vec<Finding>);

impl Findings {
    /// Adds one of the catalogue.
    pub(super) fn add(&mut self, code: &str, place: impl Into<String>, text: impl Into<String>) {
        // The tests ask for every code that is named anywhere.
        let Some(kind) = kind(code) else { return };
        self.0.push(Finding { kind, place: place.into(), text: text.into() });
    }

    /// Adds one for all of these: the place of the first, as looking for lines takes time, and how many more.
    pub(super) fn add_first<'d, 'a: 'd>(
        &mut self,
        code: &str,
        found: impl IntoIterator<Item = (Node<'d, 'a>, String)>,
    ) {
        let mut found = found.into_iter();
        let Some((node, text)) = found.next() else { return };
        let text = match found.count() {
            0 => text,
            more => format!("{text}; so in {more} more places"),
        };
        self.add(code, node.place(), text);
    }

    pub(super) fn has(&self, code: &str) -> bool {
        self.0.iter().any(|f| f.kind.code == code)
    }
}

/// Warnings and faults that are listed of one file.
const MOST: usize = 100;

/// Looks for everything that is wrong with a file; never fails.
///
/// Cost: that of reading it, of some hundred totals and of 4,096 samples a component.
pub fn examine(bytes: &[u8], limits: &Limits) -> Examination {
    let mut found = Findings::default();
    let (bsdf, error) = match look(bytes, limits, &mut found) {
        Ok(bsdf) => (bsdf, None),
        Err(error) => (None, Some(error)),
    };
    if let Some(bsdf) = &bsdf {
        form::look(bsdf, &mut found);
        light::look(bsdf, &mut found);
    }
    Examination { findings: found.0, bsdf, error }
}

/// The text and what the reader says of it.
fn look(bytes: &[u8], limits: &Limits, found: &mut Findings) -> Result<Option<Bsdf>, Error> {
    let head = &bytes[..bytes.len().min(foreign::HEAD as usize)];
    if let Some(format) = foreign::recognise(head) {
        let page = format.name.starts_with("a web page");
        found.add(if page { "web-page" } else { "other-format" }, "", format.to_string());
        return Err(Error::format(format.to_string()));
    }
    let mut report = Report::new(MOST);
    let text = decode(bytes, &mut report).inspect_err(|e| unreadable(found, e))?;
    file::look(&text, bytes, found);
    let document = Document::parse(&text, limits, &mut report);
    let Some(document) = document else {
        return report.finish().map(|_| None).inspect_err(|e| unreadable(found, e));
    };
    let outline = Outline::of(&document);
    words::look(&document, &outline, found);
    description::look(&outline, found);
    blocks::look(&outline, found);

    let bsdf = read_document(&document, limits, &mut report);
    match report.finish() {
        Ok(warnings) => {
            // Energy is judged of all that leaves a side; what precedes the declaration has a kind of its own.
            let before = file::has_text_before(&text);
            let told = |code: &str, place: &str| match code {
                "energy" => true,
                "outside-text" => before && place == "line 1",
                _ => false,
            };
            for warning in warnings.into_iter().filter(|w| !told(w.code, &w.place)) {
                found.add(warning.code, warning.place, warning.text);
            }
            Ok(bsdf)
        }
        Err(error) => {
            // What the reader refuses and a kind of its own explains is not said twice.
            let explained = found.has("no-visible")
                || blocks::as_values(&text, &outline).is_some_and(|text| is_sound(&text, limits));
            if !explained {
                unreadable(found, &error);
            }
            Err(error)
        }
    }
}

fn unreadable(found: &mut Findings, error: &Error) {
    found.add("unreadable", "", error.to_string());
}

/// Whether a text can be read.
fn is_sound(text: &str, limits: &Limits) -> bool {
    let mut report = Report::without_warnings(1);
    let document = Document::parse(text, limits, &mut report);
    document.is_some_and(|document| read_document(&document, limits, &mut report).is_some())
}
