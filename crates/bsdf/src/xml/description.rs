//! Writes `Material` and `Geometry`.

use std::io::Write;

use quick_xml::escape::escape;

use super::kept::{GEOMETRY, MATERIAL};
use super::placeholders::{FIELDS, comment, placeholder, placeholders};
use super::write::Writer;
use crate::{Error, Result};

impl<W: Write> Writer<'_, W> {
    /// What is known of the specimen, and placeholders for what must not be missing.
    pub(super) fn material(&mut self) -> Result<()> {
        let metadata = self.metadata;
        let invented = match self.options.window_fields {
            true => placeholders(metadata),
            false => Vec::new(),
        };
        let is_invented = |field: &str| invented.contains(&field);
        let known = |field: &str| {
            let own = metadata.property(field).filter(|_| !is_invented(field));
            own.and_then(|text| text.trim().parse().ok())
        };
        self.line("<Material>")?;
        if !invented.is_empty() {
            self.line(format_args!("<!-- {} -->", comment(&invented)))?;
        }
        for (field, own) in [("Name", &metadata.name), ("Manufacturer", &metadata.manufacturer)] {
            let text = if is_invented(field) { &placeholder(field, known) } else { own.as_str() };
            self.element(field, text)?;
        }
        let sizes = [
            ("Thickness", metadata.thickness),
            ("Width", metadata.width),
            ("Height", metadata.height),
        ];
        for (name, metres) in sizes {
            if is_invented(name) {
                let metres = placeholder(name, known);
                self.line(format_args!("<{name} unit=\"Meter\">{metres}</{name}>"))?;
            } else if metres > 0.0 {
                self.line(format_args!("<{name} unit=\"Meter\">{metres}</{name}>"))?;
            }
        }
        for (key, value) in &metadata.properties {
            if key == "WindowElementType" || is_invented(key) {
                continue;
            }
            if !is_name(key) {
                let text = format!("property {key:?}: expected a name of letters and digits");
                return Err(Error::argument(text));
            }
            self.element(key, value)?;
        }
        let sized = |field: &str| sizes.iter().any(|(name, _)| *name == field);
        for (field, _) in &FIELDS[2..] {
            if is_invented(field) && !sized(field) {
                self.element(field, &placeholder(field, known))?;
            }
        }
        self.unread(MATERIAL)?;
        self.line("</Material>")
    }

    pub(super) fn geometry(&mut self) -> Result<()> {
        let Some(mgf) = &self.metadata.geometry else {
            self.line("<Geometry>")?;
            self.unread(GEOMETRY)?;
            return self.line("</Geometry>");
        };
        let mgf = escape(mgf.as_str());
        self.line("<Geometry format=\"MGF\">")?;
        self.line(format_args!("<MGFblock unit=\"Meter\">{mgf}</MGFblock>"))?;
        self.unread(GEOMETRY)?;
        self.line("</Geometry>")
    }
}

/// Whether `key` can be the name of an element.
fn is_name(key: &str) -> bool {
    let letter = |c: char| c.is_alphabetic() || c == '_';
    key.starts_with(letter) && key.chars().all(|c| letter(c) || c.is_numeric() || "-.".contains(c))
}
