//! Peaks of no width, told apart from what is scattered about them: against materials whose coefficients are known.

mod support;

use bsdfkit::spectrum::{Bands, Illuminant, View};
use bsdfkit::{Components, DVec3, Metadata, Part, Side};
use bsdfkit_fit::deliver::{Kind, Order, Subject};
use bsdfkit_fit::interpolant::{Encoding, FitSettings, Frame, Interpolant};
use bsdfkit_fit::specular::{Separated, Signature, separate};
use bsdfkit_measure::{Colorimetry, Measurement, Mirror, Symmetry};
use bsdfkit_represent::Watch;
use bsdfkit_simulate::material::{ClearGlass, MirrorFilm, PerforatedSheet, RuledFilm};
use bsdfkit_simulate::{Goniophotometer, Material, SymmetryHint};
use bsdfkit_sphere::direction::{from_degrees, to_degrees};
use support::{coarse, grid, hemisphere, measured};

const THETAS: [f64; 6] = [0.0, 15.0, 30.0, 45.0, 60.0, 75.0];

/// A material, its symmetry, and the angles that it is measured at.
type Case = (Box<dyn Material>, Symmetry, Vec<(f64, f64)>);

fn materials() -> Vec<Case> {
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
    // Points elsewhere, middles found elsewhere.
    let dense = Goniophotometer { sweeps: 36, points_per_sweep: 120, seed: 5, ..coarse() };
    let both = materials().into_iter().map(|m| (m, coarse()));
    let all = both.chain(materials().into_iter().take(2).map(|m| (m, dense.clone())));
    for ((material, symmetry, angles), gonio) in all {
        let found = separated(&gonio, &*material, symmetry, &angles);
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
            for (theta, phi) in
                [(7.0, 10.0), (22.0, 50.0), (38.0, 100.0), (52.0, 75.0), (68.0, 20.0)]
            {
                let wi = from_degrees(theta, phi);
                let Some(wo) = law.scattered(wi, material.scattered()) else { continue };
                if wo.z.abs() < 0.26 {
                    continue; // beyond what was seen
                }
                let coefficient = peak.specular.coefficient.at(wi).y;
                let off = coefficient / truth(&*material, wi, wo) - 1.0;
                println!(
                    "{name} {} held out {theta}: {coefficient:.4} off {off:.4}",
                    law_name(peak)
                );
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

/// A glass that is weaker toward the blue, by the same share in every direction: its peak has that colour in daylight.
#[test]
fn a_peak_of_a_spectrum_has_its_colour() {
    let wavelengths: Vec<f64> = (0..16).map(|k| 380.0 + 25.0 * f64::from(k)).collect();
    let shares: Vec<f64> = (0..16).map(|k| 0.25 + 0.05 * f64::from(k)).collect();
    let bands = Bands::new(wavelengths).unwrap();
    let seen = View::Colour(Illuminant::D65).weights(&bands).unwrap();
    let tint: Vec<f64> = seen.apply(&shares).collect();
    assert!(tint[2] < 0.7 * tint[1], "{tint:?}");
    let gonio = coarse();
    let mut m =
        measured(&gonio, &ClearGlass::default(), Symmetry::Isotropic, &grid(&THETAS, &[0.0]));
    for incidence in &mut m.incidences {
        let row = |y: &f32| {
            std::iter::once(tint[1] as f32 * y)
                .chain(shares.iter().map(|s| *s as f32 * y))
                .collect::<Vec<_>>()
        };
        incidence.values = incidence.values.iter().flat_map(row).collect();
    }
    m.colorimetry = Colorimetry::Spectral(bands);
    let signature = Signature::of_aperture(gonio.aperture_degrees).unwrap();
    let found = separate(&m, &signature).unwrap();
    assert_eq!(found.peaks.len(), 1);
    for theta in [0.0, 30.0, 60.0] {
        let wi = from_degrees(theta, 0.0);
        let c = found.peaks[0].specular.coefficient.at(wi);
        for (a, b) in [(c.x / c.y, tint[0] / tint[1]), (c.z / c.y, tint[2] / tint[1])] {
            assert!((a / b - 1.0).abs() < 0.01, "{theta}: {a} {b}");
        }
        let expected = tint[1] * ClearGlass::default().peaks(wi)[0].coefficient;
        assert!((c.y / expected - 1.0).abs() < 0.02, "{theta}: {} {expected}", c.y);
    }
}

/// No peak where there is none: materials that may be looked at, through apertures of usual size.
#[test]
fn nothing_is_separated_where_nothing_is() {
    use bsdfkit_simulate::material::*;
    let quarter = [0.0, 30.0, 60.0, 90.0];
    let half = [0.0, 30.0, 60.0, 90.0, 120.0, 150.0, 180.0];
    let whole: Vec<f64> = (0..12).map(|k| 30.0 * f64::from(k)).collect();
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
        (Box::new(RotatedMetal::default()), Symmetry::None, &whole),
    ];
    for (material, symmetry, phis) in cases {
        let angles = grid(&THETAS, phis);
        let gonio = Goniophotometer { relative_noise: 0.02, ..coarse() };
        let m = measured(&gonio, &*material, symmetry, &angles);
        for aperture in [0.5, 1.0, 2.0] {
            let found = separate(&m, &Signature::of_aperture(aperture).unwrap()).unwrap();
            let laws: Vec<String> = found.peaks.iter().map(|p| p.specular.name()).collect();
            assert!(laws.is_empty(), "{} {aperture}°: {laws:?}", material.name());
        }
    }
}

/// A material without its peaks.
struct Without<'a>(&'a dyn Material);

impl Material for Without<'_> {
    fn name(&self) -> &'static str {
        self.0.name()
    }

    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        self.0.eval(wi, wo)
    }

    fn scattered(&self) -> Side {
        self.0.scattered()
    }

    fn symmetry(&self) -> SymmetryHint {
        self.0.symmetry()
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        self.0.parameters()
    }
}

