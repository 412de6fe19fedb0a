//! Files for other programs: bands, dummy blocks, descriptions, and what `--for` makes of them.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use bsdfkit::matrix::{KlemsBasis, KlemsMatrix};
use bsdfkit::tree::{Rank, TreeDistribution};
use bsdfkit::xml::{self, WriteOptions};
use bsdfkit::{Band, Bsdf, Component, Components, DVec3, Lambertian, Metadata, Side};
use serde_json::Value;

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> String {
        self.0.path().join(name).to_str().unwrap().to_owned()
    }

    /// Writes `bsdf` with every bit of its values.
    fn write(&self, name: &str, bsdf: &Bsdf) -> String {
        let path = self.path(name);
        xml::write(bsdf, &path, &WriteOptions { digits: 9, window_fields: false }).unwrap();
        path
    }
}

fn bsdf(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_bsdf")).args(arguments).output().unwrap()
}

/// Standard output and standard error of a command that succeeds.
fn ok(arguments: &[&str]) -> (String, String) {
    let output = bsdf(arguments);
    let [out, err] = [output.stdout, output.stderr].map(|b| String::from_utf8(b).unwrap());
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {err}");
    (out, err)
}

/// Standard error of a command that ends with `status`.
fn fails(arguments: &[&str], status: i32) -> String {
    let output = bsdf(arguments);
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(status), "{arguments:?}: {error}");
    error
}

const THROUGH: [(Side, Side); 2] = [(Side::Back, Side::Front), (Side::Front, Side::Back)];

/// Diffuse of total `total` at normal incidence, falling toward grazing; not symmetric.
fn diffuse(basis: &KlemsBasis, total: f64) -> KlemsMatrix {
    let n = basis.directions();
    let value = |k: usize| {
        let (i, o) = (k / n, k % n);
        let bend = 1.0 + 0.2 * basis.centre(o).y;
        (total / std::f64::consts::PI * (0.5 + 0.5 * basis.centre(i).z) * bend) as f32
    };
    KlemsMatrix::new(basis.clone(), basis.clone(), (0..n * n).map(value).collect()).unwrap()
}

fn of(pair: (Side, Side), matrix: KlemsMatrix) -> Component {
    Component::new(pair.0, pair.1, matrix)
}

/// Known from outside alone, as many files are: Visible .4, Solar .6, NIR .7.
fn banded(basis: &KlemsBasis) -> Bsdf {
    let one = |total| vec![of(THROUGH[0], diffuse(basis, total))];
    let metadata = Metadata {
        name: "Film".into(),
        thickness: 0.002,
        geometry: Some("c red\n".into()),
        comments: vec!["kept".into()],
        properties: vec![("DeviceType".into(), "Film".into())],
        ..Metadata::default()
    };
    Bsdf::new(metadata, one(0.4), Lambertian::default())
        .with_bands(vec![Band::new("Solar", one(0.6)), Band::new("NIR", one(0.7))])
}

fn total(bsdf: &Bsdf, wi: DVec3) -> f64 {
    bsdf.directional_hemispherical(wi, Components::ALL)
}

