//! Measurements that show little: what is said of them, what is made of them, and what is refused.

mod support;

use std::f64::consts::{FRAC_1_PI, PI};

use bsdfkit::{DVec3, ErrorClass, Side};
use bsdfkit_fit::interpolant::{Component, Coverage, FitSettings, Interpolant};
use bsdfkit_measure::{FEWEST, IncidenceQuality, Measurement, Symmetry, scant};
use bsdfkit_represent::Watch;
use bsdfkit_simulate::material::{BrushedMetal, RetroSheet, six};
use bsdfkit_simulate::{Goniophotometer, Material};
use bsdfkit_sphere::direction::from_degrees;
use support::{
    albedo, azimuths, coarse, fit, grid, hemisphere, incidence, measured, measurement, symmetry,
};

/// Round on the sphere about the specular direction, over a Lambertian ground.
fn glossy(wi: DVec3, wo: DVec3) -> f64 {
    let specular = DVec3::new(-wi.x, -wi.y, wi.z.abs().copysign(wo.z));
    0.1 * FRAC_1_PI + 0.3 * (20.0 * (specular.dot(wo) - 1.0)).exp()
}

/// Its directional-hemispherical value.
fn light(f: &dyn Fn(DVec3, DVec3) -> f64, wi: DVec3, side: Side) -> f64 {
    let all = hemisphere(200, side, 90.0);
    all.iter().map(|&wo| f(wi, wo)).sum::<f64>() * PI / all.len() as f64
}

/// Scattered directions, as a stage reaches them in reflection.
type Scan = fn(f64) -> Vec<DVec3>;

fn plane(_: f64) -> Vec<DVec3> {
    (-16..=16).map(|k| from_degrees(5.0 * f64::from(k), 180.0)).collect()
}

fn across(_: f64) -> Vec<DVec3> {
    (-16..=16).map(|k| from_degrees(5.0 * f64::from(k), 90.0)).collect()
}

/// The plane through X that leans by 25 degrees.
fn tilted(_: f64) -> Vec<DVec3> {
    let (sin, cos) = 25f64.to_radians().sin_cos();
    let up = |k: i32| (5.0 * f64::from(k)).to_radians().sin_cos();
    (-14..=14).map(up).map(|(x, z)| DVec3::new(x, sin * z, cos * z)).collect()
}

fn ring(_: f64) -> Vec<DVec3> {
    (0..36).map(|k| from_degrees(40.0, 10.0 * f64::from(k))).collect()
}

fn cone(theta: f64) -> Vec<DVec3> {
    let middle = from_degrees(theta, 180.0);
    let (x, y) = middle.any_orthonormal_pair();
    let at = |k: i32| {
        let (radius, turn) =
            ((f64::from(k) / 300.0).sqrt() * 25f64.to_radians(), 2.4 * f64::from(k));
        radius.cos() * middle + radius.sin() * (turn.cos() * x + turn.sin() * y)
    };
    (0..=300).map(at).filter(|w| w.z > 0.05).collect()
}

fn half(_: f64) -> Vec<DVec3> {
    let ring =
        |k: i32| (0..=12).map(move |n| from_degrees(10.0 * f64::from(k), 15.0 * f64::from(n)));
    (0..=8).flat_map(ring).collect()
}

fn one(_: f64) -> Vec<DVec3> {
    vec![from_degrees(30.0, 180.0); 9]
}

fn five(_: f64) -> Vec<DVec3> {
    [(0.0, 0.0), (45.0, 0.0), (45.0, 90.0), (45.0, 180.0), (45.0, 270.0)]
        .map(|(theta, phi)| from_degrees(theta, phi))
        .to_vec()
}

const THETAS: [f64; 4] = [0.0, 20.0, 40.0, 60.0];

fn scanned(
    f: &dyn Fn(DVec3, DVec3) -> f64,
    side: Side,
    symmetry: Symmetry,
    incident: &[(f64, f64)],
    scan: Scan,
) -> Measurement {
    let turned = |w: DVec3| DVec3::new(w.x, w.y, side.sign() * w.z);
    let at = |&(theta, phi): &(f64, f64)| {
        let wi = from_degrees(theta, phi);
        incidence(wi, scan(theta).into_iter().map(turned).collect(), |wo| f(wi, wo))
    };
    measurement(side, symmetry, incident.iter().map(at).collect())
}

/// Of an isotropic specimen.
fn isotropic(scan: Scan, side: Side) -> Measurement {
    scanned(&glossy, side, Symmetry::Isotropic, &THETAS.map(|theta| (theta, 0.0)), scan)
}

fn fitted(m: &Measurement) -> Component {
    fit(m, &FitSettings::default())
}

