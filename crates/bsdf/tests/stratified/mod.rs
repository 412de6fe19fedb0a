//! What stratified numbers are worth: the variance of a mean over drawn directions, beside that by random ones.

use bsdfkit::{Bsdf, Components, DVec2, DVec3};

use crate::support::Random;

/// Draws a mean, one in each stratum.
const DRAWS: u32 = 900;
/// Means a variance: its ratio to another is known to a factor of 1.8.
const RUNS: u32 = 64;

/// Smooth, and of no symmetry that would help.
fn integrand(w: DVec3) -> f64 {
    w.x + 2.0 * w.y * w.y
}

fn variance(mut draw: impl FnMut(u32) -> DVec3) -> f64 {
    let mean = |draw: &mut dyn FnMut(u32) -> DVec3| {
        (0..DRAWS).map(|i| integrand(draw(i))).sum::<f64>() / f64::from(DRAWS)
    };
    let means: Vec<f64> = (0..RUNS).map(|_| mean(&mut draw)).collect();
    let middle = means.iter().sum::<f64>() / f64::from(RUNS);
    means.iter().map(|m| (m - middle).powi(2)).sum::<f64>() / f64::from(RUNS)
}

/// Of [`Bsdf::sample`]: variance by one number at random in each interval, over that by random numbers.
pub(crate) fn one_number(bsdf: &Bsdf, wi: DVec3) -> f64 {
    let random = &mut Random(3);
    let draw = |u: f64| bsdf.sample(wi, u, Components::ALL).unwrap().wo;
    let plain = variance(|_| draw(random.unit()));
    let strata = variance(|i| draw((f64::from(i) + random.unit()) / f64::from(DRAWS)));
    strata / plain
}

/// The same of [`Bsdf::sample2`], with one point in each of 30 × 30 squares: none that the Hilbert curve
/// visits in one go.
pub(crate) fn two_numbers(bsdf: &Bsdf, wi: DVec3) -> f64 {
    const SIDE: u32 = 30;
    let random = &mut Random(4);
    let draw = |u: DVec2| bsdf.sample2(wi, u, Components::ALL).unwrap().wo;
    let plain = variance(|_| draw(DVec2::new(random.unit(), random.unit())));
    let strata = variance(|i| {
        let corner = DVec2::new(f64::from(i % SIDE), f64::from(i / SIDE));
        draw((corner + DVec2::new(random.unit(), random.unit())) / f64::from(SIDE))
    });
    strata / plain
}
