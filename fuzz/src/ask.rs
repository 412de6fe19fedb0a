//! What is asked of whatever a reader opened.

use bsdfkit::matrix::KlemsMatrix;
use bsdfkit::render::RenderTable;
use bsdfkit::tree::TreeDistribution;
use bsdfkit::{Bsdf, Component, Components, DVec2, DVec3, Lookup};

/// Front, back, along the horizon, the axis, and what no direction is.
pub const DIRECTIONS: [DVec3; 9] = [
    DVec3::Z,
    DVec3::NEG_Z,
    DVec3::X,
    DVec3::new(0.6, 0.0, 0.8),
    DVec3::new(-0.48, 0.36, -0.8),
    DVec3::new(0.0, 0.999_998_5, 0.001_732_050_8),
    DVec3::new(f64::NAN, 0.0, 1.0),
    DVec3::new(f64::INFINITY, -1e300, 1e-300),
    DVec3::ZERO,
];

/// Numbers that choose a sample.
const CHOICES: [f64; 4] = [0.0, 0.37, 1.0 - f64::EPSILON, f64::NAN];

/// How far a file was looked through before it answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trust {
    /// Whole: answers are numbers of at least 0.
    Checked,
    /// In place: damage gives wrong answers, and nothing worse.
    Unchecked,
}

/// Every verb at every pair of [`DIRECTIONS`]; fails where an answer is impossible. An interpolant prepares each incident
/// direction for milliseconds: it is asked at some.
pub fn ask(bsdf: &Bsdf, trust: Trust) {
    let stored = |c: &Component| {
        let of = c.distribution();
        of.downcast_ref::<TreeDistribution>().is_some()
            || of.downcast_ref::<KlemsMatrix>().is_some()
            || of.downcast_ref::<RenderTable>().is_some()
    };
    let all_stored = bsdf.components().iter().all(stored);
    five_verbs(bsdf, if all_stored { 1 } else { 3 }, trust);
    if all_stored && let Ok(smooth) = bsdf.clone().with_lookup(Lookup::Smooth) {
        five_verbs(&smooth, 1, trust);
    }
    bands(bsdf, trust);
    for band in bsdf.bands() {
        bsdf.band(&band.name);
    }
    let metadata = bsdf.metadata();
    assert!(metadata.thickness.is_finite(), "{}", metadata.thickness);
}

/// Spectra, where there are some.
fn bands(bsdf: &Bsdf, trust: Trust) {
    let Some(count) = bsdf.wavelengths().map(bsdfkit::spectrum::Bands::count) else { return };
    let mut all = vec![0.0; count * DIRECTIONS.len()];
    for wi in DIRECTIONS.into_iter().step_by(3) {
        bsdf.eval_bands_many(&[wi], &DIRECTIONS, &mut all).expect("one for all");
        for (wo, found) in DIRECTIONS.into_iter().zip(all.chunks_exact(count)) {
            if trust == Trust::Checked && wi.is_normalized() && wo.is_normalized() {
                assert!(found.iter().all(|f| *f >= 0.0), "{wi} {wo}: {found:?}");
            }
        }
    }
    let total = &mut all[..count];
    bsdf.directional_hemispherical_bands_many(&[DIRECTIONS[3]], Components::ALL, total)
        .expect("one for all");
}

/// Many at a time where a verb prepares each incident direction, which takes an interpolant milliseconds.
fn five_verbs(bsdf: &Bsdf, step: usize, trust: Trust) {
    let all = Components::ALL;
    let mut densities = [0.0; DIRECTIONS.len()];
    let mut samples = [None; CHOICES.len()];
    for wi in DIRECTIONS.into_iter().step_by(step) {
        let total = bsdf.directional_hemispherical(wi, all);
        bsdf.specular_peaks(wi, all).for_each(drop);
        bsdf.pdf_many(&[wi], &DIRECTIONS, all, &mut densities).expect("one for all");
        for (wo, pdf) in DIRECTIONS.into_iter().zip(densities) {
            let f = bsdf.eval_xyz(wi, wo).y;
            if trust == Trust::Checked && wi.is_normalized() && wo.is_normalized() {
                assert!(f >= 0.0 && pdf >= 0.0 && total >= 0.0, "{wi} {wo}: {f} {pdf} {total}");
            }
        }
        bsdf.sample_many(&[wi], &CHOICES, all, &mut samples).expect("one for all");
        for sample in samples.into_iter().flatten() {
            if trust == Trust::Checked && wi.is_normalized() {
                assert!(sample.wo.is_finite() && sample.pdf >= 0.0, "{wi}: {sample:?}");
            }
        }
    }
    let wi = DIRECTIONS[3];
    let mut angles = [[0.0; 2]; DIRECTIONS.len()];
    let many = bsdf.projected_solid_angle_many(&[wi], Some(&DIRECTIONS), &mut angles);
    many.expect("one for all");
    bsdf.projected_solid_angle(wi, None);
    bsdf.projected_solid_angle(DIRECTIONS[6], Some(wi));
    bsdf.sample2(wi, DVec2::new(0.37, 0.5), Components::DIRECTIONAL_DIFFUSE);
    bsdf.eval_pdf(wi, wi, Components::REFLECTION);
    let mut out = [0.0; DIRECTIONS.len()];
    bsdf.eval_many(&DIRECTIONS, &DIRECTIONS, &mut out).expect("as many as there are");
}
