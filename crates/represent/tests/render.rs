//! The render form of materials that are known.

use std::sync::atomic::AtomicBool;

use bsdfkit::render::Fold;
use bsdfkit::{
    Bsdf, Component, Components, DVec2, DVec3, Distribution, ErrorClass, Lambertian, Metadata,
    Sense, Side,
};
use bsdfkit_represent::tabulate::{RenderSettings, render_table};
use bsdfkit_represent::{Slice, Source, Watch};
use bsdfkit_simulate::Material;
use bsdfkit_simulate::material::{
    BrushedMetal, FrittedGlass, RotatedMetal, RoughDielectric, SymmetryHint,
};
use bsdfkit_sphere::concentric::square_to_hemisphere;

/// A material by its formula.
struct Of(Box<dyn Material>);

struct At<'a>(&'a dyn Material, DVec3);

impl Source for Of {
    fn incident(&self) -> Side {
        Side::Front
    }
    fn scattered(&self) -> Side {
        self.0.scattered()
    }
    fn isotropic(&self) -> bool {
        self.0.symmetry() == SymmetryHint::Isotropic
    }
    fn slice<'a>(&'a self, wi: DVec3) -> Box<dyn Slice + 'a> {
        Box::new(At(&*self.0, wi))
    }
}

impl Slice for At<'_> {
    fn eval(&self, wo: &[DVec3], out: &mut [f32]) {
        for (out, &wo) in out.iter_mut().zip(wo) {
            *out = self.0.eval(self.1, wo) as f32;
        }
    }
}

const SETTINGS: RenderSettings =
    RenderSettings { max_bytes: 2_500_000, max_error: 0.01, reverse: false };

fn spread(count: usize, side: Side) -> impl Iterator<Item = DVec3> {
    (0..count).map(move |n| {
        let r = 0.96 * ((n as f64 + 0.5) / count as f64).sqrt();
        let xy = DVec2::from_angle(n as f64 * 2.4) * r;
        xy.extend(side.sign() * (1.0 - r * r).sqrt())
    })
}

/// Share of the light in a wrong place and the total, by a sum over a grid.
fn wrong(material: &dyn Material, found: &dyn Distribution, wi: DVec3) -> (f64, f64) {
    let cells = 400;
    let (mut wrong, mut total) = (0.0, 0.0);
    for n in 0..cells * cells {
        let at = DVec2::new((n % cells) as f64 + 0.5, (n / cells) as f64 + 0.5) / cells as f64;
        let wo = square_to_hemisphere(at, material.scattered());
        let f = material.eval(wi, wo);
        wrong += (f - found.value(wi, wo)).abs();
        total += f;
    }
    let size = std::f64::consts::PI / (cells * cells) as f64;
    (wrong / total, total * size)
}

#[test]
fn peaks_that_move_stay_what_they_are_between_nodes() {
    for (material, fold, most) in [
        (Box::new(BrushedMetal::default()) as Box<dyn Material>, Fold::Quadrants, 0.02),
        (Box::new(RotatedMetal::default()), Fold::HalfTurn, 0.06),
        (Box::new(RoughDielectric::default()), Fold::IsotropicMirrored, 0.02),
    ] {
        let source = Of(material);
        let (table, report) = render_table(&source, &SETTINGS, &Watch::default()).unwrap();
        let name = source.0.name();
        assert_eq!(table.chart().fold(), fold, "{name}");
        assert!(report.bytes <= SETTINGS.max_bytes && report.bytes == table.bytes());
        let mut sum = 0.0;
        for wi in spread(12, Side::Front) {
            let (wrong, total) = wrong(&*source.0, &table, wi);
            assert!(wrong < 2.0 * most, "{name} {wi}: L1 {wrong}");
            sum += wrong;
            let found = table.total(wi, Sense::Forward, 0.0);
            assert!((found - total).abs() < 0.01, "{name} {wi}: {found} {total}");
        }
        assert!(sum < 12.0 * most, "{name}: mean L1 {}", sum / 12.0);
    }
}

