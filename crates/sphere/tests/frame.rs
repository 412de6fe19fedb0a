//! The specimen's frame against the reference library's `SDcompXform` and its own laws.

use bsdfkit_sphere::{DVec3, Frame};
use proptest::prelude::*;
use serde_json::Value;

fn vector(v: &Value) -> DVec3 {
    let at = |n: usize| v[n].as_f64().expect("number");
    DVec3::new(at(0), at(1), at(2))
}

#[test]
fn axes_agree_with_the_reference() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/golden/xform.json");
    let golden: Value =
        serde_json::from_str(&std::fs::read_to_string(path).expect("golden file")).expect("JSON");
    let cases = golden["cases"].as_array().expect("list");
    assert!(cases.len() >= 4);
    for case in cases {
        let frame = Frame::new(vector(&case["normal"]), vector(&case["up"])).expect("a frame");
        for (n, axis) in [frame.x, frame.y, frame.z].into_iter().enumerate() {
            let expected = vector(&case["rows_x_y_z"][n]);
            assert!((axis - expected).length() < 4e-16, "axis {n} of {case}: {axis}");
        }
    }
}

#[test]
fn without_directions_there_is_no_frame() {
    for (normal, up) in [
        (DVec3::ZERO, DVec3::Y),
        (DVec3::Z, DVec3::ZERO),
        (DVec3::Z, DVec3::Z * -3.0),
        (DVec3::new(0.1, 0.2, 0.3), DVec3::new(0.3, 0.6, 0.9)),
        (DVec3::NAN, DVec3::Y),
        (DVec3::Z, DVec3::INFINITY),
    ] {
        assert_eq!(Frame::new(normal, up), None, "{normal} {up}");
    }
}

proptest! {
    #[test]
    fn there_and_back(
        n in prop::array::uniform3(-1.0..1.0),
        up in prop::array::uniform3(-1.0..1.0),
        w in prop::array::uniform3(-1.0..1.0),
    ) {
        let (n, up, w) = (DVec3::from(n), DVec3::from(up), DVec3::from(w));
        prop_assume!(n.cross(up).length() > 1e-3);
        let frame = Frame::new(n, up).expect("a frame");
        prop_assert!((frame.to_world(frame.to_local(w)) - w).length() < 1e-14);
        prop_assert!((frame.x.cross(frame.y) - frame.z).length() < 1e-14, "right-handed");
        let seen = frame.to_local(up);
        prop_assert!(seen.x.abs() < 1e-12 && seen.y > 0.0, "up is up: {seen}");
    }
}
