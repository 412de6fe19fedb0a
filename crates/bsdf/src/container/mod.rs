//! The compiled BSDF: named arrays in a safetensors file, nothing to parse.
//!
//! Stores what the XML stores of the visible band, in the form that queries use, so that reading it back gives the
//! same values bit for bit; further bands are left out. Arrays, little-endian, C order; N counts components from 0:
//!
//! | array | type | shape | unit |
//! |---|---|---|---|
//! | `lambertian` | f64 | \[4, 3\] | none; rows: front and back reflection, front-to-back and back-to-front transmission; columns X, Y, Z |
//! | `component.N.tree.y.slots` | u32 | \[branches, 2^rank\] | 1/sr in leaves |
//! | `component.N.tree.y.root` | u32 | \[1\] | the slot of the whole hypercube |
//! | `component.N.tree.y.forward.index` | u32 | \[…\] | which slice a cell of the known direction has |
//! | `component.N.tree.y.forward.slices` | u32 | \[slices, 3\] | 1/sr: the mean's bits; link; levels of leaves |
//! | `component.N.tree.y.forward.records` | u32 | \[records, 8\] | 1/sr: the bits of four means; four links |
//! | `component.N.tree.y.reverse.*` | u32 | alike | of a lone transmission of rank 4 |
//! | `component.N.tree.u.*`, `….v.*` | u32 | alike | CIE 1976 u′, v′; in coloured trees |
//! | `component.N.tree.spectra` | f64 | \[3 + rank, bands\] | of trees with spectra: as `component.N.render.spectra` |
//! | `component.N.tree.hue` | u8 | \[slots, rank\] | of trees with spectra: coefficients beside the slots of y, 255 for the end of their range |
//! | `component.N.matrix.y` | f32 | \[incident, scattered\] | 1/sr |
//! | `component.N.matrix.x`, `….z` | f32 | alike | 1/sr; in coloured matrices |
//! | `component.N.render.energy` | f32 | \[fine nodes, 2\] | none: the total, and what values are multiplied by |
//! | `component.N.render.layer.K.values` | f16 | \[nodes, angles + 1, radii + 1\] | `value_unit` in 1/sr |
//! | `component.N.render.layer.K.colour` | f16 | \[nodes, angles + 1, radii + 1, 2\] | 64: X/Y and Z/Y; in coloured ones |
//! | `component.N.render.layer.K.density` | f16 | \[nodes, angles + 1, radii + 1\] | `drawn_unit`: what samples are drawn from |
//! | `component.N.render.layer.K.sums` | f32 | \[nodes, angles + 1, radii / 4 + 1\] | alike: sums of these outward |
//! | `component.N.render.layer.K.running` | f32 | \[nodes, angles + 1\] | alike: sums over angles, in cells |
//! | `component.N.render.layer.K.moved` | f32 | \[fine nodes, 2\] | direction cosines, beside the law; or absent |
//! | `component.N.render.spectra` | f64 | \[3 + rank, bands\] | only of spectra: wavelengths in nm; weights of bands in the luminance; offset and basis of logarithms over it: see [`Hue`](crate::spectrum::Hue) |
//! | `component.N.render.layer.K.hue` | f16 | \[nodes, angles + 1, radii + 1, rank\] | only of spectra: coefficients, as shares of their range |
//! | `component.N.render.reverse.*` | | alike | of the opposite direction of travel |
//! | `specular.K.coefficient` | f64 | \[rings, azimuths, 3\] | none; X, Y, Z of the peak of no width K: see [`Curve`](crate::specular::Curve) |
//! | `component.N.matrix.incident_rings`, `….scattered_rings` | f64 | \[rings, 2\] | upper polar angle in degrees; number of azimuths |
//!
//! A slot below 2³¹ is a leaf: the bits of its f32 value. Else the low 31 bits number a branch,
//! which comes after its parent. In a branch slot `incident part · 4 + scattered quadrant`, each
//! counted with the first dimension lowest.
//!
//! The header's `__metadata__` has one key, `bsdfkit`: a JSON text with `kind` ("bsdf"), `version`
//! (1, or 2 where there are peaks of no width), `material` ([`Metadata`]) and `components`: for each `incident` and
//! `scattered` ("front" or "back") and `representation` ("tree", "matrix" with the names of
//! both bases, or "render" with its chart and the [`Shape`](crate::render::Shape)s of its layers: see [`render`](crate::render)), and of spectra (of a tree `spectra`) `error`, `epsilon` and `range`, the least and the length of each coefficient. What is divided between Lambertian and other parts is found anew by [`load`]; for
//! [`open`] each component has `compiled`: `floor` (the constant part, XYZ in 1/sr), `negligible`,
//! `depths` (levels of branches of the trees y, u, v; of a matrix none), and of trees in arrays the sums that
//! sampling needs (`src/tree/cumulative.rs` says how they are read). `specular` lists peaks of no width: `incident`,
//! `scattered`, `linear` and `offset` of the [`Law`](crate::specular::Law), `width_degrees`.

mod hue;
mod kind;
mod load;
mod render;
mod save;
mod specular;

pub use kind::{kind, kind_of_bytes};
pub use load::{from_bytes, load, open};
pub use save::{save, to_bytes};

use serde::{Deserialize, Serialize};

use crate::{Metadata, Side};

/// The key of `__metadata__`.
const KEY: &str = "bsdfkit";
/// What this module reads and writes; interpolants say something else.
const KIND: &str = "bsdf";
/// Raised when an older reader would misread a file.
const VERSION: u32 = 1;
/// With peaks of no width, which an older reader would leave out.
const VERSION_OF_PEAKS: u32 = 2;

#[derive(Debug, Serialize, Deserialize)]
struct Header {
    kind: String,
    version: u32,
    #[serde(default)]
    material: Metadata,
    #[serde(default)]
    components: Vec<Described>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    specular: Vec<crate::specular::Described>,
}

/// A component, apart from its arrays.
#[derive(Debug, Serialize, Deserialize)]
struct Described {
    incident: SideName,
    scattered: SideName,
    representation: Representation,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    compiled: Option<Compiled>,
    /// Of a tree with spectra.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    spectra: Option<hue::Described>,
}

/// What would take a look at all of a component's values to find out.
#[derive(Debug, Serialize, Deserialize)]
struct Compiled {
    floor: [f64; 3],
    negligible: bool,
    #[serde(default)]
    depths: Vec<u32>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Representation {
    Tree,
    Matrix { incident_basis: String, scattered_basis: String },
    Render(render::Described),
}

#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum SideName {
    Front,
    Back,
}

impl From<Side> for SideName {
    fn from(side: Side) -> Self {
        match side {
            Side::Front => Self::Front,
            Side::Back => Self::Back,
        }
    }
}

impl From<SideName> for Side {
    fn from(side: SideName) -> Self {
        match side {
            SideName::Front => Self::Front,
            SideName::Back => Self::Back,
        }
    }
}

/// The rows of the array `lambertian`: incident side, scattered side.
const LAMBERTIAN_ROWS: [(Side, Side); 4] = [
    (Side::Front, Side::Front),
    (Side::Back, Side::Back),
    (Side::Front, Side::Back),
    (Side::Back, Side::Front),
];
