//! Plain tables: CSV, TSV or blank-separated, with a line that names the columns.

use std::path::Path;

use bsdfkit::Result;
use bsdfkit_sphere::direction;

use super::Colorimetry;
use super::block::{Block, Budget, FileContent, HORIZON_COSINE, Remark};
use super::colorimetry::Sorted;
use super::form::{Decimal, Separator};
use super::gather::Gathered;
use super::header::wavelengths;
use super::line::{Lines, quoted};
use super::names::{Meaning, Name, is_no_unit_of_f};

/// The four columns that every table must have.
const ANGLES: [(Meaning, &str); 4] = [
    (Meaning::IncidentTheta, "theta_i"),
    (Meaning::IncidentPhi, "phi_i"),
    (Meaning::ScatteredTheta, "theta_o"),
    (Meaning::ScatteredPhi, "phi_o"),
];

/// Five times the bands of a spectral instrument that steps by 1 nm from 380 to 780.
const MOST_COLUMNS: usize = 2000;

/// Reads a table: columns theta_i, phi_i, theta_o, phi_o in any order and spelling, the others one
/// a channel.
///
/// Convention: Radiance's frame (θ 0–180 from +Z, φ from +X toward +Y), degrees unless the names
/// say rad; values f in 1/sr, or f |cos θo| where the name says DSF or CCBSDF. A single value
/// column is luminance, columns x, y, z are CIE XYZ, columns 450nm, 460nm … a spectrum, any others channels by name.
/// Errors: class format, naming line, expected and found; class limit; class io.
pub(super) fn read(path: &Path, budget: &Budget) -> Result<FileContent> {
    let mut lines = Lines::open(path)?;
    let (mut sample_name, mut wavelength) = (None, None);
    let layout = loop {
        let Some(line) = lines.next_line()? else {
            return Err(
                lines.error("expected a line that names the columns, found the end of the file")
            );
        };
        let line = line.trim_start();
        let comment = line.strip_prefix('#');
        wavelength = wavelength.or_else(|| comment.and_then(named_wavelength));
        sample_name = sample_name.or_else(|| comment.and_then(named_sample));
        let names = match comment {
            Some(comment) if !names_all_columns(comment) => continue,
            None if !is_data(line) => continue,
            _ => comment.unwrap_or(line),
        };
        match Layout::new(names, 1.0) {
            Ok(layout) => break layout,
            Err(message) => return Err(lines.error(message)),
        }
    };
    let mut remarks = Vec::new();
    if !layout.left_out.is_empty() {
        let text = format!("columns left out: {}", layout.left_out.join(", "));
        remarks.push(Remark { line: Some(lines.number()), text });
    }
    let mut rows = Rows::new(layout);
    rows.sort().map_err(|e| e.context(path.display()))?;
    let mut count = 0;
    while let Some(line) = lines.next_line()? {
        if is_data(line) {
            let taken = rows.take(line);
            taken.map_err(|m| lines.error(m))?;
            budget.spend(&mut count, rows.channels(), path)?;
        }
    }
    if count == 0 {
        return Err(lines.error("expected rows after the column names, found the end of the file"));
    }
    remarks.extend(lines.remark());
    let (colorimetry, blocks) = rows.finish(&mut remarks);
    let wavelength = wavelength.filter(|_| colorimetry == Colorimetry::Luminance);
    let path = path.to_owned();
    Ok(FileContent { path, sample_name, colorimetry, blocks, remarks, wavelength })
}

/// The specimen's name in a comment `sample_name "..."`, as Mountain files have it.
fn named_sample(comment: &str) -> Option<String> {
    let name = comment.trim_start().strip_prefix("sample_name")?;
    let name = name.trim_matches(|c: char| c.is_whitespace() || c == ':' || c == '"');
    (!name.is_empty()).then(|| name.to_owned())
}

