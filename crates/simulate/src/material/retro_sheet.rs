//! A retro-reflective sheet: light goes back to where it came from, less the more aslant it comes; a film on top mirrors.
//!
//! Between incidences its two peaks move in opposite senses while one takes over from the other: at every
//! measured incidence it is as easy to fit as any, between them it is not to be interpolated from a few.

use std::f64::consts::FRAC_1_PI;

use bsdfkit_sphere::{DVec3, Side};

use super::optics::{schlick, soft_cosine, spherical_gaussian};
use super::{Material, SymmetryHint};

/// Beads or cube corners under a clear film, on a diffuse ground.
///
/// f = diffuse/π + (retro √(cᵢᶠ cₒᶠ) G(wi·wo) + √(S(cᵢ) S(cₒ)) G(mirrored wi·wo)) / √(s(cᵢ) s(cₒ)), with c the cosines, f the
/// fading, G Gaussians on the sphere, S Schlick's reflectance of the film and s the softened cosine.
#[derive(Clone, Debug)]
pub struct RetroSheet {
    /// What is sent back at normal incidence.
    pub retro: f64,
    /// Width of the peak that is sent back.
    pub retro_degrees: f64,
    /// What is sent back falls with this power of the cosine of incidence.
    pub fading: f64,
    /// Reflectance of the film at normal incidence; 1 at grazing.
    pub film: f64,
    /// Width of the peak that the film mirrors.
    pub film_degrees: f64,
    /// Lambertian reflectance of the ground.
    pub diffuse: f64,
}

impl Default for RetroSheet {
    fn default() -> Self {
        Self {
            retro: 0.5,
            retro_degrees: 5.0,
            fading: 4.0,
            film: 0.04,
            film_degrees: 4.0,
            diffuse: 0.1,
        }
    }
}

impl Material for RetroSheet {
    fn name(&self) -> &'static str {
        "retro-sheet"
    }

    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        let back = spherical_gaussian(wi.dot(wo), self.retro_degrees.to_radians());
        let mirrored = DVec3::new(-wi.x, -wi.y, wi.z);
        let aside = spherical_gaussian(mirrored.dot(wo), self.film_degrees.to_radians());
        let retro = self.retro * (wi.z * wo.z).powf(0.5 * self.fading);
        let film = (schlick(wi.z, self.film) * schlick(wo.z, self.film)).sqrt();
        let flat = (soft_cosine(wi.z) * soft_cosine(wo.z)).sqrt();
        (retro * back + film * aside) / flat + self.diffuse * FRAC_1_PI
    }

    fn scattered(&self) -> Side {
        Side::Front
    }

    fn symmetry(&self) -> SymmetryHint {
        SymmetryHint::Isotropic
    }

    /// As few as are measured of a sheet that is taken for a simple one.
    fn polar_angles(&self) -> Vec<f64> {
        vec![0.0, 20.0, 40.0, 60.0, 75.0]
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![
            ("retro", self.retro),
            ("retro_degrees", self.retro_degrees),
            ("fading", self.fading),
            ("film", self.film),
            ("film_degrees", self.film_degrees),
            ("diffuse", self.diffuse),
        ]
    }
}

#[cfg(test)]
mod tests {
    use bsdfkit_sphere::direction::from_degrees;
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn one_peak_fades_while_the_other_grows() {
        let sheet = RetroSheet::default();
        // At their tops each peak is alone; Gaussians so narrow have 1/(2π σ²) there.
        let top = |degrees: f64| 1.0 / (2.0 * PI * degrees.to_radians().powi(2));
        for theta in [30.0f64, 45.0, 60.0] {
            let (wi, mirrored) = (from_degrees(theta, 20.0), from_degrees(theta, 200.0));
            let cosine = theta.to_radians().cos();
            let of = |share: f64, degrees: f64| {
                share * top(degrees) / soft_cosine(cosine) + sheet.diffuse / PI
            };
            let back = of(sheet.retro * cosine.powi(4), sheet.retro_degrees);
            let aside = of(schlick(cosine, sheet.film), sheet.film_degrees);
            assert!((sheet.eval(wi, wi) / back - 1.0).abs() < 1e-3, "{theta}");
            assert!((sheet.eval(wi, mirrored) / aside - 1.0).abs() < 1e-3, "{theta}");
        }
    }

    #[test]
    fn at_the_normal_light_is_that_of_one_integral_over_the_polar_angle() {
        let sheet = RetroSheet::default();
        let steps = 20_000;
        let h = 0.5 * PI / f64::from(steps);
        let at = |k: i32| {
            let theta = (f64::from(k) + 0.5) * h;
            let f = sheet.eval(DVec3::Z, from_degrees(theta.to_degrees(), 70.0));
            2.0 * PI * f * theta.sin() * theta.cos() * h
        };
        let light: f64 = (0..steps).map(at).sum();
        let whole = sheet.retro + sheet.film + sheet.diffuse;
        assert!((sheet.albedo(DVec3::Z) / light - 1.0).abs() < 1e-3);
        // Wide peaks lose a little: 2 % of √(c/s) c^2 and less, on the mean.
        assert!(light < whole && light > 0.96 * whole, "{light} {whole}");
    }
}
