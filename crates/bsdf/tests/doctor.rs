//! Each kind of finding, on a file made for it from a good one; what mending makes of it.

use std::collections::BTreeSet;

use bsdfkit::matrix::{KlemsBasis, KlemsMatrix, Ring};
use bsdfkit::tree::{Rank, TensorTree, TreeDistribution};
use bsdfkit::xml::doctor::{self, KINDS, Mends, Program, examine, mend};
use bsdfkit::xml::{Limits, WriteOptions, from_bytes, write_to};
use bsdfkit::{Band, Bsdf, Component, DVec3, Lambertian, Metadata, Side};
use std::f64::consts::{FRAC_1_PI, PI};

const PAIRS: [(Side, Side); 4] = [
    (Side::Back, Side::Front),
    (Side::Back, Side::Back),
    (Side::Front, Side::Back),
    (Side::Front, Side::Front),
];

fn metadata() -> Metadata {
    let properties = [
        ("ThermalConductivity", "1"),
        ("EmissivityFront", ".9"),
        ("EmissivityBack", ".9"),
        ("TIR", "0"),
        ("DeviceType", "Other"),
        ("EffectiveOpennessFraction", ".1"),
    ];
    Metadata {
        name: "Shade".into(),
        manufacturer: "Acme".into(),
        thickness: 0.003,
        properties: properties.map(|(k, v)| (k.to_owned(), v.to_owned())).to_vec(),
        ..Metadata::default()
    }
}

/// `through` of the light goes straight on or is mirrored, `diffuse` is Lambertian.
fn matrix(basis: &KlemsBasis, through: f64, diffuse: f64) -> KlemsMatrix {
    let n = basis.directions();
    let value = |k: usize| {
        let peak = if k / n == k % n { through / basis.projected_solid_angle(k % n) } else { 0.0 };
        (diffuse * FRAC_1_PI + peak) as f32
    };
    KlemsMatrix::new(basis.clone(), basis.clone(), (0..n * n).map(value).collect()).unwrap()
}

fn component((incident, scattered): (Side, Side), m: KlemsMatrix) -> Component {
    Component::new(incident, scattered, m)
}

/// What every program reads: all four directions, .6 passes, .2 is reflected.
fn four(basis: &KlemsBasis) -> Vec<Component> {
    let of = |sides: (Side, Side)| {
        let (through, diffuse) = if sides.0 == sides.1 { (0.05, 0.15) } else { (0.5, 0.1) };
        component(sides, matrix(basis, through, diffuse))
    };
    PAIRS.map(of).to_vec()
}

fn with(mut list: Vec<Component>, sides: (Side, Side), m: KlemsMatrix) -> Vec<Component> {
    let at = list.iter().position(|c| (c.incident, c.scattered) == sides).unwrap();
    list[at] = component(sides, m);
    list
}

fn copy(m: &KlemsMatrix) -> KlemsMatrix {
    KlemsMatrix::new(m.incident().clone(), m.scattered().clone(), m.values().to_vec()).unwrap()
}

fn file(visible: Vec<Component>, solar: Vec<Component>) -> String {
    let bands = if solar.is_empty() { Vec::new() } else { vec![Band::new("Solar", solar)] };
    let bsdf = Bsdf::new(metadata(), visible, Lambertian::default()).with_bands(bands);
    let mut bytes = Vec::new();
    write_to(&bsdf, &mut bytes, &WriteOptions { digits: 9, ..WriteOptions::default() }).unwrap();
    String::from_utf8(bytes).unwrap()
}

fn good() -> String {
    let full = KlemsBasis::full();
    file(four(&full), four(&full))
}

/// The same with Visible changed.
fn visible(change: impl FnOnce(Vec<Component>) -> Vec<Component>) -> String {
    let full = KlemsBasis::full();
    file(change(four(&full)), four(&full))
}

fn replaced(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "{from}");
    text.replace(from, to)
}

fn once(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "{from}");
    text.replacen(from, to, 1)
}

/// The text of the first `WavelengthData`.
fn first_data(text: &str) -> &str {
    let end = "</WavelengthData>\n";
    &text[text.find("<WavelengthData>").unwrap()..text.find(end).unwrap() + end.len()]
}

fn codes(bytes: &[u8]) -> BTreeSet<&'static str> {
    examine(bytes, &Limits::default()).findings.iter().map(|f| f.kind.code).collect()
}

fn bsdf(bytes: &[u8]) -> Bsdf {
    from_bytes(bytes, &Limits::default()).unwrap().0
}

