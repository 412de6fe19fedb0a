//! The module `bsdfkit._bsdfkit`: numpy arrays in and out of the five verbs, the GIL released meanwhile.
//!
//! A face: directions and settings are handed on, results put into arrays; nothing is computed here.
//! The documentation comments of what Python sees are Python's docstrings.

use pyo3::prelude::*;

mod array;
mod bsdf;
mod check;
mod direction;
mod error;
mod fit;
mod interpolant;
mod look;
mod material;
mod measurement;
mod open;
mod simulate;
mod spectra;
mod tabulate;
mod validation;
mod view;
mod watch;

#[pymodule]
mod _bsdfkit {
    use bsdfkit::Components;
    use pyo3::prelude::*;
    use pyo3::types::PyDict;

    #[pymodule_export]
    use crate::bsdf::Bsdf;
    #[pymodule_export]
    use crate::check::check;
    #[pymodule_export]
    use crate::direction::{angles, direction};
    #[pymodule_export]
    use crate::fit::fit;
    #[pymodule_export]
    use crate::interpolant::Interpolant;
    #[pymodule_export]
    use crate::material::{Component, Metadata};
    #[pymodule_export]
    use crate::measurement::{Measurement, read};
    #[pymodule_export]
    use crate::open::open;
    #[pymodule_export]
    use crate::simulate::{materials, simulate};
    #[pymodule_export]
    use crate::spectra::view_weights;
    #[pymodule_export]
    use crate::validation::Validation;
    #[pymodule_export]
    use crate::view::{Viewer, view, viewer_page};

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        let flags = [
            ("REFLECTION", Components::REFLECTION),
            ("TRANSMISSION", Components::TRANSMISSION),
            ("NON_LAMBERTIAN", Components::NON_LAMBERTIAN),
            ("LAMBERTIAN", Components::LAMBERTIAN),
            ("SPECULAR", Components::SPECULAR),
            ("DIRECTIONAL_DIFFUSE", Components::DIRECTIONAL_DIFFUSE),
            ("FRONT", Components::FRONT),
            ("BACK", Components::BACK),
            ("ALL", Components::ALL),
            ("NONE", Components::NONE),
        ];
        let bits = PyDict::new(module.py());
        for (name, components) in flags {
            bits.set_item(name, components.bits())?;
        }
        module.add("COMPONENT_BITS", bits)?;
        module.add("PART_NUMBERS", crate::bsdf::part_numbers(module.py())?)?;
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
