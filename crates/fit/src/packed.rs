//! Measured points as named arrays in a safetensors file: for programs that read no goniophotometer files.
//!
//! Keeps what a picture needs: sides, symmetry, incidences, directions and luminance; names of files, other channels and notes
//! are left out. Little-endian, C order; N counts components from 0:
//!
//! | array | type | shape | unit |
//! |---|---|---|---|
//! | `component.N.incident` | f64 | \[incidences, 3\] | unit vectors away from the surface |
//! | `component.N.points` | u32 | \[incidences\] | how many points each has |
//! | `component.N.scattered` | f32 | \[points, 3\] | unit vectors away from the surface |
//! | `component.N.values` | f32 | \[points\] | f in 1/sr, luminance |
//!
//! The header's `__metadata__` has one key, `bsdfkit`: a JSON text with `kind` ("measurement"), `version` (1), `name` and
//! `components`: of each `front_incident`, `front_scattered` and `symmetry`.

use std::collections::HashMap;

use bsdfkit::{DVec3, Error, Result, Side};
use safetensors::{Dtype, SafeTensors};
use serde::{Deserialize, Serialize};

use crate::interpolant::file::arrays::{Array, Arrays};
use crate::interpolant::file::container::SYMMETRIES;
use crate::measurement::{Colorimetry, Incidence, Measurement};

/// The key of `__metadata__`.
const KEY: &str = "bsdfkit";
/// What these files say that they are.
const KIND: &str = "measurement";
const VERSION: u32 = 1;

#[derive(Debug, Serialize, Deserialize)]
struct Header {
    kind: String,
    version: u32,
    name: Option<String>,
    components: Vec<Described>,
}

#[derive(Debug, Serialize, Deserialize)]
struct Described {
    front_incident: bool,
    front_scattered: bool,
    symmetry: String,
}

fn side(front: bool) -> Side {
    if front { Side::Front } else { Side::Back }
}

/// The file's content.
///
/// Accuracy: points in single precision, as they are kept.
/// Errors: argument where it cannot be stored.
pub fn to_bytes(measurements: &[Measurement]) -> Result<Vec<u8>> {
    let mut arrays: Vec<(String, Array)> = Vec::new();
    let mut components = Vec::new();
    for (n, m) in measurements.iter().enumerate() {
        let mut push = |name: &str, a: Array| arrays.push((format!("component.{n}.{name}"), a));
        let (count, points) = (m.incidences.len(), m.points());
        let channel = m.colorimetry.luminance_channel();
        push(
            "incident",
            Array::f64(&[count, 3], m.incidences.iter().flat_map(|i| i.wi.to_array())),
        );
        let counts = m.incidences.iter().flat_map(|i| (i.wo.len() as u32).to_le_bytes());
        push("points", Array { dtype: Dtype::U32, shape: vec![count], bytes: counts.collect() });
        let single = |c: f64| (c as f32).to_le_bytes();
        let wo = m.incidences.iter().flat_map(|i| i.wo.iter()).flat_map(|w| w.to_array());
        let bytes = wo.flat_map(single).collect();
        push("scattered", Array { dtype: Dtype::F32, shape: vec![points, 3], bytes });
        let bytes = m.incidences.iter().flat_map(|i| i.channel(channel)).flat_map(single).collect();
        push("values", Array { dtype: Dtype::F32, shape: vec![points], bytes });
        let symmetry = SYMMETRIES.iter().find(|(_, s)| *s == m.symmetry);
        components.push(Described {
            front_incident: m.incident == Side::Front,
            front_scattered: m.scattered == Side::Front,
            symmetry: symmetry.map_or("none", |(name, _)| name).to_owned(),
        });
    }
    let name = measurements.iter().find_map(|m| m.sample_name.clone());
    let header = Header { kind: KIND.to_owned(), version: VERSION, name, components };
    let stored = |e: &dyn std::fmt::Display| Error::argument(format!("cannot be stored: {e}"));
    let json = serde_json::to_string(&header).map_err(|e| stored(&e))?;
    let metadata = HashMap::from([(KEY.to_owned(), json)]);
    safetensors::serialize(arrays.iter().map(|(n, a)| (n, a)), Some(metadata))
        .map_err(|e| stored(&e))
}