/// A file with one fault.
struct Case {
    code: &'static str,
    bytes: Vec<u8>,
    /// What else is the matter with such a file.
    beside: &'static [&'static str],
}

fn case(code: &'static str, text: impl Into<Vec<u8>>, beside: &'static [&'static str]) -> Case {
    Case { code, bytes: text.into(), beside }
}

fn cases() -> Vec<Case> {
    let mut all = of_the_file();
    all.extend(of_words_and_description());
    all.extend(of_blocks());
    all.extend(of_form());
    all.extend(of_light());
    all
}

fn of_the_file() -> Vec<Case> {
    let good = good();
    let wide: Vec<u8> = good.encode_utf16().flat_map(u16::to_le_bytes).collect();
    vec![
        case("web-page", "<!DOCTYPE html>\n<html><body>shade.xml</body></html>", &[]),
        case("other-format", b"tensor_file\0\x01\0".to_vec(), &[]),
        case(
            "unreadable",
            once(&good, "<ScatteringData>\n", "<ScatteringData>\n1,"),
            TRANSMITS_NOT,
        ),
        case("before-declaration", format!("stray line\n{good}"), &["transmits"]),
        case("outside-text", format!("{good}stray line\n"), &["transmits"]),
        case("encoding", [b"\xff\xfe".to_vec(), wide].concat(), &["transmits"]),
        case(
            "line-breaks",
            once(&good, "\n<IncidentDataStructure>", "<IncidentDataStructure>"),
            &["transmits"],
        ),
        case(
            "late-structure",
            once(&good, "<Optical>", &format!("<Optical>{}", "\n".repeat(2000))),
            &["transmits"],
        ),
    ]
}

const TRANSMITS_NOT: &[&str] = &[];

fn of_words_and_description() -> Vec<Case> {
    let good = good();
    let lines = replaced(&replaced(&good, ",\n", "\n"), ",", " ");
    let swap = |from, to| once(&good, from, to);
    vec![
        case("padded-label", replaced(&good, ">Visible<", ">\n Visible\n<"), &["transmits"]),
        case("padded-label", swap(">Reflection Back<", "> Reflection Back <"), &["transmits"]),
        case("padded-keyword", swap(">Columns<", ">\tColumns<"), &["transmits"]),
        case("padded-keyword", swap(">BSDF<", ">BSDF <"), &["transmits"]),
        case("cie-y", replaced(&good, ">Visible<", ">CIE-Y<"), &["transmits"]),
        case("rows", swap(">Columns<", ">Rows<"), &["transmits"]),
        case("separators", lines, &["transmits"]),
        case("no-description", swap(">Acme<", "><"), &["transmits"]),
        case("no-thermal-data", swap("<TIR>0</TIR>", ""), &["transmits"]),
        case("thickness-unit", swap("unit=\"Meter\"", "unit=\"Inch\""), &["transmits"]),
        case("no-size", swap("<Width unit=\"Meter\">1</Width>", ""), &["transmits"]),
    ]
}

fn of_blocks() -> Vec<Case> {
    let good = good();
    let full = KlemsBasis::full();
    let zero = || matrix(&full, 0.0, 0.0);
    let (tf, tb, rf) = (PAIRS[0], PAIRS[2], PAIRS[1]);
    let coloured = |x: f64| {
        let values = vec![x as f32; 145 * 145];
        matrix(&full, 0.05, 0.15).with_colour(values.clone(), vec![0.05; 145 * 145]).unwrap()
    };
    let colour = visible(|list| with(list, rf, coloured(0.05)));
    let mut three = four(&full);
    three.pop();
    let nir = vec![Band::new("Solar", four(&full)), Band::new("NIR", four(&full))];
    let nir = Bsdf::new(metadata(), four(&full), Lambertian::default()).with_bands(nir);
    let mut with_nir = Vec::new();
    write_to(&nir, &mut with_nir, &WriteOptions::default()).unwrap();
    let at = good.rfind("<ScatteringData>\n").unwrap() + "<ScatteringData>\n".len();
    let broken = format!("{}x{}", &good[..at], &good[at..]);
    vec![
        case("no-visible", replaced(&good, ">Visible<", ">NIR<"), &["further-bands"]),
        case("no-solar", file(four(&full), Vec::new()), &["transmits"]),
        case("missing-directions", file(four(&full), three), &["transmits"]),
        case("further-bands", with_nir, &["transmits"]),
        case("further-bands", colour.clone(), &["transmits"]),
        case(
            "duplicate-block",
            once(&good, first_data(&good), &first_data(&good).repeat(2)),
            &["transmits"],
        ),
        case("fractional", shares(), &[]),
        case(
            "dummy-transmission",
            visible(|list| with(with(list, tb, zero()), tf, matrix(&full, 0.5, 0.0))),
            &["transmits"],
        ),
        case(
            "dummy-loses-floor",
            visible(|list| with(list, tb, zero())),
            &["dummy-transmission", "transmits"],
        ),
        case("dummy-block", visible(|list| with(list, rf, zero())), &["transmits"]),
        case(
            "dummy-band",
            file(four(&full), PAIRS.map(|sides| component(sides, zero())).to_vec()),
            &["transmits"],
        ),
        case(
            "dummy-colour",
            visible(|list| with(list, rf, coloured(0.0))),
            &["further-bands", "transmits"],
        ),
        case("half-colour", replaced(&colour, ">CIE-Z<", ">NIR<"), &["further-bands", "transmits"]),
        case("band-not-read", broken, &["transmits"]),
        case("negative", once(&good, "<ScatteringData>\n", "<ScatteringData>\n-"), &["transmits"]),
        case(
            "further-layers",
            once(&good, "</Layer>", "</Layer>\n<Layer></Layer>"),
            &["transmits"],
        ),
    ]
}

/// Transmission from the front of the file as shares of light.
fn shares() -> String {
    let full = KlemsBasis::full();
    let (tf, n) = (PAIRS[0], full.directions());
    let values = matrix(&full, 0.5, 0.1).values().to_vec();
    let share = |(k, v): (usize, f32)| v * full.projected_solid_angle(k % n) as f32;
    let values = values.into_iter().enumerate().map(share).collect();
    let text = visible(|list| {
        with(list, tf, KlemsMatrix::new(full.clone(), full.clone(), values).unwrap())
    });
    let data = first_data(&text);
    assert!(data.contains("Transmission Front"));
    once(&text, data, &once(data, ">BTDF<", ">Fractional Diffuse<"))
}

fn of_form() -> Vec<Case> {
    let tree = |rank| TreeDistribution::new(TensorTree::constant(rank, 0.1).unwrap());
    let trees = |rank, sides: &[(Side, Side)]| {
        let all = sides.iter().map(|(i, s)| Component::new(*i, *s, tree(rank)));
        file(all.collect(), Vec::new())
    };
    let on = |basis: &KlemsBasis| file(four(basis), four(basis));
    let rings = [30.0, 60.0, 90.0].map(|upper_degrees| Ring { upper_degrees, patches: 8 });
    let own = KlemsBasis::new("Own", rings.to_vec()).unwrap();
    let short = KlemsBasis::new("Short", rings[..2].to_vec()).unwrap();
    let half_73 = KlemsBasis::new("Seventy-three", KlemsBasis::half_73().rings().to_vec()).unwrap();
    let named = |text: String, from: &str, to: &str| {
        replaced(&text, &format!(">{from}<"), &format!(">LBNL/Klems {to}<"))
    };
    vec![
        case("tree", trees(Rank::Four, &PAIRS), &["transmits"]),
        case("not-klems-full", on(&KlemsBasis::quarter()), &["transmits"]),
        case("half-77", on(&KlemsBasis::half()), &["not-klems-full", "transmits"]),
        case(
            "half-73",
            named(on(&half_73), "Seventy-three", "Half"),
            &["not-klems-full", "transmits"],
        ),
        case("other-rings", named(on(&own), "Own", "Quarter"), &["not-klems-full", "transmits"]),
        case("incomplete-basis", on(&short), &["not-klems-full", "transmits"]),
        case("lone-isotropic-tree", trees(Rank::Three, &PAIRS[..1]), &["tree", "transmits"]),
        case("transmits", good(), &[]),
    ]
}

fn of_light() -> Vec<Case> {
    let full = KlemsBasis::full();
    let n = full.directions();
    let (tf, rf, tb, rb) = (PAIRS[0], PAIRS[1], PAIRS[2], PAIRS[3]);
    let diffuse = |share| matrix(&full, 0.0, share);
    // All light leaves toward one patch, from wherever it comes.
    let one_way = |share: f64| {
        let omega = full.projected_solid_angle(20);
        let value = |k: usize| if k % n == 20 { (share / omega) as f32 } else { 1e-4 };
        KlemsMatrix::new(full.clone(), full.clone(), (0..n * n).map(value).collect()).unwrap()
    };
    let bent = one_way(0.5).reversed().unwrap();
    let outside = file(vec![component(rf, matrix(&full, 0.3, 0.1))], Vec::new());
    let faint = matrix(&full, 0.0005, 0.0001);
    let dark = file(PAIRS.map(|sides| component(sides, diffuse(0.0))).to_vec(), Vec::new());
    vec![
        case("energy", visible(|list| with(list, rb, diffuse(0.5))), &["transmits"]),
        case("band-energy", file(four(&full), with(four(&full), rb, diffuse(0.5))), &["transmits"]),
        case(
            "exchanged-sides",
            visible(|list| {
                let list = with(with(list, tf, diffuse(0.2)), tb, diffuse(0.7));
                with(with(list, rf, diffuse(0.2)), rb, diffuse(0.7))
            }),
            &["transmits", "not-reciprocal"],
        ),
        case("reflects-outside", outside, &["no-solar", "missing-directions"]),
        case("not-reciprocal", visible(|list| with(list, rf, one_way(0.3))), &["transmits"]),
        case("dark", dark, &["no-solar", "transmits"]),
        case("weak", visible(|list| with(list, rf, diffuse(0.1))), &["transmits"]),
        case("faint", visible(|list| with(list, rf, faint)), &["transmits"]),
        case(
            "asymmetric",
            visible(|list| with(with(list, tf, one_way(0.5)), tb, copy(&bent))),
            &["transmits", "energy"],
        ),
    ]
}

#[test]
fn every_kind_is_found_in_a_file_made_for_it_and_nothing_else() {
    let (mut seen, mut wrong) = (BTreeSet::new(), Vec::new());
    for Case { code, bytes, beside } in cases() {
        let expected: BTreeSet<&str> = beside.iter().copied().chain([code]).collect();
        let found = codes(&bytes);
        if found != expected {
            wrong.push(format!("{code}: expected {expected:?}, found {found:?}"));
        }
        seen.insert(code);
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    let all: BTreeSet<&str> = KINDS.iter().map(|kind| kind.code).collect();
    assert_eq!(
        all.difference(&seen).copied().collect::<Vec<_>>(),
        Vec::<&str>::new(),
        "no file for"
    );
    assert_eq!(all.len(), KINDS.len(), "a code twice");
}

#[test]
fn what_is_mended_is_gone_and_mending_twice_changes_nothing() {
    let limits = Limits::default();
    for Case { code, bytes, beside } in cases() {
        let kind = doctor::kind(code).unwrap();
        let also: &[&str] = if matches!(kind.mends, Mends::Asked(_)) { &[code] } else { &[] };
        let mended = match mend(&bytes, also, &limits) {
            Ok(mended) => mended,
            Err(e) => {
                let never = ["web-page", "other-format", "unreadable", "no-visible"];
                assert!(never.contains(&code), "{code}: {e}");
                continue;
            }
        };
        let after = codes(&mended.bytes);
        let goes = matches!(kind.mends, Mends::Always(_) | Mends::Asked(_));
        assert_eq!(after.contains(code), !goes, "{code}: {after:?}");
        let told: Vec<&str> = mended.changes.iter().map(|(f, _)| f.kind.code).collect();
        assert_eq!(told.contains(&code), goes, "{code}: {told:?}");
        let goes = |code: &&str| matches!(doctor::kind(code).unwrap().mends, Mends::Always(_));
        if !goes(&code) && also.is_empty() && !beside.iter().any(goes) {
            assert!(mended.bytes == bytes, "{code}: changed without need");
        }
        let twice = mend(&mended.bytes, also, &limits).unwrap();
        assert!(twice.bytes == mended.bytes && twice.changes.is_empty(), "{code}");
    }
}

/// Values at some pairs of directions, of the visible band and of Solar.
fn values(bytes: &[u8]) -> Vec<f64> {
    let bsdf = bsdf(bytes);
    let directions: Vec<DVec3> = (0..60u32)
        .map(|k| {
            let (theta, phi) = (f64::from(k * 37 % 178) + 1.0, f64::from(k * 97 % 360));
            bsdfkit_sphere::direction::from_degrees(theta, phi)
        })
        .collect();
    let bands = [Some(bsdf.clone()), bsdf.band("Solar")];
    let of = |bsdf: &Bsdf| -> Vec<f64> {
        let pairs = directions.iter().flat_map(|i| directions.iter().map(move |o| (*i, *o)));
        pairs.map(|(i, o)| bsdf.eval(i, o)).collect()
    };
    bands.iter().flatten().flat_map(of).collect()
}

#[test]
fn mending_text_keeps_every_value() {
    let limits = Limits::default();
    let (plain, rows) = (values(good().as_bytes()), ["rows", "half-73", "other-rings"]);
    for Case { code, bytes, .. } in of_the_file().into_iter().chain(of_words_and_description()) {
        if let Ok(mended) = mend(&bytes, &[], &limits) {
            assert!(rows.contains(&code) || values(&mended.bytes) == plain, "{code}");
        }
    }
    for Case { code, bytes, .. } in cases().into_iter().filter(|c| rows.contains(&c.code)) {
        let mended = mend(&bytes, &[], &limits).unwrap();
        assert_eq!(values(&mended.bytes), values(&bytes), "{code}");
    }
}

#[test]
fn shares_of_light_become_values() {
    let mended = mend(shares().as_bytes(), &[], &Limits::default()).unwrap();
    for (a, b) in values(&mended.bytes).into_iter().zip(values(good().as_bytes())) {
        assert!((a - b).abs() <= 1e-6 * b, "{a} {b}");
    }
}

#[test]
fn a_dummy_transmission_is_the_other_one_reversed() {
    let full = KlemsBasis::full();
    let n = full.directions();
    let bent = (0..n * n).map(|k| 1e-3 + (k * 31 % 97) as f32 * 1e-3).collect();
    let bent = KlemsMatrix::new(full.clone(), full.clone(), bent).unwrap();
    let zero = matrix(&full, 0.0, 0.0);
    let text = visible(|list| with(with(list, PAIRS[2], zero), PAIRS[0], copy(&bent)));
    let mended = mend(text.as_bytes(), &[], &Limits::default()).unwrap();
    let bsdf = bsdf(&mended.bytes);
    let back = bsdf.components().iter().find(|c| (c.incident, c.scattered) == PAIRS[2]).unwrap();
    let back = back.distribution().downcast_ref::<KlemsMatrix>().unwrap();
    assert_eq!(back.values(), bent.reversed().unwrap().values());
}

#[test]
fn energy_is_scaled_to_what_arrives_where_it_is_a_little_too_much() {
    let full = KlemsBasis::full();
    let of = |share: f64| visible(|list| with(list, PAIRS[3], matrix(&full, 0.0, share)));
    // .6 passes: 1.1 and 1.3 in all.
    let mended = mend(of(0.5).as_bytes(), &[], &Limits::default()).unwrap();
    let limits = Limits::default();
    let (few, many) = (bsdf(&mended.bytes), of(0.7));
    let wi = DVec3::new(0.6, 0.0, 0.8);
    let total = |wi| few.directional_hemispherical(wi, bsdfkit::Components::ALL);
    assert!((total(wi) - 1.0).abs() < 1e-5, "{}", total(wi));
    let kept = few.directional_hemispherical(wi, bsdfkit::Components::TRANSMISSION);
    assert!((kept - 0.6 / 1.1).abs() < 1e-5, "{kept}");
    // The other side was sound.
    assert!((total(-wi) - 0.8).abs() < 1e-5, "{}", total(-wi));
    let left = mend(many.as_bytes(), &[], &limits).unwrap();
    assert!(left.bytes == many.as_bytes() && left.changes.is_empty());
}

#[test]
fn averaging_makes_reciprocal() {
    let case = of_light().into_iter().find(|c| c.code == "not-reciprocal").unwrap();
    let mended = mend(&case.bytes, &["not-reciprocal"], &Limits::default()).unwrap();
    let bsdf = bsdf(&mended.bytes);
    for k in 0..40u32 {
        let at = |k: u32| {
            -bsdfkit_sphere::direction::from_degrees(f64::from(k * 13 % 89), f64::from(k * 71))
        };
        let (a, b) = (at(k), at(k + 7));
        let (there, back) = (bsdf.eval(a, b), bsdf.eval(b, a));
        assert!((there - back).abs() <= 1e-6 * there, "{there} {back}");
    }
}

#[test]
fn only_what_may_be_asked_for_is() {
    for code in ["energy", "tree", "nonsense"] {
        let error = mend(good().as_bytes(), &[code], &Limits::default()).unwrap_err().to_string();
        assert!(error.contains("not-reciprocal") && error.contains(code), "{error}");
    }
}

#[test]
fn programs_have_names() {
    for program in Program::ALL {
        assert_eq!(program.name().parse::<Program>().unwrap(), program);
    }
    assert!("Radiance".parse::<Program>().is_err());
}

/// Of the golden files nothing panics, and what cannot be read says so in a finding.
#[test]
fn bad_files_are_explained() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/golden/badxml");
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let bytes = std::fs::read(&path).unwrap();
        let found = examine(&bytes, &Limits::default());
        if found.error.is_some() {
            let explained = ["unreadable", "no-visible", "fractional", "other-format", "web-page"];
            let any = found.findings.iter().any(|f| explained.contains(&f.kind.code));
            assert!(any, "{}: {:?}", path.display(), found.findings);
        }
    }
}

