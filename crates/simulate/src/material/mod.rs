//! Closed-form BSDFs, one class of material a file.

use std::f64::consts::PI;

use bsdfkit_sphere::{DVec2, DVec3, Side, concentric};

mod brushed_metal;
mod clear_coat;
mod clear_glass;
mod crossed_threads;
mod fabric;
mod facets;
mod fritted_glass;
mod grating_film;
mod haze_and_beam;
mod louver;
mod microfacet;
mod mirror_film;
mod narrow_metal;
mod optics;
mod peak;
mod pearl_paint;
mod perforated_screen;
mod perforated_sheet;
mod prism_film;
mod retro_sheet;
mod rotated_metal;
mod rough_dielectric;
mod ruled_film;
mod splitting_peak;
mod square_diffuser;
mod three_facet_film;
mod velvet;

pub use brushed_metal::BrushedMetal;
pub use clear_coat::ClearCoat;
pub use clear_glass::ClearGlass;
pub use crossed_threads::CrossedThreads;
pub use fabric::Fabric;
pub use fritted_glass::FrittedGlass;
pub use grating_film::GratingFilm;
pub use haze_and_beam::HazeAndBeam;
pub use louver::Louver;
pub use mirror_film::MirrorFilm;
pub use narrow_metal::NarrowMetal;
pub use peak::Peak;
pub use pearl_paint::PearlPaint;
pub use perforated_screen::PerforatedScreen;
pub use perforated_sheet::PerforatedSheet;
pub use prism_film::PrismFilm;
pub use retro_sheet::RetroSheet;
pub use rotated_metal::RotatedMetal;
pub use rough_dielectric::RoughDielectric;
pub use ruled_film::RuledFilm;
pub use splitting_peak::SplittingPeak;
pub use square_diffuser::SquareDiffuser;
pub use three_facet_film::ThreeFacetFilm;
pub use velvet::Velvet;

/// The symmetry that a material's formula has, which tells a laboratory what to measure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SymmetryHint {
    /// One plane of incidence suffices.
    Isotropic,
    /// Both mirrors: azimuths 0–90°.
    Quadrilateral,
    /// Mirror y → −y: azimuths 0–180°.
    Bilateral,
    /// Azimuths all around.
    None,
}

impl SymmetryHint {
    /// As files and the command line name it.
    pub fn name(self) -> &'static str {
        match self {
            SymmetryHint::Isotropic => "isotropic",
            SymmetryHint::Quadrilateral => "quadrilateral",
            SymmetryHint::Bilateral => "bilateral-y",
            SymmetryHint::None => "none",
        }
    }
}

/// A closed-form BSDF with one component, lit from the front.
pub trait Material: Send + Sync {
    /// The name in the [`registry`].
    fn name(&self) -> &'static str;

    /// f(wi, wo), 1/sr without cosine; 0 for directions on other sides than the component's. Without
    /// [`Material::peaks`].
    fn eval(&self, wi: DVec3, wo: DVec3) -> f64;

    /// Light from `wi` that goes all one way, or nearly: what no value of f tells.
    fn peaks(&self, _wi: DVec3) -> Vec<Peak> {
        Vec::new()
    }

    /// Wavelengths in nm at which it is measured; none: its light has no colour, and [`Material::eval`] tells all.
    fn wavelengths(&self) -> Vec<f64> {
        Vec::new()
    }

    /// f at one wavelength in nm.
    fn eval_at(&self, wi: DVec3, wo: DVec3, _nanometres: f64) -> f64 {
        self.eval(wi, wo)
    }

    /// The side that light is scattered to; it comes from the front.
    fn scattered(&self) -> Side;

    /// What the formula is symmetric to.
    fn symmetry(&self) -> SymmetryHint;

    /// Incident polar angles that a laboratory would measure, degrees, ascending.
    fn polar_angles(&self) -> Vec<f64> {
        vec![0.0, 15.0, 30.0, 45.0, 60.0, 75.0]
    }

