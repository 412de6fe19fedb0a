//! Cells: their areas are projected solid angles, and their values are those of the queries.

mod golden;

use bsdfkit::{Bsdf, Cell, Components, DVec3, Side};
use bsdfkit_sphere::direction::from_degrees;

fn read(name: &str) -> Bsdf {
    bsdfkit::xml::read(golden::path(&format!("xml/{name}.xml"))).unwrap()
}

/// The area of its outline in the plane of direction cosines.
fn area(cell: &Cell) -> f64 {
    let next = cell.outline.iter().cycle().skip(1);
    let sum: f64 = cell.outline.iter().zip(next).map(|(a, b)| a.x * b.y - b.x * a.y).sum();
    0.5 * sum.abs()
}

/// Σ value · area is the total, Σ area all of π.
fn expect_all_light(bsdf: &Bsdf, wi: DVec3, scattered: Side, tolerance: f64) {
    let cells = bsdf.cells(wi, scattered).unwrap();
    let whole: f64 = cells.iter().map(area).sum();
    let close = |a: f64, b: f64| (a - b).abs() <= tolerance * b + 1e-9;
    assert!(close(whole, std::f64::consts::PI), "{whole}");
    let light: f64 = cells.iter().map(|c| area(c) * bsdf.eval(wi, c.middle)).sum();
    let way = match Side::of(wi) == scattered {
        true => Components::REFLECTION,
        false => Components::TRANSMISSION,
    };
    let total = bsdf.directional_hemispherical(wi, way);
    assert!(close(light, total), "{light} of {total}");
}

#[test]
fn cells_hold_all_the_light() {
    let directions =
        [(0.0, 0.0), (35.0, 110.0), (80.0, 300.0), (150.0, 20.0)].map(|(t, p)| from_degrees(t, p));
    for name in ["t4_rf_rb_tf_tb", "t3_rf_rb_tf_tb", "color_mtx_0.2_0.6", "custom_basis"] {
        let bsdf = read(name);
        let pairs: Vec<_> = bsdf.components().iter().map(|c| (c.incident, c.scattered)).collect();
        let mut checked = 0;
        for wi in directions {
            for (_, scattered) in pairs.iter().filter(|p| p.0 == Side::of(wi)) {
                expect_all_light(&bsdf, wi, *scattered, 0.01);
                checked += 1;
            }
        }
        assert!(checked >= 1, "{name}");
    }
}

#[test]
fn a_transmission_that_is_stored_one_way_has_its_leaves_from_the_other() {
    let bsdf = read("t4_tf");
    let stored = &bsdf.components()[0];
    let wi = stored.scattered.facing(from_degrees(25.0, 70.0));
    expect_all_light(&bsdf, wi, stored.incident, 0.01);
    // An isotropic tree has no borders there.
    let isotropic = read("t3_tf");
    let stored = &isotropic.components()[0];
    let wi = stored.scattered.facing(from_degrees(25.0, 70.0));
    assert!(isotropic.cells(wi, stored.incident).unwrap().is_empty());
}

#[test]
fn directions_without_cells_have_none() {
    let bsdf = read("t4_tf");
    let stored = &bsdf.components()[0];
    let wi = stored.incident.facing(from_degrees(25.0, 70.0));
    assert!(bsdf.cells(wi, stored.incident).unwrap().is_empty());
    assert!(bsdf.cells(DVec3::NAN, Side::Front).unwrap().is_empty());
}
