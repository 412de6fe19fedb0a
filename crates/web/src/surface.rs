//! An opened file.

use bsdfkit::{Bsdf, DVec3, Lookup, Side};
use bsdfkit_fit::open::{self, Content, Opened};
use bsdfkit_sphere::direction::from_degrees;
use wasm_bindgen::prelude::{JsError, wasm_bindgen};

use crate::about;
use crate::lobe::Lobe;
use crate::selection::Selection;
use crate::{cells, map, scene, section};

/// A file that answers queries, whatever its form.
#[wasm_bindgen]
pub struct Surface {
    content: Content,
    bsdf: Bsdf,
    about: String,
}

impl Surface {
    /// Opens the content of a file called `name`.
    ///
    /// Errors: as [`open::bsdf_from_bytes`], with the name before them.
    pub fn read(name: &str, bytes: &[u8]) -> bsdfkit::Result<Self> {
        let (content, opened) = open::open_bytes(bytes).map_err(|e| e.context(name))?;
        let warnings = match &opened {
            Opened::Bsdf(_, warnings) => warnings.clone(),
            Opened::Interpolant(_) => Vec::new(),
        };
        let bsdf = opened.into_bsdf();
        let about = about::of(content, &bsdf, &warnings).to_string();
        Ok(Self { content, bsdf, about })
    }

    /// The BSDF.
    pub fn bsdf(&self) -> &Bsdf {
        &self.bsdf
    }
}

#[wasm_bindgen]
impl Surface {
    /// [`Surface::read`] for JavaScript.
    pub fn open(name: &str, bytes: &[u8]) -> Result<Surface, JsError> {
        Self::read(name, bytes).map_err(|e| JsError::new(&e.to_string()))
    }

    /// What the file holds, as a JSON text: [`about::of`].
    pub fn about(&self) -> String {
        self.about.clone()
    }

    /// The surface in a further band of the file.
    pub fn band(&self, name: &str) -> Option<Surface> {
        let bsdf = self.bsdf.band(name)?;
        let about = about::of(self.content, &bsdf, &[]).to_string();
        Some(Self { content: self.content, bsdf, about })
    }

    /// The surface with its trees read smoothly, or leaf by leaf.
    pub fn with_lookup(&self, smooth: bool) -> Result<Surface, JsError> {
        let lookup = if smooth { Lookup::Smooth } else { Lookup::Stored };
        let bsdf =
            self.bsdf.clone().with_lookup(lookup).map_err(|e| JsError::new(&e.to_string()))?;
        Ok(Self { content: self.content, bsdf, about: self.about.clone() })
    }

    /// f of one pair of directions, 1/sr.
    pub fn value(&self, wi: &[f64], wo: &[f64], selection: &Selection) -> f64 {
        selection.value(&self.bsdf, vector(wi), vector(wo))
    }

    /// X, Y and Z of the whole f of one pair of directions, 1/sr.
    pub fn value_xyz(&self, wi: &[f64], wo: &[f64]) -> Vec<f64> {
        let f = self.bsdf.eval_xyz(vector(wi), vector(wo));
        vec![f.x, f.y, f.z]
    }

    /// The projected solid angle of the cell that a pair of directions falls in, sr.
    pub fn cell_size(&self, wi: &[f64], wo: &[f64]) -> f64 {
        self.bsdf.projected_solid_angle(vector(wi), Some(vector(wo))).1
    }

    /// Directional-hemispherical reflectance and transmittance of the selection, dimensionless.
    pub fn totals(&self, wi: &[f64], selection: &Selection) -> Vec<f64> {
        let wi = vector(wi);
        let to = |side| self.bsdf.directional_hemispherical(wi, selection.to_side(wi, side));
        let here = Side::of(wi);
        vec![to(here), to(here.opposite())]
    }

    /// Peaks of no width, which no value of f has: four numbers each, the direction and the share of the incident light.
    pub fn specular_peaks(&self, wi: &[f64], selection: &Selection) -> Vec<f64> {
        let peaks = self.bsdf.specular_peaks(vector(wi), selection.components);
        peaks.flat_map(|p| [p.wo.x, p.wo.y, p.wo.z, p.coefficient.y]).collect()
    }

    /// f over one hemisphere of scattered directions, as pixels: [`map::values`].
    pub fn map(
        &self,
        wi: &[f64],
        front: bool,
        selection: &Selection,
        size: usize,
        equal_angles: bool,
    ) -> Vec<f32> {
        let projection = map::Projection::of(equal_angles);
        map::values(&self.bsdf, vector(wi), side(front), selection, size, projection)
    }

    /// f over one hemisphere of scattered directions, as a mesh: [`Lobe::new`].
    pub fn lobe(
        &self,
        wi: &[f64],
        front: bool,
        selection: &Selection,
        finest: usize,
        samples: usize,
    ) -> Lobe {
        Lobe::new(&self.bsdf, vector(wi), side(front), selection, (finest, samples))
    }

    /// Outlines of leaves or patches: [`cells::outlines`].
    pub fn cells(&self, wi: &[f64], front: bool) -> Vec<f32> {
        cells::outlines(&self.bsdf, vector(wi), side(front))
    }

    /// f in the plane of the normal and azimuth `phi`: [`section::values`].
    pub fn section(&self, wi: &[f64], phi: f64, selection: &Selection, steps: usize) -> Vec<f32> {
        section::values(&self.bsdf, vector(wi), phi, selection, steps)
    }

    /// Directional-hemispherical values over one hemisphere of incident directions, as pixels.
    pub fn energy(
        &self,
        front: bool,
        selection: &Selection,
        size: usize,
        equal_angles: bool,
    ) -> Vec<f32> {
        let projection = map::Projection::of(equal_angles);
        map::totals(&self.bsdf, side(front), selection, size, projection)
    }

    /// Rows of a picture of a lit object: [`scene::rows`].
    pub fn scene(
        &self,
        shape: &str,
        light: &[f64],
        exposure: f64,
        size: usize,
        first: usize,
        count: usize,
    ) -> Vec<u8> {
        let rows = first.min(size)..first.saturating_add(count).min(size);
        scene::rows(&self.bsdf, scene::Shape::named(shape), vector(light), exposure, size, rows)
    }
}

/// Polar angle and azimuth where three numbers were expected are no direction.
pub(crate) fn vector(v: &[f64]) -> DVec3 {
    match *v {
        [x, y, z] => DVec3::new(x, y, z),
        [theta, phi] => from_degrees(theta, phi),
        _ => DVec3::NAN,
    }
}

pub(crate) fn side(front: bool) -> Side {
    if front { Side::Front } else { Side::Back }
}
