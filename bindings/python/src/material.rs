//! What a file says about a specimen, and what its components are.

use bsdfkit::Side;
use bsdfkit::matrix::KlemsMatrix;
use bsdfkit::render::RenderTable;
use bsdfkit::tree::TreeDistribution;
use bsdfkit_fit::interpolant::{Continuous, Part};
use pyo3::prelude::*;

/// "front" or "back".
pub(crate) fn side_name(side: Side) -> &'static str {
    match side {
        Side::Front => "front",
        Side::Back => "back",
    }
}

/// Description of a specimen.
///
/// Attributes:
///     name: Name of the material; empty when unknown.
///     manufacturer: Who makes it.
///     width: Width in metres; 0 when not given.
///     height: Height in metres; 0 when not given.
///     thickness: Thickness in metres; 0 when not given.
///     geometry: Geometry of the device as MGF text, in metres, or None.
///     comments: Comments, in the order of the file.
///     properties: Every other (key, value), in the order of the file.
#[pyclass(frozen, get_all, module = "bsdfkit")]
pub(crate) struct Metadata {
    name: String,
    manufacturer: String,
    width: f64,
    height: f64,
    thickness: f64,
    geometry: Option<String>,
    comments: Vec<String>,
    properties: Vec<(String, String)>,
}

impl From<&bsdfkit::Metadata> for Metadata {
    fn from(m: &bsdfkit::Metadata) -> Self {
        Self {
            name: m.name.clone(),
            manufacturer: m.manufacturer.clone(),
            width: m.width,
            height: m.height,
            thickness: m.thickness,
            geometry: m.geometry.clone(),
            comments: m.comments.clone(),
            properties: m.properties.clone(),
        }
    }
}

#[pymethods]
impl Metadata {
    fn __repr__(&self) -> String {
        format!(
            "Metadata(name={:?}, manufacturer={:?}, width={}, height={}, thickness={})",
            self.name, self.manufacturer, self.width, self.height, self.thickness
        )
    }
}

/// One stored distribution, and the pair of sides it belongs to.
///
/// Attributes:
///     incident: Side of the incident direction, "front" (z > 0) or "back".
///     scattered: Side of the scattered direction.
///     representation: "tree3" or "tree4" (tensor tree of that rank), "matrix", "render" (render form), or, in an interpolant,
///         "transport" (fitted here), "sir" (fitted by Radiance) or "tables" (of RGL, MERL or Zemax, as
///         they are).
///     coloured: Whether values have a colour, not just a luminance.
///     incidences: Incident directions of a matrix or an interpolant, nodes of a render form, None for a tree.
///     leaves: Values in a tree, else None.
///     expected_error: L1 error to expect half-way between the incidences of an interpolant; None where
///         too few incidences tell.
#[pyclass(frozen, get_all, module = "bsdfkit")]
pub(crate) struct Component {
    pub(crate) incident: &'static str,
    pub(crate) scattered: &'static str,
    pub(crate) representation: String,
    pub(crate) coloured: bool,
    pub(crate) incidences: Option<usize>,
    pub(crate) leaves: Option<usize>,
    pub(crate) expected_error: Option<f64>,
}

impl From<&bsdfkit::Component> for Component {
    fn from(c: &bsdfkit::Component) -> Self {
        let distribution = c.distribution();
        let tree = distribution.downcast_ref::<TreeDistribution>();
        let matrix = distribution.downcast_ref::<KlemsMatrix>();
        let render = distribution.downcast_ref::<RenderTable>();
        let continuous = distribution.downcast_ref::<Continuous>().map(Continuous::part);
        Self {
            incident: side_name(c.incident),
            scattered: side_name(c.scattered),
            representation: match (tree, continuous) {
                (Some(tree), _) => format!("tree{}", tree.luminance().rank().dimensions()),
                (_, Some(Part::Transported(_))) => "transport".into(),
                (_, Some(Part::Sir(_))) => "sir".into(),
                (_, Some(Part::Dense(_))) => "tables".into(),
                _ if render.is_some() => "render".into(),
                _ => "matrix".into(),
            },
            coloured: distribution.is_coloured(),
            incidences: matrix
                .map(|m| m.incident().directions())
                .or(render.map(|t| t.chart().nodes()))
                .or(continuous.map(Part::incidences)),
            leaves: tree.map(|t| t.luminance().leaf_count()),
            expected_error: match continuous {
                Some(Part::Transported(c)) => c.expected_error,
                _ => None,
            },
        }
    }
}

#[pymethods]
impl Component {
    fn __repr__(&self) -> String {
        let Self { incident, scattered, representation, .. } = self;
        format!("<Component {incident} to {scattered}: {representation}>")
    }
}
