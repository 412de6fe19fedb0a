//! The interpolant's container: named arrays in a safetensors file. (DESIGN §5)
//!
//! Arrays, little-endian, C order; N counts components from 0, I incidences, L lobes:
//!
//! | array | type | shape | unit |
//! |---|---|---|---|
//! | `component.N.incident` | f64 | \[I, 3\] | unit vectors, away from the surface, front hemisphere |
//! | `component.N.figures` | f64 | \[I, 5\] | floor 1/sr; directional-hemispherical value; relative fit error; largest sin θₒ; points |
//! | `component.N.lobe_start` | u32 | \[I + 1\] | first lobe of each incidence |
//! | `component.N.lobes` | f64 | \[L, 6\] | mass; centre x, y; covariance xx, xy, yy (frame coordinates) |
//! | `component.N.detail` | f16 | \[I, channels, side, side\] | log ratio of data to lobes: control values of a cubic B-spline over \[−1, 1\]², row-major in y, of the scattered direction's (x, y) / √(1 + \|z\|) |
//! | `component.N.detail_step` | f32 | \[I · channels · levels\] | compact files have these three instead: step of each level, coarse to fine |
//! | `component.N.detail_kept` | u8 | \[bytes\] | one bit a tile of 2 × 2 values of each level, lowest first, tiles row-major in y: whether it is kept |
//! | `component.N.detail_tile` | i8 | \[kept, 2, 2\] | in steps, what a level adds to the subdivided one before |
//! | `component.N.seen` | u8 | \[I, 288\] | optional: where directions lie between points, one bit a cell of 48² equal cells of the square of scattered directions, rows of x, lowest bit first |
//! | `component.N.spectra` | f64 | \[2 + rank, bands\] | only of spectra: wavelengths in nm; offset; basis of logarithms over the guide. `detail` then has the guide's channel |
//! | `component.N.coefficient` | f16 | \[I, rank, side, side\] | only of spectra: coefficients of the basis, as `detail` |
//! | `component.N.energy` | f64 | \[K, 4\] | centre x, y, z and weight of the energy correction |
//! | `specular.K.coefficient` | f64 | \[rings, azimuths, 3\] | none; X, Y, Z of the peak of no width K: see [`Curve`](bsdfkit::specular::Curve) |
//! | `component.N.sir` | u8 | \[bytes\] | instead of all others: a Radiance SIR file as it was |
//!
//! The header's `__metadata__` has one key, `bsdfkit`: a JSON text with `kind` ("interpolant"),
//! `version` (7, or 8 where there are peaks of no width, listed under `specular`), `name` and `components` (sides, symmetry,
//! motion, ε, energy constants; in compact files `lattice`, channels and side; if known `expected_error`, L1 between
//! incidences; of spectra `spectral_error`, the basis's relative L1).
//! Files without `seen` were fitted to points all over the hemisphere, as far as they say.
//! Mesh and transport plans follow from these and are made on opening (about 0.1 ms an edge).

use std::collections::HashMap;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;

use bsdfkit::limits::{CONTAINER_BYTES, MAGNITUDE, read_file};
use bsdfkit::{DVec2, DVec3, Error, Result, Side, Specular, replace_file};
use half::f16;
use safetensors::{Dtype, SafeTensors};
use serde::{Deserialize, Serialize};

use crate::interpolant::component::component::Component;
use crate::interpolant::component::fitted::Fitted;
use crate::interpolant::file::arrays::{Array, Arrays};
use crate::interpolant::file::pyramid::Pyramid;
use crate::interpolant::file::spectra;
use crate::interpolant::incidence::fitted::FittedIncidence;
use crate::interpolant::motion::hypothesis::Motion;
use crate::interpolant::whole::{Interpolant, Part, SirPart};
use crate::lobe::detail::Detail;
use crate::lobe::{Covariance, Lobe, LobeSet};
use bsdfkit_measure::{Mirror, Seen, Symmetry};
use bsdfkit_represent::sir::{Plans, Sir, SirLimits};

/// The key of `__metadata__`, shared with compiled BSDFs.
const KEY: &str = "bsdfkit";
/// What this module reads and writes.
const KIND: &str = "interpolant";
/// Version of files; raised when another reader would misread one.
const VERSION: u32 = 7;
/// With peaks of no width, which an older reader would leave out.
const VERSION_OF_PEAKS: u32 = 8;

/// How much a file says of what lobes leave over.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Encoding {
    /// In half precision: 5e-4 of a log ratio.
    #[default]
    Plain,
    /// Within 2 % of f (past the outermost incidences 6 %), in a tenth to a half of the space.
    Compact,
}

