//! The universal BRDF data format of the BiRD project, JSON.

use std::collections::{HashMap, HashSet};

use bsdfkit::Result;
use bsdfkit::limits::{MAGNITUDE, is_plausible};
use serde::Deserialize;

use super::Whole;
use crate::Colorimetry;
use crate::block::{FileContent, Remark};
use crate::gather::Gathered;

/// A file: what it says of its origin, and columns of one length.
#[derive(Deserialize)]
struct File {
    #[serde(default)]
    metadata: Metadata,
    data: Data,
}

#[derive(Default, Deserialize)]
struct Metadata {
    #[serde(default)]
    sample: Sample,
}

#[derive(Default, Deserialize)]
struct Sample {
    name: Option<String>,
}

#[derive(Deserialize)]
struct Data {
    theta_i: Column,
    phi_i: Column,
    theta_r: Column,
    phi_r: Column,
    #[serde(rename = "BRDF")]
    brdf: Column,
    wavelength_i: Option<Column>,
    polarization_i: Option<Polarization>,
    /// Uncertainties, which no fit asks for yet, and variables that change what a row means.
    #[serde(flatten)]
    other: HashMap<String, serde_json::Value>,
}

#[derive(Deserialize)]
struct Column {
    unit: String,
    values: Vec<f64>,
}

#[derive(Deserialize)]
struct Polarization {
    values: Vec<State>,
}

/// In letters, or as a Stokes vector of intensity 1.
#[derive(Deserialize)]
#[serde(untagged)]
enum State {
    Letter(String),
    Stokes(Vec<f64>),
}

/// How light of a row is polarised: the mean of s and p is that of light that is not.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Light {
    Unpolarised,
    S,
    P,
}

impl State {
    fn light(&self) -> std::result::Result<Light, String> {
        match self {
            Self::Letter(letter) if letter == "u" => Ok(Light::Unpolarised),
            Self::Letter(letter) if letter == "s" => Ok(Light::S),
            Self::Letter(letter) if letter == "p" => Ok(Light::P),
            Self::Stokes(v) if v[..] == [1.0, 0.0, 0.0, 0.0] => Ok(Light::Unpolarised),
            Self::Stokes(v) if v[..] == [1.0, 1.0, 0.0, 0.0] => Ok(Light::S),
            Self::Stokes(v) if v[..] == [1.0, -1.0, 0.0, 0.0] => Ok(Light::P),
            Self::Letter(other) => Err(format!("expected u, s or p, found {other:?}")),
            Self::Stokes(other) => {
                Err(format!("expected light that is not, s- or p-polarised, found {other:?}"))
            }
        }
    }
}

impl Column {
    /// The values times what the unit stands for.
    fn scaled(&self, name: &str, units: &[(&str, f64)]) -> std::result::Result<Vec<f64>, String> {
        let Some((_, factor)) = units.iter().find(|(unit, _)| *unit == self.unit) else {
            let known: Vec<&str> = units.iter().map(|(unit, _)| *unit).collect();
            let known = known.join(", ");
            return Err(format!(
                "{name}: expected one of the units {known}, found {:?}",
                self.unit
            ));
        };
        Ok(self.values.iter().map(|v| v * factor).collect())
    }
}

const ANGLES: &[(&str, f64)] = &[("°", 1.0), ("deg", 1.0), ("rad", 180.0 / std::f64::consts::PI)];
const LENGTHS: &[(&str, f64)] = &[("nm", 1.0), ("μm", 1000.0), ("µm", 1000.0), ("um", 1000.0)];
const PER_STERADIAN: &[(&str, f64)] = &[("1/sr", 1.0), ("sr^-1", 1.0)];

/// As of Cornell's files: five times those of an instrument that steps by 1 nm from 380 to 780.
const MOST_BANDS: usize = 2000;

/// One pair of directions: its values by wavelength, each with the light that it was measured in.
#[derive(Default)]
struct Row {
    values: Vec<(u64, Light, f64)>,
}

/// Reads such a file: columns `theta_i phi_i theta_r phi_r BRDF` and, where they are, `wavelength_i polarization_i`; every
/// pair of directions at all wavelengths, s- and p-polarised light both or neither.
///
/// Convention: zenith and azimuth of both directions away from the surface, from a mark on the specimen, as Nicodemus
/// defines f. Source: `BRDF_JSON_schema/data_json_schema_v1.0.json` of github.com/BiRD-project/BiRD_view.
/// Errors: class format, naming the column, expected and found.
pub(super) fn read(whole: &Whole<'_>) -> Result<FileContent> {
    let file: File =
        serde_json::from_slice(whole.bytes).map_err(|e| whole.error(format!("JSON: {e}")))?;
    let rows = u64::try_from(file.data.brdf.values.len()).unwrap_or(u64::MAX);
    whole.budget.spend_all(rows, 1, whole.path)?;
    content(&file, whole).map_err(|text| whole.error(text))
}

