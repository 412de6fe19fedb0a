//! Blocks that are 0 throughout, written where a direction is not known, count as absent.

use bsdfkit::tree::TreeDistribution;
use bsdfkit::xml::{Limits, from_bytes};
use bsdfkit::{Bsdf, Components, DVec3, Side};

/// A way of writing numbers: its structure, values, and zeros.
#[derive(Clone, Copy)]
struct Encoding {
    structure: &'static str,
    values: &'static str,
    zeros: &'static str,
}

const TREE4: Encoding = Encoding {
    structure: "TensorTree4",
    values: "{ .1 .2 .1 .1 .1 .1 .3 .1 .1 .1 .1 .1 .5 .1 .1 .1 }",
    zeros: "{ {0} {0} {0.0} {0} {0} {0} {0} {0} {0} {0} {0} {-0} {0} {0} {0} {0e9} }",
};
const TREE3: Encoding =
    Encoding { structure: "TensorTree3", values: "{ .1 .2 .1 .1 .1 .1 .3 .1 }", zeros: "{ 0 }" };

fn matrix(structure: &'static str) -> Encoding {
    let numbers: Vec<String> =
        (0..41 * 41).map(|n| format!("{:.3}", 0.05 + f64::from(n * 7 % 13) * 0.02)).collect();
    let text = |numbers: Vec<String>| -> &'static str { numbers.join(", ").leak() };
    Encoding { structure, values: text(numbers), zeros: text(vec!["0.000000".into(); 41 * 41]) }
}

fn block(wavelength: &str, direction: &str, data: &str, matrix: bool) -> String {
    let basis = "LBNL/Klems Quarter";
    let bases = match matrix {
        true => format!(
            "<ColumnAngleBasis>{basis}</ColumnAngleBasis><RowAngleBasis>{basis}</RowAngleBasis>"
        ),
        false => "<AngleBasis>LBNL/Shirley-Chiu</AngleBasis>".to_owned(),
    };
    format!(
        "<WavelengthData><Wavelength>{wavelength}</Wavelength><WavelengthDataBlock>\
         <WavelengthDataDirection>{direction}</WavelengthDataDirection>{bases}\
         <ScatteringData>{data}</ScatteringData></WavelengthDataBlock></WavelengthData>"
    )
}

/// A file of blocks (wavelength, direction, data), and what the reader remarked.
fn read(structure: &str, blocks: &[(&str, &str, &str)]) -> (Bsdf, Vec<String>) {
    let matrix = !structure.starts_with("Tensor");
    let blocks: String = blocks.iter().map(|(w, d, data)| block(w, d, data, matrix)).collect();
    let file = format!(
        "<WindowElement><Optical><Layer><DataDefinition><IncidentDataStructure>{structure}\
         </IncidentDataStructure></DataDefinition>{blocks}</Layer></Optical></WindowElement>"
    );
    let (bsdf, warnings) = from_bytes(file.as_bytes(), &Limits::default()).unwrap();
    (bsdf, warnings.into_iter().map(|w| w.text).collect())
}

fn encodings() -> [Encoding; 4] {
    [matrix("Columns"), matrix("Rows"), TREE4, TREE3]
}

/// A zero transmission block beside a real one answers as if it were not there, on either side.
#[test]
fn transmission_the_other_way_is_reversed() {
    for Encoding { structure, values, zeros } in encodings() {
        for (real, dummy) in [
            ("Transmission Front", "Transmission Back"),
            ("Transmission Back", "Transmission Front"),
        ] {
            let (alone, _) = read(structure, &[("Visible", real, values)]);
            for order in [false, true] {
                let mut blocks = [("Visible", real, values), ("Visible", dummy, zeros)];
                if order {
                    blocks.reverse();
                }
                let (both, remarks) = read(structure, &blocks);
                let said = |words: &str| remarks.iter().any(|r| r.contains(words));
                assert!(said(dummy) && said("dummy block, ignored"), "{structure}: {remarks:?}");
                assert!(said(&format!("{real} reversed answers")), "{remarks:?}");
                assert_eq!(both.components().len(), 1);
                for z in [0.7, -0.7] {
                    let wi = DVec3::new(0.51, 0.2, z).normalize();
                    let wo = DVec3::new(-0.3, 0.4, -z).normalize();
                    assert!(both.eval(wi, wo) > 0.0);
                    assert_eq!(both.eval(wi, wo), alone.eval(wi, wo), "{structure} {dummy}");
                    let total = |b: &Bsdf| b.directional_hemispherical(wi, Components::ALL);
                    // The reference has no reverse totals at rank 3.
                    assert!(total(&both) == total(&alone) && total(&both) > 0.0, "{structure}");
                }
            }
        }
    }
}