#[derive(Serialize, Deserialize)]
struct Header {
    kind: String,
    version: u32,
    #[serde(default)]
    name: Option<String>,
    #[serde(default)]
    components: Vec<Described>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    specular: Vec<bsdfkit::specular::Described>,
}

#[derive(Serialize, Deserialize)]
struct Described {
    front_incident: bool,
    front_scattered: bool,
    #[serde(default)]
    fitted: Option<DescribedFit>,
}

#[derive(Serialize, Deserialize)]
struct DescribedFit {
    symmetry: String,
    motion: Motion,
    epsilon: f64,
    energy_constant: f64,
    energy_slope: f64,
    /// Channels and values across a lattice of compact details.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    lattice: Option<[usize; 2]>,
    /// L1 to expect between incidences.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    expected_error: Option<f64>,
    /// Relative L1 of the basis of spectra; there are some where it is said.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    spectral_error: Option<f64>,
}

pub(crate) const SYMMETRIES: [(&str, Symmetry); 6] = [
    ("isotropic", Symmetry::Isotropic),
    ("quadrilateral", Symmetry::Quadrilateral),
    ("bilateral-x", Symmetry::Bilateral(Mirror::X)),
    ("bilateral-y", Symmetry::Bilateral(Mirror::Y)),
    ("rotational180", Symmetry::Rotational180),
    ("none", Symmetry::None),
];

impl Interpolant {
    /// Writes the container; an existing file is replaced whole or not at all.
    ///
    /// Accuracy: see [`Encoding`]; lobes and energy are exact.
    pub fn save(&self, path: &Path, encoding: Encoding) -> Result<()> {
        let bytes = self.to_bytes(encoding)?;
        replace_file(path, |out| out.write_all(&bytes).map_err(|e| Error::io("writing", &e)))
    }

    /// The container as bytes.
    pub fn to_bytes(&self, encoding: Encoding) -> Result<Vec<u8>> {
        let mut arrays: Vec<(String, Array)> = Vec::new();
        let mut components = Vec::new();
        for (n, part) in self.components.iter().enumerate() {
            let mut push = |name: &str, a: Array| arrays.push((format!("component.{n}.{name}"), a));
            components.push(match part {
                Part::Sir(s) => {
                    let (shape, bytes) = (vec![s.bytes.len()], s.bytes.to_vec());
                    push("sir", Array { dtype: Dtype::U8, shape, bytes });
                    Described {
                        front_incident: s.sir.incident() == Side::Front,
                        front_scattered: s.sir.scattered() == Side::Front,
                        fitted: None,
                    }
                }
                Part::Dense(d) => {
                    let (shape, bytes) = (vec![d.bytes.len()], d.bytes.to_vec());
                    push("tables", Array { dtype: Dtype::U8, shape, bytes });
                    Described {
                        front_incident: d.function.incident() == Side::Front,
                        front_scattered: d.function.scattered() == Side::Front,
                        fitted: None,
                    }
                }
                Part::Transported(c) => {
                    store(c, &mut push);
                    let lattice = store_details(c, encoding, &mut push);
                    described(c, lattice)
                }
            });
        }
        for (k, peak) in self.specular.iter().enumerate() {
            let [rings, azimuths] = peak.coefficient.shape();
            let table = Array::f64(&[rings, azimuths, 3], peak.table());
            arrays.push((format!("specular.{k}.coefficient"), table));
        }
        let specular: Vec<_> = self.specular.iter().map(Specular::described).collect();
        let version = if specular.is_empty() { VERSION } else { VERSION_OF_PEAKS };
        let (kind, name) = (KIND.to_owned(), self.name.clone());
        let header = Header { kind, version, name, components, specular };
        let json = serde_json::to_string(&header)
            .map_err(|e| Error::argument(format!("interpolant cannot be described: {e}")))?;
        let metadata = HashMap::from([(KEY.to_owned(), json)]);
        safetensors::serialize(arrays.iter().map(|(n, a)| (n, a)), Some(metadata))
            .map_err(|e| Error::argument(format!("interpolant cannot be stored: {e}")))
    }

    /// Opens a container.
    ///
    /// Errors: io; format, naming the array; limit above 4 GiB.
    pub fn open(path: &Path) -> Result<Self> {
        let bytes = read_file(path, CONTAINER_BYTES)?;
        Self::from_bytes(&bytes).map_err(|e| e.context(path.display()))
    }

