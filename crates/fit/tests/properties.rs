//! What holds of any material, mesh and measurement: random ones, few by default.
//!
//! `BSDFKIT_CASES=10000 cargo test --release -p bsdfkit-fit --test properties` tries as many in all; `BSDFKIT_CASE=N` tries number N
//! of each property alone, as a failure names it.

mod support;

use std::f64::consts::{PI, TAU};
use std::fmt::Write as _;

use bsdfkit::{DVec2, DVec3, Side};
use bsdfkit_fit::interpolant::{Component, FitSettings};
use bsdfkit_measure::{
    self, Image, Incidence, Measurement, Mirror, ReadOptions, Symmetry, SymmetryKind,
};
use bsdfkit_sphere::direction::{from_degrees, to_degrees};
use bsdfkit_transport::{Problem, network_simplex, partial};
use support::{difference, fit, hemisphere, measurement, values};

/// A reproducible stream. [Steele, Lea, Flood 2014]
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// In [0, 1).
    fn share(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.share()
    }

    /// Of 0..n.
    fn one_of(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    /// Evenly by projected solid angle to `limit` degrees of the front, or behind it.
    fn direction(&mut self, side: Side, limit: f64) -> DVec3 {
        let sine = limit.to_radians().sin() * self.share().sqrt();
        let (y, x) = (TAU * self.share()).sin_cos();
        let z = (1.0 - sine * sine).sqrt();
        DVec3::new(sine * x, sine * y, if side == Side::Front { z } else { -z })
    }
}

/// Tries `check` on as many cases as this property's `share` of a hundred asks for.
fn cases(share: usize, mut check: impl FnMut(&mut Random)) {
    let number = |name| std::env::var(name).ok().and_then(|n| n.parse::<usize>().ok());
    let all = match number("BSDFKIT_CASE") {
        Some(one) => one..one + 1,
        None => 0..(number("BSDFKIT_CASES").unwrap_or(100) * share).div_ceil(100),
    };
    for case in all {
        println!("BSDFKIT_CASE={case}");
        check(&mut Random(
            (case as u64).wrapping_mul(0xd134_2543_de82_ef95).wrapping_add(share as u64),
        ));
    }
}

/// f of a random material: a constant and peaks about directions that follow the incident one, none negative.
struct Material {
    floor: f64,
    /// Height, width as the sine of an angle, how far off the specular direction.
    peaks: Vec<(f64, f64, DVec2)>,
    scattered: Side,
    symmetry: Symmetry,
}

impl Material {
    fn random(r: &mut Random) -> Self {
        let symmetry = [
            Symmetry::Isotropic,
            Symmetry::Quadrilateral,
            Symmetry::Bilateral(Mirror::X),
            Symmetry::Bilateral(Mirror::Y),
            Symmetry::Rotational180,
            Symmetry::None,
        ][r.one_of(6)];
        let scattered = if r.share() < 0.6 { Side::Front } else { Side::Back };
        let peak = |r: &mut Random| {
            let width: f64 = 10_f64.powf(r.within(-1.0, -0.2));
            // So that no peak holds more light than 0.3 of it all.
            let height = r.within(0.02, 0.3) / (PI * width * width);
            (height, width, DVec2::new(r.within(-0.3, 0.3), r.within(-0.3, 0.3)))
        };
        let count = r.one_of(4);
        let floor = if r.share() < 0.3 { 0.0 } else { r.within(0.0, 0.1) };
        let peaks: Vec<_> = (0..count).map(|_| peak(r)).collect();
        let floor = if peaks.is_empty() { floor + 0.01 } else { floor };
        Self { floor, peaks, scattered, symmetry }
    }

    fn once(&self, wi: DVec3, wo: DVec3) -> f64 {
        let mut f = self.floor;
        for (height, width, off) in &self.peaks {
            // Isotropic: the offset turns along with the light.
            let off = match self.symmetry {
                Symmetry::Isotropic => wi.truncate() * off.x,
                _ => *off,
            };
            let apart = wo.truncate() + wi.truncate() - off;
            f += height * (-apart.length_squared() / (width * width)).exp();
        }
        f
    }

