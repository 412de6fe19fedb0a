//! Radiance's interpolant files: golden values of its own programs, mass, and files broken in every way.

use std::path::PathBuf;

use bsdfkit::{DVec3, ErrorClass};
use bsdfkit_represent::Source;
use bsdfkit_represent::sir::{Migration, Plans, Sir, SirLimits};
use bsdfkit_sphere::Side;
use bsdfkit_sphere::direction::from_degrees;
use proptest::prelude::*;

fn golden(name: &str) -> Vec<u8> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../tests/golden/sir").join(name);
    std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn sir(name: &str, plans: Plans) -> Sir {
    Sir::from_bytes(&golden(&format!("{name}.sir")), plans, SirLimits::default())
        .expect("a good file")
}

fn rows(name: &str) -> Vec<[f64; 5]> {
    let json: serde_json::Value =
        serde_json::from_slice(&golden(&format!("{name}.json"))).expect("JSON");
    let row = |r: &serde_json::Value| std::array::from_fn(|k| r[k].as_f64().expect("a number"));
    json["rows"].as_array().expect("rows").iter().map(row).collect()
}

fn value(sir: &Sir, wi: DVec3, wo: DVec3) -> f32 {
    let mut out = [0.0];
    sir.slice(wi).eval(&[wo], &mut out);
    out[0]
}

/// How many of 400 values differ by at most each bound, relatively.
fn within(name: &str, plans: Plans, bounds: [f64; 3]) -> [usize; 3] {
    let sir = sir(name, plans);
    let errors: Vec<f64> = rows(name)
        .iter()
        .map(|r| {
            f64::from(value(&sir, from_degrees(r[0], r[1]), from_degrees(r[2], r[3]))) / r[4] - 1.0
        })
        .collect();
    assert_eq!(errors.len(), 400);
    bounds.map(|b| errors.iter().filter(|e| e.abs() <= b).count())
}

#[test]
fn answers_what_radiance_answers() {
    for name in ["diel", "frit", "fabric"] {
        let [close, all, _] = within(name, Plans::AsStored, [1e-4, 1e-3, 1.0]);
        assert!(
            close >= 399 && all == 400,
            "{name}: {close} of 400 within 1e-4, {all} within 1e-3"
        );
    }
}

#[test]
fn repaired_plans_move_the_answers_little() {
    // The lost entries carry up to 0.6 % of the light, but a whole lobe where they go missing.
    for name in ["diel", "frit", "fabric"] {
        let [most, nearly_all, all] = within(name, Plans::Repaired, [1e-2, 0.05, 0.2]);
        assert!(
            most >= 360 && nearly_all >= 390 && all == 400,
            "{name}: {most}, {nearly_all}, {all} of 400"
        );
    }
}

/// Plans with a row that sums to less than 0.99.
fn short_plans(sir: &Sir) -> usize {
    let short = |m: &&Migration| {
        let sum = |i| m.plan.row(i).iter().map(|e| f64::from(e.fraction)).sum::<f64>();
        (0..sir.nodes()[m.from].lobes.len()).any(|i| sum(i) < 0.99)
    };
    sir.migrations().iter().filter(short).count()
}

#[test]
fn plans_lose_an_entry_and_get_it_back() {
    for name in ["diel", "frit", "fabric"] {
        let (stored, repaired) = (sir(name, Plans::AsStored), sir(name, Plans::Repaired));
        let (before, plans) = (short_plans(&stored), stored.migrations().len());
        assert!(before * 2 > plans, "{name}: {before} of {plans} plans have a short row");
        assert_eq!(
            short_plans(&repaired),
            0,
            "{name}: {} of {plans} repaired",
            repaired.repaired()
        );
        assert_eq!(stored.repaired(), 0);
    }
}

/// Integral of f · (0.98 |cos θ| + 0.02) over the scattered side: what the file calls DSF.
fn scattered(sir: &Sir, wi: DVec3) -> f64 {
    // Steps of 0.15 degrees: the narrowest lobe has σ = 0.45 degrees.
    let (rings, sectors) = (600_i32, 1200_i32);
    let mut directions = Vec::new();
    for i in 0..rings {
        let theta = (f64::from(i) + 0.5) / f64::from(rings) * 90.0;
        let theta = if sir.scattered() == Side::Front { theta } else { 180.0 - theta };
        directions.extend(
            (0..sectors).map(|j| from_degrees(theta, f64::from(j) / f64::from(sectors) * 360.0)),
        );
    }
    let mut values = vec![0.0; directions.len()];
    sir.slice(wi).eval(&directions, &mut values);
    let step = (90.0 / f64::from(rings)).to_radians() * (360.0 / f64::from(sectors)).to_radians();
    let dsf = |(w, &f): (&DVec3, &f32)| {
        f64::from(f) * (0.98 * w.z.abs() + 0.02) * w.truncate().length() * step
    };
    directions.iter().zip(&values).map(dsf).sum()
}