#[test]
fn samples_weigh_nearly_the_same() {
    let source = Of(Box::new(BrushedMetal::default()));
    let (table, _) = render_table(&source, &SETTINGS, &Watch::default()).unwrap();
    let component = Component::new(Side::Front, Side::Front, table);
    let bsdf = Bsdf::new(Metadata::default(), vec![component], Lambertian::default());
    for wi in spread(8, Side::Front) {
        let weight = |n: i32| {
            let u = (f64::from(n) + 0.5) / 4096.0;
            bsdf.sample(wi, u, Components::ALL).map_or(0.0, |s| s.weight)
        };
        let weights: Vec<f64> = (0..4096).map(weight).collect();
        let mean = weights.iter().sum::<f64>() / 4096.0;
        let variance = weights.iter().map(|w| (w - mean).powi(2)).sum::<f64>() / 4096.0;
        assert!(variance.sqrt() < 0.15 * mean, "{wi}: {} of {mean}", variance.sqrt());
        let total = bsdf.directional_hemispherical(wi, Components::ALL);
        assert!((mean / total - 1.0).abs() < 0.01, "{wi}: {mean} {total}");
    }
}

/// Loses nothing: half of the light diffusely, half in a peak about the mirror direction, at each incidence as much.
struct White;

struct WhiteAt(DVec3, f64);

impl WhiteAt {
    const WIDTH: f64 = 0.2;

    fn new(wi: DVec3) -> Self {
        let mut at = Self(wi, 1.0);
        let (radii, angles) = (64, 96);
        let peak = |n: usize| {
            let r = (((n / angles) as f64 + 0.5) / radii as f64).sqrt();
            let turn = (n % angles) as f64 / angles as f64 * std::f64::consts::TAU;
            at.peak((DVec2::from_angle(turn) * r).extend((1.0 - r * r).sqrt()))
        };
        let count = radii * angles;
        at.1 = 1.0 / ((0..count).map(peak).sum::<f64>() * std::f64::consts::PI / count as f64);
        at
    }

    fn peak(&self, wo: DVec3) -> f64 {
        let apart = (self.0 + wo).truncate() / Self::WIDTH;
        self.1 * (-0.5 * apart.length_squared()).exp()
    }
}

impl Source for White {
    fn incident(&self) -> Side {
        Side::Front
    }
    fn scattered(&self) -> Side {
        Side::Front
    }
    fn isotropic(&self) -> bool {
        true
    }
    fn slice<'a>(&'a self, wi: DVec3) -> Box<dyn Slice + 'a> {
        Box::new(WhiteAt::new(wi))
    }
}

impl Slice for WhiteAt {
    fn eval(&self, wo: &[DVec3], out: &mut [f32]) {
        for (out, &wo) in out.iter_mut().zip(wo) {
            *out = (0.5 * std::f64::consts::FRAC_1_PI + 0.5 * self.peak(wo)) as f32;
        }
    }
}

#[test]
fn a_white_furnace_stays_white() {
    let (table, _) = render_table(&White, &SETTINGS, &Watch::default()).unwrap();
    let component = Component::new(Side::Front, Side::Front, table);
    let bsdf = Bsdf::new(Metadata::default(), vec![component], Lambertian::default());
    for wi in spread(10, Side::Front) {
        let total = bsdf.directional_hemispherical(wi, Components::ALL);
        assert!((total - 1.0).abs() < 2e-3, "{wi}: total {total}");
        // Light that comes from everywhere alike, seen by values and by samples.
        let (cells, draws) = (200, 20_000);
        let mut seen = 0.0;
        for n in 0..cells * cells {
            let at = DVec2::new((n % cells) as f64 + 0.5, (n / cells) as f64 + 0.5) / cells as f64;
            seen += bsdf.eval(wi, square_to_hemisphere(at, Side::Front));
        }
        let seen = seen * std::f64::consts::PI / (cells * cells) as f64;
        let weight = |n: i32| {
            let u = (f64::from(n) + 0.5) / f64::from(draws);
            bsdf.sample(wi, u, Components::ALL).map_or(0.0, |s| s.weight)
        };
        let drawn = (0..draws).map(weight).sum::<f64>() / f64::from(draws);
        assert!((seen - 1.0).abs() < 0.01, "{wi}: values add up to {seen}");
        assert!((drawn - 1.0).abs() < 0.01, "{wi}: samples weigh {drawn}");
    }
}

