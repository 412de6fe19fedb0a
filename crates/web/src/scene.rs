//! A lit object: what the material looks like.

use std::f64::consts::PI;
use std::ops::Range;

use bsdfkit::{Bsdf, DVec3, Xyz};
use bsdfkit_sphere::frame::Frame;

/// CIE XYZ → linear sRGB, of a white where X = Y = Z: grey data are shown grey.
/// Source: IEC 61966-2-1, its columns times the white point of D65.
const XYZ_TO_RGB: [[f64; 3]; 3] = [
    [3.2406 * 0.9505, -1.5372, -0.4986 * 1.0890],
    [-0.9689 * 0.9505, 1.8758, 0.0415 * 1.0890],
    [0.0557 * 0.9505, -0.2040, 1.0570 * 1.0890],
];

/// What is lit. +X right, +Y up, +Z toward the eye, as the specimen is seen from the front.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shape {
    /// Seen from afar; light from behind does not get through.
    Sphere,
    /// A curtain of folds, lit and seen from either side.
    Drape,
    /// A square seen from near, leaning back by 45 degrees.
    Plane,
}

impl Shape {
    pub(crate) fn named(name: &str) -> Self {
        match name {
            "drape" => Self::Drape,
            "plane" => Self::Plane,
            _ => Self::Sphere,
        }
    }

    /// The normal at a point of the picture, −1 to 1 across, and the direction to the eye.
    fn at(self, x: f64, y: f64) -> Option<(DVec3, DVec3)> {
        match self {
            Self::Sphere => {
                let z2 = 0.95 * 0.95 - x * x - y * y;
                (z2 > 0.0).then(|| (DVec3::new(x, y, z2.sqrt()).normalize(), DVec3::Z))
            }
            Self::Drape => {
                let inside = x.abs() < 0.95 && y.abs() < 0.95;
                // z = 0.08 sin(7 x + sin 2 y): its gradient.
                let slope = 0.08 * (7.0 * x + (2.0 * y).sin()).cos();
                let gradient = (7.0 * slope, 2.0 * (2.0 * y).cos() * slope);
                inside.then(|| (DVec3::new(-gradient.0, -gradient.1, 1.0).normalize(), DVec3::Z))
            }
            Self::Plane => {
                let normal = DVec3::new(0.0, 1.0, 1.0).normalize();
                let up = DVec3::new(0.0, 1.0, -1.0).normalize();
                let eye = DVec3::new(0.0, 0.0, 3.0);
                let ray = DVec3::new(x, y, -2.2);
                let hit = eye + ray * (-eye.dot(normal) / ray.dot(normal));
                let inside = ray.dot(normal) < 0.0 && hit.x.abs() < 1.0 && hit.dot(up).abs() < 1.0;
                inside.then(|| (normal, (eye - hit).normalize()))
            }
        }
    }

    fn is_closed(self) -> bool {
        self == Self::Sphere
    }
}

/// Some rows of a picture of `size` × `size` pixels, the upper row first: four bytes a pixel, sRGB and opacity.
///
/// `light` is the direction to a distant source that gives one lux across its beam; a white matt surface that faces
/// it is shown at 0.8 of white, times 2^`exposure`. No shadows, no light from one place of the object to another.
/// Cost: a query a pixel, each of another incident direction.
pub(crate) fn rows(
    bsdf: &Bsdf,
    shape: Shape,
    light: DVec3,
    exposure: f64,
    size: usize,
    rows: Range<usize>,
) -> Vec<u8> {
    let at = |k: usize| (2 * k + 1) as f64 / size as f64 - 1.0;
    let mut picture = vec![0; 4 * size * rows.len()];
    let (mut places, mut wi, mut wo) = (Vec::new(), Vec::new(), Vec::new());
    for (place, pixel) in (rows.start * size..rows.end * size).enumerate() {
        let Some((normal, eye)) = shape.at(at(pixel % size), -at(pixel / size)) else { continue };
        let Some(frame) = Frame::new(normal, DVec3::Y) else { continue };
        picture[4 * place + 3] = 255;
        let (to_light, to_eye) = (frame.to_local(light), frame.to_local(eye));
        if to_light.z > 0.0 || !shape.is_closed() {
            places.push(place);
            wi.push(to_light);
            wo.push(to_eye);
        }
    }
    let mut f = vec![Xyz::ZERO; places.len()];
    bsdf.eval_xyz_many(&wi, &wo, &mut f).expect("one value for each pair");
    let scale = 0.8 * PI * exposure.exp2();
    for ((place, wi), f) in places.into_iter().zip(wi).zip(f) {
        let light = [f.x, f.y, f.z].map(|c| c * wi.z.abs() * scale);
        for (channel, row) in XYZ_TO_RGB.iter().enumerate() {
            let linear: f64 = row.iter().zip(light).map(|(a, b)| a * b).sum();
            picture[4 * place + channel] = (255.0 * encoded(linear)).round() as u8;
        }
    }
    picture
}

/// Linear → sRGB, 0 to 1.
fn encoded(linear: f64) -> f64 {
    let linear = linear.clamp(0.0, 1.0);
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}
