//! The class `Interpolant`: a continuous BSDF made of measurements.

use std::path::PathBuf;

use bsdfkit::matrix::KlemsBasis;
use bsdfkit::tree::Rank;
use bsdfkit::{DVec3, Error, Lambertian, Result, Side};
use bsdfkit_fit::interpolant::{self, Encoding, Part};
use bsdfkit_fit::tabulate::{self, Form, KlemsSettings, Reciprocity, Source, TreeSettings, Watch};
use bytemuck::cast_slice;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use rayon::prelude::*;

use crate::array::{Argument, Output, broadcast};
use crate::bsdf::Bsdf;
use crate::error::{argument, raised};
use crate::material::{Component, Metadata, side_name};
use crate::watch::watched;

/// A continuous BSDF over all directions, made of measurements by displacement interpolation.
///
/// Conventions and shapes are those of `Bsdf`; sides that were not measured are dark.
#[pyclass(frozen, module = "bsdfkit")]
pub(crate) struct Interpolant(interpolant::Interpolant);

impl From<interpolant::Interpolant> for Interpolant {
    fn from(interpolant: interpolant::Interpolant) -> Self {
        Self(interpolant)
    }
}

/// Scattered directions that one thread takes at a time, for each of which an incidence's
/// distribution is prepared anew: 50 µs against 2 ms.
const GRAIN: usize = 4096;

/// Values of one incident direction, `width` (1, or 3: X, Y, Z) a scattered direction.
fn eval_incidence(
    interpolant: &interpolant::Interpolant,
    wi: DVec3,
    wo: &dyn Fn(usize) -> DVec3,
    width: usize,
    out: &mut [f64],
) {
    for side in [Side::Front, Side::Back] {
        let on_side = |k: &usize| Side::of(wo(*k)) == side;
        let members: Vec<usize> = (0..out.len() / width).filter(on_side).collect();
        let directions: Vec<DVec3> = members.iter().map(|&k| wo(k)).collect();
        let part = interpolant.part(Side::of(wi), side);
        let channels = part.map_or(1, Source::channels);
        let mut values = vec![0.0; members.len() * channels];
        if let Some(part) = part.filter(|_| !members.is_empty()) {
            part.slice(wi).eval(&directions, &mut values);
        }
        for ((&k, w), value) in members.iter().zip(directions).zip(values.chunks(channels)) {
            let out = &mut out[k * width..][..width];
            match (value, &mut *out) {
                // Luminance comes first, and stands in the middle of X, Y, Z.
                (&[y, x, z], [to_x, to_y, to_z]) => {
                    (*to_x, *to_y, *to_z) = (x.into(), y.into(), z.into());
                }
                (&[y, ..], out) => out.fill(y.into()),
                ([], out) => out.fill(0.0),
            }
            if wi.is_nan() || w.is_nan() {
                out.fill(f64::NAN);
            }
        }
    }
}

/// Values of all pairs, runs of one incident direction together.
fn eval_all(
    interpolant: &interpolant::Interpolant,
    wi: &[DVec3],
    wo: &[DVec3],
    width: usize,
    out: &mut [f64],
) {
    let at = |w: &[DVec3], n: usize| if w.len() == 1 { w[0] } else { w[n] };
    let mut jobs = Vec::new();
    let (mut first, mut left) = (0, out);
    while !left.is_empty() {
        let most = (left.len() / width).min(GRAIN);
        let same = |k: &usize| at(wi, first + k) == at(wi, first);
        let run = 1 + (1..most).take_while(same).count();
        let (now, later) = left.split_at_mut(run * width);
        jobs.push((first, now));
        (first, left) = (first + run, later);
    }
    jobs.into_par_iter().for_each(|(first, out)| {
        eval_incidence(interpolant, at(wi, first), &|k| at(wo, first + k), width, out);
    });
}

/// A representation that `tabulate` makes.
enum Target {
    Tree(TreeSettings),
    Matrix(KlemsBasis, KlemsSettings),
}