/// Files as found in the wild: of the sound ones nothing that breaks Radiance is told but what is there.
#[test]
fn no_false_alarm_on_real_files() {
    let Ok(folder) = std::env::var("BSDFKIT_DATA") else {
        println!("BSDFKIT_DATA is not set: real files are not looked at");
        return;
    };
    let mut sound = 0;
    for part in ["xml", "xml_ignis_mini"] {
        for entry in std::fs::read_dir(std::path::Path::new(&folder).join(part)).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            let bytes = std::fs::read(&path).unwrap();
            let found = examine(&bytes, &Limits::default());
            let breaks = |program| -> Vec<&str> {
                let all = found.findings.iter().filter(|f| f.kind.breaks(program));
                let codes: BTreeSet<&str> = all.map(|f| f.kind.code).collect();
                codes.into_iter().collect()
            };
            let expected: &[&str] = match name.as_str() {
                "minimalBSDFt.xml" | "WINDOW6BSDFt.xml" => &["unreadable"],
                n if n.starts_with("W6_") => &["unreadable"],
                // Pretty-printed: Radiance refuses it.
                "CS10_genBSDF.xml" => &["padded-keyword", "padded-label"],
                // 88 times the light that arrives.
                "testBSDF.xml" => &["energy"],
                _ => &[],
            };
            assert_eq!(breaks(Program::Radiance), expected, "{name}");
            // WINDOW's engine reads this one; of ec60 the solar reflection is the transmission.
            if name == "CS10_genBSDF.xml" {
                assert_eq!(breaks(Program::Window), Vec::<&str>::new(), "{name}");
            }
            if name == "ec60.xml" {
                assert!(breaks(Program::Window).contains(&"band-energy"), "{name}");
            }
            sound += usize::from(expected.is_empty());
        }
    }
    assert!(sound >= 20, "{sound} sound files");
}