#[test]
fn mass_is_the_interpolated_total() {
    // Between the nodes of the isotropic file, on both sides of each, at other azimuths; floor and horizon add a little.
    let sir = sir("frit", Plans::Repaired);
    for (k, pair) in sir.nodes().windows(2).enumerate().take(3) {
        let degrees = |n: usize| bsdfkit_sphere::direction::to_degrees(sir.nodes()[n].incident).0;
        for t in [0.0, 0.6] {
            let theta = degrees(k) * (1.0 - t) + degrees(k + 1) * t;
            let expected = pair[0].total * (1.0 - t) + pair[1].total * t;
            let found = scattered(&sir, from_degrees(theta, 77.0 * t));
            assert!(
                (found / expected - 1.0).abs() < 0.03,
                "θ = {theta}: {found}, expected {expected}"
            );
        }
    }
}

#[test]
fn other_sides_are_black_and_beyond_the_mesh_is_the_floor() {
    let sir = sir("frit", Plans::Repaired);
    assert_eq!((sir.incident(), sir.scattered(), sir.name()), (Side::Front, Side::Back, "frit"));
    assert!(sir.isotropic() && sir.channels() == 1);
    let (front, back) = (from_degrees(20.0, 0.0), from_degrees(160.0, 180.0));
    assert!(value(&sir, front, back) > 0.0);
    assert_eq!(value(&sir, front, front), 0.0);
    assert_eq!(value(&sir, back, back), 0.0);
    assert!(value(&sir, DVec3::NAN, back).is_nan() && value(&sir, front, DVec3::NAN).is_nan());
    assert_eq!(value(&sir, from_degrees(80.0, 0.0), back), sir.floor() as f32);
    assert!(!sir.is_measured(from_degrees(80.0, 0.0)) && sir.is_measured(from_degrees(74.9, 0.0)));
}