/// Places beyond the horizon of one node are read between it and nodes that see them.
#[test]
fn a_metal_near_the_horizon_scatters_no_more_than_it_gets() {
    let material = BrushedMetal::default();
    let source = Of(Box::new(material.clone()));
    let settings = RenderSettings { max_error: 0.03, ..SETTINGS };
    let (table, _) = render_table(&source, &settings, &Watch::default()).unwrap();
    // Even over azimuths, and over the logarithm of the cosine, where the light is.
    let (rows, columns) = (160, 240);
    for (theta, phi) in
        [(85.0_f64, 20.0_f64), (87.0, 45.0), (88.0, 45.0), (88.0, 60.0), (89.0, 30.0)]
    {
        let (theta, phi) = (theta.to_radians(), phi.to_radians());
        let wi = DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos());
        let (mut found, mut truth) = (0.0, 0.0);
        let lowest = 1e-4_f64.ln();
        for n in 0..rows * columns {
            let z = (lowest * (1.0 - ((n / columns) as f64 + 0.5) / rows as f64)).exp();
            let turn = std::f64::consts::TAU * ((n % columns) as f64 + 0.5) / columns as f64;
            let wo = (DVec2::from_angle(turn) * (1.0 - z * z).sqrt()).extend(z);
            found += table.value(wi, wo) * z * z;
            truth += material.eval(wi, wo) * z * z;
        }
        let share = found / truth;
        assert!((0.3..2.0).contains(&share), "{theta} {phi}: {share}");
    }
}

#[test]
fn a_lone_transmission_is_drawn_the_other_way_too() {
    let source = Of(Box::new(FrittedGlass::default()));
    let settings = RenderSettings { reverse: true, ..SETTINGS };
    let (table, _) = render_table(&source, &settings, &Watch::default()).unwrap();
    assert!(table.reverse().is_some());
    let component = Component::new(Side::Front, Side::Back, table);
    let bsdf = Bsdf::new(Metadata::default(), vec![component], Lambertian::default());
    for wi in spread(8, Side::Back) {
        let wo = DVec3::new(-wi.x, -wi.y, -wi.z);
        assert_eq!(bsdf.eval(wi, wo), bsdf.eval(wo, wi));
        let weight = |n: i32| {
            let u = (f64::from(n) + 0.5) / 4096.0;
            bsdf.sample(wi, u, Components::ALL).map_or(0.0, |s| s.weight)
        };
        let weights: Vec<f64> = (0..4096).map(weight).collect();
        let mean = weights.iter().sum::<f64>() / 4096.0;
        let total = bsdf.directional_hemispherical(wi, Components::ALL);
        assert!((mean - total).abs() < 0.01, "{wi}: {mean} {total}");
        let variance = weights.iter().map(|w| (w - mean).powi(2)).sum::<f64>() / 4096.0;
        assert!(variance.sqrt() < 0.3 * mean, "{wi}: {} of {mean}", variance.sqrt());
    }
}

#[test]
fn it_can_be_stopped() {
    let stop = AtomicBool::new(true);
    let watch = Watch { progress: None, cancel: Some(&stop) };
    let source = Of(Box::new(BrushedMetal::default()));
    let error = render_table(&source, &SETTINGS, &watch).unwrap_err();
    assert_eq!(error.class(), ErrorClass::Limit);
}
