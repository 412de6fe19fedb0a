//! What a file itself tells of a material.

use bsdfkit::component::name_of_sides;
use bsdfkit::matrix::KlemsMatrix;
use bsdfkit::render::RenderTable;
use bsdfkit::tree::TreeDistribution;
use bsdfkit::{Bsdf, Component, Components, DVec3};
use bsdfkit_fit::interpolant::{Interpolant, Part};
use bsdfkit_represent::tabulate::is_isotropic;
use serde::{Deserialize, Serialize};

/// What is computed of a file, whatever people say of it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Facts {
    /// Symmetry of the scattering; empty where the form of the file does not tell.
    pub symmetry: String,
    /// Pairs of sides that data are stored of: "front reflection", ….
    pub components: Vec<String>,
    /// Whether any value has a colour.
    pub coloured: bool,
    /// Share of light along the front normal that is reflected, directional-hemispherical; photopic.
    pub reflectance: f64,
    /// The same transmitted.
    pub transmittance: f64,
}

impl Facts {
    /// Of a stored BSDF.
    pub(crate) fn of_bsdf(bsdf: &Bsdf) -> Self {
        let symmetries = bsdf.components().iter().map(stored_symmetry).collect();
        let components = bsdf.components().iter().map(|c| (c.incident, c.scattered));
        let coloured = bsdf.components().iter().any(|c| c.distribution().is_coloured());
        Self {
            symmetry: common(symmetries),
            components: components.map(|(i, s)| name_of_sides(i, s).to_owned()).collect(),
            coloured,
            ..Self::totals(bsdf)
        }
    }

    /// Of an interpolant, and of `bsdf`, which is the same.
    pub(crate) fn of_interpolant(interpolant: &Interpolant, bsdf: &Bsdf) -> Self {
        let symmetry = |part: &Part| match part {
            Part::Transported(c) => c.symmetry().to_string(),
            Part::Sir(part) if part.sir.isotropic() => "isotropic".to_owned(),
            Part::Dense(part) if part.function.isotropic() => "isotropic".to_owned(),
            Part::Sir(_) | Part::Dense(_) => String::new(),
        };
        Self {
            symmetry: common(interpolant.components.iter().map(symmetry).collect()),
            ..Self::of_bsdf(bsdf)
        }
    }

    fn totals(bsdf: &Bsdf) -> Self {
        let total = |components| {
            let total = bsdf.directional_hemispherical(DVec3::Z, components);
            if total.is_finite() { total } else { 0.0 }
        };
        Self {
            reflectance: total(Components::REFLECTION),
            transmittance: total(Components::TRANSMISSION),
            ..Self::default()
        }
    }
}

/// What all parts say; nothing if they differ.
fn common(mut all: Vec<String>) -> String {
    all.dedup();
    if all.len() == 1 { all.remove(0) } else { String::new() }
}

fn stored_symmetry(component: &Component) -> String {
    let text = if is_isotropic(component) {
        "isotropic"
    } else if component.distribution().downcast_ref::<TreeDistribution>().is_some() {
        "anisotropic"
    } else {
        ""
    };
    text.to_owned()
}

/// How a BSDF is stored, in words.
pub(crate) fn form(bsdf: &Bsdf) -> String {
    let form = |c: &Component| {
        let distribution = c.distribution();
        if let Some(tree) = distribution.downcast_ref::<TreeDistribution>() {
            format!("tensor tree of rank {}", tree.luminance().rank().dimensions())
        } else if let Some(matrix) = distribution.downcast_ref::<KlemsMatrix>() {
            format!("matrix, {}", matrix.incident().name())
        } else if distribution.downcast_ref::<RenderTable>().is_some() {
            "render form".to_owned()
        } else {
            "function".to_owned()
        }
    };
    let mut forms: Vec<String> = bsdf.components().iter().map(form).collect();
    forms.sort();
    forms.dedup();
    if forms.is_empty() { "Lambertian parts".to_owned() } else { forms.join("; ") }
}
