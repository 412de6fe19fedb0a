//! Written files read back the same; broken ones never panic.

mod golden;
mod support;

use bsdfkit::matrix::{KlemsBasis, KlemsMatrix, Ring};
use bsdfkit::tree::{Rank, TensorTree, TreeDistribution};
use bsdfkit::xml::{Limits, WriteOptions, from_bytes, read, write, write_to};
use bsdfkit::{Bsdf, Component, Components, Error, Lambertian, Metadata, Side, Xyz};
use proptest::prelude::*;
use support::{Random, random_tree};

const PAIRS: [(Side, Side); 4] = [
    (Side::Front, Side::Front),
    (Side::Front, Side::Back),
    (Side::Back, Side::Back),
    (Side::Back, Side::Front),
];

fn text(bsdf: &Bsdf, options: &WriteOptions) -> Result<String, Error> {
    let mut out = Vec::new();
    write_to(bsdf, &mut out, options)?;
    Ok(String::from_utf8(out).unwrap())
}

fn back(bsdf: &Bsdf, options: &WriteOptions) -> Bsdf {
    let text = text(bsdf, options).unwrap();
    let (back, warnings) = from_bytes(text.as_bytes(), &Limits::default()).unwrap();
    let energy = |w: &&bsdfkit::xml::Warning| !w.text.contains("% of the light");
    assert_eq!(warnings.iter().filter(energy).count(), 0, "{warnings:?}");
    back
}

const EXACT: WriteOptions = WriteOptions { digits: 9, window_fields: false };

fn matrix(incident: &KlemsBasis, scattered: &KlemsBasis, random: &mut Random) -> KlemsMatrix {
    let mut channel = |scale: f64| {
        let n = incident.directions() * scattered.directions();
        (0..n).map(|_| (scale * random.unit().powi(8)) as f32).collect::<Vec<f32>>()
    };
    KlemsMatrix::new(incident.clone(), scattered.clone(), channel(0.1))
        .unwrap()
        .with_colour(channel(0.2), channel(1e-6))
        .unwrap()
}

fn assert_same_values(a: &Bsdf, b: &Bsdf, relative: f64, random: &mut Random) {
    for _ in 0..300 {
        for (i, s) in PAIRS {
            let (wi, wo) = (random.direction(i), random.direction(s));
            let (x, y) = (a.eval_xyz(wi, wo), b.eval_xyz(wi, wo));
            for (x, y) in [(x.x, y.x), (x.y, y.y), (x.z, y.z)] {
                assert!((x - y).abs() <= relative * x.abs(), "{wi} {wo}: {x} {y}");
            }
        }
    }
}

#[test]
fn matrices_of_all_bases_come_back_bit_by_bit() {
    let custom = KlemsBasis::new(
        "mine & <yours>",
        vec![
            Ring { upper_degrees: 12.25, patches: 2 },
            Ring { upper_degrees: 1.0 / 3.0 + 40.0, patches: 7 },
            Ring { upper_degrees: 90.0, patches: 5 },
        ],
    )
    .unwrap();
    let [full, half, old, quarter] =
        [KlemsBasis::full(), KlemsBasis::half(), KlemsBasis::half_73(), KlemsBasis::quarter()];
    let random = &mut Random(1);
    for (incident, scattered) in
        [(&full, &full), (&half, &old), (&old, &old), (&quarter, &custom), (&custom, &half)]
    {
        let components =
            PAIRS.map(|(i, s)| Component::new(i, s, matrix(incident, scattered, random)));
        let bsdf = Bsdf::new(Metadata::default(), components.into(), Lambertian::default());
        let read = back(&bsdf, &EXACT);
        assert_eq!(read.components().len(), 4);
        for c in bsdf.components() {
            let twin = |d: &&Component| (d.incident, d.scattered) == (c.incident, c.scattered);
            let d = read.components().iter().find(twin).unwrap();
            let [c, d] = [c, d].map(|c| c.distribution().downcast_ref::<KlemsMatrix>().unwrap());
            assert_eq!(c.values(), d.values());
            assert_eq!(c.chromatic(), d.chromatic());
            assert_eq!(c.incident().rings(), d.incident().rings());
            assert_eq!(c.scattered().rings(), d.scattered().rings());
        }
        assert_same_values(&bsdf, &back(&bsdf, &WriteOptions::default()), 5.1e-5, random);
    }
}