#[test]
fn every_band_is_converted() {
    let folder = Folder::new();
    let source = banded(&KlemsBasis::quarter());
    let file = folder.write("bands.xml", &source);
    for kind in ["klems-half", "klems-full", "klems-quarter"] {
        let path = folder.path(kind);
        ok(&["convert", &file, "--to", kind, "-o", &path]);
        let (made, warnings) = xml::read_with(&path, &xml::Limits::default()).unwrap();
        assert!(warnings.is_empty(), "{warnings:?}");
        assert_eq!(made.bands().len(), 2);
        for band in ["Solar", "NIR"] {
            let (made, source) = (made.band(band).unwrap(), source.band(band).unwrap());
            for theta in [0.0_f64, 0.4, 0.9] {
                let wi = -DVec3::new(theta.sin(), 0.0, theta.cos());
                let (a, b) = (total(&made, wi), total(&source, wi));
                assert!((a - b).abs() < 0.04 * b && b > 0.4, "{kind} {band} {theta}: {a}, {b}");
            }
        }
        let matrix = |b: &Bsdf| {
            let c = b.band("NIR").unwrap().components()[0].clone();
            c.distribution().downcast_ref::<KlemsMatrix>().unwrap().values().to_vec()
        };
        assert_eq!(kind == "klems-quarter", matrix(&made) == matrix(&source));
        // The description goes along.
        let (a, b) = (made.metadata(), source.metadata());
        assert_eq!((&a.name, a.thickness, &a.geometry), (&b.name, b.thickness, &b.geometry));
        assert_eq!((&a.comments, &a.properties), (&b.comments, &b.properties));
        assert_eq!(a.unread, b.unread);
        let (info, _) = ok(&["info", &path]);
        assert!(info.contains("band Solar: back transmission"), "{info}");
        let (info, _) = ok(&["info", &path, "--json"]);
        let info: Value = serde_json::from_str(&info).unwrap();
        assert_eq!(info["bands"][1]["name"], "NIR");
        assert_eq!(info["bands"][1]["components"][0]["structure"], "matrix");
    }
}

#[test]
fn bands_become_trees_with_the_visible_one() {
    let folder = Folder::new();
    let file = folder.write("bands.xml", &banded(&KlemsBasis::quarter()));
    let tree = folder.path("tree.xml");
    ok(&["convert", &file, "--max-depth", "3", "-o", &tree]);
    let text = fs::read_to_string(&tree).unwrap();
    assert!(!text.contains("ColumnAngleBasis") && !text.contains("Klems"));
    let made = xml::read(&tree).unwrap();
    for (band, expected) in [("Solar", 0.6), ("NIR", 0.7)] {
        let band = made.band(band).unwrap();
        let tree = band.components()[0].distribution().downcast_ref::<TreeDistribution>();
        assert!(tree.is_some_and(|t| t.luminance().rank() == Rank::Four));
        let found = total(&band, -DVec3::Z);
        assert!((found - expected).abs() < 0.05 * expected, "{found}");
    }
}

#[test]
fn one_band_alone() {
    let folder = Folder::new();
    let source = banded(&KlemsBasis::quarter());
    let file = folder.write("bands.xml", &source);
    let solar = folder.path("solar.xml");
    ok(&["convert", &file, "--band", "solar", "--to", "klems-quarter", "-o", &solar]);
    let made = xml::read(&solar).unwrap();
    assert!(made.bands().is_empty());
    assert_eq!(total(&made, -DVec3::Z), total(&source.band("Solar").unwrap(), -DVec3::Z));
    let error = fails(&["convert", &file, "--band", "UV", "-o", &solar], 2);
    assert!(error.contains("bands.xml") && error.contains("Solar, NIR"), "{error}");
    let compiled = folder.path("compiled.safetensors");
    let (_, said) = ok(&["compile", &file, "-o", &compiled]);
    assert!(said.contains("left out: band Solar, NIR"), "{said}");
}

