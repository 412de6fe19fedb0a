//! Optical data of others: totals, and a record where the file tells of the component.

use std::collections::BTreeMap;

use bsdfkit::{Error, Result};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::place::Place;
use crate::record::Record;

/// Directional-hemispherical values that somebody states: shares of the light that comes from one direction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Total {
    /// The side that the light falls on: `prime`, `nonPrime`; empty where the file does not say.
    pub surface: String,
    /// Of which light: `visible`, `solar`, ….
    pub band: String,
    /// Polar angle of the light, degrees.
    pub polar: f64,
    /// Azimuth of the light, degrees from the prime direction.
    pub azimuth: Option<f64>,
    /// Share reflected into the hemisphere.
    pub reflectance: Option<f64>,
    /// Share transmitted into the hemisphere.
    pub transmittance: Option<f64>,
}

/// What a file of BED-JSON shares with a catalogue.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OpticalData {
    /// What it tells of the component: name, maker, class, method, date, identifiers.
    pub record: Record,
    /// Its directional-hemispherical values of whole bands.
    pub totals: Vec<Total>,
    /// What was passed over: how many points, of which kind.
    pub passed_over: Vec<String>,
}

/// More values of one file are refused.
const MOST: usize = 10_000;
/// Shares of light as measured: what noise does to 0 and 1 is allowed.
const SHARE: (f64, f64) = (-0.1, 1.1);
/// Bands that the format has a name for.
const BANDS: [&str; 5] = ["visible", "solar", "infrared", "ultraviolet", "other"];
/// An enumeration of the format.
const HEMISPHERICAL: &str = "hemispherical";

/// Whether a file of JSON has the shape of BED-JSON, good or not: optical data, a component or components.
pub fn is_bed(file: &Value) -> bool {
    let first = |name: &str| file.get(name).and_then(Value::as_array).map(|a| a.first());
    file.get("optical").is_some_and(Value::is_array)
        || first("components").is_some()
        || first("data").flatten().is_some_and(|first| first.get("dataPoints").is_some())
}

/// Reads optical data, alone or those of one component.
///
/// Errors: format, with the place in the file: what is not as the schema has it; more than one component; no
/// directional-hemispherical values of whole bands, with what was found instead. Limit: more than 10,000 of them.
pub fn read(file: &Value) -> Result<OpticalData> {
    let root = Place::root(file);
    let mut read = OpticalData::default();
    let mut passed = BTreeMap::new();
    let component = match root.get("components") {
        None => root,
        Some(components) => {
            let mut all = components.items()?;
            match (all.next(), all.next()) {
                (Some(one), None) => one,
                _ => return Err(components.expected("one component")),
            }
        }
    };
    match component.get("optical") {
        None => read.add(&component.field("data")?, &mut passed)?,
        Some(optical) => {
            for set in optical.items()? {
                for data in set.field("data")?.items()? {
                    read.add(&data.field("data")?, &mut passed)?;
                }
                read.record = std::mem::take(&mut read.record).or(&of_set(&set));
            }
        }
    }
    let told = of_component(&component);
    let notes = format!("{} {}", told.notes, read.record.notes).trim().to_owned();
    read.record = kept(Record { notes, ..told.or(&read.record) });
    read.passed_over = passed.iter().map(|(kind, count)| format!("{count} of {kind}")).collect();
    if read.totals.is_empty() {
        let found = match read.passed_over.join(", ") {
            none if none.is_empty() => "none".to_owned(),
            some => some,
        };
        return Err(Error::format(format!(
            "BED-JSON: expected directional-hemispherical reflectance or transmittance of a band, found points: {found}"
        )));
    }
    Ok(read)
}

impl OpticalData {
    /// All points of an array of data.
    fn add(&mut self, data: &Place<'_>, passed: &mut BTreeMap<&str, usize>) -> Result<()> {
        for set in data.items()? {
            let surface = match set.get("componentCharacteristics").and_then(|c| c.get("surface")) {
                None => "",
                Some(place) => place
                    .text()
                    .filter(|s| ["prime", "nonPrime"].contains(s))
                    .ok_or_else(|| place.expected("\"prime\" or \"nonPrime\""))?,
            };
            for point in set.field("dataPoints")?.items()? {
                match total(&point, surface)? {
                    Ok(total) => self.totals.push(total),
                    Err(kind) => *passed.entry(kind).or_default() += 1,
                }
                if self.totals.len() > MOST {
                    return Err(Error::limit(format!("BED-JSON: expected at most {MOST} values")));
                }
            }
        }
        Ok(())
    }
}

