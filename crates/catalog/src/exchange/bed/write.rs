//! Totals of a BSDF as optical data.

use std::io::Write;

use bsdfkit::{Bsdf, Components, DVec3, Error, Result};
use bsdfkit_represent::tabulate::is_isotropic;
use bsdfkit_sphere::direction::from_degrees;
use serde_json::{Value, json};

/// Polar angles of the light, degrees.
const POLAR: [f64; 9] = [0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0];
/// Azimuths of the light, degrees from the prime direction.
const AZIMUTHS: [f64; 8] = [0.0, 45.0, 90.0, 135.0, 180.0, 225.0, 270.0, 315.0];

/// Writes the reflectance and transmittance of the front, which is called the prime surface, for light from some directions:
/// of the visible band, and of Solar where there is one.
///
/// Convention: the prime direction is +Y, "up"; azimuths are counter-clockwise from it, seen by who looks at the lit surface.
/// Errors: io.
pub fn write(bsdf: &Bsdf, out: &mut impl Write) -> Result<()> {
    // Peaks of no width are seen by their totals.
    let isotropic = bsdf.components().iter().all(is_isotropic)
        && bsdf.specular().iter().all(bsdfkit::Specular::is_isotropic);
    let solar = bsdf.band("Solar");
    let bands = [("visible", Some(bsdf)), ("solar", solar.as_ref())];
    let points: Vec<Value> = bands
        .iter()
        .filter_map(|(name, band)| Some((*name, (*band)?)))
        .flat_map(|(name, band)| points(band, name, isotropic))
        .collect();
    let mut characteristics = json!({"surface": "prime", "normalization": "absolute"});
    if isotropic {
        characteristics["symmetries"] = json!("azimuthalAngleInvariance");
    }
    let file =
        json!({"data": [{"componentCharacteristics": characteristics, "dataPoints": points}]});
    serde_json::to_writer_pretty(out, &file)
        .map_err(|e| Error::io("BED", &std::io::Error::other(e)))
}

fn points(bsdf: &Bsdf, band: &str, isotropic: bool) -> Vec<Value> {
    let azimuths = |polar: f64| if isotropic || polar == 0.0 { &AZIMUTHS[..1] } else { &AZIMUTHS };
    let directions = POLAR.iter().flat_map(|&p| azimuths(p).iter().map(move |&a| (p, a)));
    let point = |(polar, azimuth): (f64, f64)| {
        let wi: DVec3 = from_degrees(polar, azimuth + 90.0);
        let total = |components| {
            let total = bsdf.directional_hemispherical(wi, components);
            (total * 1e5).round() / 1e5
        };
        let mut direction = json!({"polar": polar});
        if !isotropic && polar != 0.0 {
            direction["azimuth"] = json!(azimuth);
        }
        json!({
            "incidence": {"direction": direction, "wavelengths": {"integral": band}},
            "emergence": {"direction": "hemispherical"},
            "results": {
                "transmittance": total(Components::TRANSMISSION),
                "reflectance": total(Components::REFLECTION),
            },
        })
    };
    directions.map(point).collect()
}
