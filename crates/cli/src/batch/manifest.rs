//! A manifest as rows of keys and texts, whether it is TOML or CSV.

use std::fs;
use std::ops::Range;
use std::path::Path;

use bsdfkit::{Error, Result};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Bytes of a manifest.
const MOST_BYTES: u64 = 64 << 20;
/// Materials of a manifest.
const MOST_ROWS: usize = 100_000;
/// Parts the texts of one cell in CSV.
const PARTS: char = '|';

/// What a key says.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value {
    One(String),
    Many(Vec<String>),
}

/// A key and what it says.
#[derive(Clone, Debug)]
pub(crate) struct Field {
    pub(crate) key: String,
    pub(crate) value: Value,
    /// Where it stands, from 1.
    pub(crate) line: usize,
}

/// What a manifest says of one material.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    /// Where it begins, from 1.
    pub(crate) line: usize,
    pub(crate) fields: Vec<Field>,
}

/// What is said of all materials, and of each.
#[derive(Debug, Default)]
pub(crate) struct Manifest {
    pub(crate) usual: Vec<Field>,
    pub(crate) rows: Vec<Row>,
}

impl Manifest {
    /// Reads `path`, by its suffix as TOML or as CSV.
    ///
    /// Errors: io; argument for another suffix; format with the line, what was expected and what was found; limit.
    pub(crate) fn read(path: &Path) -> Result<Self> {
        let place = |e: Error| e.context(path.display());
        let io = |e: std::io::Error| Error::io(path.display(), &e);
        let bytes = fs::metadata(path).map_err(io)?.len();
        if bytes > MOST_BYTES {
            let text = format!("expected a manifest of at most {MOST_BYTES} bytes, found {bytes}");
            return Err(place(Error::limit(text)));
        }
        let suffix = path.extension().and_then(|s| s.to_str()).map(str::to_ascii_lowercase);
        let text = fs::read(path).map_err(io)?;
        let text = String::from_utf8(text).map_err(|e| {
            let bad = e.utf8_error().valid_up_to();
            let line = e.as_bytes()[..bad].iter().filter(|&&b| b == b'\n').count() + 1;
            let text = format!("line {line}: expected UTF-8, found bytes that are none");
            place(Error::format(text))
        })?;
        let text = text.trim_start_matches('\u{feff}');
        let manifest = match suffix.as_deref() {
            Some("toml") => Self::from_toml(text),
            Some("csv") => Self::from_csv(text),
            _ => Err(Error::argument("expected a manifest named .toml or .csv")),
        };
        let manifest = manifest.map_err(place)?;
        match manifest.rows.len() {
            0 => Err(place(Error::format("expected at least one material, found none"))),
            n if n > MOST_ROWS => Err(place(Error::limit(format!(
                "expected at most {MOST_ROWS} materials, found {n}"
            )))),
            _ => Ok(manifest),
        }
    }

    /// Tables `[[material]]`, and `[defaults]` for what each leaves open.
    fn from_toml(text: &str) -> Result<Self> {
        let root = DeTable::parse(text).map_err(|e| {
            let line = e.span().map_or(1, |span| line_of(text, &span));
            Error::format(format!("line {line}: {}", e.message()))
        })?;
        let mut manifest = Self::default();
        for (key, value) in root.get_ref() {
            let wrong = |expected: &str| {
                let (line, found) = (line_of(text, &value.span()), value.get_ref().type_str());
                Error::format(format!(
                    "line {line}: {}: expected {expected}, found {found}",
                    key.get_ref()
                ))
            };
            match (&**key.get_ref(), value.get_ref()) {
                ("defaults", DeValue::Table(table)) => manifest.usual = fields(text, table)?,
                ("defaults", _) => return Err(wrong("a table [defaults]")),
                ("material", DeValue::Array(all)) => {
                    for one in all {
                        let DeValue::Table(table) = one.get_ref() else {
                            return Err(wrong("tables [[material]]"));
                        };
                        let line = line_of(text, &one.span());
                        manifest.rows.push(Row { line, fields: fields(text, table)? });
                    }
                }
                ("material", _) => return Err(wrong("tables [[material]]")),
                _ => {
                    let line = line_of(text, &key.span());
                    return Err(Error::format(format!(
                        "line {line}: expected [defaults] or [[material]], found {:?}",
                        key.get_ref()
                    )));
                }
            }
        }
        Ok(manifest)
    }

    /// A head of keys and a row for each material, parted by commas, semicolons or tabs; empty cells say nothing.
    fn from_csv(text: &str) -> Result<Self> {
        let head = text.lines().next().unwrap_or_default();
        let most = |c: &u8| head.bytes().filter(|b| b == c).count();
        let delimiter = [b',', b';', b'\t'].into_iter().rev().max_by_key(most).unwrap_or(b',');
        let mut reader = csv::ReaderBuilder::new();
        let reader = reader.delimiter(delimiter).comment(Some(b'#')).trim(csv::Trim::All);
        let mut reader = reader.from_reader(text.as_bytes());
        let wrong = |e: csv::Error| Error::format(e.to_string());
        let heads = reader.headers().map_err(wrong)?.clone();
        let mut manifest = Self::default();
        for (row, record) in reader.records().enumerate() {
            let record = record.map_err(|e| match e.kind() {
                csv::ErrorKind::UnequalLengths { pos, expected_len, len } => {
                    let line = pos.as_ref().map_or(row as u64 + 2, csv::Position::line);
                    let text = format!(
                        "line {line}: expected {expected_len} cells, as the head has, found {len}"
                    );
                    Error::format(text)
                }
                _ => wrong(e),
            })?;
            let line = record.position().map_or(row + 2, |at| at.line() as usize);
            let cells = heads.iter().zip(&record).filter(|(_, cell)| !cell.is_empty());
            let field = |(key, cell): (&str, &str)| Field {
                key: key.to_owned(),
                value: match cell.contains(PARTS) {
                    true => Value::Many(cell.split(PARTS).map(|t| t.trim().to_owned()).collect()),
                    false => Value::One(cell.to_owned()),
                },
                line,
            };
            let fields: Vec<Field> = cells.map(field).collect();
            if !fields.is_empty() {
                manifest.rows.push(Row { line, fields });
            }
        }
        Ok(manifest)
    }
}