#[test]
fn one_plane_of_an_isotropic_specimen_is_turned_where_that_is_certain_and_rounded_elsewhere() {
    for side in [Side::Front, Side::Back] {
        let m = isotropic(plane, side);
        let c = fitted(&m);
        let up = |theta: f64, phi: f64| {
            let w = from_degrees(theta, phi);
            DVec3::new(w.x, w.y, side.sign() * w.z)
        };
        for (theta, within) in [(0.0, 0.01), (20.0, 0.03), (30.0, 0.03), (40.0, 0.03), (60.0, 0.05)]
        {
            let wi = from_degrees(theta, 0.0);
            let (ours, truth) = (c.at(wi).directional_hemispherical(), light(&glossy, wi, side));
            println!("{side:?} {theta}: {ours:.4}, truth {truth:.4}");
            assert!((ours / truth - 1.0).abs() < within, "{side:?} {theta}: {ours} {truth}");
        }
        let normal = c.at(DVec3::Z);
        for theta in [5.0, 15.0, 30.0, 50.0] {
            let [along, aside] = [0.0, 90.0].map(|phi| normal.eval(up(theta, phi)));
            assert!((aside / along - 1.0).abs() < 0.02, "{theta}: {along} {aside}");
            let truth = glossy(DVec3::Z, up(theta, 90.0));
            assert!((aside / truth - 1.0).abs() < 0.05, "{theta}: {aside} {truth}");
        }
        // Which are guesses is told.
        assert!(c.seen(DVec3::Z) > 0.95 && c.seen(from_degrees(40.0, 0.0)) < 0.1);
        assert!(
            c.tells(DVec3::Z)
                && !c.tells(from_degrees(10.0, 0.0))
                && !c.tells(from_degrees(70.0, 0.0))
        );
        let of = |ti: f64, to: f64, po: f64| c.coverage(from_degrees(ti, 0.0), up(to, po));
        assert_eq!(of(0.0, 30.0, 90.0), Coverage::Measured);
        assert_eq!(of(40.0, 30.0, 180.0), Coverage::Measured);
        assert_eq!(of(50.0, 30.0, 180.0), Coverage::Interpolated);
        assert_eq!(of(40.0, 30.0, 90.0), Coverage::Extrapolated);
        assert_eq!(of(50.0, 30.0, 120.0), Coverage::Extrapolated);
        let extent = c.extent();
        assert!(extent.extrapolated > 0.8 && extent.seen < 0.1, "{extent}");
        assert!(extent.to_string().contains("% of the hemisphere was seen"), "{extent}");
        for theta in THETAS {
            let fit = m.incidences.iter().zip(c.incidences());
            let (_, own) = fit
                .clone()
                .find(|(i, _)| i.wi.distance(from_degrees(theta, 0.0)) < 1e-9)
                .expect("there");
            assert!(own.fit_error < 5e-3 && own.points == 33, "{theta}: {}", own.fit_error);
        }
    }
}

/// Facets make peaks narrower across the plane than along it, toward grazing.
#[test]
fn one_plane_of_a_rough_metal_gives_its_light_within_what_is_said() {
    let metal = BrushedMetal { roughness_x: 0.25, roughness_y: 0.25, ..BrushedMetal::default() };
    let f = |wi: DVec3, wo: DVec3| metal.eval(wi, wo);
    let incident = THETAS.map(|theta| (theta, 0.0));
    let m = scanned(&f, Side::Front, Symmetry::Isotropic, &incident, plane);
    let c = fitted(&m);
    for (i, q) in m.incidences.iter().zip(m.quality().incidences) {
        let truth = light(&f, i.wi, Side::Front);
        let fit = c.at(i.wi).directional_hemispherical();
        let off = q.hemispherical_uncertainty.as_ref().map_or(0.0, |u| u[0]);
        println!(
            "{:.0}: {:.4} ± {off:.4}, fit {fit:.4}, truth {truth:.4}",
            q.theta_degrees, q.hemispherical[0]
        );
        assert!((q.hemispherical[0] - truth).abs() < off + 0.04 * truth, "{q:?} {truth}");
        assert!((fit / truth - 1.0).abs() < 0.12, "{fit} {truth}");
    }
}

