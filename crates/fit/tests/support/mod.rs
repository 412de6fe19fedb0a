//! Virtual specimens measured in memory, and distances between what was measured, fitted and true.

#![allow(dead_code)] // each test program uses its part

use bsdfkit::{DVec3, Side};
use bsdfkit_fit::interpolant::Distribution;
use bsdfkit_fit::interpolant::build;
use bsdfkit_fit::interpolant::mesh::IncidenceMesh;
use bsdfkit_fit::interpolant::{Component, FitSettings, Frame};
use bsdfkit_measure::{Colorimetry, Incidence, Measurement, Mirror, Symmetry};
use bsdfkit_represent::Watch;
use bsdfkit_simulate::{Goniophotometer, Material, SymmetryHint};
use bsdfkit_sphere::DVec2;
use bsdfkit_sphere::concentric::{hemisphere_to_square, square_to_hemisphere};
use bsdfkit_sphere::direction::from_degrees;
use bsdfkit_sphere::sequence::plastic;

/// About 7000 points an incidence: a seventh of what laboratories take.
pub(crate) fn instrument() -> Goniophotometer {
    Goniophotometer { sweeps: 36, points_per_sweep: 120, spiral_points: 2000, ..Default::default() }
}

/// The symmetry that a material's formula has.
pub(crate) fn symmetry(material: &dyn Material) -> Symmetry {
    match material.symmetry() {
        SymmetryHint::Isotropic => Symmetry::Isotropic,
        SymmetryHint::Quadrilateral => Symmetry::Quadrilateral,
        SymmetryHint::Bilateral => Symmetry::Bilateral(Mirror::Y),
        SymmetryHint::None => Symmetry::None,
    }
}

/// A measurement of `incidences`, in luminance.
pub(crate) fn measurement(
    scattered: Side,
    symmetry: Symmetry,
    incidences: Vec<Incidence>,
) -> Measurement {
    Measurement {
        incident: Side::Front,
        scattered,
        colorimetry: Colorimetry::Luminance,
        symmetry,
        incidences,
        sample_name: None,
        notes: Vec::new(),
    }
}

/// One incidence: `f` at every one of `wo`.
pub(crate) fn incidence(wi: DVec3, wo: Vec<DVec3>, f: impl Fn(DVec3) -> f64) -> Incidence {
    let values: Vec<f64> = wo.iter().map(|&w| f(w)).collect();
    Incidence::new(wi, wo, values)
}

/// Measures `material` at (θ, φ), degrees.
pub(crate) fn measured(
    gonio: &Goniophotometer,
    material: &dyn Material,
    symmetry: Symmetry,
    angles: &[(f64, f64)],
) -> Measurement {
    let scan = |&(theta, phi): &(f64, f64)| {
        let scan = gonio.scan(material, theta, phi);
        Incidence::new(scan.wi, scan.wo, scan.values)
    };
    measurement(material.scattered(), symmetry, angles.iter().map(scan).collect())
}

/// Every θ with every φ, the normal once.
pub(crate) fn grid(thetas: &[f64], phis: &[f64]) -> Vec<(f64, f64)> {
    let mut angles = Vec::new();
    for &theta in thetas {
        let phis = if theta == 0.0 { &[0.0][..] } else { phis };
        angles.extend(phis.iter().map(|&phi| (theta, phi)));
    }
    angles
}

/// About 3000 points an incidence, for tests of the interpolant's shape.
pub(crate) fn coarse() -> Goniophotometer {
    Goniophotometer { sweeps: 24, points_per_sweep: 90, spiral_points: 800, ..Default::default() }
}

/// Azimuths that fill the domain of `symmetry` in steps of about 30 degrees, from `first`.
pub(crate) fn azimuths(symmetry: Symmetry, first: f64) -> Vec<f64> {
    let range = match symmetry {
        Symmetry::Isotropic => return vec![first],
        Symmetry::Quadrilateral => 90.0,
        Symmetry::Bilateral(_) | Symmetry::Rotational180 => 180.0,
        Symmetry::None => 359.0,
    };
    let steps = (0..12).map(|k| first + 30.0 * f64::from(k));
    steps.take_while(|&phi| phi <= range).collect()
}

/// Settings with a given frame, which saves the time to choose it.
pub(crate) fn given(frame: Frame) -> FitSettings {
    FitSettings { frame: Some(frame), ..FitSettings::default() }
}

