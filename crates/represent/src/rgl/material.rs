//! A file as it is stored: reflection of the front at a grid of incident directions.

use std::f64::consts::{PI, TAU};

use bsdfkit::Xyz;
use bsdfkit::limits::is_plausible;
use bsdfkit::spectrum::{self, Illuminant, View};
use bsdfkit_sphere::{DVec2, DVec3};

use super::half_vector::reflected;
use super::tensor::{Stored, read_tensors};
use super::warp::Warp;

/// Values at nodes, linear between them; rows are y, the last of each row and column on the far border.
#[derive(Debug)]
pub(super) struct Grid {
    width: usize,
    values: Vec<f32>,
}

/// What the values of a node are.
#[derive(Clone, Debug, PartialEq)]
pub enum Bands {
    /// Linear RGB of sRGB's primaries.
    Rgb,
    /// Wavelengths, nm.
    Wavelengths(Vec<f32>),
}

/// What of a table was not passed on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Left {
    /// Nodes that the file calls invalid.
    pub invalid: usize,
    /// Nodes that are negative as a whole.
    pub negative: usize,
    /// Other nodes with R, G or B below 0: colours outside of sRGB's gamut.
    pub outside: usize,
    /// X, Y, Z or bands below 0 of other nodes: taken as 0.
    pub cut: usize,
    /// Nodes along or below the horizon.
    pub below: usize,
    /// Whether the file's mask says 1 for what is invalid.
    pub inverted: bool,
}

/// A file.
#[derive(Debug)]
pub struct Material {
    /// Its words, as they stand in the file.
    pub description: String,
    /// Incident polar angles and azimuths, radians, rising.
    pub(super) thetas: Vec<f64>,
    pub(super) phis: Vec<f64>,
    /// Distribution of normals and projected area; without them values are f cos θo as they are.
    factors: Option<(Grid, Grid)>,
    /// By azimuth, then polar angle.
    pub(super) warps: Vec<Warp>,
    /// What its channels are.
    pub bands: Bands,
    /// Nodes of a row of values.
    width: usize,
    /// Nodes of one table.
    nodes: usize,
    /// By azimuth, polar angle, channel, row, column.
    values: Vec<f32>,
    /// One a node, if the file has a mask.
    valid: Option<Vec<bool>>,
}

/// One node of one incidence.
pub struct Point {
    /// Scattered direction, unit.
    pub wo: DVec3,
    /// f in 1/sr: X, Y, Z of RGB, else one a wavelength.
    pub values: Vec<f32>,
}

/// Points nearer to the horizon (as a cosine) belong to neither side.
const HORIZON_COSINE: f64 = 1e-4;

