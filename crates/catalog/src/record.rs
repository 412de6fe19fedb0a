//! What people say of a material; what a file says for itself is in [`Facts`](crate::Facts).

use bsdfkit::{Error, Metadata, Result};
use serde::{Deserialize, Serialize};

use crate::exchange::{bed, bird};

/// Who made a specimen, who measured it, and what may be done with the data. Empty: not known.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Record {
    /// Name of the material.
    pub name: String,
    /// Who makes it.
    pub maker: String,
    /// What kind of thing it is: metal, fabric, glazing, ….
    pub class: String,
    /// What it was measured with, or simulated by.
    pub instrument: String,
    /// When it was measured: ISO 8601, a year, a month or a day.
    pub date: String,
    /// Under which licence the data are: an SPDX expression.
    pub licence: String,
    /// DOI of the data or of what they were published with, from `10.` on.
    pub doi: String,
    /// What else a reader should know.
    pub notes: String,
}

/// Characters that a field may have; of the notes ten times as many.
const LONGEST: usize = 400;

/// What a comment of a BSDF file starts with that holds a record as JSON.
const COMMENT: &str = "bsdfkit record: ";

impl Record {
    /// The fields as sidecar files name them, with other spellings.
    const FIELDS: [(&str, &str); 8] = [
        ("name", "title"),
        ("maker", "manufacturer"),
        ("class", "kind"),
        ("instrument", "device"),
        ("date", "measured"),
        ("licence", "license"),
        ("doi", "DOI"),
        ("notes", "comment"),
    ];

