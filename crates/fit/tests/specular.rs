//! Peaks of no width, told apart from what is scattered about them: against materials whose coefficients are known.

#[allow(dead_code, reason = "other tests use the rest")]
mod support;

use bsdfkit::DVec3;
use bsdfkit_fit::measurement::{Mirror, Symmetry};
use bsdfkit_fit::specular::{Separated, Signature, separate};
use bsdfkit_simulate::material::{ClearGlass, MirrorFilm, PerforatedSheet, RuledFilm};
use bsdfkit_simulate::{Goniophotometer, Material};
use bsdfkit_sphere::direction::from_degrees;
use support::{coarse, grid, measured};

const THETAS: [f64; 6] = [0.0, 15.0, 30.0, 45.0, 60.0, 75.0];

fn materials() -> Vec<(Box<dyn Material>, Symmetry, Vec<(f64, f64)>)> {
    let ring = grid(&THETAS, &[0.0]);
    let half = grid(&THETAS, &[0.0, 30.0, 60.0, 90.0, 120.0, 150.0, 180.0]);
    vec![
        (Box::new(ClearGlass::default()), Symmetry::Isotropic, ring.clone()),
        (Box::new(MirrorFilm::default()), Symmetry::Isotropic, ring.clone()),
        (Box::new(PerforatedSheet::default()), Symmetry::Isotropic, ring),
        (Box::new(RuledFilm::default()), Symmetry::Bilateral(Mirror::Y), half),
    ]
}

fn separated(
    gonio: &Goniophotometer,
    material: &dyn Material,
    symmetry: Symmetry,
    angles: &[(f64, f64)],
) -> Separated {
    let m = measured(gonio, material, symmetry, angles);
    let signature = Signature::of_aperture(gonio.aperture_degrees).unwrap();
    separate(&m, &signature).unwrap()
}

/// The true coefficient of the peak that stands where a law says; 0 where none does.
fn truth(material: &dyn Material, wi: DVec3, wo: DVec3) -> f64 {
    let peaks = material.peaks(wi).into_iter();
    peaks.filter(|p| p.wo.angle_between(wo) < 2e-3).map(|p| p.coefficient).sum()
}

/// Within 1 % where it was measured, and 2 % where it was not.
#[test]
fn coefficients_are_found() {
    for (material, symmetry, angles) in materials() {
        let found = separated(&coarse(), &*material, symmetry, &angles);
        let name = material.name();
        let laws: Vec<String> = found.peaks.iter().map(|p| p.specular.name()).collect();
        assert_eq!(laws.len(), material.peaks(DVec3::Z).len(), "{name}: {laws:?}");
        for peak in &found.peaks {
            let law = peak.specular.law;
            assert!(peak.measured.len() >= 4, "{name}: {}", peak.measured.len());
            for &(wi, coefficient) in &peak.measured {
                let wo = law.scattered(wi, material.scattered()).unwrap();
                let off = coefficient / truth(&*material, wi, wo) - 1.0;
                let theta = wi.z.acos().to_degrees();
                println!("{name} {} {theta:.0}: {coefficient:.4} off {off:.4}", law_name(peak));
                assert!(off.abs() < 0.01, "{name} at {wi}: {coefficient}, off by {off}");
            }
            for (theta, phi) in [(7.0, 10.0), (22.0, 50.0), (38.0, 100.0), (52.0, 75.0), (68.0, 20.0)] {
                let wi = from_degrees(theta, phi);
                let Some(wo) = law.scattered(wi, material.scattered()) else { continue };
                if wo.z.abs() < 0.26 {
                    continue; // beyond what was seen
                }
                let coefficient = peak.specular.coefficient.at(wi).y;
                let off = coefficient / truth(&*material, wi, wo) - 1.0;
                println!("{name} {} held out {theta}: {coefficient:.4} off {off:.4}", law_name(peak));
                assert!(off.abs() < 0.02, "{name} at {theta} {phi}: {coefficient}, off by {off}");
            }
        }
    }
}

fn law_name(peak: &bsdfkit_fit::specular::FoundPeak) -> String {
    peak.specular.name()
}

/// What is left is what the material scatters: nowhere far from it, and the points are all there.
#[test]
fn the_surround_is_left() {
    for (material, symmetry, angles) in materials() {
        let m = measured(&coarse(), &*material, symmetry, &angles);
        let found = separated(&coarse(), &*material, symmetry, &angles);
        let name = material.name();
        for (before, after) in m.incidences.iter().zip(&found.measurement.incidences) {
            assert_eq!(before.wo.len(), after.wo.len(), "{name}");
            let (mut off, mut all) = (0.0, 0.0);
            for (wo, f) in after.points(0) {
                let true_f = material.eval(after.wi, wo);
                off += (f - true_f).abs() * wo.z.abs();
                all += true_f * wo.z.abs();
            }
            let theta = after.wi.z.acos().to_degrees();
            println!("{name} {theta:.0}: {:.5}", off / all);
            assert!(off / all < 0.005, "{name} at {theta}: {}", off / all);
        }
    }
}

/// No peak where there is none: materials that may be looked at, through apertures of usual size.
#[test]
fn nothing_is_separated_where_nothing_is() {
    use bsdfkit_simulate::material::*;
    let quarter = [0.0, 30.0, 60.0, 90.0];
    let half = [0.0, 30.0, 60.0, 90.0, 120.0, 150.0, 180.0];
    let all = Symmetry::Quadrilateral;
    let cases: Vec<(Box<dyn Material>, Symmetry, &[f64])> = vec![
        (Box::new(BrushedMetal::default()), all, &quarter),
        (Box::new(Fabric::default()), Symmetry::Bilateral(Mirror::Y), &half),
        (Box::new(PrismFilm::default()), Symmetry::Bilateral(Mirror::Y), &half),
        (Box::new(FrittedGlass::default()), Symmetry::Isotropic, &[0.0]),
        (Box::new(RoughDielectric::default()), Symmetry::Isotropic, &[0.0]),
        (Box::new(ClearCoat::default()), all, &quarter),
        (Box::new(GratingFilm::default()), Symmetry::Bilateral(Mirror::Y), &half),
        (Box::new(Louver::default()), Symmetry::Bilateral(Mirror::Y), &half),
        (Box::new(PerforatedScreen::default()), all, &quarter),
        (Box::new(SplittingPeak::default()), Symmetry::Bilateral(Mirror::Y), &half),
        (Box::new(ThreeFacetFilm::default()), Symmetry::Bilateral(Mirror::Y), &half),
    ];
    for (material, symmetry, phis) in cases {
        let angles = grid(&THETAS, phis);
        for noise in [0.0, 0.03] {
            let gonio = Goniophotometer { relative_noise: noise, ..coarse() };
            let m = measured(&gonio, &*material, symmetry, &angles);
            for aperture in [0.5, 1.0, 2.0] {
                let found = separate(&m, &Signature::of_aperture(aperture).unwrap()).unwrap();
                let laws: Vec<String> = found.peaks.iter().map(|p| p.specular.name()).collect();
                assert!(laws.is_empty(), "{} {aperture}° {noise}: {laws:?}", material.name());
            }
        }
    }
}

