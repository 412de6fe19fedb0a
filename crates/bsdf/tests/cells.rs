//! Cells are where the values are: each outline holds the directions that the lookup answers with its value.

use std::f64::consts::PI;

use bsdfkit::{Bsdf, Cell, DVec2, DVec3, Side, xml};

fn open(name: &str) -> Bsdf {
    xml::read(format!("{}/../../tests/golden/xml/{name}.xml", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

fn area(cell: &Cell) -> f64 {
    let next = cell.outline.iter().cycle().skip(1);
    (0.5 * cell.outline.iter().zip(next).map(|(a, b)| a.perp_dot(*b)).sum::<f64>()).abs()
}

/// Whether a point is inside, by how often a ray from it crosses the outline.
fn holds(cell: &Cell, p: DVec2) -> bool {
    let next = cell.outline.iter().cycle().skip(1);
    let crosses = |a: &DVec2, b: &DVec2| {
        (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)
    };
    cell.outline.iter().zip(next).filter(|(a, b)| crosses(a, b)).count() % 2 == 1
}

fn check(bsdf: &Bsdf, wi: DVec3, scattered: Side, least: usize) {
    let cells = bsdf.cells(wi, scattered);
    assert!(cells.len() >= least, "{} cells", cells.len());
    // Chords of 4 degrees leave out 0.2 % of a disk; cells next to each other share them.
    let covered: f64 = cells.iter().map(area).sum();
    assert!((covered - PI).abs() < 0.003 * PI, "{covered}");
    let (mut inside, mut found) = (0, 0);
    for k in 0..2000 {
        let (r, turn) = ((f64::from(k) + 0.5) / 2000.0, f64::from(k) * 2.399_963);
        let p = 0.99 * r.sqrt() * DVec2::new(turn.cos(), turn.sin());
        let wo = DVec3::new(p.x, p.y, scattered.sign() * (1.0 - p.length_squared()).sqrt());
        let holding: Vec<&Cell> = cells.iter().filter(|c| holds(c, p)).collect();
        inside += holding.len();
        let f = bsdf.eval(wi, wo);
        found += usize::from(holding.iter().any(|c| (c.value - f).abs() < 1e-9));
    }
    // A point nearer to a curved border than its chord is may count with the neighbour.
    assert!((inside as i32 - 2000).abs() < 12, "{inside} points in cells");
    assert!(found >= 1988, "{found} points in a cell of their value");
}

#[test]
fn of_trees() {
    let four = open("t4_rf_rb_tf_tb");
    let three = open("t3_rf_rb_tf_tb");
    for wi in [DVec3::new(0.3, -0.5, 0.812_403_84), DVec3::new(-0.8, 0.1, -0.591_607_98), DVec3::Z]
    {
        for scattered in [Side::Front, Side::Back] {
            check(&four, wi.normalize(), scattered, 8);
            check(&three, wi.normalize(), scattered, 4);
        }
    }
}

#[test]
fn of_a_lone_transmission_both_ways() {
    let tree = open("t4_tf");
    let (front, back) =
        (DVec3::new(0.3, -0.5, 0.8).normalize(), DVec3::new(0.3, 0.6, -0.7).normalize());
    check(&tree, front, Side::Back, 4);
    check(&tree, back, Side::Front, 4);
    assert_eq!(tree.cells(front, Side::Front), []);
}

#[test]
fn of_matrices_both_ways() {
    for name in ["kf_in_tf", "kf_out_tf", "custom_basis", "mixed_basis"] {
        let matrix = open(name);
        let (front, back) =
            (DVec3::new(0.3, -0.5, 0.8).normalize(), DVec3::new(0.3, 0.6, -0.7).normalize());
        let answered =
            [(front, Side::Front), (front, Side::Back), (back, Side::Front), (back, Side::Back)];
        let answered = answered.iter().filter(|(wi, to)| !matrix.cells(*wi, *to).is_empty());
        let mut checked = 0;
        for &(wi, scattered) in answered {
            check(&matrix, wi, scattered, 4);
            checked += 1;
        }
        assert!(checked > 0, "{name}");
    }
}

#[test]
fn nan_has_none() {
    assert_eq!(open("t4_tf").cells(DVec3::NAN, Side::Back), []);
}