impl Target {
    fn new(
        kind: &str,
        max_error: Option<f64>,
        max_depth: Option<u32>,
        reciprocity: Option<&str>,
    ) -> Result<Self> {
        let basis = match kind {
            "tensor-tree" => {
                let usual = TreeSettings::default();
                return Ok(Self::Tree(TreeSettings {
                    max_error: max_error.unwrap_or(usual.max_error),
                    max_depth: max_depth.or(usual.max_depth),
                    reciprocity: match reciprocity {
                        None | Some("auto") => Reciprocity::Auto,
                        Some("on") => Reciprocity::On,
                        Some("off") => Reciprocity::Off,
                        Some(found) => {
                            return Err(Error::argument(format!(
                                "reciprocity: expected \"auto\", \"on\" or \"off\", found {found:?}"
                            )));
                        }
                    },
                    ..usual
                }));
            }
            "klems-full" => KlemsBasis::full(),
            "klems-half" => KlemsBasis::half(),
            "klems-quarter" => KlemsBasis::quarter(),
            _ => {
                return Err(Error::argument(format!(
                    "kind: expected \"tensor-tree\", \"klems-full\", \"klems-half\" or \"klems-quarter\", found {kind:?}"
                )));
            }
        };
        if max_depth.is_some() || reciprocity.is_some() {
            let text = "max_depth, reciprocity: expected only for a tensor tree";
            return Err(Error::argument(text));
        }
        let tolerance = max_error.unwrap_or(KlemsSettings::default().tolerance);
        Ok(Self::Matrix(basis, KlemsSettings { tolerance, ..KlemsSettings::default() }))
    }

    /// `rank` is that of every tree of the file.
    fn component(&self, part: &Part, rank: Rank, watch: &Watch<'_>) -> Result<bsdfkit::Component> {
        let (incident, scattered) = (part.incident(), part.scattered());
        let form = match self {
            Self::Tree(settings) => {
                // Only reflection has both directions of a pair in one component.
                let reciprocity = match settings.reciprocity {
                    Reciprocity::On if incident != scattered => Reciprocity::Off,
                    asked => asked,
                };
                Form::Tree(TreeSettings { rank: Some(rank), reciprocity, ..*settings })
            }
            Self::Matrix(basis, settings) => Form::Klems(basis.clone(), *settings),
        };
        Ok(tabulate::component(part, &form, watch)?.component)
    }
}

impl From<&Part> for Component {
    fn from(part: &Part) -> Self {
        let (representation, incidences) = match part {
            Part::Transported(c) => ("transport", c.incidences.len()),
            Part::Sir(s) => ("sir", s.sir.nodes().len()),
        };
        Self {
            incident: side_name(part.incident()),
            scattered: side_name(part.scattered()),
            representation: representation.into(),
            coloured: part.channels() > 1,
            incidences: Some(incidences),
            leaves: None,
        }
    }
}

impl Interpolant {
    fn described(&self) -> bsdfkit::Metadata {
        let name = self.0.name.clone().unwrap_or_default();
        bsdfkit::Metadata { name, ..bsdfkit::Metadata::default() }
    }
}

