//! The five verbs of an interpolant as a BSDF, against slow sums and against each other.

mod support;

use std::sync::{Arc, OnceLock};

use bsdfkit::{Bsdf, Components, DVec2, DVec3, Sample, Side};
use bsdfkit_fit::interpolant::{Component, FitSettings, Frame, Interpolant, Part};
use bsdfkit_fit::open;
use bsdfkit_measure::Symmetry;
use bsdfkit_represent::Source;
use bsdfkit_simulate::material::{Fabric, FrittedGlass, PrismFilm};
use bsdfkit_sphere::concentric::{hemisphere_to_square, square_to_hemisphere};
use bsdfkit_sphere::direction::from_degrees;
use bsdfkit_sphere::sequence::{golden, quintic};
use support::{coarse, fit, given, grid, measured, symmetry};

/// A fabric that reflects and a fritted glass that transmits, in one.
fn both() -> &'static (Interpolant, [Arc<Component>; 2]) {
    static BOTH: OnceLock<(Interpolant, [Arc<Component>; 2])> = OnceLock::new();
    BOTH.get_or_init(|| {
        let (fabric, glass) = (Fabric::default(), FrittedGlass::default());
        let around = [0.0, 45.0, 90.0, 135.0, 180.0];
        let cloth = grid(&[0.0, 25.0, 50.0, 70.0], &around);
        let cloth = measured(&coarse(), &fabric, symmetry(&fabric), &cloth);
        let pane = grid(&[0.0, 20.0, 40.0, 60.0, 75.0], &[0.0]);
        let pane = measured(&coarse(), &glass, Symmetry::Isotropic, &pane);
        let fitted = [(cloth, Frame::Half), (pane, Frame::Shift)];
        let fitted = fitted.map(|(m, frame)| Arc::new(fit(&m, &given(frame))));
        let parts = fitted.iter().map(|c| Part::Transported(c.clone())).collect();
        (Interpolant { components: parts, ..Interpolant::default() }, fitted)
    })
}

fn bsdf() -> &'static Bsdf {
    static BSDF: OnceLock<Bsdf> = OnceLock::new();
    BSDF.get_or_init(|| both().0.bsdf())
}

/// Middles of n × n cells of equal projected solid angle.
fn cells(n: usize, side: Side) -> Vec<DVec3> {
    let middle = |k: usize| DVec2::new((k / n) as f64 + 0.5, (k % n) as f64 + 0.5) / n as f64;
    (0..n * n).map(|k| square_to_hemisphere(middle(k), side)).collect()
}

/// ∫ g |cos θ| dω by n × n midpoints.
fn integral(n: usize, side: Side, g: impl Fn(&[DVec3], &mut [f64])) -> f64 {
    let wo = cells(n, side);
    let mut values = vec![0.0; wo.len()];
    g(&wo, &mut values);
    values.iter().sum::<f64>() * std::f64::consts::PI / wo.len() as f64
}

const INCIDENT: [(f64, f64); 4] = [(0.0, 0.0), (33.0, 20.0), (62.0, 130.0), (80.0, 300.0)];

#[test]
fn values_are_those_of_the_parts_and_a_lone_transmission_answers_both_ways() {
    let (_, [cloth, pane]) = both();
    for (theta, phi) in INCIDENT {
        let wi = from_degrees(theta, phi);
        for wo in [from_degrees(20.0, 200.0), from_degrees(70.0, 10.0)] {
            let f32_of = |f: f64| f64::from(f as f32);
            assert_eq!(bsdf().eval(wi, wo), f32_of(cloth.at(wi).eval(wo)));
            let across = DVec3::new(wo.x, wo.y, -wo.z);
            let through = bsdf().eval(wi, across);
            assert_eq!(through, f32_of(pane.at(wi).eval(across)));
            assert!(through > 0.0);
            // Light from behind takes the same way back; what is behind was not measured.
            assert_eq!(bsdf().eval(across, wi), through);
            assert_eq!(bsdf().eval(across, across), 0.0);
        }
    }
}

/// What is made ready for one pair alone leaves out lobes that do not reach it, and those alone: of lobes that move, of families,
/// of facets, of cells with a twin and past the rim.
#[test]
fn one_value_is_to_the_bit_what_the_whole_slice_says() {
    let film = PrismFilm::default();
    let around: Vec<f64> = (0..9).map(|k| 22.5 * f64::from(k)).collect();
    let points = grid(&[0.0, 20.0, 40.0, 60.0], &around);
    let points = measured(&coarse(), &film, symmetry(&film), &points);
    let film = fit(&points, &FitSettings { frame: Some(Frame::Shift), ..FitSettings::default() });
    let (_, [cloth, pane]) = both();
    for component in [&**cloth, &**pane, &film] {
        let mut lit = 0;
        for k in 0..3000 {
            let [x, y, z, w] = quintic(k);
            let wi = square_to_hemisphere(DVec2::new(x, y), component.incident());
            let wo = square_to_hemisphere(DVec2::new(z, w), component.scattered());
            let mut value = [0.0f32];
            Source::value(component, wi, wo, &mut value);
            assert_eq!(value[0], component.at(wi).eval(wo) as f32, "{wi} {wo}");
            lit += usize::from(value[0] > 1e-3);
        }
        assert!(lit > 500, "{lit}");
    }
}

