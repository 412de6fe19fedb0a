//! Trees and the render form of a spectral measurement keep its bands: values, energy of each band, files.

mod support;

use bsdfkit::spectrum::{Bands, View};
use bsdfkit::xml::{self, Limits, WriteOptions};
use bsdfkit::{Bsdf, Components, DVec3, Lambertian, Lookup, Metadata, container};
use bsdfkit_fit::deliver::{Kind, Order, Subject};
use bsdfkit_fit::interpolant::{FitSettings, Interpolant};
use bsdfkit_measure::{Colorimetry, Incidence, Symmetry};
use bsdfkit_represent::Watch;
use bsdfkit_represent::tabulate::{Form, TreeSettings, component};
use bsdfkit_simulate::Material;
use bsdfkit_simulate::material::PearlPaint;
use bsdfkit_sphere::direction::from_degrees;
use support::{grid, instrument, measurement};

/// A paint whose hue turns with the angle, in 31 bands.
fn paint() -> Interpolant {
    let paint = PearlPaint::default();
    let bands = Bands::new(paint.wavelengths()).unwrap();
    let scan = |&(theta, phi): &(f64, f64)| {
        let scan = instrument().scan(&paint, theta, phi);
        let points = scan.values.iter().zip(scan.bands.chunks_exact(bands.count()));
        let row = |(y, bands): (&f64, &[f64])| [&[*y], bands].concat();
        Incidence::new(scan.wi, scan.wo, points.flat_map(row))
    };
    let incidences = grid(&[0.0, 15.0, 30.0, 45.0, 60.0, 75.0], &[0.0]).iter().map(scan).collect();
    let mut m = measurement(paint.scattered(), Symmetry::Isotropic, incidences);
    m.colorimetry = Colorimetry::Spectral(bands.clone());
    Interpolant::fit(&[m], &FitSettings::default(), &Watch::default()).unwrap()
}

fn made(of: &Interpolant, order: &Order) -> Bsdf {
    order.deliver(Subject::Continuous(of), Metadata::default(), &Watch::default()).unwrap().bsdf
}

fn scattered() -> Vec<DVec3> {
    (0..400)
        .map(|k| from_degrees(((f64::from(k) + 0.5) / 400.0).sqrt() * 80.0, f64::from(k) * 137.508))
        .collect()
}

fn bands(bsdf: &Bsdf, wi: DVec3, wo: &[DVec3]) -> Vec<f64> {
    let mut out = vec![0.0; wo.len() * bsdf.expect_wavelengths().unwrap().count()];
    bsdf.eval_bands_many(&[wi], wo, &mut out).unwrap();
    out
}

/// Relative L1.
fn l1(found: &[f64], truth: &[f64]) -> f64 {
    let off: f64 = found.iter().zip(truth).map(|(a, b)| (a - b).abs()).sum();
    off / truth.iter().sum::<f64>()
}

fn luminance(bsdf: &Bsdf, wi: DVec3, wo: &[DVec3]) -> Vec<f64> {
    wo.iter().map(|wo| bsdf.eval(wi, *wo)).collect()
}

/// `table` against the continuous function: bands as near as so many times luminance and some more; energy of each band within `energy`.
fn expect_bands(table: &Bsdf, whole: &Bsdf, [times, more]: [f64; 2], energy: f64) {
    assert_eq!(table.wavelengths(), whole.wavelengths());
    let wo = scattered();
    for (theta, phi) in [(0.0, 0.0), (22.5, 20.0), (45.0, 100.0), (67.5, 250.0)] {
        let wi = from_degrees(theta, phi);
        let told = bands(table, wi, &wo);
        let spectra = l1(&told, &bands(whole, wi, &wo));
        let light = l1(&luminance(table, wi, &wo), &luminance(whole, wi, &wo));
        println!("{theta}: bands {spectra:.4}, luminance {light:.4}");
        assert!(spectra < times * light + more, "{theta}: {spectra} beside {light}");
        let count = told.len() / wo.len();
        let [mut a, mut b] = [vec![0.0; count], vec![0.0; count]];
        table.directional_hemispherical_bands(wi, Components::ALL, &mut a).unwrap();
        whole.directional_hemispherical_bands(wi, Components::ALL, &mut b).unwrap();
        let worst = a.iter().zip(&b).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max);
        println!("{theta}: energy of a band at most {worst:.4} off");
        assert!(worst < energy, "{theta}: {worst}");
    }
    let nan = DVec3::NAN;
    let mut out = vec![0.0; whole.expect_wavelengths().unwrap().count()];
    table.eval_bands(nan, wo[0], &mut out).unwrap();
    assert!(out.iter().all(|v| v.is_nan()));
    table.eval_bands(wo[0], DVec3::NEG_Z, &mut out).unwrap();
    assert!(out.iter().all(|v| *v == 0.0));
}