/// The wavelength in a comment `lambda 550`, as Mountain files have it.
fn named_wavelength(comment: &str) -> Option<f64> {
    let value = comment.trim_start().strip_prefix("lambda")?;
    let value = value.trim_start().trim_start_matches([':', '=']);
    wavelengths(value, None).ok().filter(|found| found.len() == 1).map(|found| found[0])
}

/// Whether there are names or numbers in `line`: it is not empty, no comment, and not Excel's
/// "sep=;".
pub(super) fn is_data(line: &str) -> bool {
    let line = line.trim_start();
    !line.is_empty() && !line.starts_with('#') && !line.starts_with("sep=")
}

/// Whether `line` names columns of such a table.
pub(super) fn names_columns(line: &str) -> bool {
    let names = Name::all_in(line);
    ANGLES.iter().any(|(meaning, _)| names.iter().any(|n| n.meaning == Some(*meaning)))
}

/// Whether `line` names all that a table must have: then a comment may be the line that names the
/// columns.
pub(super) fn names_all_columns(line: &str) -> bool {
    let names = Name::all_in(line);
    ANGLES.iter().all(|(meaning, _)| names.iter().any(|n| n.meaning == Some(*meaning)))
}

/// Which column holds what.
pub(super) struct Layout {
    columns: usize,
    angles: [usize; 4],
    /// What each angle is to be multiplied with to be degrees.
    degrees: [f64; 4],
    values: Vec<usize>,
    /// Whether a value contains |cos θo|, one a value.
    cosine: Vec<bool>,
    colorimetry: Colorimetry,
    /// Names of columns that hold no value.
    left_out: Vec<String>,
}

impl Layout {
    /// What the names in `line` say; angles without a unit are `usual` times degrees.
    pub(super) fn new(line: &str, usual: f64) -> std::result::Result<Self, String> {
        let names = Name::all_in(line);
        if names.len() > MOST_COLUMNS {
            return Err(format!("expected at most {MOST_COLUMNS} columns, found {}", names.len()));
        }
        let (mut angles, mut degrees) = ([0; 4], [1.0; 4]);
        for (k, (meaning, wanted)) in ANGLES.into_iter().enumerate() {
            let mut those = (0..names.len()).filter(|&i| names[i].meaning == Some(meaning));
            let at = those.next().ok_or_else(|| {
                let found: Vec<&str> = names.iter().map(|n| n.text.as_str()).collect();
                format!(
                    "expected a column {wanted}, found the columns {}",
                    quoted(&found.join(" "))
                )
            })?;
            if let Some(second) = those.next() {
                let [a, b] = [at, second].map(|i| quoted(&names[i].text));
                return Err(format!("expected each column once, found {a} and {b}"));
            }
            angles[k] = at;
            let factor = names[at].degrees().map_err(|m| format!("{wanted}: {m}"))?;
            degrees[k] = if names[at].unit.is_some() { factor } else { usual };
        }
        for (i, name) in names.iter().enumerate() {
            let twice = names[..i].iter().any(|n| n.text == name.text) && !name.letters.is_empty();
            if twice {
                return Err(format!(
                    "expected each column once, found {} twice",
                    quoted(&name.text)
                ));
            }
            expect_value_of_f(name)?;
        }
        let aside = |i: &usize| names[*i].meaning == Some(Meaning::Beside);
        let others: Vec<usize> = (0..names.len()).filter(|i| !angles.contains(i)).collect();
        let (beside, mut values): (Vec<usize>, Vec<usize>) = others.into_iter().partition(aside);
        let named = |wanted: &str| names.iter().position(|n| n.letters == wanted);
        let colorimetry = match (values.len(), named("x"), named("y"), named("z")) {
            (0, ..) => return Err("expected a column of values, found only angles".to_owned()),
            (1, ..) => Colorimetry::Luminance,
            (3, Some(x), Some(y), Some(z)) => {
                values = vec![x, y, z];
                Colorimetry::Xyz
            }
            _ => Colorimetry::Named(values.iter().map(|&i| names[i].text.clone()).collect()),
        };
        let cosine = values.iter().map(|&i| names[i].meaning == Some(Meaning::Dsf)).collect();
        let left_out = beside.iter().map(|&i| quoted(&names[i].text)).collect();
        Ok(Self { columns: names.len(), angles, degrees, values, cosine, colorimetry, left_out })
    }
}

