//! Spectral measurements: bands follow peaks, and are seen as light, colour and the sun's energy.

mod support;

use bsdfkit::spectrum::{Bands, Illuminant, View};
use bsdfkit::{Bsdf, Components, DVec3, Metadata};
use bsdfkit_fit::deliver::{Consumer, Kind, Order, Subject};
use bsdfkit_fit::interpolant::{Encoding, FitSettings, Interpolant};
use bsdfkit_measure::{Colorimetry, Incidence, Measurement, Symmetry};
use bsdfkit_represent::{Source, Watch};
use bsdfkit_simulate::Material;
use bsdfkit_simulate::material::PearlPaint;
use bsdfkit_sphere::direction::from_degrees;
use support::{grid, instrument, measurement};

/// Where values are compared: all over the hemisphere but the last degrees.
fn scattered() -> impl Iterator<Item = DVec3> {
    (0..240).map(|k| {
        let k = f64::from(k);
        from_degrees(((k + 0.5) / 240.0).sqrt() * 80.0, k * 137.508)
    })
}

fn paint(thetas: &[f64]) -> (PearlPaint, Bands, Measurement) {
    let paint = PearlPaint::default();
    let bands = Bands::new(paint.wavelengths()).unwrap();
    let scan = |&(theta, phi): &(f64, f64)| {
        let scan = instrument().scan(&paint, theta, phi);
        let points = scan.values.iter().zip(scan.bands.chunks_exact(bands.count()));
        let values: Vec<f64> = points
            .flat_map(|(y, bands)| std::iter::once(*y).chain(bands.iter().copied()))
            .collect();
        Incidence::new(scan.wi, scan.wo, values)
    };
    let incidences = grid(thetas, &[0.0]).iter().map(scan).collect();
    let mut m = measurement(paint.scattered(), Symmetry::Isotropic, incidences);
    m.colorimetry = Colorimetry::Spectral(bands.clone());
    (paint, bands, m)
}

fn fitted(m: &Measurement) -> Interpolant {
    Interpolant::fit(std::slice::from_ref(m), &FitSettings::default(), &Watch::default()).unwrap()
}

/// f of every band.
fn spectrum(bsdf: &Bsdf, wi: DVec3, wo: DVec3) -> Vec<f64> {
    let mut values = vec![0.0; bsdf.wavelengths().expect("bands").count()];
    bsdf.eval_bands(wi, wo, &mut values).unwrap();
    values
}

/// The hue of this paint turns with the angle: a spectrum that stayed at its place, or one of the mean hue, would be 0.05 and
/// more off.
#[test]
fn bands_between_incidences_are_as_near_as_luminance() {
    let (paint, bands, m) = paint(&[0.0, 15.0, 30.0, 45.0, 60.0]);
    let spectral = fitted(&m);
    let luminance = spectral.seen_as(View::Photopic(Illuminant::D65)).unwrap();
    let (part, whole) = (&spectral.components[0], spectral.bsdf());
    assert!(part.spectra().unwrap().rank() <= 4 && part.spectra().unwrap().error() < 0.004);
    for theta in [0.0, 22.5, 45.0, 52.5] {
        let wi = from_degrees(theta, 20.0);
        let (mut off, mut all, mut off_y, mut all_y) = (0.0, 0.0, 0.0, 0.0);
        for wo in scattered() {
            let told = spectrum(&whole, wi, wo);
            for (w, told) in bands.nanometres().iter().zip(&told) {
                let truth = paint.eval_at(wi, wo, *w);
                off += (told - truth).abs();
                all += truth;
            }
            let y = luminance.bsdf().eval(wi, wo);
            off_y += (y - paint.eval(wi, wo)).abs();
            all_y += paint.eval(wi, wo);
        }
        let (spectra, light) = (off / all, off_y / all_y);
        assert!(spectra < light + 0.01, "{theta}: {spectra} beside {light}");
        assert!(light < 0.02, "{theta}: {light}");
    }
}

#[test]
fn the_file_keeps_every_band() {
    let (_, bands, m) = paint(&[0.0, 40.0]);
    let before = fitted(&m);
    for (encoding, within) in [(Encoding::Plain, 2e-3), (Encoding::Compact, 0.021)] {
        let after = Interpolant::from_bytes(&before.to_bytes(encoding).unwrap()).unwrap();
        assert_eq!(after.bands(), Some(&bands));
        let wi = from_degrees(25.0, 10.0);
        let [first, second] = [&before, &after].map(Interpolant::bsdf);
        for wo in scattered() {
            for (a, b) in spectrum(&first, wi, wo).iter().zip(spectrum(&second, wi, wo)) {
                assert!((a - b).abs() <= within * (a + 1e-3), "{a} {b}");
            }
        }
    }
}

#[test]
fn a_file_whose_basis_is_short_or_no_number_is_refused() {
    let (_, _, m) = paint(&[0.0, 40.0]);
    let bytes = fitted(&m).to_bytes(Encoding::Plain).unwrap();
    let damaged = |from: &str, to: &str| {
        assert_eq!(from.len(), to.len());
        let at = bytes.windows(from.len()).position(|w| w == from.as_bytes()).unwrap();
        let mut bytes = bytes.clone();
        bytes[at..at + to.len()].copy_from_slice(to.as_bytes());
        Interpolant::from_bytes(&bytes).expect_err("refused").to_string()
    };
    // The array is no longer there.
    let message = damaged("component.0.spectra", "component.0.spectre");
    assert!(message.contains("component.0.spectra"), "{message}");
    let message = damaged("component.0.coefficient", "component.0.coefficienX");
    assert!(message.contains("component.0.coefficient"), "{message}");
}