fn content(file: &File, whole: &Whole<'_>) -> std::result::Result<FileContent, String> {
    let data = &file.data;
    let mut remarks = Vec::new();
    for name in data.other.keys() {
        // What is constant has no column.
        match name.as_str() {
            "uBRDF" => remarks.push(Remark::of_file("uncertainties (uBRDF) left out".to_owned())),
            _ => {
                return Err(format!(
                    "data: expected no variable but directions, wavelength and polarisation of the light, found {name:?}"
                ));
            }
        }
    }
    let angles = [
        ("theta_i", &data.theta_i),
        ("phi_i", &data.phi_i),
        ("theta_r", &data.theta_r),
        ("phi_r", &data.phi_r),
    ];
    let mut columns = Vec::new();
    for (name, column) in angles {
        columns.push((name, column.scaled(name, ANGLES)?));
    }
    let values = data.brdf.scaled("BRDF", PER_STERADIAN)?;
    let wavelengths = match &data.wavelength_i {
        Some(column) => Some(column.scaled("wavelength_i", LENGTHS)?),
        None => None,
    };
    let lengths = columns.iter().map(|(name, column)| (*name, column.len()));
    let lengths = lengths.chain(wavelengths.iter().map(|w| ("wavelength_i", w.len())));
    let states = data.polarization_i.iter().map(|p| ("polarization_i", p.values.len()));
    for (name, found) in lengths.chain(states) {
        if found != values.len() {
            return Err(format!(
                "{name}: expected {} values as of BRDF, found {found}",
                values.len()
            ));
        }
    }
    if values.is_empty() {
        return Err("BRDF: expected values, found none".to_owned());
    }
    for (name, column) in &columns {
        if let Some(k) = column.iter().position(|v| !(-360.0..=360.0).contains(v)) {
            return Err(format!("{name}: value {}: expected degrees, found {}", k + 1, column[k]));
        }
    }

    if let Some(k) = values.iter().position(|v| !is_plausible(*v)) {
        return Err(format!(
            "BRDF: value {}: expected f of at most {MAGNITUDE:e} per steradian, found {:e}",
            k + 1,
            values[k]
        ));
    }
    let mut order: Vec<[u64; 4]> = Vec::new();
    let mut all: HashMap<[u64; 4], Row> = HashMap::new();
    for (k, value) in values.iter().enumerate() {
        let key = [0, 1, 2, 3].map(|c| columns[c].1[k].to_bits());
        let light = match &data.polarization_i {
            Some(p) => p.values[k].light().map_err(|e| format!("polarization_i: {e}"))?,
            None => Light::Unpolarised,
        };
        let nm = wavelengths.as_ref().map_or(0.0, |w| w[k]);
        let row = all.entry(key).or_insert_with(|| {
            order.push(key);
            Row::default()
        });
        row.values.push((nm.to_bits(), light, *value));
    }
    let bands: HashSet<u64> = all.values().flat_map(|row| row.values.iter().map(|v| v.0)).collect();
    let mut bands: Vec<f64> = bands.into_iter().map(f64::from_bits).collect();
    bands.sort_by(f64::total_cmp);
    if bands.len() > MOST_BANDS {
        let found = bands.len();
        return Err(format!(
            "wavelength_i: expected at most {MOST_BANDS} wavelengths, found {found}"
        ));
    }

    let mut gathered = Gathered::default();
    let mut spectrum = Vec::new();
    let mut is_one_sided = false;
    for key in &order {
        let [a, b, c, d] = key.map(f64::from_bits);
        spectrum.clear();
        let means = all[key].means();
        for nm in &bands {
            let (value, both) = means.at(*nm).map_err(|text| {
                format!("theta_i {a} phi_i {b} theta_r {c} phi_r {d}{}: {text}", named(*nm))
            })?;
            is_one_sided |= !both;
            spectrum.push(value as f32);
        }
        gathered.take((a, b), (c, d), &spectrum)?;
    }
    if is_one_sided {
        let text = "some values are of s- or p-polarised light alone, and taken as they are";
        remarks.push(Remark::of_file(text.to_owned()));
    }
    let colorimetry = match wavelengths {
        Some(_) => Colorimetry::Named(bands.iter().map(|nm| format!("{nm}nm")).collect()),
        None => Colorimetry::Luminance,
    };
    let blocks = gathered.finish(&mut remarks);
    let (path, sample_name) = (whole.path.to_owned(), file.metadata.sample.name.clone());
    Ok(FileContent { path, sample_name, colorimetry, wavelength: None, blocks, remarks })
}

fn named(nm: f64) -> String {
    if nm == 0.0 { String::new() } else { format!(" at {nm} nm") }
}

impl Row {
    /// Means of what was measured more than once.
    fn means(&self) -> Means {
        let mut sums: HashMap<(u64, Light), (f64, u32)> = HashMap::new();
        for (nm, light, value) in &self.values {
            let (sum, count) = sums.entry((*nm, *light)).or_default();
            *sum += value;
            *count += 1;
        }
        Means(sums.into_iter().map(|(key, (sum, count))| (key, sum / f64::from(count))).collect())
    }
}

/// Of one pair of directions, by wavelength and light.
struct Means(HashMap<(u64, Light), f64>);

impl Means {
    /// The value at a wavelength, of light that is not polarised, and whether it is known for such.
    fn at(&self, nm: f64) -> std::result::Result<(f64, bool), String> {
        let of = |light: Light| self.0.get(&(nm.to_bits(), light)).copied();
        match (of(Light::Unpolarised), of(Light::S), of(Light::P)) {
            (Some(value), ..) => Ok((value, true)),
            (None, Some(s), Some(p)) => Ok((0.5 * (s + p), true)),
            (None, Some(one), None) | (None, None, Some(one)) => Ok((one, false)),
            (None, None, None) => {
                Err("expected a value at every wavelength, found none".to_owned())
            }
        }
    }
}