#[test]
fn trees_come_back_bit_by_bit() {
    let random = &mut Random(2);
    for rank in [Rank::Three, Rank::Four] {
        let mut components = Vec::new();
        for (i, s) in PAIRS {
            let tree = random_tree(rank, 3, 0.0, random);
            let u = random_tree(rank, 2, 0.1, random);
            let v = random_tree(rank, 1, 0.2, random);
            let tree = TreeDistribution::with_chromaticity(tree, u, v).unwrap();
            components.push(Component::new(i, s, tree));
        }
        let bsdf = Bsdf::new(Metadata::default(), components, Lambertian::default());
        let read = back(&bsdf, &EXACT);
        for c in bsdf.components() {
            let twin = |d: &&Component| (d.incident, d.scattered) == (c.incident, c.scattered);
            let d = read.components().iter().find(twin).unwrap();
            let [c, d] =
                [c, d].map(|c| c.distribution().downcast_ref::<TreeDistribution>().unwrap());
            assert_eq!(c.luminance(), d.luminance());
            assert_eq!(c.chromaticity(), d.chromaticity());
        }
    }
}

#[test]
fn lambertian_parts_are_written_into_the_values() {
    let lambertian = Lambertian {
        reflection_front: Xyz::grey(0.3),
        reflection_back: Xyz::grey(0.1),
        transmission_front: Xyz::grey(0.2),
        transmission_back: Xyz::grey(0.2),
    };
    let random = &mut Random(3);
    let tree = |random: &mut Random| TreeDistribution::new(random_tree(Rank::Four, 2, 0.0, random));
    let components = vec![
        Component::new(Side::Front, Side::Front, tree(random)),
        Component::new(Side::Back, Side::Front, tree(random)),
    ];
    let bsdf = Bsdf::new(Metadata::default(), components, lambertian);
    assert_same_values(&bsdf, &back(&bsdf, &EXACT), 1e-6, random);
    // Nothing but Lambertian parts, one of them coloured.
    let lambertian = Lambertian { reflection_back: Xyz::new(0.2, 0.3, 0.4), ..lambertian };
    let bsdf = Bsdf::new(Metadata::default(), Vec::new(), lambertian);
    let read = back(&bsdf, &EXACT);
    let grey = |a: Xyz, b: Xyz| (a.y - b.y).abs() < 1e-7;
    assert!(grey(read.lambertian().reflection_front, bsdf.lambertian().reflection_front));
    assert!(grey(read.lambertian().transmission_back, bsdf.lambertian().transmission_back));
    // Colour goes through u′, v′ and a four-digit matrix.
    assert_same_values(&bsdf, &read, 2e-4, random);
}

#[test]
fn what_the_format_cannot_hold_is_refused() {
    let tree = |rank| TreeDistribution::new(TensorTree::constant(rank, 0.1).unwrap());
    let of = |components, lambertian| Bsdf::new(Metadata::default(), components, lambertian);
    let none = Lambertian::default();
    let front = |rank| Component::new(Side::Front, Side::Front, tree(rank));
    let back = |rank| Component::new(Side::Back, Side::Back, tree(rank));
    let refused = |bsdf: &Bsdf| text(bsdf, &EXACT).unwrap_err().to_string();
    let mixed = of(vec![front(Rank::Three), back(Rank::Four)], none);
    assert!(refused(&mixed).contains("one kind"));
    assert!(
        refused(&of(vec![front(Rank::Four), front(Rank::Four)], none)).contains("one component")
    );
    let coloured = Lambertian { reflection_front: Xyz::new(1.0, 0.5, 0.5), ..none };
    assert!(refused(&of(vec![front(Rank::Four)], coloured)).contains("coloured"));
    let options = WriteOptions { digits: 0, ..EXACT };
    assert!(text(&of(Vec::new(), none), &options).unwrap_err().to_string().contains("digits"));
}