#[test]
fn totals_have_their_closed_form() {
    let full = KlemsBasis::full();
    let bsdf = Bsdf::new(metadata(), four(&full), Lambertian::default());
    for side in [Side::Front, Side::Back] {
        let most = doctor::largest_total(&bsdf, side).unwrap();
        assert!((most.total - 0.8).abs() < 1e-6 && !most.is_too_much(), "{most:?}");
        assert_eq!(Side::of(most.wi), side);
    }
    let dull = Bsdf::new(metadata(), Vec::new(), Lambertian::default());
    assert!(doctor::largest_total(&dull, Side::Front).is_none());
    assert!((matrix(&full, 0.0, 1.0).values()[0] - FRAC_1_PI as f32).abs() < 1e-6 && PI > 3.0);
}

/// The guide's table, a row a kind.
fn guide() -> String {
    let mut table = String::from(
        "| code | what | which programs, and how | to do | mended |\n|---|---|---|---|---|\n",
    );
    for kind in KINDS {
        let harm = |h: &doctor::Harm| {
            let names = match h.programs.len() == Program::ALL.len() {
                true => "all".to_owned(),
                false => h.programs.iter().map(|p| p.name()).collect::<Vec<_>>().join(", "),
            };
            format!("{names} ({}): {}", h.how.name(), h.text)
        };
        let harms = kind.harms.iter().map(harm).collect::<Vec<_>>().join("; ");
        let mended = match kind.mends {
            Mends::Always(how) => format!("yes: {how}"),
            Mends::For => "with `--for`".to_owned(),
            Mends::Asked(how) => format!("with `--also`: {how}"),
            Mends::Never => "no".to_owned(),
        };
        let row = format!(
            "| `{}` | {} | {harms} | {} | {mended} |\n",
            kind.code, kind.title, kind.remedy
        );
        table += &row;
    }
    table
}

#[test]
fn the_guide_lists_every_kind() {
    let page = include_str!("../../../docs/guide/check.md");
    assert!(page.contains(&guide()), "docs/guide/check.md: expected this table:\n{}", guide());
}