    /// Every field by its name.
    pub fn fields(&self) -> [(&'static str, &str); 8] {
        let values = [
            &self.name,
            &self.maker,
            &self.class,
            &self.instrument,
            &self.date,
            &self.licence,
            &self.doi,
            &self.notes,
        ];
        let mut fields = [("", ""); 8];
        for (k, value) in values.into_iter().enumerate() {
            fields[k] = (Self::FIELDS[k].0, value);
        }
        fields
    }

    fn field_mut(&mut self, name: &str) -> Option<&mut String> {
        let at = Self::FIELDS.iter().position(|(field, other)| *field == name || *other == name)?;
        Some(match at {
            0 => &mut self.name,
            1 => &mut self.maker,
            2 => &mut self.class,
            3 => &mut self.instrument,
            4 => &mut self.date,
            5 => &mut self.licence,
            6 => &mut self.doi,
            _ => &mut self.notes,
        })
    }

    /// From the text of a TOML file: one key a field, dates with or without quotes.
    ///
    /// Errors: format: TOML's own, unknown fields, and as [`Record::checked`].
    pub fn from_toml(text: &str) -> Result<Self> {
        let table: toml::Table = toml::from_str(text)
            .map_err(|e| Error::format(format!("TOML: {}", e.to_string().trim_end())))?;
        let text = |value: toml::Value| match value {
            toml::Value::String(text) => Some(text),
            toml::Value::Datetime(date) => Some(date.to_string()),
            _ => None,
        };
        Self::of(table.into_iter().map(|(key, value)| (key, text(value))))
    }

    /// From the text of a JSON file: an object of strings, or what a file of BiRD or of BED-JSON says
    /// ([`exchange`](crate::exchange)).
    ///
    /// Errors: as [`Record::from_toml`] and [`bed::read`].
    pub fn from_json(text: &str) -> Result<Self> {
        let value: serde_json::Value =
            serde_json::from_str(text).map_err(|e| Error::format(format!("JSON: {e}")))?;
        Self::from_value(value)
    }

    /// Errors: as [`Record::from_json`].
    pub(crate) fn from_value(value: serde_json::Value) -> Result<Self> {
        if let Some(record) = bird::record(&value) {
            return Ok(record);
        }
        if bed::is_bed(&value) {
            return bed::read(&value).map(|read| read.record);
        }
        let serde_json::Value::Object(object) = value else {
            return Err(Error::format("JSON: expected an object of texts"));
        };
        let text = |value: serde_json::Value| value.as_str().map(str::to_owned);
        Self::of(object.into_iter().map(|(key, value)| (key, text(value))))
    }

    fn of(pairs: impl Iterator<Item = (String, Option<String>)>) -> Result<Self> {
        let mut record = Self::default();
        for (key, value) in pairs {
            let Some(field) = record.field_mut(&key) else {
                let names = Self::FIELDS.map(|(name, _)| name).join(", ");
                return Err(Error::format(format!(
                    "record: expected the fields {names}, found {key:?}"
                )));
            };
            let Some(value) = value else {
                return Err(Error::format(format!("{key}: expected a text in quotes")));
            };
            *field = value;
        }
        record.checked()
    }

    /// What the metadata of a file tell: a record that was written into it, else name, manufacturer and `DeviceType`.
    pub fn of_metadata(metadata: &Metadata) -> Self {
        let written = metadata
            .comments
            .iter()
            .find_map(|comment| Self::from_json(comment.trim().strip_prefix(COMMENT)?).ok());
        let kind = metadata.property("DeviceType").filter(|kind| *kind != "Other");
        let own = Self {
            name: metadata.name.clone(),
            maker: metadata.manufacturer.clone(),
            class: kind.unwrap_or_default().to_owned(),
            ..Self::default()
        };
        written.unwrap_or_default().or(&own.cut())
    }

    /// Writes it into the metadata of a file: name and maker where XML has fields for them, all of it in a comment,
    /// which every program passes over.
    pub fn write_into(&self, metadata: &mut Metadata) {
        metadata.comments.retain(|comment| !comment.trim().starts_with(COMMENT));
        if !self.name.is_empty() {
            metadata.name.clone_from(&self.name);
        }
        if !self.maker.is_empty() {
            metadata.manufacturer.clone_from(&self.maker);
        }
        let told = self.fields().into_iter().filter(|(_, value)| !value.is_empty());
        let told: serde_json::Map<_, _> =
            told.map(|(name, value)| (name.to_owned(), value.into())).collect();
        // A comment of XML cannot hold two hyphens.
        let json = serde_json::Value::from(told).to_string().replace("--", "-\\u002d");
        metadata.comments.push(format!("{COMMENT}{json}"));
    }

    /// The fields that are known here, the others as `other` has them.
    #[must_use]
    pub fn or(mut self, other: &Self) -> Self {
        for (name, value) in other.fields() {
            if let Some(field) = self.field_mut(name).filter(|field| field.is_empty()) {
                value.clone_into(field);
            }
        }
        self
    }

    /// Trimmed, and what is wrong told.
    ///
    /// Errors: format: a licence that is no SPDX expression, a date that is not ISO 8601, a DOI that does not start with
    /// `10.`, control characters, fields of more than 400 characters (notes: 4000).
    pub fn checked(mut self) -> Result<Self> {
        for (name, _) in Self::FIELDS {
            let field = self.field_mut(name).expect("every field has its name");
            *field = field.trim().to_owned();
            let longest = if name == "notes" { 10 * LONGEST } else { LONGEST };
            let length = field.chars().count();
            if length > longest {
                let text = format!("{name}: expected at most {longest} characters, found {length}");
                return Err(Error::format(text));
            }
            if let Some(c) = field.chars().find(|c| c.is_control() && !"\n\t\r".contains(*c)) {
                return Err(Error::format(format!("{name}: expected text, found {c:?}")));
            }
        }
        for prefix in ["https://doi.org/", "http://doi.org/", "doi:", "DOI:"] {
            if let Some(bare) = self.doi.strip_prefix(prefix) {
                self.doi = bare.trim().to_owned();
            }
        }
        if !self.doi.is_empty() && !is_doi(&self.doi) {
            let text = format!("doi: expected 10.PREFIX/SUFFIX, found {:?}", self.doi);
            return Err(Error::format(text));
        }
        if !self.date.is_empty() && !is_date(&self.date) {
            let text = format!("date: expected YYYY, YYYY-MM or YYYY-MM-DD, found {:?}", self.date);
            return Err(Error::format(text));
        }
        if !self.licence.is_empty()
            && let Err(e) = spdx::Expression::parse(&self.licence)
        {
            return Err(Error::format(format!(
                "licence: expected an SPDX expression such as CC-BY-4.0 or LicenseRef-NAME, found {:?} ({})",
                self.licence, e.reason
            )));
        }
        Ok(self)
    }

    /// What a file says for itself, which nobody promised to check: cut to what fits.
    pub(crate) fn cut(mut self) -> Self {
        for (name, _) in Self::FIELDS {
            let field = self.field_mut(name).expect("every field has its name");
            let text = field.chars().filter(|c| !c.is_control()).take(LONGEST);
            *field = text.collect::<String>().trim().to_owned();
        }
        self
    }
}

fn is_doi(text: &str) -> bool {
    let registrant = text.strip_prefix("10.").and_then(|rest| rest.split_once('/'));
    registrant.is_some_and(|(prefix, suffix)| {
        let digit = |c: char| c.is_ascii_digit() || c == '.';
        !prefix.is_empty()
            && prefix.chars().all(digit)
            && !suffix.is_empty()
            && !text.contains(char::is_whitespace)
    })
}

/// Whether it is a year, a month or a day that the calendar has.
fn is_date(text: &str) -> bool {
    let parts: Vec<&str> = text.split('-').collect();
    let number = |k: usize, digits: usize| {
        let part = parts.get(k)?;
        (part.len() == digits && part.bytes().all(|b| b.is_ascii_digit()))
            .then(|| part.parse().ok())?
    };
    let Some(year) = number(0, 4) else { return false };
    let leap = |y: u32| y.is_multiple_of(4) && (!y.is_multiple_of(100) || y.is_multiple_of(400));
    let month = number(1, 2).filter(|m| (1..=12).contains(m));
    let days = match month {
        Some(2) => 28 + u32::from(leap(year)),
        Some(4 | 6 | 9 | 11) => 30,
        _ => 31,
    };
    match parts.len() {
        1 => true,
        2 => month.is_some(),
        3 => month.is_some() && number(2, 2).is_some_and(|d| (1..=days).contains(&d)),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn toml_and_json_say_the_same() {
        let toml = "name = \"A\"\nlicense = \"CC-BY-4.0 OR MIT\"\ndate = 2024-02-29\ndoi = \"https://doi.org/10.5281/zenodo.1\"";
        let json = r#"{"title": "A", "licence": " CC-BY-4.0 OR MIT ", "date": "2024-02-29", "doi": "10.5281/zenodo.1"}"#;
        let record = Record::from_toml(toml).unwrap();
        assert_eq!(record, Record::from_json(json).unwrap());
        assert_eq!((&*record.licence, &*record.doi), ("CC-BY-4.0 OR MIT", "10.5281/zenodo.1"));
    }

    #[test]
    fn what_is_wrong_is_told_with_its_field() {
        for (text, words) in [
            ("colour = \"red\"", "found \"colour\""),
            ("name = 3", "name: expected a text"),
            ("licence = \"mine\"", "licence: expected an SPDX"),
            ("date = \"30.11.2026\"", "date: expected YYYY"),
            ("date = \"2023-02-29\"", "date: expected YYYY"),
            ("doi = \"javascript:alert(1)\"", "doi: expected 10."),
            ("name = \"a\\u0007\"", "name: expected text"),
            ("name = ", "TOML: "),
        ] {
            let error = Record::from_toml(text).unwrap_err().to_string();
            assert!(error.contains(words), "{text}: {error}");
        }
        let long = format!("name = \"{}\"", "a".repeat(401));
        assert!(Record::from_toml(&long).unwrap_err().to_string().contains("at most 400"));
    }

    #[test]
    fn a_record_in_a_file_comes_back() {
        let record = Record {
            name: "A --- \"b\"".into(),
            licence: "CC0-1.0".into(),
            date: "2026".into(),
            ..Record::default()
        };
        let mut metadata = Metadata { manufacturer: "M".into(), ..Metadata::default() };
        record.write_into(&mut metadata);
        record.write_into(&mut metadata);
        assert_eq!((metadata.comments.len(), &*metadata.name), (1, "A --- \"b\""));
        assert!(!metadata.comments[0].contains("--"));
        let read = Record::of_metadata(&metadata);
        assert_eq!(read, Record { maker: "M".into(), ..record });
    }
}
