//! The class `Bsdf`: the five verbs over arrays.

use std::collections::BTreeMap;
use std::path::PathBuf;

use bsdfkit::xml::{self, WriteOptions};
use bsdfkit::{Components, DVec2, DVec3, Part, Side, Xyz, container, reciprocity};
use bsdfkit_fit::deliver::Subject;
use bytemuck::cast_slice;
use numpy::{PyArrayDyn, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PySlice, PyTuple};

use crate::array::{Argument, Output, broadcast, empty, finished};
use crate::error::{argument, raised};
use crate::look;
use crate::material::{Component, Metadata, side_name};
use crate::tabulate::{Labels, Wanted, save_rgl, tabulated};

/// Results whose colours or samples are held at a time, beside the arrays they go to: 4 MB.
const CHUNK: usize = 1 << 16;

/// A BSDF of tensor trees, matrices or (`Interpolant`) continuous functions: immutable, shared by any number of threads.
///
/// Directions are unit vectors that point away from the surface, in the frame +Z front normal, +Y up;
/// shape (..., 3), float64. The leading axes of all arguments broadcast, and are those of the result:
/// single directions give plain numbers. NaN in, NaN out.
#[pyclass(frozen, subclass, module = "bsdfkit")]
pub(crate) struct Bsdf(bsdfkit::Bsdf);

impl From<bsdfkit::Bsdf> for Bsdf {
    fn from(bsdf: bsdfkit::Bsdf) -> Self {
        Self(bsdf)
    }
}

/// `bsdfkit.Components` or the integer of its bits; everything by default.
fn selection(components: Option<&Bound<'_, PyAny>>) -> PyResult<Components> {
    let Some(given) = components else { return Ok(Components::ALL) };
    let (all, front, back) = (Components::ALL, Components::FRONT, Components::BACK);
    let bits = given.extract::<u8>().ok().filter(|bits| *bits <= all.bits()).ok_or_else(|| {
        let found = given.repr().map(|r| r.to_string()).unwrap_or_default();
        argument(format!("components: expected a combination of bsdfkit.Components, found {found}"))
    })?;
    // `from_bits` takes no side for both; here `FRONT & BACK` is neither.
    let mut selected = Components::from_bits(bits | (front.bits() ^ back.bits()));
    for (side, other) in [(front, back), (back, front)] {
        let bit = side.bits() & !other.bits();
        selected = if bits & bit == 0 { selected & other } else { selected };
    }
    Ok(selected)
}

/// The first peak of no width; the next ones are below.
const SPECULAR: i64 = -4;

/// A [`Part`] as an integer: 0 and more number components.
fn part_number(part: Part) -> i64 {
    match part {
        Part::LambertianReflection => -1,
        Part::LambertianTransmission => -2,
        Part::Component(n) => n as i64,
        Part::Specular(n) => SPECULAR - n as i64,
    }
}

/// The part of a sample where nothing is scattered.
const NOTHING: i64 = -3;

/// Names of the negative numbers of parts.
pub(crate) fn part_numbers(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let numbers = PyDict::new(py);
    numbers.set_item("LAMBERTIAN_REFLECTION", part_number(Part::LambertianReflection))?;
    numbers.set_item("LAMBERTIAN_TRANSMISSION", part_number(Part::LambertianTransmission))?;
    numbers.set_item("NOTHING", NOTHING)?;
    numbers.set_item("SPECULAR", SPECULAR)?;
    Ok(numbers)
}

/// Elements of chunk `chunk` of `values`, which holds one for each result or one for all.
fn part_of<T>(values: &[T], chunk: usize, length: usize) -> &[T] {
    if values.len() == 1 { values } else { &values[chunk * CHUNK..][..length] }
}

/// Where samples go.
struct Samples<'a> {
    wo: &'a mut [f64],
    weight: &'a mut [f64],
    pdf: &'a mut [f64],
    part: &'a mut [i64],
}