    /// The parameters by name, for a record of the truth.
    fn parameters(&self) -> Vec<(&'static str, f64)>;

    /// ∫ f |cos θo| dωo over the scattered side, by 512² equal projected solid angles.
    fn albedo(&self, wi: DVec3) -> f64 {
        hemisphere(512, self.scattered()).map(|wo| self.eval(wi, wo)).sum::<f64>() * PI
            / (512.0 * 512.0)
    }
}

/// Directions on `side`, each for a projected solid angle of π / cells².
pub(crate) fn hemisphere(cells: usize, side: Side) -> impl Iterator<Item = DVec3> {
    (0..cells * cells).map(move |k| {
        let square = DVec2::new((k / cells) as f64 + 0.5, (k % cells) as f64 + 0.5);
        concentric::square_to_hemisphere(square / cells as f64, side)
    })
}

/// The six materials that the interpolant was built beside, with their default parameters: a surface of each usual class.
///
/// Tests and benches hold a figure for each of them.
pub fn six() -> Vec<Box<dyn Material>> {
    vec![
        Box::new(BrushedMetal::default()),
        Box::new(RotatedMetal::default()),
        Box::new(Fabric::default()),
        Box::new(PrismFilm::default()),
        Box::new(FrittedGlass::default()),
        Box::new(RoughDielectric::default()),
    ]
}

/// Those with peaks of no width beside what they scatter, with their default parameters, by name.
pub fn with_peaks() -> Vec<Box<dyn Material>> {
    vec![
        Box::new(ClearGlass::default()),
        Box::new(MirrorFilm::default()),
        Box::new(PerforatedSheet::default()),
        Box::new(RuledFilm::default()),
    ]
}

/// Every material with its default parameters: [`registry`], then those [`with_peaks`].
pub fn every() -> Vec<Box<dyn Material>> {
    let mut all = registry();
    all.extend(with_peaks());
    all
}

/// Every material without peaks of no width, with its default parameters: [`six`], then those whose light obeys more laws
/// than one, by name.
pub fn registry() -> Vec<Box<dyn Material>> {
    let mut all = six();
    all.extend(several_laws());
    all
}

fn several_laws() -> Vec<Box<dyn Material>> {
    vec![
        Box::new(ClearCoat::default()),
        Box::new(CrossedThreads::default()),
        Box::new(GratingFilm::default()),
        Box::new(HazeAndBeam::default()),
        Box::new(Louver::default()),
        Box::new(NarrowMetal::default()),
        Box::new(PearlPaint::default()),
        Box::new(PerforatedScreen::default()),
        Box::new(RetroSheet::default()),
        Box::new(SplittingPeak::default()),
        Box::new(SquareDiffuser::default()),
        Box::new(ThreeFacetFilm::default()),
        Box::new(Velvet::default()),
    ]
}

#[cfg(test)]
mod tests {
    use bsdfkit_sphere::direction::from_degrees;

    use super::*;

    #[test]
    fn no_material_returns_more_light_than_it_gets() {
        for material in registry() {
            for theta in [0.0, 20.0, 40.0, 60.0, 75.0, 85.0] {
                for phi in [0.0, 25.0, 90.0, 200.0] {
                    let albedo = material.albedo(from_degrees(theta, phi));
                    let name = material.name();
                    assert!(albedo > 0.01 && albedo <= 1.0, "{name} {theta} {phi}: {albedo}");
                }
            }
        }
    }

    /// Values of an independent implementation of the same formulas.
    #[test]
    fn values_agree_with_an_independent_implementation() {
        let expected = [
            0.096861052906,
            0.897525092902,
            0.599182825249,
            11.5580119277,
            0.0868595978588,
            1.73839464878,
            0.05784382939021753,
        ];
        let sheet: Box<dyn Material> = Box::new(RetroSheet::default());
        for (material, expected) in six().iter().chain([&sheet]).zip(expected) {
            let theta_o = if material.scattered() == Side::Front { 30.0 } else { 150.0 };
            let f = material.eval(from_degrees(40.0, 25.0), from_degrees(theta_o, 215.0));
            let name = material.name();
            assert!((f / expected - 1.0).abs() < 1e-9, "{name}: {f}, expected {expected}");
        }
    }

