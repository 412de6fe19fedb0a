//! What `tabulate` is asked for, of a stored BSDF and of an interpolant.

use std::collections::BTreeMap;
use std::path::Path;

use bsdfkit::Metadata;
use bsdfkit::xml::set_property;
use bsdfkit_fit::deliver::{Consumer, Kind, Order, Subject};
use bsdfkit_represent::rgl;
use bsdfkit_represent::tabulate::Reciprocity;
use pyo3::prelude::*;

use crate::bsdf::Bsdf;
use crate::error::{argument, raised};
use crate::watch::watched;

/// The form and its settings, as Python has them.
pub(crate) struct Wanted<'a> {
    pub(crate) kind: Option<&'a str>,
    pub(crate) consumer: Option<&'a str>,
    pub(crate) max_error: Option<f64>,
    pub(crate) max_leaves: Option<usize>,
    pub(crate) max_depth: Option<u32>,
    pub(crate) reciprocity: Option<&'a str>,
}

impl Wanted<'_> {
    fn order(&self, subject: Subject<'_>) -> bsdfkit::Result<Order> {
        let given: Option<Kind> = self.kind.map(str::parse).transpose()?;
        let consumer: Option<Consumer> = self.consumer.map(str::parse).transpose()?;
        let kind = match (given, consumer) {
            (None, Some(consumer)) => consumer.kind_of(subject),
            (given, Some(consumer)) => consumer.kind(given)?,
            (Some(kind), None) => kind,
            (None, None) => Kind::TensorTree,
        };
        let reciprocity = match self.reciprocity {
            None | Some("auto") => Reciprocity::Auto,
            Some("on") => Reciprocity::On,
            Some("off") => Reciprocity::Off,
            Some(found) => {
                return Err(bsdfkit::Error::argument(format!(
                    "reciprocity: expected \"auto\", \"on\" or \"off\", found {found:?}"
                )));
            }
        };
        let (max_error, max_leaves, max_depth) = (self.max_error, self.max_leaves, self.max_depth);
        if max_leaves == Some(0) {
            return Err(bsdfkit::Error::argument("max_leaves: expected at least 1, found 0"));
        }
        if kind != Kind::TensorTree && (max_leaves.is_some() || max_depth.is_some()) {
            let text = "max_leaves, max_depth: expected only for a tensor tree";
            return Err(bsdfkit::Error::argument(text));
        }
        Ok(Order { consumer, max_error, max_leaves, max_depth, reciprocity, ..Order::new(kind) })
    }
}

/// What the specimen is called.
pub(crate) struct Labels {
    pub(crate) name: Option<String>,
    pub(crate) manufacturer: Option<String>,
    pub(crate) thickness: Option<f64>,
    pub(crate) width: Option<f64>,
    pub(crate) height: Option<f64>,
    pub(crate) properties: Option<BTreeMap<String, String>>,
}

impl Labels {
    /// `metadata` with what was given.
    pub(crate) fn over(self, mut metadata: Metadata) -> PyResult<Metadata> {
        let lengths = [
            ("thickness", self.thickness, &mut metadata.thickness),
            ("width", self.width, &mut metadata.width),
            ("height", self.height, &mut metadata.height),
        ];
        for (name, given, known) in lengths {
            let Some(length) = given else { continue };
            if !(length.is_finite() && length >= 0.0) {
                return Err(argument(format!(
                    "{name}: expected metres of at least 0, found {length}"
                )));
            }
            *known = length;
        }
        metadata.name = self.name.unwrap_or(metadata.name);
        metadata.manufacturer = self.manufacturer.unwrap_or(metadata.manufacturer);
        for (key, value) in self.properties.unwrap_or_default() {
            set_property(&mut metadata, &key, &value).map_err(|e| raised(&e))?;
        }
        Ok(metadata)
    }
}

/// Writes RGL's tables of `subject`; what is left out goes to the logger.
pub(crate) fn save_rgl(
    py: Python<'_>,
    subject: Subject<'_>,
    metadata: &Metadata,
    path: &Path,
) -> PyResult<()> {
    let Some(channels) = rgl::channels_of(path) else {
        return Err(argument(format!(
            "{}: expected a name ending in _rgb.bsdf or _spec.bsdf",
            path.display()
        )));
    };
    let said =
        watched(py, None, "rgl", |watch| subject.write_rgl(metadata, channels, path, watch))?;
    let logger = py.import("logging")?.call_method1("getLogger", ("bsdfkit",))?;
    for note in said {
        logger.call_method1("warning", ("%s", format!("{}: {note}", path.display())))?;
    }
    Ok(())
}

/// `subject` in the form that is wanted; what was left out or made up, or not reached, goes to the logger.
pub(crate) fn tabulated(
    py: Python<'_>,
    subject: Subject<'_>,
    wanted: &Wanted<'_>,
    metadata: Metadata,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Bsdf> {
    let order = wanted.order(subject).map_err(|e| raised(&e))?;
    let made =
        watched(py, progress, order.kind.name(), |watch| order.deliver(subject, metadata, watch))?;
    let missed = made.reports.iter().filter_map(|r| r.missed()).map(|missed| missed.to_string());
    let colour = made.loses_colour.then(|| "luminance only".to_owned());
    let logger = py.import("logging")?.call_method1("getLogger", ("bsdfkit",))?;
    for note in made.said.iter().cloned().chain(missed).chain(colour) {
        logger.call_method1("info", ("%s", note))?;
    }
    Ok(made.bsdf.into())
}
