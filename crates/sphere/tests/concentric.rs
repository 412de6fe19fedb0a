//! The concentric map against the reference library's.

use bsdfkit_sphere::DVec2;
use bsdfkit_sphere::concentric::{disk_to_square, square_to_disk};
use serde_json::Value;

#[test]
fn agrees_with_the_reference() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/golden/square_disk.json");
    let golden: Value =
        serde_json::from_str(&std::fs::read_to_string(path).expect("golden file")).expect("JSON");
    let point = |v: &Value| DVec2::new(v[0].as_f64().expect("x"), v[1].as_f64().expect("y"));
    for (name, map) in [
        ("square_to_disk", square_to_disk as fn(DVec2) -> DVec2),
        ("disk_to_square", disk_to_square),
    ] {
        for row in golden[name].as_array().expect("list") {
            let (from, want) = (point(&row[0]), point(&row[1]));
            let got = map(from);
            // The reference shrinks the disk by 1e-13, so that rounding never leaves it.
            assert!((got - want).length() < 1e-12, "{name}({from}) is {got}, not {want}");
        }
    }
}