/// Fits without progress.
pub(crate) fn fit(m: &Measurement, settings: &FitSettings) -> Component {
    build(m, settings, &Watch::default()).unwrap_or_else(|e| panic!("{e}"))
}

/// Directions on `side`, each for the same projected solid angle, to `limit` degrees.
pub(crate) fn hemisphere(cells: usize, side: Side, limit: f64) -> Vec<DVec3> {
    let lowest = limit.to_radians().cos();
    (0..cells * cells)
        .map(|k| DVec2::new((k / cells) as f64 + 0.5, (k % cells) as f64 + 0.5) / cells as f64)
        .map(|s| square_to_hemisphere(s, side))
        .filter(|w| w.z.abs() >= lowest)
        .collect()
}

/// The true directional-hemispherical value, by 160² equal projected solid angles.
pub(crate) fn albedo(material: &dyn Material, wi: DVec3) -> f64 {
    let all = hemisphere(160, material.scattered(), 90.0);
    let sum: f64 = all.iter().map(|&wo| material.eval(wi, wo)).sum();
    sum * std::f64::consts::PI / all.len() as f64
}

/// Relative L1 distance of the model from the measured points, each cell of the square counting
/// by its area however many points fell into it.
pub(crate) fn distance_from_points(model: &Distribution<'_>, i: &Incidence) -> f64 {
    const CELLS: usize = 48;
    let cell = |w: DVec3| {
        let s = hemisphere_to_square(w) * CELLS as f64;
        (s.x as usize).min(CELLS - 1) * CELLS + (s.y as usize).min(CELLS - 1)
    };
    let mut count = vec![0u32; CELLS * CELLS];
    i.wo.iter().for_each(|w| count[cell(w)] += 1);
    let (mut error, mut total) = (0.0, 0.0);
    for (w, v) in i.points(0) {
        let weight = 1.0 / f64::from(count[cell(w)]);
        error += weight * (model.eval(w) - v).abs();
        total += weight * v;
    }
    error / total
}

/// Relative L1 distance of the model from the truth over all directions to 80 degrees.
pub(crate) fn distance_from_truth(
    model: &Distribution<'_>,
    material: &dyn Material,
    wi: DVec3,
) -> f64 {
    relative_l1(material, wi, |wo| model.eval(wo))
}

/// The same for linear interpolation of the truth at the corners of the incidence mesh.
pub(crate) fn distance_of_linear(m: &Measurement, material: &dyn Material, wi: DVec3) -> f64 {
    let directions: Vec<DVec3> = m.incidences.iter().map(|i| i.wi).collect();
    let mesh = IncidenceMesh::new(&directions, m.symmetry).expect("a mesh");
    let (folded, image) = m.symmetry.fold(wi);
    let corners = mesh.locate(folded).weights(&mesh.topology);
    relative_l1(material, wi, |wo| {
        let value = |(v, weight): (u32, f64)| {
            weight * material.eval(mesh.vertices[v as usize].wi, image.apply(wo))
        };
        corners.into_iter().map(value).sum()
    })
}

fn relative_l1(material: &dyn Material, wi: DVec3, f: impl Fn(DVec3) -> f64) -> f64 {
    let (mut error, mut total) = (0.0, 0.0);
    for wo in hemisphere(80, material.scattered(), 80.0) {
        let truth = material.eval(wi, wo);
        error += (f(wo) - truth).abs();
        total += truth;
    }
    error / total
}

/// f of the component at one incident direction.
pub(crate) fn values(c: &Component, wi: DVec3, wo: &[DVec3]) -> Vec<f64> {
    let distribution = c.at(wi);
    wo.iter().map(|&w| distribution.eval(w)).collect()
}

/// Relative L1 distance of two sets of values.
pub(crate) fn difference(a: &[f64], b: &[f64]) -> f64 {
    let apart: f64 = a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum();
    apart / a.iter().sum::<f64>().max(1e-12)
}

/// A direction of a low-discrepancy sequence over the front hemisphere to `limit` degrees.
pub(crate) fn direction(k: usize, limit: f64) -> DVec3 {
    let u = plastic(k + 1);
    from_degrees(limit * u.x.sqrt(), 360.0 * u.y)
}