#[test]
fn description_and_unread_elements_survive() {
    let source = "<!-- made by hand -->\n<WindowElement><Checksum>7</Checksum><Extra>8</Extra><Optical><Layer>\
        <Material><Name>A &amp; &lt;B&gt;</Name><Manufacturer>M</Manufacturer>\
        <Thickness unit='Inch'>1</Thickness><DeviceType>Film</DeviceType>\
        <Conductance unit='W'>5</Conductance></Material>\
        <Geometry format='MGF'><Slats n='3'/><MGFblock unit='meter'>c red\r\n&lt;</MGFblock></Geometry>\
        <DataDefinition><IncidentDataStructure>TensorTree4</IncidentDataStructure></DataDefinition>\
        <WavelengthData><Wavelength>Solar</Wavelength><WavelengthDataBlock>1 2</WavelengthDataBlock></WavelengthData>\
        <WavelengthData><Wavelength>Visible</Wavelength><WavelengthDataBlock>\
        <WavelengthDataDirection>Absorbed Front</WavelengthDataDirection><ScatteringData>9</ScatteringData>\
        </WavelengthDataBlock><WavelengthDataBlock>\
        <WavelengthDataDirection>transmission front</WavelengthDataDirection>\
        <ScatteringData><![CDATA[{ .1 }]]></ScatteringData></WavelengthDataBlock></WavelengthData>\
        </Layer></Optical></WindowElement>";
    let (bsdf, _) = from_bytes(source.as_bytes(), &Limits::default()).unwrap();
    let metadata = bsdf.metadata();
    assert_eq!(metadata.name, "A & <B>");
    assert_eq!(metadata.thickness, 0.0254);
    assert_eq!(metadata.property("DeviceType"), Some("Film"));
    assert_eq!(metadata.geometry.as_deref(), Some("c red\n<"));
    assert_eq!(metadata.comments, ["made by hand"]);
    let read = back(&bsdf, &EXACT);
    assert_eq!(read.metadata(), metadata);
    let written = text(&bsdf, &EXACT).unwrap();
    for part in
        ["<Extra>8<", "<Slats n='3'/>", "<Conductance unit='W'>5<", "Solar", "Absorbed Front"]
    {
        assert_eq!(written.matches(part).count(), 1, "{part} in {written}");
    }
    assert!(!written.contains("Checksum"));
    assert!(text(&bsdf, &WriteOptions::default()).unwrap().contains("<EmissivityFront>0.9<"));
}

/// A file whose Front and Back are exchanged must not come back as the same.
#[test]
fn mirrored_sides_are_noticed() {
    let random = &mut Random(4);
    let matrix = matrix(&KlemsBasis::full(), &KlemsBasis::full(), random);
    let components = vec![Component::new(Side::Front, Side::Back, matrix)];
    let bsdf = Bsdf::new(Metadata::default(), components, Lambertian::default());
    let text = text(&bsdf, &EXACT).unwrap();
    // Light incident on our front is, in the file, light from the back.
    assert!(text.contains(">Transmission Back<") && !text.contains("Front<"));
    let mirrored = text.replace("Transmission Back", "Transmission Front");
    let (mirrored, _) = from_bytes(mirrored.as_bytes(), &Limits::default()).unwrap();
    let wi = random.direction(Side::Front);
    let different = (0..100).any(|_| {
        let wo = random.direction(Side::Back);
        (bsdf.eval(wi, wo) - mirrored.eval(wi, wo)).abs() > 1e-3
    });
    assert!(different);
}