    /// As symmetric as it says.
    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        let images = self.symmetry.images();
        let sum: f64 = images.iter().map(|i| self.once(i.apply(wi), i.apply(wo))).sum();
        sum / images.len() as f64
    }

    /// At a random few incident directions, each at scattered directions of its own, some of them unseen; noise on some.
    fn measured(&self, r: &mut Random) -> Measurement {
        let rings = 2 + r.one_of(2);
        let most = r.within(40.0, 75.0);
        let around = match self.symmetry {
            Symmetry::Isotropic => 1,
            Symmetry::Quadrilateral => 2,
            Symmetry::Bilateral(_) | Symmetry::Rotational180 => 3,
            Symmetry::None => 5,
        };
        let mut incident = vec![DVec3::Z];
        for ring in 1..=rings {
            let theta = most * ring as f64 / rings as f64 * r.within(0.9, 1.0);
            let first = r.within(0.0, 90.0);
            let azimuth = |k: usize| {
                first + 360.0 * k as f64 / (around as f64 * self.symmetry.images().len() as f64)
            };
            incident
                .extend((0..around).map(|k| self.symmetry.fold(from_degrees(theta, azimuth(k))).0));
        }
        let noise = if r.share() < 0.3 { 0.03 } else { 0.0 };
        let hole =
            (r.share() < 0.3).then(|| (r.direction(self.scattered, 80.0), r.within(0.9, 0.99)));
        let count = 100 + r.one_of(200);
        let mut incidences: Vec<Incidence> = Vec::new();
        for wi in incident {
            let mut wo: Vec<DVec3> =
                (0..count).map(|_| r.direction(self.scattered, 85.0)).collect();
            wo.retain(|w| hole.is_none_or(|(centre, cosine)| w.dot(centre) < cosine));
            let value = |w: &DVec3| self.eval(wi, *w) * (1.0 + noise * (2.0 * r.share() - 1.0));
            let f: Vec<f64> = wo.iter().map(value).collect();
            incidences.push(Incidence::new(wi, wo, f));
        }
        sorted(measurement(self.scattered, self.symmetry, incidences))
    }
}

/// In the order that reading leaves.
fn sorted(mut m: Measurement) -> Measurement {
    let key = |wi: DVec3| {
        let (theta, phi) = to_degrees(wi);
        ((theta * 1000.0).round() as i64, (phi * 1000.0).round() as i64)
    };
    m.incidences.sort_by_key(|i| key(i.wi));
    m
}

fn settings() -> FitSettings {
    FitSettings { detail_cells: 24, ..FitSettings::default() }
}

/// Incident directions everywhere, the horizon and the normal among them.
fn incident(r: &mut Random, m: &Measurement) -> Vec<DVec3> {
    let mut all: Vec<DVec3> = (0..6).map(|_| r.direction(Side::Front, 90.0)).collect();
    all.extend([from_degrees(89.999, r.within(0.0, 360.0)), from_degrees(1e-9, 200.0)]);
    all.push(m.incidences[r.one_of(m.incidences.len())].wi);
    all
}

/// Relative L1 distance of two fits at `wi` and, through `image`, of the other.
fn apart(a: &Component, b: &Component, wi: DVec3, image: Image, scale: f64) -> f64 {
    let wo = hemisphere(10, a.scattered(), 89.0);
    let turned: Vec<DVec3> = wo.iter().map(|&w| image.apply(w)).collect();
    let here: Vec<f64> = values(a, wi, &wo).iter().map(|v| v * scale).collect();
    difference(&here, &values(b, image.apply(wi), &turned))
}