/// Two peaks on one line, each as round as it is: no ring.
#[test]
fn a_peak_beside_the_specular_one_stays_a_peak() {
    let f = |wi: DVec3, wo: DVec3| {
        let specular = DVec3::new(-wi.x, -wi.y, wi.z);
        let lobe = |at: DVec3| (60.0 * (at.dot(wo) - 1.0)).exp();
        0.01 + lobe(specular) + 0.5 * lobe(wi)
    };
    let incident = [(0.0, 0.0), (25.0, 0.0), (45.0, 0.0)];
    let m = scanned(&f, Side::Front, Symmetry::Isotropic, &incident, plane);
    let c = fitted(&m);
    let wi = from_degrees(45.0, 0.0);
    // As far from the specular direction as the other peak is.
    let aside = c.at(wi).eval(DVec3::Y);
    assert!(aside < 0.1, "{aside}");
    let (ours, truth) = (c.at(wi).directional_hemispherical(), light(&f, wi, Side::Front));
    assert!((ours / truth - 1.0).abs() < 0.15, "{ours} {truth}");
}

#[test]
fn what_was_seen_is_told_in_words_and_shares() {
    let sine = |degrees: f64| degrees.to_radians().sin().powi(2);
    let scans: [(Scan, &str, f64); 8] = [
        (plane, "one plane (azimuths 0 and 180, that of incidence)", 0.04),
        (across, "one plane (azimuths 90 and 270)", 0.04),
        (tilted, "one plane (leaning 25 degrees from the normal toward azimuth 90)", 0.04),
        (ring, "one ring (40 degrees about the normal)", 0.07),
        (
            cone,
            "a cone (25 degrees about the specular direction, theta 40 phi 180)",
            sine(25.0) * 40f64.to_radians().cos(),
        ),
        (half, "half the hemisphere (azimuths 0 to 180)", 0.5 * sine(80.0)),
        (one, "one direction (theta 30 phi 180)", 0.0),
        (five, "5 directions", 0.0),
    ];
    for side in [Side::Front, Side::Back] {
        for (scan, words, share) in &scans {
            let m = scanned(&glossy, side, Symmetry::None, &[(40.0, 0.0)], *scan);
            let sight = m.sights()[0];
            let words = if side == Side::Back {
                words.replace("theta 40", "theta 140").replace("theta 30", "theta 150")
            } else {
                (*words).to_owned()
            };
            assert_eq!(sight.pattern.to_string(), words, "{side:?}");
            assert!(
                (sight.share - share).abs() < 0.04 && sight.is_scant(),
                "{words}: {}",
                sight.share
            );
            let told = scant(&[sight]);
            assert!(
                told.len() == 1 && told[0].starts_with(&format!("only {words} measured at 1 of 1")),
                "{told:?}"
            );
        }
    }
    // A hole where a peak may be, whatever its share.
    let tilted = isotropic(tilted, Side::Front).sights();
    assert!(tilted[0].is_scant() && !tilted[0].specular, "{tilted:?}");
    assert!(scant(&tilted)[0].contains("not the specular direction at 4"), "{tilted:?}");
    // What the mirror or a turn shows is seen.
    let all = scanned(
        &glossy,
        Side::Front,
        Symmetry::Bilateral(bsdfkit_measure::Mirror::Y),
        &[(40.0, 0.0)],
        half,
    );
    assert!(!all.sights()[0].is_scant(), "{:?}", all.sights());
    let turned = isotropic(across, Side::Front).sights();
    assert!(!turned[0].is_scant() && turned[1].is_scant(), "{turned:?}");
    let told = scant(&turned);
    assert!(
        told.len() == 1
            && told[0].contains("at 4 of 4")
            && told[0].contains("seen at 3, all of it through"),
        "{told:?}"
    );
}

#[test]
fn totals_of_a_part_are_bounds_or_unknown() {
    let quality = |scan: Scan, symmetry: Symmetry| -> IncidenceQuality {
        scanned(&glossy, Side::Front, symmetry, &[(40.0, 0.0)], scan).quality().incidences.remove(0)
    };
    let truth = light(&glossy, from_degrees(40.0, 0.0), Side::Front);
    for scan in [half as Scan, cone, ring] {
        let q = quality(scan, Symmetry::None);
        assert!(q.extrapolated && q.hemispherical[0].is_nan(), "{q:?}");
        let least = q.hemispherical_at_least[0];
        assert!(least > 0.0 && least < truth, "{} {least} {truth}", q.pattern);
    }
    for scan in [one as Scan, five] {
        let q = quality(scan, Symmetry::None);
        assert!(
            q.extrapolated && q.hemispherical[0].is_nan() && q.hemispherical_at_least[0].is_nan()
        );
    }
    let q = quality(plane, Symmetry::None);
    let off = q.hemispherical_uncertainty.as_ref().expect("of a plane")[0];
    assert!(
        q.extrapolated && off > 0.0 && (q.hemispherical[0] - truth).abs() < 1.1 * off,
        "{q:?} {truth}"
    );
}