impl Material {
    /// Reads a file.
    ///
    /// Errors: the message, naming tensor, expected and found.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, String> {
        let tensors = read_tensors(bytes)?;
        let find = |name: &str| tensors.iter().find(|t| t.name == name);
        let need = |name: &str| {
            let names: Vec<&str> = tensors.iter().map(|t| t.name).collect();
            find(name)
                .ok_or_else(|| format!("expected a tensor {name}, found {}", names.join(", ")))
        };
        let thetas = rising(need("theta_i")?, 0.0..=PI / 2.0 + 1e-4)?;
        let phis = rising(need("phi_i")?, -TAU - 1e-4..=TAU + 1e-4)?;
        let slices = [phis.len(), thetas.len()];
        let vndf = need("vndf")?;
        let [warp_height, warp_width] = expect_shape(vndf, &slices)?;
        let densities = vndf.numbers()?;
        let mut warps = Vec::new();
        for (k, density) in densities.chunks_exact(warp_height * warp_width).enumerate() {
            // What is between values that are all above 0 is, too; zeros are kept, rounding below them is not.
            let density: Vec<f64> = density.iter().map(|v| f64::from(v.max(0.0))).collect();
            if !density.iter().any(|v| *v > 0.0) {
                return Err(format!("vndf: expected light at incidence {k}, found zeros"));
            }
            warps.push(Warp::new(warp_width, density));
        }
        let (bands, table) = match (find("spectra"), find("rgb")) {
            (Some(spectra), _) => {
                let wavelengths = rising(
                    need("wavelengths")?,
                    spectrum::Bands::RANGE[0]..=spectrum::Bands::RANGE[1],
                )?;
                (Bands::Wavelengths(wavelengths.iter().map(|w| *w as f32).collect()), spectra)
            }
            (None, Some(rgb)) => (Bands::Rgb, rgb),
            (None, None) => need("rgb").map(|rgb| (Bands::Rgb, rgb))?,
        };
        let channels = bands.count();
        let [height, width] = expect_shape(table, &[slices[0], slices[1], channels])?;
        let values = table.numbers()?;
        let jacobian = find("jacobian").is_none_or(|t| t.octets().is_ok_and(|b| b != [0]));
        let factors = match jacobian {
            true => Some((Grid::of(need("ndf")?)?, Grid::of(need("sigma")?)?)),
            false => None,
        };
        let description = find("description").and_then(|t| t.octets().ok()).unwrap_or_default();
        let description = String::from_utf8_lossy(description).trim().to_owned();
        let nodes = width * height;
        let valid = match find("valid") {
            Some(mask) => Some(bits(mask, nodes * warps.len())?),
            None => None,
        };
        Ok(Self { description, thetas, phis, factors, warps, bands, width, nodes, values, valid })
    }

    /// Whether azimuths count only by their difference.
    pub fn is_isotropic(&self) -> bool {
        self.phis.len() == 1
    }

    /// How many incident directions it has tables of.
    pub fn slices(&self) -> usize {
        self.warps.len()
    }

    /// How many of the file's azimuths make a whole turn: 1, or 2 and 4 of a material with that symmetry.
    pub(super) fn copies(&self) -> usize {
        let span = self.phis.last().unwrap_or(&0.0) - self.phis.first().unwrap_or(&0.0);
        match (TAU / span.max(1e-9)).round() as usize {
            copies @ (2 | 4) if !self.is_isotropic() => copies,
            _ => 1,
        }
    }

    /// The incident directions off the horizon that differ, with the slice of each.
    pub fn incidences(&self) -> Vec<(usize, DVec3)> {
        let mut incidences: Vec<(usize, DVec3)> = Vec::new();
        for (p, phi) in self.phis.iter().enumerate() {
            for (t, theta) in self.thetas.iter().enumerate() {
                let wi = direction(*theta, *phi);
                let known = || incidences.iter().any(|(_, w)| (*w - wi).length() < 1e-5);
                // The last azimuth is the first again, and along the normal all are one.
                let again = p > 0 && (*theta < 1e-5 || (p + 1 == self.phis.len() && known()));
                if wi.z > HORIZON_COSINE && !again {
                    incidences.push((p * self.thetas.len() + t, wi));
                }
            }
        }
        incidences
    }

    /// Whether the file's mask says 1 for what is invalid: then it does so more often below the horizon than above.
    pub fn mask_is_inverted(&self) -> bool {
        let Some(mask) = &self.valid else { return false };
        let (mut marked, mut all) = ([0_usize; 2], [0_usize; 2]);
        for (slice, wi) in self.incidences() {
            let own = &mask[slice * self.nodes..][..self.nodes];
            for ((wo, _), is_marked) in self.places(slice, wi).into_iter().zip(own) {
                let above = usize::from(wo.z > HORIZON_COSINE);
                all[above] += 1;
                marked[above] += usize::from(*is_marked);
            }
        }
        marked[0] * all[1] > marked[1] * all[0]
    }

    /// f at the nodes of `slice`, whose light comes from `wi`; what was left out is added to `left`.
    pub fn points(&self, slice: usize, wi: DVec3, left: &mut Left) -> Vec<Point> {
        let places = self.places(slice, wi);
        let mask = self.valid.as_ref().map(|v| &v[slice * self.nodes..][..self.nodes]);
        let mut points = Vec::new();
        for (node, (wo, factor)) in places.into_iter().enumerate() {
            if wo.z <= HORIZON_COSINE {
                left.below += 1;
                continue;
            }
            if mask.is_some_and(|mask| mask[node] == left.inverted) {
                left.invalid += 1;
                continue;
            }
            let mut values = self.node(slice, node);
            let guide = match self.bands {
                Bands::Rgb => values[1],
                Bands::Wavelengths(_) => values.iter().sum(),
            };
            if guide < 0.0 {
                left.negative += 1;
                continue;
            }
            left.outside += usize::from(self.bands == Bands::Rgb && self.is_outside(slice, node));
            for value in &mut values {
                left.cut += usize::from(*value < 0.0);
                *value = value.max(0.0) * factor / wo.z;
            }
            if values.iter().all(|v| is_plausible(*v)) {
                points.push(Point { wo, values: values.into_iter().map(|v| v as f32).collect() });
            }
        }
        points
    }

    /// Where each node of `slice` lies, and what its value is to be multiplied with to be f cos θo.
    fn places(&self, slice: usize, wi: DVec3) -> Vec<(DVec3, f64)> {
        let azimuth = if self.is_isotropic() { self.phis[0] } else { 0.0 };
        let last = DVec2::new((self.width - 1) as f64, (self.nodes / self.width - 1) as f64);
        let place = |node: usize| {
            let even = DVec2::new((node % self.width) as f64, (node / self.width) as f64) / last;
            let point = self.warps[slice].at(even).0;
            (reflected(point, wi, azimuth).wo, self.factor(point, wi))
        };
        (0..self.nodes).map(place).collect()
    }

    /// f cos θo by value, at a point of the square of half vectors.
    pub(super) fn factor(&self, point: DVec2, wi: DVec3) -> f64 {
        self.factors
            .as_ref()
            .map_or(1.0, |(ndf, sigma)| ndf.at(point) / (4.0 * sigma.at(square(wi, 0.0))))
    }

    /// The values of one node: X, Y, Z of RGB, else one a wavelength.
    fn node(&self, slice: usize, node: usize) -> Vec<f64> {
        let channels = self.bands.count();
        let at = |c: usize| f64::from(self.values[(slice * channels + c) * self.nodes + node]);
        match self.bands {
            Bands::Rgb => {
                let Xyz { x, y, z } = Xyz::from_linear_rgb([at(0), at(1), at(2)]);
                vec![x, y, z]
            }
            Bands::Wavelengths(_) => (0..channels).map(at).collect(),
        }
    }

    /// Whether R, G or B of a node is below 0.
    fn is_outside(&self, slice: usize, node: usize) -> bool {
        (0..3).any(|c| self.values[(slice * 3 + c) * self.nodes + node] < 0.0)
    }

    /// What is seen of spectra in daylight; `None` of RGB.
    ///
    /// Errors: the message, where the wavelengths do not cover the visible.
    pub(super) fn colour(&self) -> Result<Option<spectrum::Weights>, String> {
        let Bands::Wavelengths(all) = &self.bands else { return Ok(None) };
        let all = all.iter().map(|nm| f64::from(*nm)).collect();
        let weights = spectrum::Bands::new(all)
            .and_then(|bands| View::Colour(Illuminant::D65).weights(&bands));
        weights.map(Some).map_err(|e| e.to_string())
    }

    /// The tables of `slice`, as many as asked for: Y, X and Z, none below 0; of spectra what `colour` makes of them.
    pub(super) fn tables(
        &self,
        slice: usize,
        channels: usize,
        colour: Option<&spectrum::Weights>,
    ) -> Vec<Grid> {
        let mut tables = vec![Vec::with_capacity(self.nodes); channels];
        for node in 0..self.nodes {
            let values = self.node(slice, node);
            let seen: Vec<f64> = match colour {
                Some(weights) => weights.apply(&values).collect(),
                None => values,
            };
            let [x, y, z] = seen[..] else { continue };
            let light = if y < 0.0 { 0.0 } else { 1.0 };
            for (table, value) in tables.iter_mut().zip([y, x, z]) {
                table.push((light * value.max(0.0)) as f32);
            }
        }
        tables.into_iter().map(|values| Grid { width: self.width, values }).collect()
    }

    /// Whether R, G and B differ anywhere; spectra may.
    pub(super) fn is_coloured(&self) -> bool {
        let tables = self.values.chunks_exact(3 * self.nodes);
        self.bands != Bands::Rgb
            || tables.into_iter().any(|t| {
                (0..self.nodes).any(|k| t[k] != t[self.nodes + k] || t[k] != t[2 * self.nodes + k])
            })
    }
}