#[test]
fn faults_name_place_expected_and_found() {
    let whole = golden("frit.sir");
    let start = whole.windows(2).position(|w| w == b"\n\n").expect("a header") + 2;
    let edit = |from: &str, to: &str| {
        let text = String::from_utf8(whole[..start].to_vec()).expect("text").replace(from, to);
        [text.as_bytes(), &whole[start..]].concat()
    };
    let with = |at: usize, bytes: &[u8]| {
        let mut copy = whole.clone();
        copy[at..at + bytes.len()].copy_from_slice(bytes);
        copy
    };
    let cases = [
        (Vec::new(), "byte 0: header: expected a line feed, found none"),
        (b"<html>\n\n".to_vec(), "header: expected SYMMETRY=, found none"),
        (edit("SYMMETRY=0", "SYMMETRY=5"), "SYMMETRY: expected one of 0, 1, 2"),
        (edit("IO_SIDES= 1 -1", "IO_SIDES= 1"), "IO_SIDES: expected two of 1 and -1, found \" 1\""),
        (
            edit("CIE-Y", "Spectral"),
            "COLORIMETRY: expected CIE-Y, CIE-XYZ or Unknown, found \"Spectral\"",
        ),
        (edit("GRIDRES=256", "GRIDRES=70000"), "GRIDRES: expected 16 to 65535, found \"70000\""),
        (edit("GRIDRES=256", "GRIDRES=16"), "expected a cell below 16"),
        (edit("BSDFMIN=0", "BSDFMIN=n"), "BSDFMIN: expected a number"),
        (edit("BSDF_RBFmesh", "picture"), "FORMAT: expected BSDF_RBFmesh, found \"picture\""),
        (
            edit("IO_SIDES= 1 -1", "IO_SIDES= -1 1"),
            "node 0: expected a unit incident vector on side Back",
        ),
        (with(start, &[0, 0]), "magic number: expected 0x5a3c, found 0x0000"),
        (with(start + 2, &[0, 0, 0, 7]), "node 0: expected ordinal 0, found 7"),
        (
            with(start + 26, &[0x7f, 0xff, 0xff, 0xff]),
            "lobes in the rest of the file, found 2147483647",
        ),
        (whole[..whole.len() - 8].to_vec(), "before the end of the file"),
    ];
    for (bytes, expected) in cases {
        let error =
            Sir::from_bytes(&bytes, Plans::Repaired, SirLimits::default()).expect_err(expected);
        assert_eq!(error.class(), ErrorClass::Format);
        assert!(error.to_string().contains(expected), "{error}\nexpected: {expected}");
    }
    let error =
        Sir::from_bytes(&whole, Plans::Repaired, SirLimits { bytes: 1000 }).expect_err("too large");
    assert_eq!(error.class(), ErrorClass::Limit);
    let error = Sir::read(std::path::Path::new("no such file.sir")).expect_err("absent");
    assert_eq!(error.class(), ErrorClass::Io);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Whatever bytes change or go missing: an error, or answers that are finite and not negative.
    #[test]
    fn broken_files_do_no_harm(
        edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        keep in prop::option::of(any::<prop::sample::Index>()),
        header in any::<bool>(),
    ) {
        let mut bytes = golden("frit.sir");
        let start = bytes.windows(2).position(|w| w == b"\n\n").expect("a header") + 2;
        let length = bytes.len();
        for (at, byte) in edits {
            // Header and node heads are rare among the bytes, so every other case aims there.
            let range = if header { start + 34 } else { length };
            bytes[at.index(range)] = byte;
        }
        if let Some(keep) = keep {
            bytes.truncate(keep.index(length));
        }
        if let Ok(sir) = Sir::from_bytes(&bytes, Plans::Repaired, SirLimits::default()) {
            for theta in [0.0, 10.0, 44.0, 61.0, 80.0] {
                let wi = from_degrees(theta, 30.0);
                let wi = DVec3::new(wi.x, wi.y, wi.z * sir.incident().sign());
                let wo: Vec<DVec3> = (0..20)
                    .map(|k| from_degrees(4.7 * f64::from(k), 50.0 * f64::from(k)))
                    .map(|w| DVec3::new(w.x, w.y, w.z * sir.scattered().sign()))
                    .collect();
                let mut out = vec![0.0; wo.len() * sir.channels()];
                sir.slice(wi).eval(&wo, &mut out);
                prop_assert!(out.iter().all(|v| v.is_finite() && *v >= 0.0), "{out:?}");
            }
        }
    }
}

/// A file of `nodes` lone-lobe nodes, all joined: the smallest that could make faces without bound.
fn clique(nodes: u32) -> Vec<u8> {
    let float = |x: f64| {
        let exponent = if x == 0.0 { 0 } else { x.abs().log2().floor() as i32 + 1 };
        let mantissa = (x / f64::from(exponent).exp2() * f64::from(i32::MAX)) as i32;
        [&mantissa.to_be_bytes()[..], &(exponent as i8).to_be_bytes()].concat()
    };
    let mut bytes =
        b"#?RADIANCE\nSYMMETRY=15\nIO_SIDES= 1 1\nFORMAT=BSDF_RBFmesh\n\n\x5a\x3c".to_vec();
    for k in 0..nodes {
        bytes.extend(k.to_be_bytes());
        let w = from_degrees(1.0 + 80.0 * f64::from(k) / f64::from(nodes), 137.5 * f64::from(k));
        [w.x, w.y, w.z, 0.5].into_iter().for_each(|x| bytes.extend(float(x)));
        bytes.extend(1_u32.to_be_bytes());
        bytes.extend(float(0.1));
        [49750_u16, 1000, 100, 100].into_iter().for_each(|x| bytes.extend(x.to_be_bytes()));
    }
    bytes.extend((-1_i32).to_be_bytes());
    for from in 0..nodes {
        for to in from + 1..nodes {
            bytes.extend([from.to_be_bytes(), to.to_be_bytes()].concat());
            bytes.push(0);
            bytes.extend(float(1.0));
            bytes.push(0);
        }
    }
    bytes.extend([-1_i32, -1].map(i32::to_be_bytes).concat());
    bytes
}

#[test]
fn a_mesh_that_is_not_planar_is_refused_before_it_grows() {
    let read = |n| Sir::from_bytes(&clique(n), Plans::Repaired, SirLimits::default());
    assert_eq!(read(4).expect("four nodes are a mesh").nodes().len(), 4);
    let message = read(400).expect_err("a clique of 400").to_string();
    assert!(
        message.contains("expected a planar mesh of 400 nodes, found more than 1600 faces"),
        "{message}"
    );
}