#[test]
fn the_target_is_replaced_whole_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.xml");
    std::fs::write(&path, "old").unwrap();
    let tree = TreeDistribution::new(TensorTree::constant(Rank::Four, 0.1).unwrap());
    let bsdf = |components| Bsdf::new(Metadata::default(), components, Lambertian::default());
    let one = Component::new(Side::Front, Side::Front, tree);
    let unwritable = bsdf(vec![one.clone(), one.clone()]);
    assert!(write(&unwritable, &path, &EXACT).is_err());
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "old");
    write(&bsdf(vec![one]), &path, &EXACT).unwrap();
    let total = read(&path).unwrap().directional_hemispherical(bsdfkit::DVec3::Z, Components::ALL);
    assert!((total - 0.1 * std::f64::consts::PI).abs() < 1e-6);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    let missing = folder.path().join("no/such/folder/out.xml");
    let error = write(&bsdf(Vec::new()), &missing, &EXACT).unwrap_err();
    assert_eq!(error.class(), bsdfkit::ErrorClass::Io);
    assert!(error.to_string().contains("out.xml"));
}

#[test]
fn golden_files_come_back() {
    let random = &mut Random(5);
    let mut count = 0;
    for entry in std::fs::read_dir(golden::path("xml")).unwrap() {
        let bsdf = read(entry.unwrap().path()).unwrap();
        assert_same_values(&bsdf, &back(&bsdf, &EXACT), 1e-6, random);
        count += 1;
    }
    assert!(count > 60, "{count}");
}

/// One change to a file.
#[derive(Clone, Debug)]
enum Mutation {
    Overwrite(usize, u8),
    Delete(usize, usize),
    Repeat(usize, usize),
    Insert(usize, &'static str),
    Cut(usize),
}

fn mutation() -> impl Strategy<Value = Mutation> {
    let pieces = prop::sample::select(vec![
        "{",
        "}",
        "<",
        ">",
        "&",
        "&#0;",
        "&#x110000;",
        "<!--",
        "-->",
        "<![CDATA[",
        "]]>",
        "<a>",
        "</a>",
        "1e99",
        "-",
        ",",
        "<!DOCTYPE x [",
        "\u{e4}",
        "<?xml",
        "nan",
    ]);
    prop_oneof![
        (any::<usize>(), any::<u8>()).prop_map(|(at, byte)| Mutation::Overwrite(at, byte)),
        (any::<usize>(), 1usize..200).prop_map(|(at, n)| Mutation::Delete(at, n)),
        (any::<usize>(), 1usize..200).prop_map(|(at, n)| Mutation::Repeat(at, n)),
        (any::<usize>(), pieces).prop_map(|(at, piece)| Mutation::Insert(at, piece)),
        any::<usize>().prop_map(Mutation::Cut),
    ]
}

fn mutate(bytes: &mut Vec<u8>, mutation: &Mutation) {
    if bytes.is_empty() {
        return;
    }
    let length = bytes.len();
    let span = |at: usize, n: usize| at % length..(at % length + n).min(length);
    match *mutation {
        Mutation::Overwrite(at, byte) => bytes[at % length] = byte,
        Mutation::Delete(at, n) => drop(bytes.drain(span(at, n))),
        Mutation::Repeat(at, n) => {
            let part = bytes[span(at, n)].to_vec();
            bytes.splice(at % length..at % length, part);
        }
        Mutation::Insert(at, piece) => drop(bytes.splice(at % length..at % length, piece.bytes())),
        Mutation::Cut(at) => bytes.truncate(at % length),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn broken_files_never_panic(
        file in prop::sample::select(vec![
            "badxml/00_good_tree.xml", "xml/custom_basis.xml", "xml/color_tree_0.6_0.3.xml",
            "badxml/53_bom.xml", "xml/t3_kids8.xml", "xml/meta_1.xml",
        ]),
        mutations in prop::collection::vec(mutation(), 1..6),
    ) {
        let mut bytes = std::fs::read(golden::path(file)).unwrap();
        for mutation in &mutations {
            mutate(&mut bytes, mutation);
        }
        if let Ok((bsdf, _)) = from_bytes(&bytes, &Limits::default()) {
            let wi = bsdfkit::DVec3::new(0.6, 0.0, 0.8);
            prop_assert!(bsdf.eval(wi, wi) >= 0.0);
            // What could be read can be written and read again.
            let text = text(&bsdf, &EXACT).unwrap();
            prop_assert!(from_bytes(text.as_bytes(), &Limits::default()).is_ok(), "{}", text);
        }
    }
}
