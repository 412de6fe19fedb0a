//! A hemisphere as pixels, seen from the front: +X right, +Y up.

use std::f64::consts::FRAC_PI_2;

use bsdfkit::{Bsdf, DVec2, DVec3, Side};
use wasm_bindgen::prelude::wasm_bindgen;

use crate::selection::Selection;

/// How far from the centre a polar angle is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Projection {
    /// sin θ: equal areas are equal projected solid angles.
    EqualArea,
    /// θ.
    EqualAngles,
}

impl Projection {
    pub(crate) fn of(equal_angles: bool) -> Self {
        if equal_angles { Self::EqualAngles } else { Self::EqualArea }
    }

    /// The direction drawn at a point of the disk of radius 1; `None` outside.
    fn direction(self, p: DVec2, side: Side) -> Option<DVec3> {
        let r = p.length();
        if r >= 1.0 {
            return None;
        }
        let (sin, cos) = match self {
            Self::EqualArea => (r, (1.0 - r * r).sqrt()),
            Self::EqualAngles => (r * FRAC_PI_2).sin_cos(),
        };
        let turned = if r > 0.0 { p * (sin / r) } else { DVec2::ZERO };
        Some(DVec3::new(turned.x, turned.y, side.sign() * cos))
    }

    /// Inverse of [`Projection::direction`], whatever the side.
    fn place(self, w: DVec3) -> DVec2 {
        let sin = w.truncate().length();
        match self {
            Self::EqualAngles if sin > 0.0 => {
                w.truncate() * (sin.atan2(w.z.abs()) / FRAC_PI_2 / sin)
            }
            _ => w.truncate(),
        }
    }
}

/// Directions of all pixels inside the disk, and their places in the picture.
fn pixels(side: Side, size: usize, projection: Projection) -> (Vec<usize>, Vec<DVec3>) {
    let at = |k: usize| (2 * k + 1) as f64 / size as f64 - 1.0;
    let inside = (0..size * size).filter_map(|k| {
        let p = DVec2::new(at(k % size), -at(k / size));
        projection.direction(p, side).map(|w| (k, w))
    });
    inside.unzip()
}

fn picture(size: usize, places: &[usize], values: impl IntoIterator<Item = f64>) -> Vec<f32> {
    let mut picture = vec![f32::NAN; size * size];
    for (&place, value) in places.iter().zip(values) {
        picture[place] = value as f32;
    }
    picture
}

/// f(wi, ·) of `selection` on `side`, 1/sr: `size` rows of `size` pixels, the upper row first, NaN outside the disk.
///
/// Cost: a query a pixel, 0.8 `size`² of them.
pub(crate) fn values(
    bsdf: &Bsdf,
    wi: DVec3,
    side: Side,
    selection: &Selection,
    size: usize,
    projection: Projection,
) -> Vec<f32> {
    let (places, wo) = pixels(side, size, projection);
    picture(size, &places, selection.values(bsdf, wi, &wo))
}

/// Directional-hemispherical values of incident directions on `side`, dimensionless, as [`values`].
pub(crate) fn totals(
    bsdf: &Bsdf,
    side: Side,
    selection: &Selection,
    size: usize,
    projection: Projection,
) -> Vec<f32> {
    let (places, wi) = pixels(side, size, projection);
    let mut totals = vec![0.0; wi.len()];
    bsdf.directional_hemispherical_many(&wi, selection.components, &mut totals)
        .expect("one value for each direction");
    picture(size, &places, totals)
}

/// The direction drawn at a point of the disk of radius 1; no number outside.
#[wasm_bindgen]
pub fn map_direction(x: f64, y: f64, front: bool, equal_angles: bool) -> Vec<f64> {
    let side = if front { Side::Front } else { Side::Back };
    let direction = Projection::of(equal_angles).direction(DVec2::new(x, y), side);
    direction.map_or_else(Vec::new, |w| w.to_array().into())
}

/// Where in that disk a direction is drawn.
#[wasm_bindgen]
pub fn map_place(w: &[f64], equal_angles: bool) -> Vec<f64> {
    let &[x, y, z] = w else { return vec![f64::NAN; 2] };
    Projection::of(equal_angles).place(DVec3::new(x, y, z)).to_array().into()
}