impl Samples<'_> {
    /// Draws all; `u` holds elements of type `U`.
    fn draw<U: Copy>(
        self,
        wi: &[DVec3],
        u: &[U],
        is_nan: impl Fn(U) -> bool,
        draw: impl Fn(&[DVec3], &[U], &mut [Option<bsdfkit::Sample>]) -> bsdfkit::Result<()>,
    ) -> bsdfkit::Result<()> {
        let mut drawn = vec![None; CHUNK.min(self.weight.len())];
        let chunks = self.wo.chunks_mut(3 * CHUNK).zip(self.weight.chunks_mut(CHUNK));
        let others = self.pdf.chunks_mut(CHUNK).zip(self.part.chunks_mut(CHUNK));
        for (n, ((wo, weight), (pdf, part))) in chunks.zip(others).enumerate() {
            let drawn = &mut drawn[..weight.len()];
            let (wi, u) = (part_of(wi, n, drawn.len()), part_of(u, n, drawn.len()));
            draw(wi, u, drawn)?;
            for (k, sample) in drawn.iter().enumerate() {
                let at = |length: usize| if length == 1 { 0 } else { k };
                let found = match sample {
                    Some(s) => (s.wo, s.weight, s.pdf, part_number(s.part)),
                    None if wi[at(wi.len())].is_nan() || is_nan(u[at(u.len())]) => {
                        (DVec3::NAN, f64::NAN, f64::NAN, NOTHING)
                    }
                    None => (DVec3::NAN, 0.0, 0.0, NOTHING),
                };
                wo[3 * k..][..3].copy_from_slice(&found.0.to_array());
                (weight[k], pdf[k], part[k]) = (found.1, found.2, found.3);
            }
        }
        Ok(())
    }
}

impl Bsdf {
    /// One number for each of the broadcast directions, or `width`; `verb` gets as many directions as results, or one.
    pub(crate) fn numbers<'py>(
        py: Python<'py>,
        directions: &[(&str, &Bound<'py, PyAny>)],
        verb: impl Fn(&[&[DVec3]], &mut [f64]) -> bsdfkit::Result<()> + Sync,
        width: Option<usize>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let given: PyResult<Vec<Argument<'_>>> =
            directions.iter().map(|(name, w)| Argument::directions(name, w)).collect();
        let given = given?;
        let named: Vec<(&str, &Argument<'_>)> =
            directions.iter().zip(&given).map(|((name, _), a)| (*name, a)).collect();
        let shape = broadcast(&named)?;
        let mut output = Output::new(py, &shape, width)?;
        let expanded: PyResult<Vec<_>> = given.iter().map(|a| a.expanded(&shape)).collect();
        let expanded = expanded?;
        let slices: Vec<&[DVec3]> = expanded.iter().map(|a| cast_slice(a)).collect();
        let numbers = output.numbers()?;
        py.detach(|| verb(&slices, numbers)).map_err(|e| raised(&e))?;
        output.finish()
    }

    /// Samples, from elements of `u` with `width` numbers.
    fn samples<'py>(
        py: Python<'py>,
        wi: &Bound<'py, PyAny>,
        u: &Argument<'py>,
        draw: impl Fn(Samples<'_>, &[DVec3], &[f64]) -> bsdfkit::Result<()> + Sync,
    ) -> PyResult<Bound<'py, PyAny>> {
        let wi = Argument::directions("wi", wi)?;
        let shape = broadcast(&[("wi", &wi), ("u", u)])?;
        let mut wo = Output::new(py, &shape, Some(3))?;
        let (mut weight, mut pdf) =
            (Output::new(py, &shape, None)?, Output::new(py, &shape, None)?);
        let part = empty(py, &shape, "int64")?;
        {
            let mut numbers = part.cast::<PyArrayDyn<i64>>()?.try_readwrite()?;
            let samples = Samples {
                wo: wo.numbers()?,
                weight: weight.numbers()?,
                pdf: pdf.numbers()?,
                part: numbers.as_slice_mut().map_err(|e| argument(e.to_string()))?,
            };
            let (wi, u) = (wi.expanded(&shape)?, u.expanded(&shape)?);
            let (wi, u): (&[f64], &[f64]) = (&wi, &u);
            py.detach(|| draw(samples, cast_slice(wi), u)).map_err(|e| raised(&e))?;
        }
        let fields = (wo.finish()?, weight.finish()?, pdf.finish()?, finished(part)?);
        py.import("bsdfkit._types")?.getattr("Sample")?.call1(fields)
    }
}

#[pymethods]
impl Bsdf {
    /// f(wi, wo) in 1/sr, without cosine.
    ///
    /// Args:
    ///     wi: Incident directions, shape (..., 3).
    ///     wo: Scattered directions, shape (..., 3).
    ///     xyz: Colour (CIE X, Y, Z) instead of luminance alone.
    ///     components: Luminance of these `Components` alone; the constant part of each counts as Lambertian.
    ///
    /// Returns:
    ///     Shape (...), or (..., 3) with `xyz`, whose [..., 1] is the luminance; grey data have X = Y = Z.
    #[pyo3(signature = (wi, wo, *, xyz = false, components = None))]
    fn eval<'py>(
        &self,
        py: Python<'py>,
        wi: &Bound<'py, PyAny>,
        wo: &Bound<'py, PyAny>,
        xyz: bool,
        components: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let directions = [("wi", wi), ("wo", wo)];
        if components.is_some() {
            if xyz {
                return Err(argument(
                    "components: expected without xyz: they are told apart in luminance",
                ));
            }
            let components = selection(components)?;
            let values = |w: &[&[DVec3]], f: &mut [f64]| {
                self.0.eval_components_many(w[0], w[1], components, f)
            };
            return Self::numbers(py, &directions, values, None);
        }
        if !xyz {
            return Self::numbers(py, &directions, |w, f| self.0.eval_many(w[0], w[1], f), None);
        }
        let colours = |w: &[&[DVec3]], f: &mut [f64]| {
            let mut colours = vec![Xyz::ZERO; CHUNK.min(f.len() / 3)];
            for (n, f) in f.chunks_mut(3 * CHUNK).enumerate() {
                let colours = &mut colours[..f.len() / 3];
                let length = colours.len();
                self.0.eval_xyz_many(
                    part_of(w[0], n, length),
                    part_of(w[1], n, length),
                    colours,
                )?;
                for (f, c) in f.chunks_exact_mut(3).zip(colours) {
                    f.copy_from_slice(&[c.x, c.y, c.z]);
                }
            }
            Ok(())
        };
        Self::numbers(py, &directions, colours, Some(3))
    }