/// A point that is a total, or which kind it is.
fn total(point: &Place<'_>, surface: &str) -> Result<std::result::Result<Total, &'static str>> {
    let incidence = point.field("incidence")?;
    let (from, wavelengths) = (incidence.field("direction")?, incidence.field("wavelengths")?);
    let into = point.field("emergence")?.field("direction")?;
    let results = point.field("results")?;
    let share = |name| results.get(name).map(|p| p.number(SHARE.0, SHARE.1)).transpose();
    let (reflectance, transmittance) = (share("reflectance")?, share("transmittance")?);
    let band = match wavelengths.get("integral") {
        Some(integral) => {
            let known = BANDS.iter().find(|band| integral.text() == Some(**band));
            *known.ok_or_else(|| integral.expected(&format!("one of {}", BANDS.join(", "))))?
        }
        None => {
            wavelengths.field("wavelength")?.number(0.0, 1e9)?;
            ""
        }
    };
    let light = match from.text() {
        Some(HEMISPHERICAL) => None,
        Some(_) => return Err(from.expected("an object or \"hemispherical\"")),
        None => {
            let azimuth = from.get("azimuth").map(|a| a.number(0.0, 360.0)).transpose()?;
            Some((from.field("polar")?.number(0.0, 90.0)?, azimuth))
        }
    };
    match into.text() {
        Some(HEMISPHERICAL) => (),
        Some("diffuse") => return Ok(Err("light scattered by more than 10°")),
        Some(_) => return Err(into.expected("an object, \"diffuse\" or \"hemispherical\"")),
        None => {
            into.field("polar")?.number(-360.0, 360.0)?;
            return Ok(Err("light into one direction"));
        }
    }
    let Some((polar, azimuth)) = light else { return Ok(Err("light from the whole hemisphere")) };
    if band.is_empty() {
        return Ok(Err("single wavelengths"));
    }
    if let Some(polarization) = incidence.get("polarization") {
        // Both halves alike: no polarisation.
        let half = |name| polarization.get(name).map(|p| p.number(-1.0, 2.0)).transpose();
        let (s, p) = (half("s")?, half("p")?);
        if s.is_none() || s != p {
            return Ok(Err("polarised light"));
        }
    }
    if reflectance.is_none() && transmittance.is_none() {
        return Ok(Err("absorptance or emittance"));
    }
    let (surface, band) = (surface.to_owned(), band.to_owned());
    Ok(Ok(Total { surface, band, polar, azimuth, reflectance, transmittance }))
}

/// What a component tells of itself: its name and its maker, and of a file of IGSDB what it calls them.
fn of_component(component: &Place<'_>) -> Record {
    let at = |names: &[&str]| text_at(component, names);
    let igsdb = |name| at(&["serverSpecific", "igsdb", name]);
    let first = |options: [String; 2]| options.into_iter().find(|o| !o.is_empty());
    let kinds = component.get("categories").and_then(|c| c.get("componentType"));
    let kinds = kinds.and_then(|k| k.items().ok()).map(|kinds| {
        kinds.filter_map(|kind| kind.text().map(str::to_owned)).collect::<Vec<_>>().join(", ")
    });
    let id = identifier(component);
    let notes = [
        first([at(&["description"]), igsdb("shortDescription")]).unwrap_or_default(),
        if id.is_empty() { id } else { format!("Component {id}.") },
    ];
    kept(Record {
        name: first([at(&["name"]), igsdb("marketingName")]).unwrap_or_default(),
        maker: at(&["roles", "manufacturer", "name"]),
        class: kinds.unwrap_or_default(),
        notes: notes.join(" ").trim().to_owned(),
        ..Record::default()
    })
}

/// What a data set tells: when and how it was made.
fn of_set(set: &Place<'_>) -> Record {
    let at = |names: &[&str]| text_at(set, names);
    let date = [at(&["timestamp"]), at(&["createdAt"])].into_iter().find(|d| !d.is_empty());
    let id = identifier(set);
    let notes = if id.is_empty() { id } else { format!("Data set {id}.") };
    kept(Record {
        instrument: at(&["appliedMethod", "method", "name"]),
        date: date.unwrap_or_default().chars().take(10).collect(),
        notes: [at(&["description"]), notes].join(" ").trim().to_owned(),
        ..Record::default()
    })
}

/// A text some fields further in; empty if there is none.
fn text_at(place: &Place<'_>, names: &[&str]) -> String {
    let inner = names.iter().try_fold(place.clone(), |place, name| place.get(name));
    inner.and_then(|p| p.text().map(|t| t.trim().to_owned())).unwrap_or_default()
}

/// An identifier stands alone or with who issued it.
fn identifier(place: &Place<'_>) -> String {
    let alone = text_at(place, &["id"]);
    if alone.is_empty() { text_at(place, &["id", "value"]) } else { alone }
}

/// What a record cannot hold is left out, cut to what fits.
fn kept(record: Record) -> Record {
    let mut record = record.cut();
    let date = Record { date: record.date.clone(), ..Record::default() };
    if date.checked().is_err() {
        record.date = String::new();
    }
    record
}
