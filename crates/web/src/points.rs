//! Measured points, beside the surfaces that were made of them.

use bsdfkit::component::name_of_sides;
use bsdfkit::{DVec3, Side};
use bsdfkit_fit::packed;
use bsdfkit_measure::Measurement;
use bsdfkit_sphere::direction::to_degrees;
use serde_json::json;
use wasm_bindgen::prelude::{JsError, wasm_bindgen};

use crate::surface::{side, vector};

/// A measurement, as [`packed`] keeps it.
#[wasm_bindgen]
pub struct Points {
    measurements: Vec<Measurement>,
}

/// The points of one incidence, seen through the symmetry that brings it nearest to the light.
#[wasm_bindgen]
#[derive(Clone, Debug)]
pub struct SeenPoints {
    incident: DVec3,
    directions: Vec<f32>,
    values: Vec<f32>,
}

#[wasm_bindgen]
impl SeenPoints {
    /// (θ, φ) of the incidence, in degrees.
    #[wasm_bindgen(getter)]
    pub fn incident(&self) -> Vec<f64> {
        let (theta, phi) = to_degrees(self.incident);
        vec![theta, phi]
    }

    /// Unit vectors, three numbers each.
    #[wasm_bindgen(getter)]
    pub fn directions(&self) -> Vec<f32> {
        self.directions.clone()
    }

    /// f of each, 1/sr.
    #[wasm_bindgen(getter)]
    pub fn values(&self) -> Vec<f32> {
        self.values.clone()
    }
}

impl Points {
    /// Reads the content of a file called `name`.
    ///
    /// Errors: as [`packed::from_bytes`], with the name before them.
    pub fn read(name: &str, bytes: &[u8]) -> bsdfkit::Result<Self> {
        let measurements = packed::from_bytes(bytes).map_err(|e| e.context(name))?;
        Ok(Self { measurements })
    }

    fn from(&self, wi: DVec3, scattered: Side) -> Option<&Measurement> {
        let of = |m: &&Measurement| m.incident == Side::of(wi) && m.scattered == scattered;
        self.measurements.iter().find(of)
    }
}

#[wasm_bindgen]
impl Points {
    /// Whether a file holds measured points.
    pub fn are_in(bytes: &[u8]) -> bool {
        packed::holds(bytes)
    }

    /// [`Points::read`] for JavaScript.
    pub fn open(name: &str, bytes: &[u8]) -> Result<Points, JsError> {
        Self::read(name, bytes).map_err(|e| JsError::new(&e.to_string()))
    }

    /// What was measured, as a JSON text: the `name` of the specimen, and of each of `components` its `name`, `incident`
    /// and `scattered` side, `symmetry`, numbers of `incidences` and `points`.
    pub fn about(&self) -> String {
        let of = |side| if side == Side::Front { "front" } else { "back" };
        let component = |m: &Measurement| {
            json!({
                "name": name_of_sides(m.incident, m.scattered),
                "incident": of(m.incident),
                "scattered": of(m.scattered),
                "symmetry": m.symmetry.to_string(),
                "incidences": m.incidences.len(),
                "points": m.points(),
            })
        };
        let name = self.measurements.iter().find_map(|m| m.sample_name.as_deref());
        let components: Vec<_> = self.measurements.iter().map(component).collect();
        json!({ "name": name.unwrap_or_default(), "components": components }).to_string()
    }

    /// Measured incident directions and their images on one side, three numbers each.
    pub fn incidences(&self, front: bool) -> Vec<f32> {
        let here = self.measurements.iter().filter(|m| m.incident == side(front));
        let all = here.flat_map(|m| m.incidences.iter().map(|i| i.wi));
        all.flat_map(|w| w.to_array()).map(|c| c as f32).collect()
    }

    /// The points on one side of the incidence that is nearest to `wi`; none where that side was not measured.
    pub fn nearest(&self, wi: &[f64], front: bool) -> Option<SeenPoints> {
        let wi = vector(wi);
        let m = self.from(wi, side(front))?;
        let images = m.incidences.iter().map(|i| {
            let (_, image) = m.symmetry.nearest_image(i.wi, wi);
            (image.apply(i.wi).dot(wi), i, image)
        });
        let (_, incidence, image) = images.max_by(|a, b| a.0.total_cmp(&b.0))?;
        let seen = incidence.transformed(image);
        let directions = seen.wo.iter().flat_map(|w| w.to_array()).map(|c| c as f32).collect();
        Some(SeenPoints { incident: seen.wi, directions, values: seen.values })
    }
}