    #[test]
    fn reflection_is_reciprocal() {
        for material in registry().iter().filter(|m| m.scattered() == Side::Front) {
            for k in 0..100 {
                let k = f64::from(k);
                let a = from_degrees((k * 7.3) % 85.0, k * 41.0);
                let b = from_degrees((k * 11.9) % 85.0, k * 67.0);
                let (there, back) = (material.eval(a, b), material.eval(b, a));
                let name = material.name();
                assert!((there - back).abs() <= 1e-12 * there.max(1.0), "{name}: {there} {back}");
            }
        }
    }

    #[test]
    fn peaks_are_on_their_side_and_leave_no_more_light_than_came() {
        for material in with_peaks() {
            for (theta, phi) in [(0.0, 0.0), (20.0, 70.0), (50.0, 200.0), (80.0, 10.0)] {
                let wi = from_degrees(theta, phi);
                let peaks = material.peaks(wi);
                let light: f64 = peaks.iter().map(|p| p.coefficient).sum();
                let all = light + material.albedo(wi);
                let name = material.name();
                assert!(light > 0.01 && all <= 1.0, "{name} {theta} {phi}: {light} {all}");
                for p in peaks {
                    assert!((p.wo.length() - 1.0).abs() < 1e-12, "{name}");
                    assert_eq!(Side::of(p.wo), material.scattered(), "{name}");
                }
                assert!(material.peaks(-wi).is_empty(), "{name}");
            }
        }
    }

    #[test]
    fn symmetry_is_what_the_hint_says() {
        let mirror_x = |w: DVec3| DVec3::new(-w.x, w.y, w.z);
        let mirror_y = |w: DVec3| DVec3::new(w.x, -w.y, w.z);
        // not by a quarter: a square would come to lie on itself
        let turn = |w: DVec3| optics::turn_z(w, 37.0);
        for material in registry() {
            let z = material.scattered().sign();
            let (mut x, mut y, mut round) = (0.0f64, 0.0f64, 0.0f64);
            for k in 0..400 {
                let k = f64::from(k);
                let wi = from_degrees((k * 7.3) % 75.0, k * 41.0);
                let mut wo = from_degrees((k * 11.9) % 75.0, k * 67.0);
                wo.z *= z;
                let f = material.eval(wi, wo);
                let off = |map: &dyn Fn(DVec3) -> DVec3| {
                    (material.eval(map(wi), map(wo)) - f).abs() / f.max(1e-3)
                };
                x = x.max(off(&mirror_x));
                y = y.max(off(&mirror_y));
                round = round.max(off(&turn));
            }
            let holds = |worst: f64| worst < 1e-9;
            let expected = match material.symmetry() {
                SymmetryHint::Isotropic => (true, true, true),
                SymmetryHint::Quadrilateral => (true, true, false),
                SymmetryHint::Bilateral => (false, true, false),
                SymmetryHint::None => (false, false, false),
            };
            assert_eq!((holds(x), holds(y), holds(round)), expected, "{}", material.name());
        }
    }

    #[test]
    fn nothing_on_the_other_side() {
        for material in registry() {
            let front = from_degrees(20.0, 30.0);
            let back = from_degrees(150.0, 200.0);
            let wrong = if material.scattered() == Side::Front { back } else { front };
            assert_eq!(material.eval(front, wrong), 0.0, "{}", material.name());
            assert_eq!(material.eval(back, front), 0.0, "{}", material.name());
        }
    }

    #[test]
    fn the_six_come_first_and_the_others_by_name() {
        let names: Vec<_> = registry().iter().map(|m| m.name()).collect();
        assert!(six().iter().map(|m| m.name()).eq(names[..6].iter().copied()));
        assert!(names[6..].is_sorted(), "{names:?}");
    }

    #[test]
    fn names_are_unique() {
        let mut names: Vec<_> = every().iter().map(|m| m.name()).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), every().len());
    }
}