#[pymethods]
impl Interpolant {
    /// f(wi, wo) in 1/sr, without cosine.
    ///
    /// Costs 50 µs an incident direction and 0.5 µs a scattered one: keep equal incident directions
    /// together, or tabulate first.
    ///
    /// Args:
    ///     wi: Incident directions, shape (..., 3).
    ///     wo: Scattered directions, shape (..., 3).
    ///     xyz: Colour (CIE X, Y, Z) instead of luminance alone.
    ///
    /// Returns:
    ///     Shape (...), or (..., 3) with `xyz`, whose [..., 1] is the luminance; grey data have X = Y = Z.
    #[pyo3(signature = (wi, wo, *, xyz = false))]
    fn eval<'py>(
        &self,
        py: Python<'py>,
        wi: &Bound<'py, PyAny>,
        wo: &Bound<'py, PyAny>,
        xyz: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (wi, wo) = (Argument::directions("wi", wi)?, Argument::directions("wo", wo)?);
        let shape = broadcast(&[("wi", &wi), ("wo", &wo)])?;
        let width = if xyz { 3 } else { 1 };
        let mut output = Output::new(py, &shape, xyz.then_some(3))?;
        let (wi, wo) = (wi.expanded(&shape)?, wo.expanded(&shape)?);
        let (wi, wo): (&[f64], &[f64]) = (&wi, &wo);
        let out = output.numbers()?;
        py.detach(|| eval_all(&self.0, cast_slice(wi), cast_slice(wo), width, out));
        output.finish()
    }

    /// Averages the continuous BSDF over the cells of a tensor tree or of a Klems matrix.
    ///
    /// Args:
    ///     kind: "tensor-tree", "klems-full" (145 directions), "klems-half" (77) or "klems-quarter" (41).
    ///     max_error: Share of the scattered light that may be in a wrong place (L1); usually 0.01.
    ///     max_depth: Deepest level of a tree: its leaves are at least 2^-max_depth wide.
    ///     reciprocity: Whether a tree of reflection averages f(wi, wo) and f(wo, wi): "auto" (where
    ///         both agree), "on" or "off".
    ///     name: Name of the material instead of the measurement's.
    ///     manufacturer: Who makes it.
    ///     thickness: In metres.
    ///     progress: As for `fit`.
    ///
    /// Returns:
    ///     `Bsdf`.
    ///
    /// Raises:
    ///     ArgumentError: A setting makes no sense.
    #[pyo3(signature = (
        kind = "tensor-tree", *, max_error = None, max_depth = None, reciprocity = None, name = None,
        manufacturer = None, thickness = None, progress = None
    ))]
    fn tabulate(
        &self,
        py: Python<'_>,
        kind: &str,
        max_error: Option<f64>,
        max_depth: Option<u32>,
        reciprocity: Option<&str>,
        name: Option<String>,
        manufacturer: Option<String>,
        thickness: Option<f64>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Bsdf> {
        let target =
            Target::new(kind, max_error, max_depth, reciprocity).map_err(|e| raised(&e))?;
        let thickness = thickness.unwrap_or(0.0);
        if !(thickness.is_finite() && thickness >= 0.0) {
            return Err(argument(format!(
                "thickness: expected metres of at least 0, found {thickness}"
            )));
        }
        let usual = self.described();
        let metadata = bsdfkit::Metadata {
            name: name.unwrap_or(usual.name),
            manufacturer: manufacturer.unwrap_or_default(),
            thickness,
            ..bsdfkit::Metadata::default()
        };
        let parts = &self.0.components;
        let rank = if parts.iter().all(Source::isotropic) { Rank::Three } else { Rank::Four };
        let components = watched(py, progress, kind, |watch| {
            parts.iter().map(|part| target.component(part, rank, watch)).collect::<Result<_>>()
        })?;
        Ok(bsdfkit::Bsdf::new(metadata, components, Lambertian::default()).into())
    }

    /// Writes the interpolant; an existing file is replaced whole or not at all.
    ///
    /// Args:
    ///     path: Ends in .safetensors; for XML, `tabulate` first.
    ///     compact: A tenth to a half of the space, values within 2 %.
    ///
    /// Raises:
    ///     ArgumentError: Another suffix.
    ///     IoError: The file cannot be written.
    #[pyo3(signature = (path, *, compact = false))]
    fn save(&self, py: Python<'_>, path: PathBuf, compact: bool) -> PyResult<()> {
        if path.extension().is_none_or(|s| !s.eq_ignore_ascii_case("safetensors")) {
            return Err(argument(format!(
                "{}: expected a name ending in .safetensors; for XML, tabulate first",
                path.display()
            )));
        }
        let encoding = if compact { Encoding::Compact } else { Encoding::Plain };
        py.detach(|| self.0.save(&path, encoding)).map_err(|e| raised(&e))
    }

    /// Parts, one for each measured pair of sides.
    #[getter]
    fn components<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, self.0.components.iter().map(Component::from))
    }

    /// What the measurement says about the specimen: its name.
    #[getter]
    fn metadata(&self) -> Metadata {
        (&self.described()).into()
    }

    /// Values on a grid of angles as an `xarray.DataArray`; see `Bsdf.to_xarray`.
    #[pyo3(signature = (**grid))]
    fn to_xarray<'py>(
        slf: &Bound<'py, Self>,
        grid: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("bsdfkit._xarray")?.getattr("to_xarray")?.call((slf,), grid)
    }

    fn __repr__(&self) -> String {
        let parts = self.0.components.iter().map(|p| {
            let c = Component::from(p);
            format!("{} to {}: {}", c.incident, c.scattered, c.representation)
        });
        let parts: Vec<String> = parts.collect();
        let name = self.0.name.as_deref().unwrap_or_default();
        format!("<Interpolant {name:?}, {}>", parts.join(", "))
    }
}