#[test]
fn who_measured_the_hemisphere_is_told_nothing_and_gets_its_light() {
    let sheet: Box<dyn Material> = Box::new(RetroSheet::default());
    for material in six().into_iter().chain([sheet]) {
        let (material, name) = (material.as_ref(), material.name());
        let s = symmetry(material);
        let m = measured(&coarse(), material, s, &grid(&[0.0, 30.0, 60.0], &azimuths(s, 0.0)));
        assert_eq!(scant(&m.sights()), Vec::<String>::new(), "{name}");
        // Nobody sees a peak where the detector would stand in the light.
        if name == "retro-sheet" {
            continue;
        }
        for (i, q) in m.incidences.iter().zip(m.quality().incidences) {
            let (ours, truth) = (q.hemispherical[0], albedo(material, i.wi));
            assert!(!q.extrapolated && q.hemispherical_uncertainty.is_none());
            assert!((ours / truth - 1.0).abs() < 0.05, "{name} {:?}: {ours} {truth}", i.wi);
        }
    }
}

#[test]
fn light_of_a_dense_scan_is_right_to_a_hundredth() {
    let gonio = Goniophotometer::default();
    for material in six() {
        let m = measured(&gonio, material.as_ref(), Symmetry::None, &[(40.0, 25.0)]);
        let ours = m.quality().incidences[0].hemispherical[0];
        let truth = material.albedo(from_degrees(40.0, 25.0));
        println!("{}: {ours:.4}, truth {truth:.4}", material.name());
        assert!((ours / truth - 1.0).abs() < 0.01, "{}: {ours} {truth}", material.name());
    }
}

/// A plateau with steep sides on a polar grid: points lie on one side of the cells that its rim crosses.
#[test]
fn light_on_a_polar_grid_is_that_of_its_rings() {
    let f = |w: DVec3| 1.0 / (1.0 + (w.truncate().length() / 0.11).powi(12));
    let ring = |k: i32| (0..180).map(move |n| from_degrees(f64::from(k), 2.0 * f64::from(n)));
    let i = incidence(from_degrees(0.0, 0.0), (0..=85).flat_map(ring).collect(), f);
    let ours = i.quality(0, Symmetry::None).hemispherical[0];
    // 2π ∫ f sin θ cos θ dθ = π ∫ f d(sin² θ)
    let step = 1e-5;
    let truth =
        (0..100_000).map(|k| f(DVec3::X * ((f64::from(k) + 0.5) * step).sqrt())).sum::<f64>()
            * PI
            * step;
    assert!((ours / truth - 1.0).abs() < 0.01, "{ours} {truth}");
}

#[test]
fn incidences_of_too_few_directions_are_refused() {
    let refused = |m: &Measurement| {
        let (one, settings) = (std::slice::from_ref(m), FitSettings::default());
        let error = Interpolant::fit(one, &settings, &Watch::default()).expect_err("too few");
        assert_eq!(error.class(), ErrorClass::Format);
        error.to_string()
    };
    for side in [Side::Front, Side::Back] {
        let message = refused(&isotropic(one, side));
        let place = if side == Side::Front { 30 } else { 150 };
        let found = format!("found one direction (theta {place} phi 180), and too few at 4 of 4");
        assert!(message.contains(&format!("at least {FEWEST} scattered directions")), "{message}");
        assert!(message.contains(&found), "{message}");
    }
    assert!(refused(&isotropic(five, Side::Front)).contains("found 5 directions"));
    // One bad incidence is named.
    let mut m = isotropic(plane, Side::Front);
    m.incidences[2].wo.truncate(6);
    m.incidences[2].values.truncate(6);
    m.incidences[2].files = vec!["third.txt".into()];
    let message = refused(&m);
    assert!(message.starts_with("third.txt: incidence theta 40.0 phi 0.0: expected"), "{message}");
    assert!(message.contains("too few at 1 of 4"), "{message}");
    m.incidences[2] = isotropic(plane, Side::Front).incidences[2].clone();
    m.incidences[2].wo.truncate(FEWEST);
    m.incidences[2].values.truncate(FEWEST);
    fitted(&m);
}

#[test]
fn a_plane_at_each_incidence_of_an_anisotropic_specimen_is_fitted_and_called_extrapolated() {
    let incident = grid(&[0.0, 30.0, 60.0], &[0.0, 45.0, 90.0]);
    let m = scanned(&glossy, Side::Front, Symmetry::Quadrilateral, &incident, plane);
    let c = fitted(&m);
    for wi in [from_degrees(0.0, 0.0), from_degrees(30.0, 45.0), from_degrees(40.0, 20.0)] {
        assert!(!c.tells(wi), "{wi}");
        let total = c.at(wi).directional_hemispherical();
        assert!(total.is_finite() && total < 1.0, "{total}");
    }
}