#[test]
fn totals_are_slow_sums_whichever_way_light_travels() {
    let back = [from_degrees(180.0, 0.0), from_degrees(140.0, 70.0), from_degrees(110.0, 250.0)];
    // Past the rim the glass's beam dips below the horizon, and its flank is what is seen.
    let grazing = [(85.0, 25.0), (88.0, 25.0), (89.5, 70.0)];
    let front = INCIDENT.into_iter().chain(grazing).map(|(theta, phi)| from_degrees(theta, phi));
    for wi in front.into_iter().chain(back) {
        for (to, way) in [
            (Side::of(wi), Components::REFLECTION),
            (Side::of(wi).opposite(), Components::TRANSMISSION),
        ] {
            let f = |wo: &[DVec3], out: &mut [f64]| bsdf().eval_many(&[wi], wo, out).unwrap();
            let (total, slow) = (
                bsdf().directional_hemispherical(wi, way),
                integral(if wi.z > 0.0 { 640 } else { 240 }, to, f),
            );
            // Half a degree from the horizon a hundredth of a fabric's light is missed.
            let off = if wi.z.abs() < 0.01 { 0.012 } else { 0.004 };
            assert!((total - slow).abs() < off, "{wi} to {to:?}: {total}, {slow}");
            assert!((slow > 0.05) == (to == Side::Front || wi.z > 0.0), "{wi} to {to:?}: {slow}");
        }
    }
}

#[test]
fn samples_have_their_density_and_weights_mean_the_total() {
    const DRAWS: usize = 40_000;
    const BINS: usize = 8;
    // One test in a hundred thousand fails by chance.
    for (theta, phi) in [(0.0, 0.0), (33.0, 20.0), (80.0, 300.0), (140.0, 70.0)] {
        let wi = from_degrees(theta, phi);
        let u: Vec<f64> = (0..DRAWS).map(golden).collect();
        let mut drawn: Vec<Option<Sample>> = vec![None; DRAWS];
        bsdf().sample_many(&[wi], &u, Components::ALL, &mut drawn).unwrap();
        let mut counted = [[0.0; BINS * BINS]; 2];
        let (mut weights, mut squares) = (0.0, 0.0);
        for s in drawn.iter().map(|s| s.expect("something scatters")) {
            let square = hemisphere_to_square(s.wo) * BINS as f64;
            let bin = square.x.min(BINS as f64 - 1.0) as usize * BINS
                + square.y.min(BINS as f64 - 1.0) as usize;
            counted[usize::from(s.wo.z > 0.0)][bin] += 1.0;
            weights += s.weight / DRAWS as f64;
            squares += s.weight * s.weight / DRAWS as f64;
            let f = bsdf().eval_components(wi, s.wo, Components::ALL);
            assert!((s.weight * s.pdf - f * s.wo.z.abs()).abs() < 1e-9 * (1.0 + f));
        }
        let mut all = 0.0;
        for (side, counted) in [Side::Back, Side::Front].into_iter().zip(counted) {
            // The density over bins, by points that see the glass's beam near grazing.
            const FINE: usize = 96;
            let fine = cells(FINE * BINS, side);
            let mut densities = vec![0.0; fine.len()];
            bsdf().pdf_many(&[wi], &fine, Components::ALL, &mut densities).unwrap();
            let mut expected = [0.0; BINS * BINS];
            for (k, (w, density)) in fine.iter().zip(densities).enumerate() {
                let (i, j) = (k / (FINE * BINS) / FINE, k % (FINE * BINS) / FINE);
                let share = density / w.z.abs() * std::f64::consts::PI / fine.len() as f64;
                expected[i * BINS + j] += share;
                all += share;
            }
            for (counted, expected) in counted.into_iter().zip(expected) {
                let (of, spread) = (expected * DRAWS as f64, (expected * DRAWS as f64).sqrt());
                assert!((counted - of).abs() < 5.0 * spread + 8.0, "{wi}: {counted} of {of}");
            }
        }
        assert!((all - 1.0).abs() < 0.01, "{wi}: the density integrates to {all}");
        let total = bsdf().directional_hemispherical(wi, Components::ALL);
        let deviation = (squares - weights * weights).max(0.0).sqrt();
        assert!((weights - total).abs() < 0.005 * total, "{wi}: {weights}, {total}");
        assert!(deviation < 0.4 * total, "{wi}: weights vary by {deviation} about {total}");
    }
}