/// Three channels where bands are seen in colour; grey where by the sun alone.
#[test]
fn tables_have_what_the_view_makes_of_bands() {
    let (paint, bands, m) = paint(&[0.0, 30.0, 60.0]);
    let spectral = fitted(&m);
    assert_eq!(spectral.components[0].channels(), 3);
    let wi = from_degrees(30.0, 0.0);
    let weights = View::Tristimulus(Illuminant::A).weights(&bands).unwrap();
    let seen = spectral.seen_as(View::Tristimulus(Illuminant::A)).unwrap().bsdf();
    for wo in scattered().step_by(7) {
        let truth: Vec<f64> =
            bands.nanometres().iter().map(|w| paint.eval_at(wi, wo, *w)).collect();
        let expected: Vec<f64> = weights.apply(&truth).collect();
        let found = seen.eval_xyz(wi, wo);
        for (found, expected) in [found.x, found.y, found.z].into_iter().zip(expected) {
            assert!((found - expected).abs() < 0.02 * expected, "{found} {expected}");
        }
    }
    let one = spectral.seen_as(View::Wavelength(620.0)).unwrap();
    assert_eq!(one.components[0].channels(), 1);
    let message = spectral.seen_as(View::Solar).expect_err("the sun").to_string();
    assert!(message.contains("solar") && message.contains("400 to 700 nm"), "{message}");

    let order = Order { view: Some(View::Wavelength(620.0)), ..Order::new(Kind::KlemsQuarter) };
    let subject = Subject::Continuous(&spectral);
    let made = order.deliver(subject, Metadata::default(), &Watch::default()).unwrap();
    let total = |bsdf: &bsdfkit::Bsdf| bsdf.directional_hemispherical(wi, Components::ALL);
    let (table, whole) = (total(&made.bsdf), total(&one.bsdf()));
    assert!((table / whole - 1.0).abs() < 0.05, "{table} {whole}");
}

/// Bands as far as the sun's energy goes give WINDOW a Solar band of its own.
#[test]
fn solar_is_measured_where_bands_reach_that_far() {
    let bands = Bands::new((0..23).map(|k| 300.0 + 100.0 * f64::from(k)).collect()).unwrap();
    // Lambertian: dark in the visible, bright beyond.
    let value = |w: f64| if w < 750.0 { 0.1 } else { 0.25 };
    let points: Vec<DVec3> = scattered().collect();
    let row: Vec<f64> =
        std::iter::once(0.1).chain(bands.nanometres().iter().map(|w| value(*w))).collect();
    let of = |theta: f64| {
        let values: Vec<f64> = points.iter().flat_map(|_| row.clone()).collect();
        Incidence::new(from_degrees(theta, 0.0), points.clone(), values)
    };
    let incidences = [0.0, 30.0, 60.0].map(of).into();
    let mut m = measurement(bsdfkit::Side::Front, Symmetry::Isotropic, incidences);
    m.colorimetry = Colorimetry::Spectral(bands.clone());
    let spectral = fitted(&m);
    let order = Order { consumer: Some(Consumer::Window), ..Order::new(Kind::KlemsFull) };
    let subject = Subject::Continuous(&spectral);
    let made = order.deliver(subject, Metadata::default(), &Watch::default()).unwrap();
    let weights = View::Solar.weights(&bands).unwrap();
    let expected: f64 = weights.apply(&row[1..]).sum::<f64>() * std::f64::consts::PI;
    let solar = made.bsdf.band("Solar").expect("a Solar band");
    let wi = from_degrees(20.0, 0.0);
    let found = solar.directional_hemispherical(wi, Components::REFLECTION);
    assert!((found / expected - 1.0).abs() < 0.01, "{found} {expected}");
    let visible = made.bsdf.directional_hemispherical(wi, Components::REFLECTION);
    assert!((visible / (0.1 * std::f64::consts::PI) - 1.0).abs() < 0.01, "{visible}");
    assert!(!made.said.iter().any(|s| s.contains("Solar is not known")), "{:?}", made.said);
}

/// What is reflected of each band is what that band alone reflects; together they weigh what light does.
#[test]
fn totals_of_bands_are_those_of_each_band_alone() {
    let (_, bands, m) = paint(&[0.0, 30.0, 60.0]);
    let spectral = fitted(&m);
    let whole = spectral.bsdf();
    let wi = [from_degrees(0.0, 0.0), from_degrees(40.0, 70.0)];
    let mut all = vec![0.0; 2 * bands.count()];
    whole.directional_hemispherical_bands_many(&wi, Components::ALL, &mut all).unwrap();
    for (wi, totals) in wi.iter().zip(all.chunks_exact(bands.count())) {
        for k in [0, 9, 22, 30] {
            let alone = spectral.seen_as(View::Wavelength(bands.nanometres()[k])).unwrap().bsdf();
            let total = alone.directional_hemispherical(*wi, Components::ALL);
            assert!((totals[k] / total - 1.0).abs() < 3e-3, "{k}: {} {total}", totals[k]);
        }
        let mut dark = vec![1.0; bands.count()];
        whole.directional_hemispherical_bands(*wi, Components::TRANSMISSION, &mut dark).unwrap();
        assert!(dark.iter().all(|total| *total == 0.0));
    }
    let message = whole.eval_bands(wi[0], wi[0], &mut [0.0; 3]).expect_err("too few").to_string();
    assert!(message.contains("expected 31 elements") && message.contains("found 3"), "{message}");
}
