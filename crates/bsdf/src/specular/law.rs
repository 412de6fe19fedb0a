//! Where a peak of no width stands: an affine law in direction cosines.

use bsdfkit_sphere::{DVec2, DVec3, Side};

use crate::{Error, Result};

/// uo = A ui + g: direction cosines along X and Y, both directions away from the surface.
///
/// A mirror's peak and light that goes straight through have A = −1, g = 0 (their sides tell them apart); retroreflected
/// light A = 1; light refracted by a flat surface A = −1/n; order m of a grating g = m λ/period across the grooves.
/// Where |uo| would not be below 1 the peak is not there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Law {
    linear: [[f64; 2]; 2],
    offset: DVec2,
}

/// Numbers beyond this are no law of optics.
const MOST: f64 = 100.0;
/// Laws that map all directions to nearly one line have no way back.
const LEAST_DETERMINANT: f64 = 1e-6;
/// Entries nearer than this to those of a named law count as it.
const NEAR: f64 = 1e-9;

impl Law {
    /// uo = −ui: mirror, or straight through.
    pub const OPPOSITE: Self = Self { linear: [[-1.0, 0.0], [0.0, -1.0]], offset: DVec2::ZERO };
    /// uo = ui: back to where the light came from.
    pub const RETRO: Self = Self { linear: [[1.0, 0.0], [0.0, 1.0]], offset: DVec2::ZERO };

    /// Any affine law, rows of A and g.
    ///
    /// Errors: argument for numbers that are not finite or above 100, and for A without inverse.
    pub fn affine(linear: [[f64; 2]; 2], offset: [f64; 2]) -> Result<Self> {
        let numbers = linear.as_flattened().iter().chain(&offset);
        if let Some(wrong) = numbers.copied().find(|v| !v.is_finite() || v.abs() > MOST) {
            return Err(Error::argument(format!(
                "law of a specular peak: expected finite numbers up to {MOST}, found {wrong}"
            )));
        }
        let law = Self { linear, offset: offset.into() };
        if law.determinant().abs() < LEAST_DETERMINANT {
            return Err(Error::argument(format!(
                "law of a specular peak: expected a matrix with an inverse, found {linear:?}"
            )));
        }
        Ok(law)
    }

    /// uo = −ui / n: into a half-space of index `n` behind a flat surface.
    ///
    /// Errors: argument, outside 0.01 to 100.
    pub fn refracted(index: f64) -> Result<Self> {
        Self::affine([[-index.recip(), 0.0], [0.0, -index.recip()]], [0.0; 2])
    }

    /// The same law with `offset` added to uo: a diffracted order.
    ///
    /// Errors: argument, as [`Law::affine`].
    pub fn shifted(self, offset: DVec2) -> Result<Self> {
        Self::affine(self.linear, (self.offset + offset).into())
    }

    /// A, by rows.
    pub fn linear(&self) -> [[f64; 2]; 2] {
        self.linear
    }

    /// g.
    pub fn offset(&self) -> DVec2 {
        self.offset
    }

    fn determinant(&self) -> f64 {
        let [[a, b], [c, d]] = self.linear;
        a * d - b * c
    }

    /// A ui + g, whether or not there is such a direction.
    #[inline]
    pub fn cosines(&self, ui: DVec2) -> DVec2 {
        let [[a, b], [c, d]] = self.linear;
        DVec2::new(a * ui.x + b * ui.y, c * ui.x + d * ui.y) + self.offset
    }

    /// The scattered direction on `side`; `None` where it would lie on or beyond the horizon.
    #[inline]
    pub fn scattered(&self, wi: DVec3, side: Side) -> Option<DVec3> {
        let u = self.cosines(wi.truncate());
        let z = (1.0 - u.length_squared()).sqrt();
        (z > 0.0).then(|| u.extend(side.sign() * z))
    }