    /// Reads a container.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        let format =
            |e: &dyn std::fmt::Display| Error::format(format!("not a safetensors file: {e}"));
        let (_, meta) = SafeTensors::read_metadata(bytes).map_err(|e| format(&e))?;
        let tensors = SafeTensors::deserialize(bytes).map_err(|e| format(&e))?;
        let json = meta.metadata().as_ref().and_then(|m| m.get(KEY)).ok_or_else(|| {
            Error::format(format!("__metadata__: expected the key \"{KEY}\", found none"))
        })?;
        let header: Header = serde_json::from_str(json)
            .map_err(|e| Error::format(format!("__metadata__.{KEY}: {e}")))?;
        if header.kind != KIND || !(VERSION..=VERSION_OF_PEAKS).contains(&header.version) {
            return Err(Error::format(format!(
                "expected kind \"{KIND}\" version {VERSION} or {VERSION_OF_PEAKS}, found \"{}\" version {}; what another version of \
                 bsdfkit has written must be fitted again",
                header.kind, header.version
            )));
        }
        let peaks = header.specular.iter().enumerate();
        let specular = peaks.map(|(k, described)| restore_peak(&tensors, k, described));
        let specular = specular.collect::<Result<_>>()?;
        let mut interpolant = Self { name: header.name, components: Vec::new(), specular };
        for (n, d) in header.components.iter().enumerate() {
            let arrays = Arrays { tensors: &tensors, prefix: format!("component.{n}") };
            let part = match &d.fitted {
                None if arrays.holds("tables") => tables(d, &arrays)?,
                None => {
                    let bytes = arrays.bytes("sir", Dtype::U8, 1)?.1;
                    let sir = Sir::from_bytes(bytes, Plans::Repaired, SirLimits::default())
                        .map_err(|e| e.context(format!("component.{n}.sir")))?;
                    Part::Sir(SirPart { sir: sir.into(), bytes: bytes.into() })
                }
                Some(f) => Part::Transported(restore(d, f, &arrays)?.into()),
            };
            interpolant.components.push(part);
        }
        Ok(interpolant)
    }
}

fn restore_peak(
    tensors: &SafeTensors<'_>,
    k: usize,
    described: &bsdfkit::specular::Described,
) -> Result<Specular> {
    let arrays = Arrays { tensors, prefix: format!("specular.{k}") };
    let (shape, bytes) = arrays.bytes("coefficient", Dtype::F64, 3)?;
    if shape[2] != 3 {
        return Err(arrays.wrong("coefficient", "3 channels", &shape[2].to_string()));
    }
    let table: Vec<f64> = bytes.as_chunks::<8>().0.iter().map(|b| f64::from_le_bytes(*b)).collect();
    Specular::from_described(described, [shape[0], shape[1]], &table)
        .map_err(|e| Error::format(format!("{}: {e}", arrays.prefix)))
}

/// A function that is kept as its file was.
fn tables(d: &Described, arrays: &Arrays<'_>) -> Result<Part> {
    let bytes = arrays.bytes("tables", Dtype::U8, 1)?.1;
    let place = format!("{}.tables", arrays.prefix);
    let read = Interpolant::from_tables(&place, bytes).ok_or_else(|| {
        Error::format(format!("{place}: expected tables of a known format, found other bytes"))
    })??;
    let side = |front: bool| if front { Side::Front } else { Side::Back };
    let [incident, scattered] = [d.front_incident, d.front_scattered].map(side);
    read.part(incident, scattered).cloned().ok_or_else(|| {
        Error::format(format!("{place}: expected {incident:?} to {scattered:?}, found other sides"))
    })
}

fn described(c: &Component, lattice: Option<[usize; 2]>) -> Described {
    let symmetry = SYMMETRIES.iter().find(|(_, s)| *s == c.symmetry()).map_or("none", |(n, _)| n);
    let (energy_constant, energy_slope, _) = c.energy().parts();
    Described {
        front_incident: c.incident() == Side::Front,
        front_scattered: c.scattered() == Side::Front,
        fitted: Some(DescribedFit {
            symmetry: symmetry.to_owned(),
            motion: c.motion(),
            epsilon: c.fitted().epsilon,
            energy_constant,
            energy_slope,
            lattice,
            expected_error: c.expected_error,
            spectral_error: c.fitted().spectra.as_ref().map(|s| s.error()),
        }),
    }
}