    /// Wavelengths in nm of the bands of a spectral measurement, shortest first; None of what has none, or not the same in all components.
    #[getter]
    fn wavelengths(&self) -> Option<Vec<f64>> {
        self.0.wavelengths().map(|bands| bands.nanometres().to_vec())
    }

    /// f(wi, wo) in 1/sr of every band, without cosine.
    ///
    /// Args:
    ///     wi: Incident directions, shape (..., 3).
    ///     wo: Scattered directions, shape (..., 3).
    ///
    /// Returns:
    ///     Shape (..., bands), in the order of `wavelengths`; 0 for sides that were not measured. `eval_bands(...) @
    ///     view_weights("solar", wavelengths).T` is what the sun makes of it.
    ///
    /// Raises:
    ///     ArgumentError: No bands.
    fn eval_bands<'py>(
        &self,
        py: Python<'py>,
        wi: &Bound<'py, PyAny>,
        wo: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let count = self.0.expect_wavelengths().map_err(|e| raised(&e))?.count();
        let verb = |w: &[&[DVec3]], out: &mut [f64]| self.0.eval_bands_many(w[0], w[1], out);
        Self::numbers(py, &[("wi", wi), ("wo", wo)], verb, Some(count))
    }

    /// ∫ f |cos θo| dωo of every band: spectral reflectance, transmittance or their sum.
    ///
    /// Args:
    ///     wi: Incident directions, shape (..., 3).
    ///     components: Which `Components` count: `REFLECTION`, `TRANSMISSION`, sides, `SPECULAR`. Lambertian and
    ///         directional-diffuse parts count both if either does; peaks of no width count alike in all bands.
    ///
    /// Returns:
    ///     Shape (..., bands), dimensionless. What bands weigh in light is `directional_hemispherical`; their hue is within 0.2 %.
    ///     About 1 ms a direction, of an interpolant some ms.
    ///
    /// Raises:
    ///     ArgumentError: No bands.
    #[pyo3(signature = (wi, *, components = None))]
    fn directional_hemispherical_bands<'py>(
        &self,
        py: Python<'py>,
        wi: &Bound<'py, PyAny>,
        components: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let components = selection(components)?;
        let count = self.0.expect_wavelengths().map_err(|e| raised(&e))?.count();
        let verb = |w: &[&[DVec3]], out: &mut [f64]| {
            self.0.directional_hemispherical_bands_many(w[0], components, out)
        };
        Self::numbers(py, &[("wi", wi)], verb, Some(count))
    }

    /// Density with which `sample` draws wo: f |cos θo| / total, in 1/sr of solid angle.
    ///
    /// Args:
    ///     wi: Incident directions, shape (..., 3).
    ///     wo: Scattered directions, shape (..., 3).
    ///     components: Which `Components` are drawn from.
    ///
    /// Returns:
    ///     Shape (...); 0 where nothing is scattered.
    #[pyo3(signature = (wi, wo, *, components = None))]
    fn pdf<'py>(
        &self,
        py: Python<'py>,
        wi: &Bound<'py, PyAny>,
        wo: &Bound<'py, PyAny>,
        components: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let components = selection(components)?;
        let verb = |w: &[&[DVec3]], out: &mut [f64]| self.0.pdf_many(w[0], w[1], components, out);
        Self::numbers(py, &[("wi", wi), ("wo", wo)], verb, None)
    }

    /// Value and density at once, for little more than one of them.
    ///
    /// Args:
    ///     wi: Incident directions, shape (..., 3).
    ///     wo: Scattered directions, shape (..., 3).
    ///     components: Which `Components` count and are drawn from.
    ///
    /// Returns:
    ///     A pair of arrays of shape (...): what `eval` and `pdf` say of these components, 1/sr.
    #[pyo3(signature = (wi, wo, *, components = None))]
    fn eval_pdf<'py>(
        &self,
        py: Python<'py>,
        wi: &Bound<'py, PyAny>,
        wo: &Bound<'py, PyAny>,
        components: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let components = selection(components)?;
        let verb = |w: &[&[DVec3]], out: &mut [f64]| {
            self.0.eval_pdf_many(w[0], w[1], components, cast_slice_pairs(out))
        };
        let both = Self::numbers(py, &[("wi", wi), ("wo", wo)], verb, Some(2))?;
        // A scalar index gives numbers where there is no axis but that of the pair.
        let axes: usize = both.getattr("ndim")?.extract()?;
        let column = |n: usize| match axes {
            1 => both.get_item(n),
            _ => both.get_item((py.Ellipsis(), n)),
        };
        Ok((column(0)?, column(1)?))
    }

    /// ∫ f |cos θo| dωo over the selected components: reflectance, transmittance or their sum.
    ///
    /// Args:
    ///     wi: Incident directions, shape (..., 3).
    ///     components: Which `Components` count.
    ///
    /// Returns:
    ///     Shape (...); dimensionless, photopic.
    #[pyo3(signature = (wi, *, components = None))]
    fn directional_hemispherical<'py>(
        &self,
        py: Python<'py>,
        wi: &Bound<'py, PyAny>,
        components: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let components = selection(components)?;
        let verb = |w: &[&[DVec3]], out: &mut [f64]| {
            self.0.directional_hemispherical_many(w[0], components, out)
        };
        Self::numbers(py, &[("wi", wi)], verb, None)
    }

    /// Projected solid angle of the stored cells in sr: smallest and largest.
    ///
    /// Args:
    ///     wi: Incident directions, shape (..., 3).
    ///     wo: Scattered directions, shape (..., 3): then of the cells that the pair falls in;
    ///         without, of all cells that light from `wi` can reach.
    ///
    /// Returns:
    ///     Shape (..., 2): [smallest, largest]; π where nothing but Lambertian parts is stored.
    #[pyo3(signature = (wi, wo = None))]
    fn projected_solid_angle<'py>(
        &self,
        py: Python<'py>,
        wi: &Bound<'py, PyAny>,
        wo: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let directions: Vec<(&str, &Bound<'_, PyAny>)> =
            [("wi", wi)].into_iter().chain(wo.map(|wo| ("wo", wo))).collect();
        let verb = |w: &[&[DVec3]], out: &mut [f64]| {
            self.0.projected_solid_angle_many(w[0], w.get(1).copied(), cast_slice_pairs(out))
        };
        Self::numbers(py, &directions, verb, Some(2))
    }

    /// Draws scattered directions, each from one number.
    ///
    /// A pure function of `u`. It is used along a Hilbert curve: stratified numbers give stratified
    /// directions.
    ///
    /// Args:
    ///     wi: Incident directions, shape (..., 3).
    ///     u: Numbers in [0, 1), shape (...).
    ///     components: Which `Components` are drawn from.
    ///
    /// Returns:
    ///     `Sample` (wo, weight, pdf, part) of arrays with shapes (..., 3), (...), (...), (...). The weight
    ///     f |cos θo| / pdf is the same for every u. Where nothing is scattered, wo is NaN, weight
    ///     and pdf are 0 and part is `Part.NOTHING`.
    #[pyo3(signature = (wi, u, *, components = None))]
    fn sample<'py>(
        &self,
        py: Python<'py>,
        wi: &Bound<'py, PyAny>,
        u: &Bound<'py, PyAny>,
        components: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let components = selection(components)?;
        Self::samples(py, wi, &Argument::numbers(u)?, |samples, wi, u| {
            let draw = |wi: &[DVec3], u: &[f64], out: &mut [Option<bsdfkit::Sample>]| {
                self.0.sample_many(wi, u, components, out)
            };
            samples.draw(wi, u, f64::is_nan, draw)
        })
    }

    /// Draws scattered directions, each from two numbers; otherwise as `sample`.
    ///
    /// Points stratified in the square give stratified directions.
    ///
    /// Args:
    ///     wi: Incident directions, shape (..., 3).
    ///     u: Points of [0, 1)², shape (..., 2).
    ///     components: Which `Components` are drawn from.
    ///
    /// Returns:
    ///     `Sample`, as `sample`.
    #[pyo3(signature = (wi, u, *, components = None))]
    fn sample2<'py>(
        &self,
        py: Python<'py>,
        wi: &Bound<'py, PyAny>,
        u: &Bound<'py, PyAny>,
        components: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let components = selection(components)?;
        Self::samples(py, wi, &Argument::rows("u", u, 2)?, |samples, wi, u| {
            let draw = |wi: &[DVec3], u: &[DVec2], out: &mut [Option<bsdfkit::Sample>]| {
                self.0.sample2_many(wi, u, components, out)
            };
            samples.draw(wi, cast_slice(u), DVec2::is_nan, draw)
        })
    }

    /// The same light in another form: a tensor tree, a Klems matrix, or the render form.
    ///
    /// Components that have the form are copied value by value; totals are kept. What is left out, made up, or
    /// not reached goes to the logger "bsdfkit".
    ///
    /// Args:
    ///     kind: "tensor-tree", "klems-full" (145 directions), "klems-half" (77), "klems-quarter" (41) or
    ///         "render" (tables that move along with peaks, for renderers; saved as .safetensors); None: what the
    ///         consumer reads, else a tensor tree.
    ///     consumer: "window", "energyplus" or "radiance": the bands, directions and fields that this program needs.
    ///     max_error: Share of the scattered light that a tree may put in a wrong place (L1), or to which a
    ///         matrix's means are found; usually 0.01.
    ///     max_leaves: Most values in a tree, 7 bytes each in XML; usually 3 million for anisotropic and 60 000
    ///         for isotropic materials, with `max_error` 16 777 216.
    ///     max_depth: Deepest level of a tree: its leaves are at least 2^-max_depth wide.
    ///     reciprocity: Whether f(wi, wo) and f(wo, wi) of reflection are averaged: "auto" (in trees made of
    ///         interpolants, where both agree), "on" or "off".
    ///     name: Name of the material instead of what is known.
    ///     manufacturer: Who makes it.
    ///     thickness: In metres.
    ///     width: In metres: of the pane that Radiance's pkgBSDF makes.
    ///     height: Likewise.
    ///     properties: Other fields of the material: {"ThermalConductivity": "0.2"}.
    ///     progress: As for `fit`.
    ///
    /// Returns:
    ///     `Bsdf`.
    ///
    /// Raises:
    ///     ArgumentError: A setting makes no sense, or the consumer does not read that kind.
    #[pyo3(signature = (
        kind = None, *, consumer = None, max_error = None, max_leaves = None, max_depth = None,
        reciprocity = None, name = None, manufacturer = None, thickness = None, width = None, height = None,
        properties = None, progress = None
    ))]
    fn tabulate(
        &self,
        py: Python<'_>,
        kind: Option<&str>,
        consumer: Option<&str>,
        max_error: Option<f64>,
        max_leaves: Option<usize>,
        max_depth: Option<u32>,
        reciprocity: Option<&str>,
        name: Option<String>,
        manufacturer: Option<String>,
        thickness: Option<f64>,
        width: Option<f64>,
        height: Option<f64>,
        properties: Option<BTreeMap<String, String>>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let wanted = Wanted { kind, consumer, max_error, max_leaves, max_depth, reciprocity };
        let labels = Labels { name, manufacturer, thickness, width, height, properties };
        let metadata = labels.over(self.0.metadata().clone())?;
        tabulated(py, Subject::Stored(&self.0), &wanted, metadata, progress)
    }

    /// Peaks of no width, a tuple of `Specular`: light that goes all one way, which `eval` leaves out.
    #[getter]
    fn specular<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let kind = py.import("bsdfkit._types")?.getattr("Specular")?;
        let of = |s: &bsdfkit::Specular| {
            let sides = [s.incident, s.scattered].map(side_name);
            let (linear, offset) = (s.law.linear(), s.law.offset().to_array());
            let law = (sides[0], sides[1], s.name(), linear, offset);
            kind.call1((law.0, law.1, law.2, law.3, law.4, s.width_degrees, s.residual))
        };
        PyTuple::new(py, self.0.specular().iter().map(of).collect::<PyResult<Vec<_>>>()?)
    }

    /// Where light of each of the peaks of no width goes, and how much of it.
    ///
    /// Args:
    ///     wi: Incident directions, shape (..., 3).
    ///     components: Which `Components` count.
    ///
    /// Returns:
    ///     (wo, coefficient), shape (..., K, 3) each, K that of `specular`: directions, and shares of the incident light
    ///     as CIE XYZ; NaN and 0 where there is no such peak.
    #[pyo3(signature = (wi, *, components = None))]
    fn specular_peaks<'py>(
        &self,
        py: Python<'py>,
        wi: &Bound<'py, PyAny>,
        components: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let components = selection(components)?;
        let count = self.0.specular().len();
        let width = 3 * count.max(1);
        let rows = |empty: f64, row: fn(&bsdfkit::SpecularPeak) -> [f64; 3]| {
            let verb = |w: &[&[DVec3]], out: &mut [f64]| {
                for (k, out) in out.chunks_exact_mut(width).enumerate() {
                    out.fill(empty);
                    let wi = w[0][if w[0].len() == 1 { 0 } else { k }];
                    for peak in self.0.specular_peaks(wi, components) {
                        out[3 * peak.index..][..3].copy_from_slice(&row(&peak));
                    }
                }
                Ok(())
            };
            let flat = Self::numbers(py, &[("wi", wi)], verb, Some(width))?;
            let mut shape: Vec<usize> = flat.getattr("shape")?.extract()?;
            shape.pop();
            shape.extend([count, 3]);
            let known = flat.call_method1("reshape", (-1, width))?;
            let known =
                known.get_item((PySlice::full(py), PySlice::new(py, 0, 3 * count as isize, 1)))?;
            known.call_method1("reshape", (PyTuple::new(py, shape)?,))
        };
        let wo = rows(f64::NAN, |peak| peak.wo.to_array())?;
        let coefficient = rows(0.0, |peak| {
            let c = peak.coefficient;
            [c.x, c.y, c.z]
        })?;
        Ok((wo, coefficient))
    }

    /// The same light without peaks of no width: each is spread over the narrowest cells of trees or matrices.
    ///
    /// Raises:
    ///     ArgumentError: Components are neither trees nor matrices.
    fn with_peaks_in_cells(&self, py: Python<'_>) -> PyResult<Self> {
        py.detach(|| self.0.with_peaks_in_cells()).map(Self).map_err(|e| raised(&e))
    }

    /// The same light with peaks of no width taken out of narrow cells: mirror-like ones, straight through, and back to the
    /// light. A second time changes nothing.
    fn with_peaks_extracted(&self, py: Python<'_>) -> PyResult<Self> {
        py.detach(|| self.0.with_peaks_extracted()).map(Self).map_err(|e| raised(&e))
    }

    /// Further bands of the file, by name ("Solar", "NIR", …): `band` makes a BSDF of one.
    #[getter]
    fn bands(&self) -> Vec<String> {
        self.0.bands().iter().map(|b| b.name.clone()).collect()
    }

    /// A further band alone, in the place of the visible one.
    ///
    /// Raises:
    ///     ArgumentError: There is none of that name.
    fn band(&self, name: &str) -> PyResult<Self> {
        let alone = bsdfkit_fit::deliver::alone(Subject::Stored(&self.0), name);
        alone.map(Self).map_err(|e| raised(&e))
    }

    /// Stored components, in the order of the file; `Sample.part` numbers them.
    #[getter]
    fn components<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, self.0.components().iter().map(Component::from))
    }

    /// Luminance of the Lambertian parts, dimensionless, shape (2, 2): by incident side (front,
    /// back) and scattered side (front, back); the constant parts of components included.
    #[getter]
    fn lambertian<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let mut output = Output::new(py, &[2, 2], None)?;
        let sides = [Side::Front, Side::Back];
        let pairs = sides.into_iter().flat_map(|incident| sides.map(|to| (incident, to)));
        for (out, (incident, scattered)) in output.numbers()?.iter_mut().zip(pairs) {
            *out = self.0.lambertian().get(incident, scattered).y;
        }
        output.finish()
    }

    /// What the file says about the specimen.
    #[getter]
    fn metadata(&self) -> Metadata {
        self.0.metadata().into()
    }

    /// Writes the BSDF; an existing file is replaced whole or not at all.
    ///
    /// Args:
    ///     path: Ends in .xml (read by Radiance, WINDOW and others), in .safetensors (compiled: keeps
    ///         every bit and opens in milliseconds; further bands are left out, with a warning), or in
    ///         _rgb.bsdf or _spec.bsdf (reflection of the front as RGL's tables, which Mitsuba's `measured`
    ///         and pbrt read; what is left out goes to the logger "bsdfkit").
    ///     digits: Significant digits of values in XML; 9 keep every bit.
    ///
    /// Raises:
    ///     ArgumentError: Another suffix, or what the XML cannot hold.
    ///     IoError: The file cannot be written.
    #[pyo3(signature = (path, *, digits = None))]
    fn save(&self, py: Python<'_>, path: PathBuf, digits: Option<usize>) -> PyResult<()> {
        let suffix = path.extension().and_then(|s| s.to_str()).map(str::to_ascii_lowercase);
        let usual = WriteOptions::default();
        let saved = match suffix.as_deref() {
            Some("xml") => {
                let options = WriteOptions { digits: digits.unwrap_or(usual.digits), ..usual };
                py.detach(|| xml::write(&self.0, &path, &options))
            }
            Some("safetensors") if digits.is_none() => {
                let left_out = self.bands();
                if !left_out.is_empty() {
                    let text =
                        format!("{}: left out: band {}", path.display(), left_out.join(", "));
                    let logger = py.import("logging")?.call_method1("getLogger", ("bsdfkit",))?;
                    logger.call_method1("warning", ("%s", text))?;
                }
                py.detach(|| container::save(&self.0, &path))
            }
            Some("bsdf") if digits.is_none() => {
                return save_rgl(py, Subject::Stored(&self.0), self.0.metadata(), &path);
            }
            Some("safetensors" | "bsdf") => {
                return Err(argument("digits: expected only for XML; other files keep every bit"));
            }
            _ => {
                return Err(argument(format!(
                    "{}: expected a name ending in .xml, .safetensors, _rgb.bsdf or _spec.bsdf",
                    path.display()
                )));
            }
        };
        saved.map_err(|e| raised(&e))
    }

    /// Values on a grid of angles as an `xarray.DataArray`, with units; needs the package xarray.
    ///
    /// Args:
    ///     theta_i: Incident polar angles, degrees.
    ///     phi_i: Incident azimuths, degrees.
    ///     theta_o: Scattered polar angles, degrees.
    ///     phi_o: Scattered azimuths, degrees.
    ///     xyz: With one more dimension "channel": X, Y, Z.
    ///
    /// Returns:
    ///     Dimensions (theta_i, phi_i, theta_o, phi_o), values in 1/sr.
    #[pyo3(signature = (**grid))]
    fn to_xarray<'py>(
        slf: &Bound<'py, Self>,
        grid: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("bsdfkit._xarray")?.getattr("to_xarray")?.call((slf,), grid)
    }

    /// The stored cells that light from one incident direction meets: leaves of a tree, patches of a matrix.
    ///
    /// Args:
    ///     wi: The incident direction, (x, y, z).
    ///     scattered: "front" or "back".
    ///
    /// Returns:
    ///     (middles, outlines, numbers): directions in the cells, shape (N, 3), whose `eval` is the cell's value; along their
    ///     borders, (N, 32, 3); the level of a leaf or the number of a patch, (N,). N is 0 of what is stored otherwise.
    ///
    /// Raises:
    ///     LimitError: More than 2²⁰ cells.
    fn cells<'py>(
        &self,
        py: Python<'py>,
        wi: [f64; 3],
        scattered: &str,
    ) -> PyResult<Bound<'py, PyTuple>> {
        look::cells(py, &self.0, wi, scattered)
    }

    /// Peaks of f |cos θo| for one incident direction, the highest first: at most four, at least 12 degrees apart.
    ///
    /// Args:
    ///     wi: The incident direction, (x, y, z).
    ///     scattered: "front" or "back".
    ///
    /// Returns:
    ///     A list of dicts: "wo" (direction), "f" and "f_cos" there (1/sr), and the full widths of f |cos θo| at half its
    ///     height along the narrowest and the widest great circle, "narrowest_degrees" and "widest_degrees", NaN where it
    ///     stays above half out to the horizon.
    fn peaks<'py>(
        &self,
        py: Python<'py>,
        wi: [f64; 3],
        scattered: &str,
    ) -> PyResult<Vec<Bound<'py, PyDict>>> {
        look::peaks(py, &self.0, wi, scattered)
    }

    /// How far f(wi, wo) is from f(wo, wi), as a share of the light: 0 reciprocal, 1 one way only.
    ///
    /// Args:
    ///     incident: "front" or "back".
    ///     scattered: "front" or "back"; the same for reflection.
    ///
    /// Returns:
    ///     The defect, within about 0.01; None where nothing is scattered that way. Of an `Interpolant` over measured directions, None
    ///     of a transmission.
    fn reciprocity_defect(
        &self,
        py: Python<'_>,
        incident: &str,
        scattered: &str,
    ) -> PyResult<Option<f64>> {
        let (incident, scattered) =
            (look::side("incident", incident)?, look::side("scattered", scattered)?);
        Ok(py.detach(|| reciprocity::defect(&self.0, incident, scattered, 4096)))
    }

    /// Draws a picture on matplotlib (`pip install 'bsdfkit[plot]'`); `bsdfkit.plot.draw` says more.
    ///
    /// Args:
    ///     kind: One of `bsdfkit.plot.KINDS`: "hemisphere", "slice", "lobe", "hemispherical", "patches", "leaves", ….
    ///     options: What that kind takes (`bsdfkit.plot.options`), and output, a file to write.
    ///
    /// Returns:
    ///     The matplotlib figure.
    #[pyo3(signature = (kind = "hemisphere", **options))]
    fn plot<'py>(
        slf: &Bound<'py, Self>,
        kind: &str,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        look::plot(slf.as_any(), kind, options)
    }

    /// The bytes of a compiled container, for the package's own modules that query flat arrays.
    ///
    /// Raises:
    ///     ArgumentError: A component is neither tree, matrix nor render form.
    fn _container<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = py.detach(|| container::to_bytes(&self.0)).map_err(|e| raised(&e))?;
        Ok(PyBytes::new(py, &bytes))
    }

    fn __repr__(&self) -> String {
        let components: Vec<String> = self
            .0
            .components()
            .iter()
            .map(|c| {
                let Component { incident, scattered, representation, .. } = c.into();
                format!("{incident} to {scattered}: {representation}")
            })
            .collect();
        format!("<Bsdf {:?}, {}>", self.0.metadata().name, components.join(", "))
    }
}

/// Rows of two numbers.
fn cast_slice_pairs(numbers: &mut [f64]) -> &mut [[f64; 2]] {
    bytemuck::cast_slice_mut(numbers)
}