/// Blocks that nothing reads hold in their structure alone.
#[test]
fn what_would_become_wrong_is_left_out_and_said() {
    let folder = Folder::new();
    let file = folder.write("bands.xml", &banded(&KlemsBasis::quarter()));
    let absorbed = "<WavelengthData><Wavelength>Visible</Wavelength><WavelengthDataBlock>\
        <WavelengthDataDirection>Absorbed Front</WavelengthDataDirection>\
        <ScatteringData>.5</ScatteringData></WavelengthDataBlock></WavelengthData><Blind n='3'/>";
    // A basis of the same name as that of the output, which nothing uses.
    let basis = "<AngleBasis><AngleBasisName>LBNL/Klems Half</AngleBasisName><AngleBasisBlock>\
        <Theta>0</Theta><nPhis>1</nPhis><ThetaBounds><LowerTheta>0</LowerTheta>\
        <UpperTheta>90</UpperTheta></ThetaBounds></AngleBasisBlock></AngleBasis>";
    let text = fs::read_to_string(&file).unwrap();
    let text = text.replacen("</Layer>", &format!("{absorbed}</Layer>"), 1);
    let text = text.replacen("</DataDefinition>", &format!("{basis}</DataDefinition>"), 1);
    fs::write(&file, text).unwrap();
    let made = |name: &str, words: &[&str]| {
        let path = folder.path(name);
        let (_, said) = ok(&[&["convert", &file, "-o", &path], words].concat());
        xml::read(&path).unwrap();
        (fs::read_to_string(&path).unwrap(), said)
    };
    let (same, said) = made("same.xml", &["--to", "klems-quarter"]);
    assert!(same.contains("Absorbed Front") && !said.contains("left out"), "{said}");
    for words in [&["--to", "klems-half"][..], &["--max-depth", "2"], &["--for", "energyplus"]] {
        let (other, said) = made("other.xml", words);
        assert!(!other.contains("Absorbed Front") && other.contains("<Blind n='3'/>"), "{words:?}");
        assert!(said.contains("left out: ") && said.contains("Visible Absorbed Front"), "{said}");
        assert!(said.contains("LBNL/Klems Half"), "{said}");
    }
    let (info, _) = ok(&["info", &file]);
    assert!(info.contains("kept, not read: Visible Absorbed Front, LBNL/Klems Half"), "{info}");
}