fn store(c: &Component, push: &mut dyn FnMut(&str, Array)) {
    let all = c.incidences();
    let n = all.len();
    push("incident", Array::f64(&[n, 3], all.iter().flat_map(|i| i.wi.to_array())));
    let figures = |i: &FittedIncidence| {
        [i.lobes.floor, i.hemispherical, i.fit_error, i.limit, i.points as f64]
    };
    push("figures", Array::f64(&[n, 5], all.iter().flat_map(figures)));
    let bytes = all.iter().flat_map(|i| i.seen.bytes()).copied().collect();
    push("seen", Array { dtype: Dtype::U8, shape: vec![n, Seen::BYTES], bytes });
    let mut starts = vec![0u32];
    for i in all {
        starts.push(starts[starts.len() - 1] + i.lobes.lobes.len() as u32);
    }
    let total = starts[n] as usize;
    let bytes = starts.iter().flat_map(|s| s.to_le_bytes()).collect();
    push("lobe_start", Array { dtype: Dtype::U32, shape: vec![n + 1], bytes });
    let six = |l: &Lobe| {
        let k = l.covariance;
        [l.mass, l.mean.x, l.mean.y, k.xx, k.xy, k.yy]
    };
    let lobes = all.iter().flat_map(|i| i.lobes.lobes.iter().flat_map(six));
    push("lobes", Array::f64(&[total, 6], lobes));
    if let Some(spectra) = &c.fitted().spectra {
        let (name, array) = spectra::stored(spectra);
        push(name, array);
        let side = all.first().map_or(0, |i| i.coefficients[0].control().len().isqrt());
        let coefficients = all.iter().flat_map(|i| &i.coefficients);
        push("coefficient", lattices(coefficients, [n, spectra.rank(), side]));
    }
    let energy = c.energy().parts().2;
    push("energy", Array::f64(&[energy.len(), 4], energy.into_iter().flatten()));
}

/// Stores what lobes leave over; channels and side if that is compact.
fn store_details(
    c: &Component,
    encoding: Encoding,
    push: &mut dyn FnMut(&str, Array),
) -> Option<[usize; 2]> {
    let all = c.incidences();
    let channels = all.first().map_or(1, |i| i.details.len());
    let side = all.first().map_or(0, |i| i.details[0].control().len().isqrt());
    let details = all.iter().flat_map(|i| &i.details);
    match encoding {
        Encoding::Plain => {
            push("detail", lattices(details, [all.len(), channels, side]));
            None
        }
        Encoding::Compact => {
            Pyramid::of(details).store(push);
            Some([channels, side])
        }
    }
}

/// Lattices in half precision: incidences, channels and values across.
fn lattices<'a>(all: impl Iterator<Item = &'a Detail>, [n, channels, side]: [usize; 3]) -> Array {
    let bytes = all.flat_map(Detail::control).flat_map(|v| f16::from_f32(*v).to_le_bytes());
    let shape = vec![n, channels, side, side];
    Array { dtype: Dtype::F16, shape, bytes: bytes.collect() }
}

/// What each of `n` incidences shows.
fn restore_seen(arrays: &Arrays<'_>, n: usize) -> Result<Vec<Seen>> {
    if !arrays.holds("seen") {
        return Ok(vec![Seen::whole(); n]);
    }
    let (shape, bytes) = arrays.bytes("seen", Dtype::U8, 2)?;
    if shape != [n, Seen::BYTES] {
        let expected = format!("[{n}, {}]", Seen::BYTES);
        return Err(arrays.wrong("seen", &expected, &format!("{shape:?}")));
    }
    Ok(bytes.chunks_exact(Seen::BYTES).filter_map(Seen::from_bytes).collect())
}

/// The details of `n` incidences, channels fastest, and how many channels there are.
fn restore_details(
    f: &DescribedFit,
    arrays: &Arrays<'_>,
    n: usize,
) -> Result<(usize, Vec<Detail>)> {
    if let Some([channels, side]) = f.lattice {
        let count = channels.checked_mul(n).filter(|_| [1, 3].contains(&channels));
        let count = count
            .ok_or_else(|| arrays.wrong("lattice", "1 channel or 3", &channels.to_string()))?;
        return Ok((channels, Pyramid::restore(arrays, count, side)?));
    }
    restore_lattices("detail", arrays, n, &[1, 3])
}