/// Refuses columns that would be taken for values of f and are none.
fn expect_value_of_f(name: &Name) -> std::result::Result<(), String> {
    let found = quoted(&name.text);
    match (name.meaning, name.unit.as_deref()) {
        (Some(Meaning::Wavelength), _) => Err(format!(
            "expected one row a pair of directions and one column a wavelength (450nm), found a column {found}"
        )),
        (Some(Meaning::HalfAngle), _) => Err(format!(
            "expected angles of the incident and the scattered direction, found a column {found}"
        )),
        (None | Some(Meaning::Bsdf | Meaning::Dsf), Some(unit)) if is_no_unit_of_f(unit) => {
            Err(format!("expected values in 1/sr, found a column {found}"))
        }
        _ => Ok(()),
    }
}

/// The data under way.
pub(super) struct Rows {
    layout: Layout,
    /// Known from the first row.
    separator: Option<Separator>,
    decimal: Decimal,
    /// Of the row under way.
    values: Vec<f32>,
    /// What makes spectra of its values, and the spectrum.
    sorted: Option<(Sorted, Vec<f32>)>,
    gathered: Gathered,
}

impl Rows {
    /// None yet.
    pub(super) fn new(layout: Layout) -> Self {
        Self {
            layout,
            separator: None,
            decimal: Decimal::default(),
            values: Vec::new(),
            sorted: None,
            gathered: Gathered::default(),
        }
    }

    /// Makes spectra of columns that are all named after wavelengths.
    ///
    /// Errors: as [`Sorted::of`].
    fn sort(&mut self) -> Result<()> {
        self.sorted = Sorted::of(&self.layout.colorimetry)?.map(|sorted| (sorted, Vec::new()));
        Ok(())
    }

    /// Values of a point.
    pub(super) fn channels(&self) -> usize {
        self.layout.values.len() + usize::from(self.sorted.is_some())
    }

    /// Adds the row in `line`.
    pub(super) fn take(&mut self, line: &str) -> std::result::Result<(), String> {
        let layout = &self.layout;
        let separator = *self.separator.get_or_insert_with(|| Separator::of(line, layout.columns));
        let words: Vec<&str> = separator.fields(line).collect();
        if words.len() != layout.columns {
            return Err(separator.miscounted(layout.columns, line));
        }
        let mut angles = [0.0; 4];
        for (k, (_, name)) in ANGLES.into_iter().enumerate() {
            let word = words[layout.angles[k]];
            angles[k] = self.decimal.degrees(word, layout.degrees[k], name)?;
        }
        let [theta_i, phi_i, theta_o, phi_o] = angles;
        let cosine = direction::from_degrees(theta_o, phi_o).z.abs();
        self.values.clear();
        for (&column, &with_cosine) in layout.values.iter().zip(&layout.cosine) {
            let divisor = if with_cosine && cosine >= HORIZON_COSINE { cosine } else { 1.0 };
            self.values.push(self.decimal.value(words[column], divisor)?);
        }
        let values = match &mut self.sorted {
            None => &self.values,
            Some((sorted, spectrum)) => {
                spectrum.clear();
                sorted.add(&self.values, spectrum);
                spectrum
            }
        };
        self.gathered.take((theta_i, phi_i), (theta_o, phi_o), values)
    }

    /// What the values mean, and the rows by incident direction.
    pub(super) fn finish(self, remarks: &mut Vec<Remark>) -> (Colorimetry, Vec<Block>) {
        let colorimetry = self.sorted.map(|(sorted, _)| sorted.colorimetry());
        (colorimetry.unwrap_or(self.layout.colorimetry), self.gathered.finish(remarks))
    }
}