/// The line that `span` begins on, from 1.
fn line_of(text: &str, span: &Range<usize>) -> usize {
    text.as_bytes()[..span.start.min(text.len())].iter().filter(|&&b| b == b'\n').count() + 1
}

fn fields(text: &str, table: &DeTable<'_>) -> Result<Vec<Field>> {
    let one = |(key, value): (&Spanned<_>, &Spanned<DeValue<'_>>)| {
        let key: &std::borrow::Cow<'_, str> = key.get_ref();
        let line = line_of(text, &value.span());
        let wrong = |found: &str| {
            Error::format(format!(
                "line {line}: {key}: expected a text, a number, true, false or a list of them, found {found}"
            ))
        };
        let value = match value.get_ref() {
            DeValue::Array(all) => {
                let words = all.iter().map(|v| word(v.get_ref()).ok_or(v.get_ref().type_str()));
                Value::Many(words.collect::<Result<_, _>>().map_err(wrong)?)
            }
            // What fields of a material are: FIELD = VALUE.
            DeValue::Table(all) => {
                let pair =
                    |(k, v): (&Spanned<std::borrow::Cow<'_, str>>, &Spanned<DeValue<'_>>)| {
                        let value = word(v.get_ref()).ok_or(v.get_ref().type_str())?;
                        Ok(format!("{}={value}", k.get_ref()))
                    };
                Value::Many(all.iter().map(pair).collect::<Result<_, _>>().map_err(wrong)?)
            }
            other => Value::One(word(other).ok_or_else(|| wrong(other.type_str()))?),
        };
        Ok(Field { key: key.to_string(), value, line })
    };
    table.iter().map(one).collect()
}

/// A text, a number, a truth value or a date as the command line takes it.
fn word(value: &DeValue<'_>) -> Option<String> {
    match value {
        DeValue::String(text) => Some(text.to_string()),
        DeValue::Integer(number) => {
            i64::from_str_radix(number.as_str(), number.radix()).ok().map(|n| n.to_string())
        }
        DeValue::Float(number) => Some(number.as_str().to_owned()),
        DeValue::Boolean(truth) => Some(truth.to_string()),
        DeValue::Datetime(date) => Some(date.to_string()),
        DeValue::Array(_) | DeValue::Table(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(manifest: &Manifest) -> Vec<(usize, String, Value)> {
        let all = manifest.rows.iter().flat_map(|r| &r.fields);
        all.map(|f| (f.line, f.key.clone(), f.value.clone())).collect()
    }

    #[test]
    fn toml_and_csv_say_the_same() {
        let toml = "[[material]]\nname = \"a\"\nmeasurements = [\"x\", \"y/*\"]\naperture = 0.5\n";
        let one = |text: &str| Value::One(text.into());
        let expected = [
            ("aperture", one("0.5")),
            ("measurements", Value::Many(vec!["x".into(), "y/*".into()])),
            ("name", one("a")),
        ];
        let mut found = said(&Manifest::from_toml(toml).unwrap());
        found.sort_by(|a, b| a.1.cmp(&b.1));
        assert_eq!(found.iter().map(|f| f.0).collect::<Vec<_>>(), [4, 3, 2]);
        let found: Vec<(&str, Value)> = found.iter().map(|f| (&*f.1, f.2.clone())).collect();
        assert_eq!(found, expected);
        for (separator, comment) in [(",", ""), (";", "# said\n"), ("\t", "")] {
            let csv = format!("name,measurements,aperture,notes\n{comment}a,x | y/*,0.5,\n");
            let mut found = said(&Manifest::from_csv(&csv.replace(',', separator)).unwrap());
            found.sort_by(|a, b| a.1.cmp(&b.1));
            let found: Vec<(&str, Value)> = found.iter().map(|f| (&*f.1, f.2.clone())).collect();
            assert_eq!(found, expected, "{separator:?}");
        }
    }

    #[test]
    fn faults_are_told_with_their_line() {
        for (text, words) in [
            ("[[material]]\nname = ", "line 2: "),
            ("\nmaterials = 3", "line 2: expected [defaults] or [[material]], found \"materials\""),
            ("material = 3", "line 1: material: expected tables [[material]], found integer"),
            ("defaults = []", "line 1: defaults: expected a table"),
            ("[[material]]\nname = [[1]]", "line 2: name: expected a text"),
        ] {
            let error = Manifest::from_toml(text).unwrap_err().to_string();
            assert!(error.contains(words), "{text}: {error}");
        }
        let error = Manifest::from_csv("name,measurements\na,b\nc\n").unwrap_err().to_string();
        assert!(error.contains("line 3: expected 2 cells"), "{error}");
    }
}