/// Whether this is such a file's content, by its header.
pub fn holds(bytes: &[u8]) -> bool {
    bsdfkit::container::kind_of_bytes(bytes).as_deref() == Some(KIND)
}

/// Reads such a file's content.
///
/// Errors: format, naming the array.
pub fn from_bytes(bytes: &[u8]) -> Result<Vec<Measurement>> {
    let format = |e: &dyn std::fmt::Display| Error::format(format!("not a safetensors file: {e}"));
    let (_, metadata) = SafeTensors::read_metadata(bytes).map_err(|e| format(&e))?;
    let tensors = SafeTensors::deserialize(bytes).map_err(|e| format(&e))?;
    let json = metadata.metadata().as_ref().and_then(|m| m.get(KEY)).ok_or_else(|| {
        Error::format(format!("__metadata__: expected the key \"{KEY}\", found none"))
    })?;
    let header: Header = serde_json::from_str(json)
        .map_err(|e| Error::format(format!("__metadata__.{KEY}: {e}")))?;
    if (header.kind.as_str(), header.version) != (KIND, VERSION) {
        return Err(Error::format(format!(
            "expected kind \"{KIND}\" version {VERSION}, found \"{}\" version {}",
            header.kind, header.version
        )));
    }
    let component = |(n, described): (usize, &Described)| {
        let arrays = Arrays { tensors: &tensors, prefix: format!("component.{n}") };
        component(described, &arrays, header.name.clone())
    };
    header.components.iter().enumerate().map(component).collect()
}

fn component(
    described: &Described,
    arrays: &Arrays<'_>,
    name: Option<String>,
) -> Result<Measurement> {
    let symmetry = SYMMETRIES.iter().find(|(word, _)| *word == described.symmetry);
    let Some((_, symmetry)) = symmetry else {
        return Err(arrays.wrong("symmetry", "a known one", &described.symmetry));
    };
    let incident = arrays.rows::<3>("incident")?;
    let (shape, counts) = arrays.bytes("points", Dtype::U32, 1)?;
    let counts: Vec<usize> = words(counts, u32::from_le_bytes).map(|n| n as usize).collect();
    if shape[0] != incident.len() {
        let (expected, found) = (format!("{} numbers", incident.len()), shape[0].to_string());
        return Err(arrays.wrong("points", &expected, &found));
    }
    let (directions, wo) = arrays.bytes("scattered", Dtype::F32, 2)?;
    let (values_shape, values) = arrays.bytes("values", Dtype::F32, 1)?;
    let total: usize = counts.iter().sum();
    if directions != [total, 3] || values_shape != [total] {
        let found = format!("{directions:?} directions and {values_shape:?} values");
        return Err(arrays.wrong("scattered", &format!("{total} points"), &found));
    }
    let mut wo = words(wo, f32::from_le_bytes).map(f64::from);
    let mut values = words(values, f32::from_le_bytes).map(f64::from);
    if let Some(bad) = wo.clone().chain(values.clone()).find(|v| !v.is_finite()) {
        return Err(arrays.wrong("scattered", "finite numbers", &bad.to_string()));
    }
    let mut next =
        || DVec3::new(wo.next().unwrap_or(0.0), wo.next().unwrap_or(0.0), wo.next().unwrap_or(0.0));
    let incidences = incident.iter().zip(counts).map(|(wi, count)| {
        let wo: Vec<DVec3> = (0..count).map(|_| next()).collect();
        Incidence::new(DVec3::from_array(*wi), wo, values.by_ref().take(count))
    });
    Ok(Measurement {
        incident: side(described.front_incident),
        scattered: side(described.front_scattered),
        colorimetry: Colorimetry::Luminance,
        symmetry: *symmetry,
        incidences: incidences.collect(),
        sample_name: name,
        notes: Vec::new(),
    })
}

fn words<T>(bytes: &[u8], word: impl Fn([u8; 4]) -> T + Clone) -> impl Iterator<Item = T> + Clone {
    bytes.as_chunks::<4>().0.iter().map(move |b| word(*b))
}