#[test]
fn near_numbers_draw_near_directions() {
    let wi = from_degrees(33.0, 20.0);
    let u: Vec<f64> = (0..2000).map(|k| (f64::from(k) + 0.5) / 2000.0).collect();
    let mut drawn = vec![None; u.len()];
    bsdf().sample_many(&[wi], &u, Components::REFLECTION, &mut drawn).unwrap();
    let wo: Vec<DVec3> = drawn.iter().map(|s| s.expect("a sample").wo).collect();
    let steps: Vec<f64> = wo.windows(2).map(|w| w[0].distance(w[1])).collect();
    let mean = steps.iter().sum::<f64>() / steps.len() as f64;
    // In any other order it is about 1.
    assert!(mean < 0.1, "{mean}");
}

#[test]
fn many_are_as_one_by_one() {
    let directions: Vec<DVec3> = (0..40)
        .map(|k| from_degrees(f64::from(k) * 4.6, f64::from(k / 3 * 71)))
        .chain([DVec3::NAN, DVec3::X])
        .collect();
    let (mut wi, mut wo) = (Vec::new(), Vec::new());
    for (n, &i) in directions.iter().enumerate().filter(|(n, _)| n % 5 == 0 || *n > 38) {
        wi.extend(directions.iter().map(|_| i));
        wo.extend(directions.iter().cycle().skip(n).take(directions.len()));
    }
    let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    let one = |f: &dyn Fn(DVec3, DVec3) -> f64| {
        wi.iter().zip(&wo).map(|(&i, &o)| f(i, o)).collect::<Vec<_>>()
    };
    let (b, all, mut out) = (bsdf(), Components::ALL, vec![0.0; wi.len()]);
    b.eval_many(&wi, &wo, &mut out).unwrap();
    assert_eq!(bits(&out), bits(&one(&|i, o| b.eval(i, o))));
    b.eval_components_many(&wi, &wo, Components::TRANSMISSION, &mut out).unwrap();
    assert_eq!(bits(&out), bits(&one(&|i, o| b.eval_components(i, o, Components::TRANSMISSION))));
    b.pdf_many(&wi, &wo, all, &mut out).unwrap();
    for n in (0..wi.len()).step_by(37) {
        assert_eq!(out[n].to_bits(), b.pdf(wi[n], wo[n], all).to_bits());
    }
    let u: Vec<f64> = (0..directions.len()).map(|k| k as f64 / 42.0).collect();
    let mut samples = vec![None; u.len()];
    b.sample_many(&directions, &u, all, &mut samples).unwrap();
    let mut totals = vec![0.0; u.len()];
    b.directional_hemispherical_many(&directions, all, &mut totals).unwrap();
    let mut sizes = vec![[0.0; 2]; u.len()];
    b.projected_solid_angle_many(&directions, None, &mut sizes).unwrap();
    for (n, &w) in directions.iter().enumerate() {
        assert_eq!(samples[n], b.sample(w, u[n], all));
        assert_eq!(totals[n].to_bits(), b.directional_hemispherical(w, all).to_bits());
        let (least, most) = b.projected_solid_angle(w, None);
        assert_eq!(bits(&sizes[n]), bits(&[least, most]));
        assert!(w.is_nan() || 0.0 < least && least <= most, "{w}");
    }
    assert!(samples[40].is_none() && totals[40].is_nan());
}

#[test]
fn any_file_opens_as_a_bsdf() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("both.safetensors");
    both().0.save(&path, Default::default()).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let (wi, wo) = (from_degrees(40.0, 10.0), from_degrees(30.0, 200.0));
    for b in [open::bsdf(&path).unwrap(), open::bsdf_from_bytes(&bytes).unwrap()] {
        assert!((b.eval(wi, wo) / bsdf().eval(wi, wo) - 1.0).abs() < 2e-3);
    }
    let sir = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/golden/sir/frit.sir");
    let b = open::bsdf(sir.as_ref()).unwrap();
    let (wi, wo) = (from_degrees(30.0, 0.0), from_degrees(150.0, 180.0));
    let [there, back] = [(wi, wo), (wo, wi)].map(|(i, o)| b.eval(i, o));
    assert!(there > 0.0 && there == back);
    let slow = |wo: &[DVec3], out: &mut [f64]| b.eval_many(&[wi], wo, out).unwrap();
    let slow = integral(400, Side::Back, slow);
    let total = b.directional_hemispherical(wi, Components::ALL);
    assert!((total / slow - 1.0).abs() < 0.01, "{total}, {slow}");
    let s = b.sample(wi, 0.5, Components::ALL).unwrap();
    assert!(s.weight > 0.0 && s.wo.z < 0.0);
    let same = open::bsdf_from_bytes(&std::fs::read(sir).unwrap()).unwrap();
    assert_eq!(same.eval(wi, wo), there);
}