    /// The law of light that travels the other way: ui from uo.
    #[must_use]
    pub fn reversed(&self) -> Self {
        let [[a, b], [c, d]] = self.linear;
        let over = self.determinant().recip();
        let linear = [[d * over, -b * over], [-c * over, a * over]];
        let back = Self { linear, offset: DVec2::ZERO };
        Self { offset: -back.cosines(self.offset), ..back }
    }

    /// Whether it is the same after any turn about the normal.
    pub(super) fn is_isotropic(&self) -> bool {
        let [[a, b], [c, d]] = self.linear;
        let near = |x: f64, y: f64| (x - y).abs() < NEAR;
        near(a, d) && near(b, -c) && self.offset.length() < NEAR
    }

    /// In words.
    pub(super) fn name(&self, crosses: bool) -> String {
        let [[a, b], [c, d]] = self.linear;
        let near = |x: f64, y: f64| (x - y).abs() < NEAR;
        let scalar = (near(a, d) && near(b, 0.0) && near(c, 0.0)).then_some(a);
        let main = match scalar {
            Some(s) if near(s, -1.0) && crosses => "straight through".to_owned(),
            Some(s) if near(s, -1.0) => "mirror".to_owned(),
            Some(s) if near(s, 1.0) && !crosses => "retro".to_owned(),
            Some(s) if s < 0.0 && crosses => format!("refracted, index {:.4}", -s.recip()),
            _ => format!("affine [[{a:.4}, {b:.4}], [{c:.4}, {d:.4}]]"),
        };
        match self.offset.length() < NEAR {
            true => main,
            false => format!("{main}, moved by ({:.4}, {:.4})", self.offset.x, self.offset.y),
        }
    }
}

#[cfg(test)]
mod tests {
    use bsdfkit_sphere::direction::from_degrees;

    use super::*;

    #[test]
    fn laws_by_angles() {
        let wi = from_degrees(40.0, 30.0);
        let mirror = Law::OPPOSITE.scattered(wi, Side::Front).unwrap();
        assert!(mirror.distance(from_degrees(40.0, 210.0)) < 1e-12);
        let straight = Law::OPPOSITE.scattered(wi, Side::Back).unwrap();
        assert!(straight.distance(-wi) < 1e-12);
        assert!(Law::RETRO.scattered(wi, Side::Front).unwrap().distance(wi) < 1e-12);
        let inside = Law::refracted(1.5).unwrap().scattered(wi, Side::Back).unwrap();
        let sine = 40.0f64.to_radians().sin() / 1.5;
        assert!(inside.distance(from_degrees(180.0 - sine.asin().to_degrees(), 210.0)) < 1e-12);
        let order = Law::OPPOSITE.shifted(DVec2::new(0.3, 0.0)).unwrap();
        let moved = order.scattered(from_degrees(20.0, 0.0), Side::Back).unwrap();
        assert!((moved.x - (0.3 - 20.0f64.to_radians().sin())).abs() < 1e-12 && moved.z < 0.0);
        let beyond = order.scattered(from_degrees(60.0, 180.0), Side::Back);
        assert!(beyond.is_none(), "{beyond:?}");
    }

    #[test]
    fn the_way_back_leads_back() {
        let law = Law::affine([[-0.6, 0.2], [0.1, -0.8]], [0.1, -0.05]).unwrap();
        for k in 0..50 {
            let wi = from_degrees(f64::from(k) * 1.1, f64::from(k) * 37.0);
            let Some(wo) = law.scattered(wi, Side::Back) else { continue };
            let back = law.reversed().scattered(wo, Side::Front).unwrap();
            assert!(back.distance(wi) < 1e-12, "{wi} {back}");
        }
    }

    #[test]
    fn no_law() {
        assert!(Law::affine([[1.0, 1.0], [1.0, 1.0]], [0.0; 2]).is_err());
        assert!(Law::affine([[f64::NAN, 0.0], [0.0, 1.0]], [0.0; 2]).is_err());
        assert!(Law::refracted(0.0).is_err());
        assert!(Law::OPPOSITE.shifted(DVec2::new(f64::INFINITY, 0.0)).is_err());
    }
}