#[test]
fn reflection_is_absent_and_dark() {
    for Encoding { structure, values, zeros } in encodings() {
        let blocks = [
            ("Visible", "Transmission Front", values),
            ("Visible", "Transmission Back", values),
            ("Visible", "Reflection Front", zeros),
            ("Visible", "Reflection Back", values),
        ];
        let (bsdf, remarks) = read(structure, &blocks);
        assert_eq!(bsdf.components().len(), 3);
        assert!(remarks.iter().any(|r| r.starts_with("Reflection Front: all values are 0")));
        // The file's front is our back.
        let dark = bsdf.directional_hemispherical(-DVec3::Z, Components::REFLECTION);
        assert!(dark == 0.0 && bsdf.directional_hemispherical(DVec3::Z, Components::ALL) > 0.0);
    }
}

/// Where nothing else is said, 0 is what the file says.
#[test]
fn a_file_of_zeros_opens() {
    for Encoding { structure, zeros, .. } in encodings() {
        let blocks = [
            ("Visible", "Transmission Front", zeros),
            ("Visible", "Transmission Back", zeros),
            ("Visible", "Reflection Back", zeros),
        ];
        let (bsdf, remarks) = read(structure, &blocks);
        assert_eq!(bsdf.components().len(), 3);
        assert!(remarks.iter().all(|r| r.contains("no light is scattered")), "{remarks:?}");
        assert_eq!(bsdf.directional_hemispherical(DVec3::Z, Components::ALL), 0.0);
    }
}

/// A value that is stored is data, however small.
#[test]
fn one_value_makes_a_block_real() {
    let Encoding { structure, values, zeros } = matrix("Columns");
    let little = zeros.replacen("0.000000", "1e-30", 1);
    let blocks =
        [("Visible", "Transmission Front", values), ("Visible", "Transmission Back", &little)];
    assert_eq!(read(structure, &blocks).0.components().len(), 2);
}

#[test]
fn colour_is_part_of_the_block() {
    let Encoding { structure, values, zeros } = matrix("Columns");
    let front = |wavelength, data| (wavelength, "Transmission Front", data);
    let back = |wavelength, data| (wavelength, "Transmission Back", data);
    // All three channels 0: absent, and the coloured one reversed answers in colour.
    let blocks = [
        front("Visible", values),
        front("CIE-X", values),
        front("CIE-Z", zeros),
        back("Visible", zeros),
        back("CIE-X", zeros),
        back("CIE-Z", zeros),
    ];
    let (bsdf, _) = read(structure, &blocks);
    let [component] = bsdf.components() else { panic!("one component") };
    // No blue at all is a colour: that of red and yellow light.
    assert!(component.distribution().is_coloured());
    let f = bsdf.eval_xyz(DVec3::Z, -DVec3::Z);
    assert!(f.y > 0.0 && f.x == f.y && f.z == 0.0, "{f:?}");

    // Colour of 0 beside light that is seen is none.
    let blocks = [front("Visible", values), front("CIE-X", zeros), front("CIE-Z", zeros)];
    let (bsdf, remarks) = read(structure, &blocks);
    assert!(remarks.iter().any(|r| r.contains("read as grey")), "{remarks:?}");
    assert!(!bsdf.components()[0].distribution().is_coloured());

    // In trees the chromaticity of no light says nothing.
    let Encoding { structure, values, zeros } = TREE4;
    let blocks = [
        front("Visible", values),
        back("Visible", zeros),
        back("CIE-u", "{ .2 }"),
        back("CIE-v", "{ .47 }"),
        ("Visible", "Reflection Back", values),
        ("CIE-u", "Reflection Back", zeros),
        ("CIE-v", "Reflection Back", zeros),
    ];
    let (bsdf, remarks) = read(structure, &blocks);
    assert_eq!(bsdf.components().len(), 2);
    assert!(remarks.iter().any(|r| r.contains("Reflection Back: its colour is 0")), "{remarks:?}");
    let grey = |c: &bsdfkit::Component| {
        c.distribution().downcast_ref::<TreeDistribution>().unwrap().chromaticity().is_none()
    };
    assert!(bsdf.components().iter().all(grey));
}

#[test]
fn further_bands_keep_the_same_rule() {
    let Encoding { structure, values, zeros } = matrix("Columns");
    let blocks = [
        ("Visible", "Transmission Front", values),
        ("Solar", "Transmission Front", values),
        ("Solar", "Transmission Back", zeros),
        ("NIR", "Transmission Front", zeros),
    ];
    let (bsdf, remarks) = read(structure, &blocks);
    let names: Vec<&str> = bsdf.bands().iter().map(|b| b.name.as_str()).collect();
    assert_eq!(names, ["Solar"]);
    assert!(remarks.iter().any(|r| r.starts_with("NIR: all values are 0")), "{remarks:?}");
    let solar = bsdf.band("solar").unwrap();
    let [only] = solar.components() else { panic!("one component") };
    assert_eq!((only.incident, only.scattered), (Side::Back, Side::Front));
    assert!(solar.directional_hemispherical(DVec3::Z, Components::ALL) > 0.0);
}