/// The other direction reversed, the direction that is not known 0, each said.
#[test]
fn for_window_is_complete() {
    let folder = Folder::new();
    let basis = KlemsBasis::full();
    let source = banded(&basis);
    let file = folder.write("bands.xml", &source);
    let (path, again) = (folder.path("window.xml"), folder.path("again.xml"));
    let (_, said) = ok(&["convert", &file, "--for", "window", "-o", &path]);
    for words in [
        "left out: band NIR",
        "Visible: front transmission not known: the other direction reversed",
        "Solar: front transmission not known",
        "back reflection, front reflection not known: written as 0",
        "placeholders: Manufacturer, Width, Height, ThermalConductivity",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
    let text = fs::read_to_string(&path).unwrap();
    for band in ["Visible", "Solar"] {
        assert_eq!(text.matches(&format!(">{band}</Wavelength>")).count(), 4);
    }
    assert_eq!(text.matches("<WavelengthData>").count(), 8);
    let made = xml::read(&path).unwrap();
    // Read again, zeros are absent, and both ways of transmission answer as before.
    for (a, b) in [(&made, &source), (&made.band("Solar").unwrap(), &source.band("Solar").unwrap())]
    {
        assert_eq!(a.components().len(), 2);
        for wi in [DVec3::new(0.5, 0.1, 0.6), DVec3::new(-0.2, 0.3, -0.8)] {
            let wo = DVec3::new(0.1, -0.7, -wi.z.signum() * 0.5);
            assert!((a.eval(wi, wo) / b.eval(wi, wo) - 1.0).abs() < 1e-6);
        }
    }
    // frads reads what WINDOW's engine does.
    for program in ["window", "frads"] {
        ok(&["convert", &path, "--for", program, "-o", &again]);
        assert_eq!(fs::read_to_string(&again).unwrap(), text);
    }
    let (_, said) = ok(&["convert", &path, "--to", "klems-full", "-o", &again]);
    assert!(said.contains("WINDOW and frads refuse it: --for window"), "{said}");
}

/// WINDOW's engine refuses an emissivity and a TIR of more than 1 together.
#[test]
fn what_is_invented_leaves_room_for_what_is_known() {
    let folder = Folder::new();
    let file = folder.write("bands.xml", &banded(&KlemsBasis::quarter()));
    let (path, again) = (folder.path("black.xml"), folder.path("again.xml"));
    let written = |words: &[&str], own: &[&str]| {
        ok(&[&["convert", &file, "--to", "klems-quarter", "-o", &path], words].concat());
        let text = fs::read_to_string(&path).unwrap();
        own.iter().for_each(|element| assert!(text.contains(element), "{element}: {text}"));
        // A reader knows the invention for one, whatever its value.
        ok(&["convert", &path, "--to", "klems-quarter", "-o", &again]);
        assert_eq!(fs::read_to_string(&again).unwrap(), text);
    };
    written(&[], &["<TIR>0.1</TIR>", "<EmissivityBack>0.9</EmissivityBack>"]);
    written(&["--property", "EmissivityBack=1.0"], &["<TIR>0</TIR>", "<EmissivityFront>0.9<"]);
    written(&["--property", "TIR=0.75"], &["<EmissivityFront>0.25<", "<EmissivityBack>0.25<"]);
}

#[test]
fn solar_made_of_visible_is_said_and_noted() {
    let folder = Folder::new();
    let source = banded(&KlemsBasis::full()).with_bands(Vec::new());
    let file = folder.write("visible.xml", &source);
    let path = folder.path("energyplus.xml");
    let made_up = "Solar is not known: written as Visible";
    let convert = |from: &str, words: &[&str], to: &str| {
        ok(&[&["convert", from, "-o", to], words].concat()).1
    };
    let said = convert(&file, &["--for", "energyplus", "--to", "klems-quarter"], &path);
    assert!(said.contains(made_up) && said.contains("EnergyPlus transposes"), "{said}");
    let values = |b: &Bsdf| {
        let m = b.components()[0].distribution().downcast_ref::<KlemsMatrix>().unwrap();
        (m.incident().directions(), m.values().to_vec())
    };
    let made = xml::read(&path).unwrap();
    assert_eq!(values(&made), values(&made.band("Solar").unwrap()));
    assert_eq!(values(&made).0, 41);
    // What was made up does not become knowledge by being read.
    assert!(made.metadata().comments.iter().any(|c| c == made_up));
    let again = folder.path("again.xml");
    let said = convert(&path, &["--for", "energyplus", "--to", "klems-quarter"], &again);
    assert!(said.contains(made_up), "{said}");
    assert_eq!(fs::read_to_string(&again).unwrap(), fs::read_to_string(&path).unwrap());
    convert(&path, &["--for", "radiance"], &again);
    assert!(!fs::read_to_string(&again).unwrap().contains("Solar"));
}

/// A direction that Solar lacks is Visible's, unless transmission the other way tells it.
#[test]
fn a_direction_of_solar_that_is_not_known_is_that_of_visible() {
    let folder = Folder::new();
    let basis = KlemsBasis::quarter();
    let mirror = |total| of((Side::Front, Side::Front), diffuse(&basis, total));
    let through = |total| of(THROUGH[0], diffuse(&basis, total));
    let source =
        Bsdf::new(Metadata::default(), vec![through(0.4), mirror(0.3)], Lambertian::default())
            .with_bands(vec![Band::new("Solar", vec![through(0.6)])]);
    let file = folder.write("partly.xml", &source);
    let (path, again) = (folder.path("energyplus.xml"), folder.path("again.xml"));
    let words = ["--for", "energyplus", "--to", "klems-quarter"];
    let text = "Solar: front reflection not known: written as Visible";
    let convert = |from: &str, to: &str| ok(&[&["convert", from, "-o", to], &words[..]].concat()).1;
    let said = convert(&file, &path);
    assert!(said.contains(text) && said.contains("Solar: back reflection not known: written as 0"));
    let made = xml::read(&path).unwrap();
    let solar = made.band("Solar").unwrap();
    let [reflected, through] = [Components::REFLECTION, Components::TRANSMISSION]
        .map(|c| solar.directional_hemispherical(DVec3::Z, c));
    assert_eq!(reflected, made.directional_hemispherical(DVec3::Z, Components::REFLECTION));
    assert!((through - 0.6).abs() < 0.15, "{through}");
    assert!(convert(&path, &again).contains(text));
    assert_eq!(fs::read_to_string(&again).unwrap(), fs::read_to_string(&path).unwrap());
}

#[test]
fn for_radiance_a_matrix_stays_one() {
    let folder = Folder::new();
    let coloured = {
        let m = diffuse(&KlemsBasis::quarter(), 0.5);
        let (x, z) = (m.values().to_vec(), vec![0.01; m.values().len()]);
        m.with_colour(x, z).unwrap()
    };
    let components = vec![of(THROUGH[1], coloured)];
    let source = banded(&KlemsBasis::quarter());
    let source = Bsdf::new(Metadata::default(), components, Lambertian::default())
        .with_bands(source.bands().to_vec());
    let file = folder.write("coloured.xml", &source);
    let path = folder.path("radiance.xml");
    let (out, said) = ok(&["convert", &file, "--for", "radiance", "-o", &path]);
    assert!(out.contains("klems-quarter") && said.contains("left out: band Solar, band NIR"));
    assert!(said.contains("thickness of 0"), "{said}");
    let made = xml::read(&path).unwrap();
    assert!(made.bands().is_empty() && made.components()[0].distribution().is_coloured());
    // WINDOW refuses colour.
    let (_, said) = ok(&["convert", &file, "--for", "window", "-o", &path]);
    assert!(said.contains("colour left out"), "{said}");
    let text = fs::read_to_string(&path).unwrap();
    assert!(!text.contains("CIE-") && text.contains("Klems Full"));
    let full = folder.path("full.xml");
    ok(&["convert", &file, "--to", "klems-full", "-o", &full]);
}

#[test]
fn a_program_that_cannot_read_the_form_is_refused() {
    let folder = Folder::new();
    let file = folder.write("bands.xml", &banded(&KlemsBasis::quarter()));
    let out = folder.path("out.xml");
    let refused = |words: &[&str]| fails(&[&["convert", &file, "-o", &out], words].concat(), 2);
    let error = refused(&["--for", "window", "--to", "klems-half"]);
    assert!(error.contains("--for window reads klems-full"), "{error}");
    assert!(refused(&["--property", "TIR"]).contains("expected FIELD=VALUE"));
    assert!(refused(&["--property", "Name=Film"]).contains("--name"));
    assert!(refused(&["--to", "klems-quarter", "--property", "a b=1"]).contains("a b"));
    for wrong in ["tir=abc", "TIR=0,3", "EmissivityFront=2", "ThermalConductivity=nan"] {
        let error = refused(&["--property", wrong]);
        assert!(error.contains("expected a number"), "{wrong}: {error}");
    }
    let error = refused(&["--for", "window", "--band", "Solar"]);
    assert!(error.contains("--band Solar: expected without --for window"), "{error}");
    assert!(!Path::new(&out).exists());
}

/// The dummy blocks of WINDOW 6, on the command line: said by `check` and `info`, no light lost.
#[test]
fn dummy_blocks_are_said() {
    let folder = Folder::new();
    let basis = KlemsBasis::quarter();
    let zero = || {
        let n = basis.directions();
        KlemsMatrix::new(basis.clone(), basis.clone(), vec![0.0; n * n]).unwrap()
    };
    for (real, dummy) in [(0, 1), (1, 0)] {
        let components = vec![
            of(THROUGH[real], diffuse(&basis, 0.9)),
            of(THROUGH[dummy], zero()),
            of((Side::Front, Side::Front), zero()),
        ];
        let bsdf = Bsdf::new(Metadata::default(), components, Lambertian::default());
        let file = folder.write("zero.xml", &bsdf);
        for incident in ["0,0", "180,0"] {
            let (text, _) = ok(&["hemispherical", &file, "--incident", incident, "--json"]);
            let rows: Value = serde_json::from_str(&text).unwrap();
            let found = rows[0]["transmittance"].as_f64().unwrap();
            assert!((found - 0.9).abs() < 0.2 && found > 0.6, "{real} {incident}: {found}");
        }
        let (check, _) = ok(&["check", &file]);
        assert_eq!(check.matches("dummy block, ignored").count(), 2, "{check}");
        assert!(ok(&["info", &file]).1.contains("reversed answers"));
        assert!(ok(&["info", &file, "--json"]).0.contains("reversed answers"));
        let half = folder.path("half.xml");
        ok(&["convert", &file, "--to", "klems-half", "-o", &half]);
        assert_eq!(xml::read(&half).unwrap().components().len(), 1);
    }
}