/// Lattices in half precision of `n` incidences, channels fastest, and how many channels there are: one of `expected`.
fn restore_lattices(
    name: &str,
    arrays: &Arrays<'_>,
    n: usize,
    expected: &[usize],
) -> Result<(usize, Vec<Detail>)> {
    let (shape, bytes) = arrays.bytes(name, Dtype::F16, 4)?;
    let (channels, controls) = (shape[1], shape[2] * shape[3]);
    let sound = shape[0] == n && expected.contains(&channels);
    if !sound || shape[2] != shape[3] || shape[2] < 4 {
        let channels: Vec<String> = expected.iter().map(ToString::to_string).collect();
        let expected = format!("[{n}, {} channels, side, side]", channels.join(" or "));
        return Err(arrays.wrong(name, &expected, &format!("{shape:?}")));
    }
    let detail = |bytes: &[u8]| {
        let values = bytes
            .chunks_exact(2)
            .map(|c| f16::from_le_bytes([c[0], c[1]]).to_f32())
            .map(|v| if v.is_finite() { v } else { 0.0 })
            .collect();
        Detail::from_control(values).unwrap_or_else(Detail::none)
    };
    Ok((channels, bytes.chunks_exact(2 * controls).map(detail).collect()))
}

fn restore(d: &Described, f: &DescribedFit, arrays: &Arrays<'_>) -> Result<Component> {
    let symmetry = SYMMETRIES
        .iter()
        .find(|(name, _)| *name == f.symmetry)
        .map(|(_, s)| *s)
        .ok_or_else(|| arrays.wrong("symmetry", "a known symmetry", &f.symmetry))?;
    if let Some((what, expected, found)) = f.motion.wrong() {
        return Err(arrays.wrong(what, expected, &found.to_string()));
    }
    for (what, number) in [
        ("epsilon", f.epsilon),
        ("energy_constant", f.energy_constant),
        ("energy_slope", f.energy_slope),
    ] {
        let least = if what == "epsilon" { 1e-30 } else { -MAGNITUDE };
        if !(least..=MAGNITUDE).contains(&number) {
            let expected = format!("{least:e} to {MAGNITUDE:e}");
            return Err(arrays.wrong(what, &expected, &number.to_string()));
        }
    }
    let incident = arrays.rows::<3>("incident")?;
    let figures = arrays.rows::<5>("figures")?;
    let lobes = arrays.rows::<6>("lobes")?;
    let energy = arrays.rows::<4>("energy")?;
    let n = incident.len();
    let (_, starts) = arrays.bytes("lobe_start", Dtype::U32, 1)?;
    let starts: Vec<usize> = starts
        .chunks_exact(4)
        .map(|c| u32::from_le_bytes(c.try_into().unwrap_or_default()) as usize)
        .collect();
    let ascending = starts.windows(2).all(|w| w[0] <= w[1]);
    if starts.len() != n + 1 || figures.len() != n || !ascending || starts[n] != lobes.len() {
        let found =
            format!("{} starts, {} figures, {} lobes", starts.len(), figures.len(), lobes.len());
        return Err(arrays.wrong("lobe_start", &format!("arrays of {n} incidences"), &found));
    }
    let spectra = spectra::restored(arrays, f.spectral_error)?.map(Arc::new);
    let (channels, details) = restore_details(f, arrays, n)?;
    let (rank, coefficients) = match &spectra {
        Some(spectra) => restore_lattices("coefficient", arrays, n, &[spectra.rank()])?,
        None => (0, Vec::new()),
    };
    let mut coefficients = coefficients.into_iter();
    let mut details = details.into_iter();
    let seen = restore_seen(arrays, n)?;
    let lobe = |r: &[f64; 6]| Lobe {
        mass: r[0].max(0.0),
        mean: DVec2::new(r[1], r[2]),
        covariance: Covariance { xx: r[3], xy: r[4], yy: r[5] }.floored(1e-9),
    };
    let incidences = (0..n)
        .map(|i| FittedIncidence {
            wi: DVec3::from_array(incident[i]),
            lobes: LobeSet {
                floor: figures[i][0].max(0.0),
                lobes: lobes[starts[i]..starts[i + 1]].iter().map(lobe).collect(),
            },
            details: details.by_ref().take(channels).collect(),
            coefficients: coefficients.by_ref().take(rank).collect(),
            points: figures[i][4] as usize,
            hemispherical: figures[i][1],
            fit_error: figures[i][2],
            limit: figures[i][3],
            seen: seen[i].clone(),
        })
        .collect();
    let side = |front| if front { Side::Front } else { Side::Back };
    let (incident, scattered) = (side(d.front_incident), side(d.front_scattered));
    let fitted = Fitted { incident, scattered, symmetry, epsilon: f.epsilon, spectra, incidences };
    let energy = (f.energy_constant, f.energy_slope, energy);
    let component = Component::restored(fitted, f.motion, &energy);
    let mut component = component.map_err(|e| e.context(&arrays.prefix))?;
    component.expected_error = f.expected_error.filter(|e| e.is_finite());
    Ok(component)
}