/// L1 of the continuous part at an incidence that was not measured, and what the whole has.
fn rest_error(m: &Measurement, settings: &FitSettings, material: &dyn Material) -> (f64, f64) {
    let fitted = Interpolant::fit(std::slice::from_ref(m), settings, &Watch::default()).unwrap();
    let bsdf = fitted.bsdf();
    let wi = from_degrees(38.0, 100.0);
    let (mut off, mut all) = (0.0, 0.0);
    for wo in hemisphere(64, material.scattered(), 80.0) {
        let f = material.eval(wi, wo);
        off += (bsdf.eval(wi, wo) - f).abs();
        all += f;
    }
    (off / all, bsdf.directional_hemispherical(wi, Components::ALL))
}

/// The fit of the rest is as good as if the peaks had never been there, and the whole has all the light.
#[test]
fn the_rest_is_fitted_as_without_the_peak() {
    for (material, symmetry, angles) in materials().into_iter().take(3) {
        let name = material.name();
        let frame = FitSettings { frame: Some(Frame::Shift), ..FitSettings::default() };
        let signature = Some(Signature::of_aperture(1.0).unwrap());
        let apart = FitSettings { signature, ..frame.clone() };
        let with = measured(&coarse(), &*material, symmetry, &angles);
        let without = measured(&coarse(), &Without(&*material), symmetry, &angles);
        let (error, total) = rest_error(&with, &apart, &*material);
        let (bare, rest) = rest_error(&without, &frame, &*material);
        println!(
            "{name}: L1 {error:.4}, without the peak {bare:.4}; total {total:.4}, rest {rest:.4}"
        );
        assert!(error < bare + 0.005, "{name}: {error} {bare}");
        let wi = from_degrees(38.0, 100.0);
        let peaks: f64 = material.peaks(wi).iter().map(|p| p.coefficient).sum();
        assert!((total / (rest + peaks) - 1.0).abs() < 0.02, "{name}: {total} {rest} {peaks}");
    }
}