impl Bands {
    fn count(&self) -> usize {
        match self {
            Self::Rgb => 3,
            Self::Wavelengths(all) => all.len(),
        }
    }
}

/// The point of the square that a direction stands for; its azimuth counts from `azimuth`.
pub(super) fn square(w: DVec3, azimuth: f64) -> DVec2 {
    let theta = w.truncate().length().atan2(w.z);
    let y = (w.y.atan2(w.x) - azimuth + PI) / TAU;
    DVec2::new((2.0 * theta / PI).max(0.0).sqrt(), y - y.floor())
}

fn direction(theta: f64, phi: f64) -> DVec3 {
    let (sin, cos) = theta.sin_cos();
    DVec3::new(sin * phi.cos(), sin * phi.sin(), cos)
}

/// Angles or wavelengths: finite, rising, within `range`.
fn rising(tensor: &Stored<'_>, range: std::ops::RangeInclusive<f64>) -> Result<Vec<f64>, String> {
    let name = tensor.name;
    let values: Vec<f64> = tensor.numbers()?.into_iter().map(f64::from).collect();
    if tensor.shape.len() != 1 || values.is_empty() {
        return Err(format!("{name}: expected a list of numbers, found shape {:?}", tensor.shape));
    }
    if let Some(out) = values.iter().find(|v| !range.contains(v)) {
        let (least, most) = range.into_inner();
        return Err(format!("{name}: expected numbers from {least:.4} to {most:.4}, found {out}"));
    }
    match values.windows(2).find(|w| w[0] >= w[1]) {
        Some(w) => Err(format!("{name}: expected rising numbers, found {} after {}", w[1], w[0])),
        None => Ok(values),
    }
}