/// What a file holds is what was written, bit for bit; damage is refused with its place.
fn expect_kept(table: &Bsdf, array: &str) {
    let bytes = container::to_bytes(table).unwrap();
    let again = container::from_bytes(&bytes).unwrap();
    let (wi, wo) = (from_degrees(37.0, 15.0), scattered());
    assert_eq!(bands(table, wi, &wo), bands(&again, wi, &wo));
    let path =
        std::env::temp_dir().join(format!("bands-{}-{array}.safetensors", std::process::id()));
    container::save(table, &path).unwrap();
    let opened = container::open(&path).unwrap();
    assert_eq!(bands(table, wi, &wo), bands(&opened, wi, &wo));
    drop(opened);
    std::fs::remove_file(&path).unwrap();
    for name in [array, "spectra\""] {
        let at = bytes.windows(name.len()).position(|w| w == name.as_bytes()).expect(name);
        let mut damaged = bytes.clone();
        damaged[at] = b'X';
        let message = container::from_bytes(&damaged).expect_err("refused").to_string();
        assert!(message.contains(name.trim_end_matches('"')), "{message}");
    }
}

#[test]
fn the_render_form_keeps_bands() {
    let spectral = paint();
    let whole = spectral.bsdf();
    let table = made(&spectral, &Order::new(Kind::Render));
    expect_bands(&table, &whole, [1.0, 0.005], 0.018);
    expect_kept(&table, "hue\"");
    // A view that was asked for is all that is kept.
    let order = Order { view: Some(View::Wavelength(620.0)), ..Order::new(Kind::Render) };
    assert_eq!(made(&spectral, &order).wavelengths(), None);
    let message =
        made(&spectral, &order).eval_bands(DVec3::Z, DVec3::Z, &mut []).expect_err("none");
    assert!(message.to_string().contains("found none"), "{message}");
}

#[test]
fn trees_keep_bands() {
    let spectral = paint();
    let whole = spectral.bsdf();
    let settings = TreeSettings {
        max_leaves: Some(20_000),
        max_depth: Some(7),
        max_samples: Some(400_000),
        ..TreeSettings::default()
    };
    let tree = |bands: bool| {
        let form = Form::Tree(TreeSettings { bands, ..settings });
        let made = component(&spectral.components[0], &form, &Watch::default()).unwrap();
        Bsdf::new(Metadata::default(), vec![made.component], Lambertian::default())
    };
    assert!(tree(false).wavelengths().is_none());
    let table = tree(true);
    // A leaf has one hue, as it has one luminance.
    expect_bands(&table, &whole, [1.4, 0.005], 0.04);
    expect_kept(&table, "hue\"");
    // Smooth lookup leaves hue as it is stored: bands come nearer, but less than luminance does.
    expect_bands(&table.clone().with_lookup(Lookup::Smooth).unwrap(), &whole, [1.0, 0.045], 0.04);
    // XML has what its readers take.
    let mut text = Vec::new();
    xml::write_to(&table, &mut text, &WriteOptions::default()).unwrap();
    let (read, _) = xml::from_bytes(&text, &Limits::default()).unwrap();
    assert!(read.wavelengths().is_none() && read.components()[0].distribution().is_coloured());
}