/// The peak goes with the interpolant: its file has it exactly, a tree made of it as well.
#[test]
fn interpolants_keep_their_peaks() {
    let (material, symmetry, angles) = materials().swap_remove(0);
    let m = measured(&coarse(), &*material, symmetry, &angles);
    let signature = Some(Signature::of_aperture(1.0).unwrap());
    let settings = FitSettings { frame: Some(Frame::Shift), signature, ..FitSettings::default() };
    let fitted = Interpolant::fit(std::slice::from_ref(&m), &settings, &Watch::default()).unwrap();
    assert_eq!(fitted.specular.len(), 1);
    let bytes = fitted.to_bytes(Encoding::Plain).unwrap();
    let back = Interpolant::from_bytes(&bytes).unwrap();
    assert_eq!(back.specular, fitted.specular);
    assert_eq!(back.to_bytes(Encoding::Plain).unwrap(), bytes);
    let order = Order::new(Kind::KlemsQuarter);
    let made =
        order.deliver(Subject::Continuous(&back), Metadata::default(), &Watch::default()).unwrap();
    assert_eq!(made.bsdf.specular(), &fitted.specular[..]);
    let wi = from_degrees(20.0, 0.0);
    let [a, b] =
        [&fitted.bsdf(), &made.bsdf].map(|b| b.directional_hemispherical(wi, Components::ALL));
    assert!((a / b - 1.0).abs() < 0.01, "{a} {b}");
    // Samples of a mixture whose continuous part is drawn by a table near it.
    let bsdf = fitted.bsdf();
    let (mut mean, mut peaks) = (0.0, 0);
    for k in 0..2000 {
        let sample = bsdf.sample(wi, (f64::from(k) + 0.5) / 2000.0, Components::ALL).unwrap();
        mean += sample.weight / 2000.0;
        peaks += i32::from(matches!(sample.part, Part::Specular(0)));
    }
    let share = bsdf.specular()[0].coefficient.at(wi).y / a;
    assert!((mean / a - 1.0).abs() < 5e-3, "{mean} {a}");
    assert!((f64::from(peaks) / 2000.0 - share).abs() < 2e-3, "{peaks} {share}");
}

/// The empty beam as a table: points of a spiral about the direction straight through.
fn empty_beam(aperture_degrees: f64, incidences: &[f64]) -> String {
    let mut text = "theta_i phi_i theta_o phi_o BTDF\n".to_owned();
    for theta in incidences {
        let wi = from_degrees(*theta, 0.0);
        let (u, v) = (-wi).any_orthonormal_pair();
        for k in 0..800 {
            let r = 2.0 * aperture_degrees.to_radians() * (f64::from(k) / 800.0).sqrt();
            let (y, x) = (2.4 * f64::from(k)).sin_cos();
            let w = (-wi + r * (x * u + y * v)).normalize();
            let inside = w.angle_between(-wi) < 0.5 * aperture_degrees.to_radians();
            let f = if inside { 1000.0 / w.z.abs() } else { 0.0 };
            let (theta_o, phi_o) = to_degrees(w);
            text += &format!("{theta} 0 {theta_o:.4} {phi_o:.4} {f}\n");
        }
    }
    text
}

#[test]
fn a_scan_of_the_empty_beam_is_a_signature() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("empty.txt");
    let read = |text: String| {
        std::fs::write(&path, text).unwrap();
        Signature::read(&path)
    };
    let signature = read(empty_beam(1.2, &[0.0])).unwrap();
    let radius = signature.radius().to_degrees();
    assert!((radius - 0.6).abs() < 0.03, "{radius}");
    // As good as the aperture's own.
    let gonio = Goniophotometer { aperture_degrees: 1.2, ..coarse() };
    let (material, symmetry, angles) = materials().swap_remove(0);
    let found = separate(&measured(&gonio, &*material, symmetry, &angles), &signature).unwrap();
    assert_eq!(found.peaks.len(), 1);
    for (wi, coefficient) in &found.peaks[0].measured {
        let off = coefficient / material.peaks(*wi)[0].coefficient - 1.0;
        println!("by a scan, {:.0}: off {off:.4}", wi.z.acos().to_degrees());
        assert!(off.abs() < 0.03, "{wi}: {off}");
    }
    let refused = |text: String, words: &str| {
        let error = read(text).unwrap_err().to_string();
        assert!(error.contains("empty.txt") && error.contains(words), "{error}");
    };
    refused(empty_beam(1.2, &[0.0, 20.0]), "one incident direction (the empty beam), found 2");
    refused(empty_beam(25.0, &[0.0]), "expected a peak narrower than 10 degrees");
}
