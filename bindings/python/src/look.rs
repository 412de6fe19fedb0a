//! What pictures and reports show beside values: cells, peaks, meshes, families, coverage.

use bsdfkit::{DVec3, OUTLINE, Side};
use bsdfkit_fit::Maximum;
use bsdfkit_fit::interpolant::{Component, Coverage};
use bsdfkit_represent::Followed;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use rayon::prelude::*;

use crate::array::{Argument, Output, broadcast, empty};
use crate::error::{argument, raised};
use crate::material::side_name;

/// The side of that name.
///
/// Errors: argument, for another word.
pub(crate) fn side(name: &str, given: &str) -> PyResult<Side> {
    [Side::Front, Side::Back]
        .into_iter()
        .find(|s| side_name(*s) == given)
        .ok_or_else(|| argument(format!("{name}: expected \"front\" or \"back\", found {given:?}")))
}

/// Directions along an edge of a mesh, both ends included.
const PATH: usize = 13;

/// Rows of directions.
fn directions<'py>(
    py: Python<'py>,
    shape: &[usize],
    all: impl IntoIterator<Item = DVec3>,
) -> PyResult<Bound<'py, PyAny>> {
    let mut output = Output::new(py, shape, Some(3))?;
    for (out, w) in output.numbers()?.chunks_exact_mut(3).zip(all) {
        out.copy_from_slice(&w.to_array());
    }
    output.finish()
}

fn numbers<'py>(
    py: Python<'py>,
    shape: &[usize],
    all: impl IntoIterator<Item = f64>,
) -> PyResult<Bound<'py, PyAny>> {
    let mut output = Output::new(py, shape, None)?;
    for (out, number) in output.numbers()?.iter_mut().zip(all) {
        *out = number;
    }
    output.finish()
}

/// Integers as int64, in rows of `width`.
fn integers<'py>(
    py: Python<'py>,
    shape: &[usize],
    all: impl IntoIterator<Item = i64>,
) -> PyResult<Bound<'py, PyAny>> {
    use numpy::{PyArrayDyn, PyArrayMethods};
    let array = empty(py, shape, "int64")?;
    {
        let mut out = array.cast::<PyArrayDyn<i64>>()?.try_readwrite()?;
        let out = out.as_slice_mut().map_err(|e| argument(e.to_string()))?;
        for (out, number) in out.iter_mut().zip(all) {
            *out = number;
        }
    }
    Ok(array)
}

/// (middles, outlines, numbers) of the cells that light from `wi` meets.
pub(crate) fn cells<'py>(
    py: Python<'py>,
    bsdf: &bsdfkit::Bsdf,
    wi: [f64; 3],
    scattered: &str,
) -> PyResult<Bound<'py, PyTuple>> {
    let scattered = side("scattered", scattered)?;
    let cells = bsdf.cells(DVec3::from_array(wi), scattered).map_err(|e| raised(&e))?;
    let n = cells.len();
    let fields = (
        directions(py, &[n], cells.iter().map(|c| c.middle))?,
        directions(py, &[n, OUTLINE], cells.iter().flat_map(|c| c.outline))?,
        integers(py, &[n], cells.iter().map(|c| i64::from(c.number)))?,
    );
    fields.into_pyobject(py)
}

/// Peaks of one incident direction as dicts.
pub(crate) fn peaks<'py>(
    py: Python<'py>,
    bsdf: &bsdfkit::Bsdf,
    wi: [f64; 3],
    scattered: &str,
) -> PyResult<Vec<Bound<'py, PyDict>>> {
    let scattered = side("scattered", scattered)?;
    let found = py.detach(|| bsdfkit_fit::peaks(bsdf, DVec3::from_array(wi), scattered));
    let one = |m: &Maximum| {
        let peak = PyDict::new(py);
        peak.set_item("wo", directions(py, &[], [m.direction])?)?;
        peak.set_item("f", m.f)?;
        peak.set_item("f_cos", m.height)?;
        peak.set_item("narrowest_degrees", m.widths_degrees[0])?;
        peak.set_item("widest_degrees", m.widths_degrees[1])?;
        Ok(peak)
    };
    found.iter().map(one).collect()
}