#[test]
fn plans_conserve_mass() {
    cases(50, |r| {
        let masses = |r: &mut Random, n: usize| -> Vec<f64> {
            let one = |r: &mut Random| match r.one_of(5) {
                0 => 0.0,
                1 => 10_f64.powf(r.within(-12.0, 3.0)),
                _ => r.share(),
            };
            (0..n).map(|_| one(r)).collect()
        };
        let places = |r: &mut Random, n: usize| -> Vec<DVec2> {
            // Some on a lattice, so that costs tie.
            let lattice = r.share() < 0.3;
            let x = |r: &mut Random| if lattice { r.one_of(4) as f64 / 4.0 } else { r.share() };
            (0..n).map(|_| DVec2::new(x(r), x(r))).collect()
        };
        let (n, m) = (1 + r.one_of(30), 1 + r.one_of(30));
        let (mut supply, demand) = (masses(r, n), masses(r, m));
        let (from, to) = (places(r, n), places(r, m));
        let cost: Vec<f64> =
            from.iter().flat_map(|a| to.iter().map(|b| a.distance_squared(*b))).collect();
        let close = |a: f64, b: f64, total: f64| assert!((a - b).abs() <= 1e-9 * total, "{a} {b}");
        let (all, other): (f64, f64) = (supply.iter().sum(), demand.iter().sum());
        let plan = partial::solve(&supply, &demand, &cost, r.within(0.0, 0.5)).unwrap();
        let total = all + other;
        for (k, sum) in plan.travelling.row_sums().iter().enumerate() {
            close(sum + plan.faded[k], supply[k], total);
        }
        for (k, sum) in plan.travelling.column_sums().iter().enumerate() {
            close(sum + plan.appeared[k], demand[k], total);
        }
        if all > 0.0 && other > 0.0 {
            supply.iter_mut().for_each(|s| *s *= other / all);
            let plan = network_simplex::solve(&Problem::new(&supply, &demand, &cost).unwrap());
            plan.row_sums().iter().zip(&supply).for_each(|(a, b)| close(*a, *b, other));
            plan.column_sums().iter().zip(&demand).for_each(|(a, b)| close(*a, *b, other));
            assert!(plan.entries().iter().all(|f| f.mass > 0.0) && plan.is_optimal());
        }
    });
}

/// Distances at the directions of [`incident`], the last of which was measured.
///
/// The same up to rounding would be 1e-6. Where two hypotheses of motion foretell nearly as well, or lobes are fitted to noise, the last
/// digits decide which is taken and when a lobe is split; the fits then differ by what the hypotheses do. This bound was set after some
/// forty cases, the worst of which had a mean of 0.052: it finds gross faults only.
fn expect_alike(off: &[f64]) {
    let (mean, measured) = (off.iter().sum::<f64>() / off.len() as f64, off[off.len() - 1]);
    assert!(mean < 0.15 && measured < 0.1, "mean {mean}, measured {measured}");
}

#[test]
fn nothing_is_negative_or_no_number_and_energy_stays_near_what_was_measured() {
    cases(14, |r| {
        let material = Material::random(r);
        let m = material.measured(r);
        let c = fit(&m, &settings());
        let most = c.incidences().iter().map(|i| i.hemispherical).fold(0.0, f64::max);
        for wi in incident(r, &m) {
            let at = c.at(wi);
            let total = at.directional_hemispherical();
            assert!(total.is_finite() && total >= 0.0, "{:?}: {total}", to_degrees(wi));
            println!("  {:?} {} {total:.4} of {most:.4}", to_degrees(wi), c.tells(wi));
            // Past the rim lobes at the horizon are blown up: 1.031 of the light was found at 89.999 degrees (case 10).
            let bound = if c.tells(wi) { most * 1.02 } else { most.max(1.1) };
            assert!(total <= bound, "{:?}: {total}, measured at most {most}", to_degrees(wi));
            for _ in 0..100 {
                let wo = r.direction(material.scattered, 90.0);
                let f = at.eval(wo);
                assert!(
                    f.is_finite() && f >= 0.0,
                    "{:?} {:?}: {f}",
                    to_degrees(wi),
                    to_degrees(wo)
                );
            }
        }
    });
}

#[test]
fn symmetric_in_is_symmetric_out() {
    cases(8, |r| {
        let material = Material::random(r);
        let m = material.measured(r);
        let c = fit(&m, &settings());
        let mut images: Vec<Image> = material.symmetry.images().to_vec();
        if material.symmetry == Symmetry::Isotropic {
            images.push(Image::rotation_to(r.direction(Side::Front, 90.0)));
        }
        for wi in incident(r, &m) {
            for &image in &images {
                let off = apart(&c, &c, wi, image, 1.0);
                // Along the normal an isotropic fit keeps what its points made of it: no azimuth tells the turn.
                let bound = if wi.z > 1.0 - 1e-12 { 0.05 } else { 1e-6 };
                assert!(off < bound, "{} {:?} {image:?}: {off}", material.symmetry, to_degrees(wi));
            }
        }
    });
}

