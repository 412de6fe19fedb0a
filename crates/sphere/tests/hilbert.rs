//! The Hilbert curve against the reference library's and its own laws.

use bsdfkit_sphere::DVec2;
use bsdfkit_sphere::hilbert::{cell_to_index, fold, index_to_cell, unfold};
use bsdfkit_sphere::sequence;
use proptest::prelude::*;
use serde_json::Value;

fn golden() -> Value {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/golden/hilbert.json");
    serde_json::from_str(&std::fs::read_to_string(path).expect("golden file")).expect("JSON")
}

fn cell(v: &Value) -> (u32, u32) {
    (v[0].as_u64().expect("x") as u32, v[1].as_u64().expect("y") as u32)
}

#[test]
fn small_orders_agree_with_the_reference() {
    let golden = golden();
    for (order, name) in [(1, "order1"), (2, "order2"), (3, "order3")] {
        let cells = golden[name].as_array().expect("list");
        assert_eq!(cells.len(), 1 << (2 * order));
        for (i, c) in cells.iter().enumerate() {
            let (x, y) = cell(c);
            assert_eq!(index_to_cell(order, i as u64), (x, y), "order {order} index {i}");
            assert_eq!(cell_to_index(order, x, y), i as u64, "order {order} cell {x} {y}");
        }
    }
}

#[test]
fn large_orders_agree_with_the_reference() {
    let golden = golden();
    for (order, name) in [(16, "order16"), (32, "order32")] {
        for row in golden[name].as_array().expect("list") {
            let index = row[0].as_u64().expect("index");
            let (x, y) = cell(&row[1]);
            assert_eq!(index_to_cell(order, index), (x, y), "order {order} index {index}");
            assert_eq!(cell_to_index(order, x, y), index, "order {order} cell {x} {y}");
        }
    }
}

/// The reference adds a random offset below 2⁻³¹; one index step of its f64 moves up to 2⁻²⁵.
#[test]
fn unfold_agrees_with_the_reference() {
    for row in golden()["multisamp2"].as_array().expect("list") {
        let u = row[0].as_f64().expect("u");
        let want = DVec2::new(row[1][0].as_f64().expect("x"), row[1][1].as_f64().expect("y"));
        let got = unfold(u);
        assert!((got - want).abs().max_element() < 2.0_f64.powi(-25), "{u}: {got} not {want}");
    }
}

#[test]
fn neighbours_on_the_curve_share_an_edge() {
    for order in 1..=7 {
        let mut last = index_to_cell(order, 0);
        assert_eq!(last, (0, 0));
        for i in 1..1_u64 << (2 * order) {
            let next = index_to_cell(order, i);
            assert_eq!(last.0.abs_diff(next.0) + last.1.abs_diff(next.1), 1, "{order} {i}");
            last = next;
        }
        assert_eq!(last, (0, (1 << order) - 1));
    }
}

#[test]
fn ends_and_rubbish_stay_inside() {
    for u in [0.0, -1.0, 1.0, 2.0, f64::INFINITY, f64::NEG_INFINITY, 1.0 - f64::EPSILON / 2.0] {
        let p = unfold(u);
        assert!(p.min_element() > 0.0 && p.max_element() < 1.0, "{u} {p}");
    }
    assert!(unfold(f64::NAN).is_nan());
    assert!(fold(DVec2::new(0.5, f64::NAN)).is_nan());
    for p in [DVec2::ZERO, DVec2::ONE, DVec2::splat(-3.0), DVec2::new(0.0, f64::INFINITY)] {
        assert!((0.0..1.0).contains(&fold(p)), "{p}");
    }
    assert_eq!(index_to_cell(0, 77), (0, 0));
    assert_eq!(cell_to_index(0, 5, 6), 0);
}

proptest! {
    #[test]
    fn index_and_cell_are_inverse(order in 0_u32..=32, bits in any::<u64>()) {
        let index = if order == 32 { bits } else { bits & ((1 << (2 * order)) - 1) };
        let (x, y) = index_to_cell(order, index);
        prop_assert_eq!(cell_to_index(order, x, y), index);
    }

    #[test]
    fn a_coarse_index_is_a_prefix(order in 1_u32..=32, index in any::<u64>()) {
        let (x, y) = index_to_cell(order, index);
        let used = if order == 1 { 0 } else { index & (u64::MAX >> (64 - 2 * order)) };
        prop_assert_eq!(index_to_cell(order - 1, used >> 2), (x >> 1, y >> 1));
    }

    #[test]
    fn fold_inverts_unfold(u in 0.0_f64..1.0, down in 0..40) {
        let u = (u * 2.0_f64.powi(64 - down)).trunc() / 2.0_f64.powi(64);
        prop_assert_eq!(fold(unfold(u)), u);
    }
}

/// n equal strata of u land in n distinct cells, for any power of four.
#[test]
fn strata_are_kept() {
    for order in [1_u32, 3, 5] {
        let n = 1_u64 << (2 * order);
        let mut hit = vec![false; n as usize];
        for k in 0..n {
            let jitter = sequence::golden(k as usize);
            let p = unfold((k as f64 + jitter) / n as f64) * f64::from(1 << order);
            let slot = &mut hit[((p.y as usize) << order) + p.x as usize];
            assert!(!*slot, "stratum {k} of order {order} fell on another's cell");
            *slot = true;
        }
    }
}