/// What was fitted of one component, its mesh included, as a dict.
pub(crate) fn fitted<'py>(py: Python<'py>, c: &Component) -> PyResult<Bound<'py, PyDict>> {
    let (incidences, mesh, extent) = (c.incidences(), c.mesh(), c.extent());
    let n = incidences.len();
    let (vertices, triangles, edges) =
        (&mesh.vertices, mesh.topology.triangles(), mesh.topology.edges());
    let facing = |w: DVec3| c.incident().facing(w);
    let said = PyDict::new(py);
    said.set_item("symmetry", c.symmetry().to_string())?;
    said.set_item("wi", directions(py, &[n], incidences.iter().map(|i| facing(i.wi)))?)?;
    said.set_item("points", integers(py, &[n], incidences.iter().map(|i| i.points as i64))?)?;
    said.set_item(
        "lobes",
        integers(py, &[n], incidences.iter().map(|i| i.lobes.lobes.len() as i64))?,
    )?;
    said.set_item("fit_l1", numbers(py, &[n], incidences.iter().map(|i| i.fit_error))?)?;
    said.set_item("seen", numbers(py, &[n], incidences.iter().map(|i| i.seen_share()))?)?;
    said.set_item("hemispherical", numbers(py, &[n], incidences.iter().map(|i| i.hemispherical))?)?;
    let limits = incidences.iter().map(|i| i.limit.clamp(0.0, 1.0).asin().to_degrees());
    said.set_item("limit_degrees", numbers(py, &[n], limits)?)?;
    said.set_item("expected_l1", c.expected_error)?;
    said.set_item("extrapolated", extent.extrapolated)?;
    said.set_item("incidence_extrapolated", extent.incidence_extrapolated)?;
    said.set_item(
        "vertices",
        directions(py, &[vertices.len()], vertices.iter().map(|v| facing(v.wi)))?,
    )?;
    said.set_item(
        "incidence",
        integers(py, &[vertices.len()], vertices.iter().map(|v| v.incidence as i64))?,
    )?;
    let corners = |t: &[u32]| t.iter().map(|&v| i64::from(v)).collect::<Vec<_>>();
    said.set_item(
        "triangles",
        integers(py, &[triangles.len(), 3], triangles.iter().flat_map(|t| corners(t)))?,
    )?;
    said.set_item(
        "edges",
        integers(py, &[edges.len(), 2], edges.iter().flat_map(|e| corners(e)))?,
    )?;
    // Straight in the chart of the mesh, not on the sphere.
    let along = edges.iter().flat_map(|&[a, b]| {
        (0..PATH).map(move |k| {
            let share = k as f64 / (PATH - 1) as f64;
            facing(mesh.between(&[(a, 1.0 - share), (b, share)]))
        })
    });
    said.set_item("edge_paths", directions(py, &[edges.len(), PATH], along)?)?;
    Ok(said)
}

/// (centres, covariances) of a component's families at incident directions; NaN where a family is not there.
pub(crate) fn families<'py>(
    py: Python<'py>,
    c: &Component,
    wi: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyTuple>> {
    let wi = Argument::directions("wi", wi)?;
    let shape = broadcast(&[("wi", &wi)])?;
    let wi = wi.expanded(&shape)?;
    let wi: &[DVec3] = bytemuck::cast_slice(&wi);
    let (count, extents) = py.detach(|| {
        let families = c.families();
        let of = |w: &DVec3| families.extents(*w);
        (families.count(), wi.par_iter().map(of).collect::<Vec<_>>())
    });
    let side = c.scattered();
    let mut full = shape.clone();
    full.push(count);
    let place = |e: &Option<bsdfkit_represent::Extent>| match e {
        Some(e) if e.centre.length() < 1.0 => {
            e.centre.extend(side.sign() * (1.0 - e.centre.length_squared()).sqrt())
        }
        _ => DVec3::NAN,
    };
    let spread = |e: &Option<bsdfkit_represent::Extent>| match e {
        Some(e) => DVec3::from_array(e.covariance),
        None => DVec3::NAN,
    };
    let fields = (
        directions(py, &full, extents.iter().flatten().map(place))?,
        directions(py, &full, extents.iter().flatten().map(spread))?,
    );
    fields.into_pyobject(py)
}

/// How values were come by: 0 measured, 1 interpolated, 2 extrapolated.
pub(crate) fn coverage<'py>(
    py: Python<'py>,
    c: &Component,
    wi: &Bound<'py, PyAny>,
    wo: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    let (wi, wo) = (Argument::directions("wi", wi)?, Argument::directions("wo", wo)?);
    let shape = broadcast(&[("wi", &wi), ("wo", &wo)])?;
    let (wi, wo) = (wi.expanded(&shape)?, wo.expanded(&shape)?);
    let (wi, wo): (&[DVec3], &[DVec3]) = (bytemuck::cast_slice(&wi), bytemuck::cast_slice(&wo));
    let results: usize = shape.iter().product();
    let at = |all: &[DVec3], k: usize| all[if all.len() == 1 { 0 } else { k }];
    let of = |k: usize| match c.coverage(at(wi, k), at(wo, k)) {
        Coverage::Measured => 0,
        Coverage::Interpolated => 1,
        Coverage::Extrapolated => 2,
    };
    let all: Vec<i64> = py.detach(|| (0..results).into_par_iter().map(of).collect());
    crate::array::finished(integers(py, &shape, all)?)
}

/// `bsdfkit.plot.draw(subject, kind, **options)`.
pub(crate) fn plot<'py>(
    subject: &Bound<'py, PyAny>,
    kind: &str,
    options: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyAny>> {
    subject.py().import("bsdfkit.plot")?.getattr("draw")?.call((subject, kind), options)
}