/// Rows and columns of tables, of which there are as many as `outer` says.
fn expect_shape(tensor: &Stored<'_>, outer: &[usize]) -> Result<[usize; 2], String> {
    let shape = &tensor.shape;
    match shape.strip_prefix(outer) {
        Some(&[height, width]) if height >= 2 && width >= 2 => Ok([height, width]),
        _ => Err(format!(
            "{}: expected shape {outer:?} and rows and columns of at least 2, found {shape:?}",
            tensor.name
        )),
    }
}

/// One bit a node, the highest of each byte first.
fn bits(mask: &Stored<'_>, count: usize) -> Result<Vec<bool>, String> {
    let bytes = mask.octets()?;
    if bytes.len() != count.div_ceil(8) {
        return Err(format!(
            "valid: expected {count} bits in {} bytes, found {}",
            count.div_ceil(8),
            bytes.len()
        ));
    }
    Ok((0..count).map(|k| bytes[k / 8] >> (7 - k % 8) & 1 == 1).collect())
}

impl Grid {
    fn of(tensor: &Stored<'_>) -> Result<Self, String> {
        let [_, width] = expect_shape(tensor, &[])?;
        Ok(Self { width, values: tensor.numbers()? })
    }

    /// The value at a point of the unit square.
    pub(super) fn at(&self, point: DVec2) -> f64 {
        let height = self.values.len() / self.width;
        let cell = |along: f64, nodes: usize| {
            let along = along.clamp(0.0, 1.0) * (nodes - 1) as f64;
            let k = (along as usize).min(nodes - 2);
            (k, along - k as f64)
        };
        let ((i, x), (j, y)) = (cell(point.x, self.width), cell(point.y, height));
        let value = |i: usize, j: usize| f64::from(self.values[j * self.width + i]);
        let row = |j: usize| (1.0 - x) * value(i, j) + x * value(i + 1, j);
        (1.0 - y) * row(j) + y * row(j + 1)
    }
}