#[test]
fn a_specimen_that_is_turned_or_mirrored_scatters_turned_or_mirrored() {
    let quarter = Image::rotation_to(DVec3::Y);
    cases(10, |r| {
        let material = Material::random(r);
        let m = material.measured(r);
        let image = [quarter, Image::HALF_TURN, Image::MIRROR_X, Image::MIRROR_Y][r.one_of(4)];
        let crosswise = image == quarter;
        let symmetry = match material.symmetry {
            Symmetry::Bilateral(Mirror::X) if crosswise => Symmetry::Bilateral(Mirror::Y),
            Symmetry::Bilateral(Mirror::Y) if crosswise => Symmetry::Bilateral(Mirror::X),
            other => other,
        };
        let through = |i: &Incidence| {
            let turned = i.transformed(image);
            let (_, back) = symmetry.fold(turned.wi);
            turned.transformed(back)
        };
        let turned = measurement(m.scattered, symmetry, m.incidences.iter().map(through).collect());
        let (a, b) = (fit(&m, &settings()), fit(&sorted(turned), &settings()));
        let mut all = Vec::new();
        for wi in incident(r, &m) {
            let off = apart(&a, &b, wi, image, 1.0);
            println!("  {symmetry} {image:?} {:?}: {off:.1e}", to_degrees(wi));
            all.push(off);
        }
        expect_alike(&all);
    });
}

#[test]
fn what_is_twice_as_bright_scatters_twice_as_much() {
    cases(10, |r| {
        let material = Material::random(r);
        let m = material.measured(r);
        // No digit changes.
        let scale = f64::from(1 << r.one_of(9)) / if r.share() < 0.7 { 256.0 } else { 1.0 };
        let mut scaled = m.clone();
        for i in &mut scaled.incidences {
            i.values.iter_mut().for_each(|v| *v = (f64::from(*v) * scale) as f32);
        }
        let (a, b) = (fit(&m, &settings()), fit(&scaled, &settings()));
        for wi in incident(r, &m) {
            let off = apart(&a, &b, wi, Image::IDENTITY, scale);
            println!("  {scale} {:?}: {off:.1e}", to_degrees(wi));
            // Past the rim reflection may rise to 1, whatever was measured.
            assert!(off < 1e-5 || !a.tells(wi), "{scale} {:?}: {off}", to_degrees(wi));
        }
    });
}

/// Rows of one file, or of several, in any order.
#[test]
fn order_of_files_and_rows_does_not_matter() {
    cases(8, |r| {
        let material = Material { symmetry: Symmetry::None, ..Material::random(r) };
        let m = material.measured(r);
        let mut rows = Vec::new();
        for i in &m.incidences {
            let (theta_i, phi_i) = to_degrees(i.wi);
            for (wo, value) in i.points(0) {
                let (theta, phi) = to_degrees(wo);
                rows.push(format!("{theta_i:.6},{phi_i:.6},{theta:.6},{phi:.6},{value:.6e}\n"));
            }
        }
        let folder = tempfile::tempdir().unwrap();
        let mut read = |name: &str, rows: &[String], files: usize| {
            let place = folder.path().join(name);
            std::fs::create_dir(&place).unwrap();
            let mut texts = vec![String::from("theta_i,phi_i,theta_o,phi_o,value\n"); files];
            for (k, row) in rows.iter().enumerate() {
                let _ = write!(texts[k % files], "{row}");
            }
            for text in texts {
                std::fs::write(place.join(format!("{}.csv", r.bits())), text).unwrap();
            }
            let options = ReadOptions {
                symmetry: Some(SymmetryKind::None),
                incomplete: true,
                ..Default::default()
            };
            let mut all = bsdfkit_measure::read(&[place], &options).unwrap();
            assert_eq!(all.len(), 1);
            fit(&all.remove(0), &settings())
        };
        let a = read("in order", &rows, 1);
        let mut shuffle = Random(rows.len() as u64);
        for k in (1..rows.len()).rev() {
            rows.swap(k, shuffle.one_of(k + 1));
        }
        let b = read("shuffled", &rows, 1 + shuffle.one_of(3));
        for wi in incident(r, &m) {
            let off = apart(&a, &b, wi, Image::IDENTITY, 1.0);
            assert!(off < 1e-3, "{:?}: {off}", to_degrees(wi));
        }
    });
}
