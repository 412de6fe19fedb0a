//! The error to expect between incidences, beside that of the fit.

mod support;

use bsdfkit::Side;
use bsdfkit_fit::interpolant::{Component, Encoding, FitSettings, Frame, Interpolant, Part};
use bsdfkit_fit::validate::{TRUSTED, expected_between};
use bsdfkit_measure::{Measurement, Symmetry};
use bsdfkit_represent::Watch;
use bsdfkit_simulate::material::{RetroSheet, six};
use bsdfkit_sphere::direction::from_degrees;
use support::{
    azimuths, coarse, distance_from_truth, fit, given, grid, instrument, measured, symmetry,
};

fn fitted(m: &Measurement) -> Interpolant {
    let fit = Interpolant::fit(std::slice::from_ref(m), &FitSettings::default(), &Watch::default());
    fit.unwrap_or_else(|e| panic!("{e}"))
}

fn component(interpolant: &Interpolant) -> &Component {
    match &interpolant.components[0] {
        Part::Transported(c) => c,
        Part::Sir(_) | Part::Dense(_) => panic!("expected a fitted part"),
    }
}

/// At its few incidences it fits, half-way between them much of its light is in a wrong place.
#[test]
fn a_retro_reflective_sheet_at_three_angles_fits_and_is_not_to_be_trusted() {
    let sheet = RetroSheet::default();
    let few = grid(&[0.0, 40.0, 75.0], &[0.0]);
    let fit = fitted(&measured(&instrument(), &sheet, Symmetry::Isotropic, &few));
    let c = component(&fit);
    let at = c.incidences().iter().map(|i| i.fit_error).sum::<f64>() / c.incidences().len() as f64;
    let half_way = [20.0, 57.5];
    let wrong = half_way.map(|t| {
        let wi = from_degrees(t, 0.0);
        distance_from_truth(&c.at(wi), &sheet, wi)
    });
    let expected = c.expected_error.expect("three incidences");
    println!("fit {at:.5}, expected {expected:.3}, half-way {wrong:.3?}");
    assert!(at < 2e-3, "{at}");
    let mean = wrong.iter().sum::<f64>() / 2.0;
    assert!(mean > 0.3, "{wrong:?}");
    assert!(expected > TRUSTED && expected < 2.0 * mean, "{expected} {mean}");
}

#[test]
fn the_six_are_to_be_trusted() {
    for material in six() {
        let (material, s) = (material.as_ref(), symmetry(material.as_ref()));
        let m =
            measured(&coarse(), material, s, &grid(&material.polar_angles(), &azimuths(s, 0.0)));
        let frame = if material.scattered() == Side::Front { Frame::Half } else { Frame::Turned };
        let c = fit(&m, &given(frame));
        let expected = expected_between(&m, &c, &Watch::default()).expect("not cancelled");
        let expected = expected.expect("many incidences");
        println!("{}: {expected:.4}", material.name());
        assert!(expected > 1e-4 && expected < 0.5 * TRUSTED, "{}: {expected}", material.name());
    }
}

#[test]
fn too_few_incidences_tell_nothing() {
    let sheet = RetroSheet::default();
    let of = |thetas: &[f64]| {
        let m = measured(&coarse(), &sheet, Symmetry::Isotropic, &grid(thetas, &[0.0]));
        component(&fitted(&m)).expected_error
    };
    assert_eq!(of(&[0.0, 40.0]), None);
    assert!(of(&[0.0, 30.0, 60.0]).is_some_and(|e| e > TRUSTED));
    // Four on an outline, none within.
    let corners = grid(&[40.0], &[0.0, 90.0, 180.0, 270.0]);
    let m = measured(&coarse(), &sheet, Symmetry::None, &corners);
    let c = component(&fitted(&m)).clone();
    assert_eq!(expected_between(&m, &c, &Watch::default()).expect("not cancelled"), None);
}

#[test]
fn files_keep_it_and_what_was_seen_and_older_ones_are_read() {
    let sheet = RetroSheet::default();
    let m = measured(&coarse(), &sheet, Symmetry::Isotropic, &grid(&[0.0, 30.0, 60.0], &[0.0]));
    let mut before = fitted(&m);
    for encoding in [Encoding::Plain, Encoding::Compact] {
        let after =
            Interpolant::from_bytes(&before.to_bytes(encoding).expect("bytes")).expect("read");
        let (a, b) = (component(&before), component(&after));
        assert!(a.expected_error.is_some());
        assert_eq!(a.expected_error, b.expected_error);
        for (x, y) in a.incidences().iter().zip(b.incidences()) {
            assert_eq!(x.seen, y.seen);
        }
    }
    // A file without either, as written before there were such.
    if let Part::Transported(c) = &mut before.components[0] {
        std::sync::Arc::make_mut(c).expected_error = None;
    }
    let bytes = before.to_bytes(Encoding::Plain).expect("bytes");
    let tensors = safetensors::SafeTensors::deserialize(&bytes).expect("ours");
    let kept = tensors.iter().filter(|(name, _)| !name.ends_with(".seen"));
    let (_, head) = safetensors::SafeTensors::read_metadata(&bytes).expect("ours");
    let old = safetensors::serialize(kept, head.metadata().clone()).expect("bytes");
    assert!(old.len() < bytes.len());
    let after = Interpolant::from_bytes(&old).expect("an older file");
    assert_eq!(component(&after).expected_error, None);
    assert!(
        component(&after)
            .incidences()
            .iter()
            .all(|i| (i.seen_share() - i.limit.powi(2)).abs() < 1e-12)
    );
}
