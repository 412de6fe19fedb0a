//! The universal BRDF data format of the BiRD project: records in, measurements and records out.
//!
//! `bsdfkit_measure` reads the points of such files. Source: the schemas and the example of
//! github.com/BiRD-project/BiRD_view, version 1.0; what they require and a record does not know is written as `NA`.

use std::io::Write;

use bsdfkit::{Error, Result, Side};
use bsdfkit_measure::{Colorimetry, Measurement};
use bsdfkit_sphere::direction;
use serde_json::{Value, json};

use crate::record::Record;

/// What says which version it is.
const SCHEMA: &str = "https://raw.githubusercontent.com/BiRD-project/BiRD_view/master/BRDF_JSON_schema/brdf_json_schema_v1.0.json";
/// What stands for what is not known.
const UNKNOWN: &str = "NA";

/// What the metadata of a file tell; nothing of an object that is none. A licence that is no SPDX expression, a date or a link
/// that a record cannot hold go into the notes.
pub fn record(file: &Value) -> Option<Record> {
    let metadata = file.get("metadata").filter(|m| m.get("type").is_some_and(|t| t == "BRDF"))?;
    let text = |path: &str| {
        let text = metadata.pointer(path).and_then(Value::as_str).unwrap_or_default().trim();
        if text == UNKNOWN { String::new() } else { text.to_owned() }
    };
    let mut record = Record {
        name: text("/sample/name"),
        maker: text("/sample/manufacturer"),
        class: text("/sample/type"),
        instrument: text("/instrumentation/name"),
        date: text("/timestamp").chars().take(10).collect(),
        licence: text("/license/type"),
        doi: text("/id"),
        notes: [text("/description"), text("/comments")].join(" ").trim().to_owned(),
    };
    // What is not as a record has it is still worth a word.
    let holds = |record: Record| record.checked().is_ok();
    if !holds(Record { licence: record.licence.clone(), ..Record::default() }) {
        record.notes = format!("{} Licence: {}.", record.notes, record.licence).trim().to_owned();
        record.licence = String::new();
    }
    if !holds(Record { date: record.date.clone(), ..Record::default() }) {
        record.date = String::new();
    }
    if !holds(Record { doi: record.doi.clone(), ..Record::default() }) {
        record.doi = String::new();
    }
    record.checked().ok()
}

/// Writes the reflection of the front with what a record says; what the format cannot hold is told.
///
/// Convention: angles away from the surface, azimuths from +X counter-clockwise.
/// Errors: argument without reflection of the front, and for colour, which the format has no word for; io.
pub fn write(
    measurements: &[Measurement],
    record: &Record,
    out: &mut impl Write,
) -> Result<Vec<String>> {
    let is_front = |m: &&Measurement| (m.incident, m.scattered) == (Side::Front, Side::Front);
    let Some(measured) = measurements.iter().find(is_front) else {
        return Err(Error::argument(
            "BiRD: expected reflection of the front, which is all that the format holds, found none",
        ));
    };
    let mut said = Vec::new();
    if measurements.len() > 1 {
        said.push(
            "the format holds reflection of the front alone: the rest is left out".to_owned(),
        );
    }
    // The description first, for whoever looks at the start of a long file.
    let (metadata, data) = (metadata(record, measured, &mut said), data(measured)?);
    write!(out, "{{\"metadata\": {metadata:#},\n\"data\": {data}}}\n")
        .map_err(|e| Error::io("BiRD", &e))?;
    Ok(said)
}

fn metadata(record: &Record, measured: &Measurement, said: &mut Vec<String>) -> Value {
    let known = |text: &str| if text.is_empty() { UNKNOWN.to_owned() } else { text.to_owned() };
    let name = measured.sample_name.clone().unwrap_or_default();
    let name = if record.name.is_empty() { name } else { record.name.clone() };
    // The format wants a second; a record knows a day at best.
    let timestamp = match record.date.len() {
        10 => format!("{}T00:00:00+00", record.date),
        _ => UNKNOWN.to_owned(),
    };
    said.push(
        "NA stands where the format wants what a record does not have: who made the dataset, and where; fill it in"
            .to_owned(),
    );
    let place = ["country", "city", "street", "building_nr", "postal_code"];
    let place: serde_json::Map<_, _> =
        place.iter().map(|field| ((*field).to_owned(), UNKNOWN.into())).collect();
    let mut metadata = json!({
        "schema": SCHEMA,
        "id": if record.doi.is_empty() { UNKNOWN.to_owned() } else { format!("https://doi.org/{}", record.doi) },
        "type": "BRDF",
        "timestamp": timestamp,
        "provenance": {"organization": UNKNOWN, "location": place, "email": UNKNOWN, "contact_person": UNKNOWN},
        "method": "measurement",
        "instrumentation": UNKNOWN,
        "software": UNKNOWN,
        "sample": {
            "name": known(&name),
            "manufacturer": known(&record.maker),
            "properties_symmetry": measured.symmetry.to_string(),
            "zero_azimuth_location": "+X: to the right, seen from the front with +Y up",
        },
        "environment": UNKNOWN,
    });
    if !record.instrument.is_empty() {
        metadata["instrumentation"] = json!({"name": record.instrument});
    }
    if !record.class.is_empty() {
        metadata["sample"]["type"] = json!(record.class);
    }
    if !record.licence.is_empty() {
        metadata["license"] = json!({"type": record.licence, "rights_holder": UNKNOWN});
    }
    if !record.notes.is_empty() {
        metadata["comments"] = json!(record.notes);
    }
    metadata
}

/// One row for each value: of a spectrum one a band.
fn data(measured: &Measurement) -> Result<Value> {
    let (channels, bands): (Vec<usize>, Vec<f64>) = match &measured.colorimetry {
        Colorimetry::Luminance => (vec![0], Vec::new()),
        Colorimetry::Spectral(bands) => {
            ((1..=bands.count()).collect(), bands.nanometres().to_vec())
        }
        other => {
            return Err(Error::argument(format!(
                "BiRD: expected one value a point, or a spectrum, found {other:?}"
            )));
        }
    };
    let mut columns: [Vec<f64>; 4] = Default::default();
    let (mut values, mut wavelengths) = (Vec::new(), Vec::<f64>::new());
    for incidence in &measured.incidences {
        let (theta_i, phi_i) = direction::to_degrees(incidence.wi);
        for (k, wo) in incidence.wo.iter().enumerate() {
            let (theta_r, phi_r) = direction::to_degrees(wo);
            let point = incidence.point(k);
            for (n, channel) in channels.iter().enumerate() {
                let angles = [theta_i, phi_i.rem_euclid(360.0), theta_r, phi_r.rem_euclid(360.0)];
                for (column, angle) in columns.iter_mut().zip(angles) {
                    // A ten-thousandth of a second of arc: what is beyond are rounding errors.
                    column.push((angle * 1e7).round() / 1e7 % 360.0);
                }
                // As short as it is: the digits that single precision has.
                values.push(point[*channel].to_string().parse::<f64>().unwrap_or(f64::NAN));
                wavelengths.extend(bands.get(n));
            }
        }
    }
    let [theta_i, phi_i, theta_r, phi_r] =
        columns.map(|values| json!({"unit": "deg", "values": values}));
    let mut data = json!({
        "theta_i": theta_i, "phi_i": phi_i, "theta_r": theta_r, "phi_r": phi_r,
        "BRDF": {"unit": "sr^-1", "values": values},
    });
    if !bands.is_empty() {
        data["wavelength_i"] = json!({"unit": "nm", "values": wavelengths});
    }
    Ok(data)
}
