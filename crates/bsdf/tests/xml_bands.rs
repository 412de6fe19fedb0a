//! Further bands, placeholders, comments and blocks that nothing reads: through reader and writer.

use bsdfkit::matrix::{KlemsBasis, KlemsMatrix};
use bsdfkit::tree::{Rank, TensorTree, TreeDistribution};
use bsdfkit::xml::{Limits, WriteOptions, from_bytes, placeholders, write_to};
use bsdfkit::{Band, Bsdf, Component, Lambertian, Metadata, Side};

const EXACT: WriteOptions = WriteOptions { digits: 9, window_fields: true };

fn text(bsdf: &Bsdf) -> String {
    let mut out = Vec::new();
    write_to(bsdf, &mut out, &EXACT).unwrap();
    String::from_utf8(out).unwrap()
}

fn read(file: &str) -> (Bsdf, Vec<String>) {
    let (bsdf, warnings) = from_bytes(file.as_bytes(), &Limits::default()).unwrap();
    (bsdf, warnings.into_iter().map(|w| w.text).collect())
}

fn matrix(scale: f32) -> KlemsMatrix {
    let (incident, scattered) = (KlemsBasis::quarter(), KlemsBasis::half());
    let values = (0..41 * 77).map(|n| scale * (1 + n * 7 % 1013) as f32).collect();
    KlemsMatrix::new(incident, scattered, values).unwrap()
}

fn banded() -> Bsdf {
    let through = |scale| Component::new(Side::Back, Side::Front, matrix(scale));
    let mirror = |scale| Component::new(Side::Front, Side::Front, matrix(scale));
    let solar = Band::new("Solar", vec![through(2.3e-5), mirror(1e-5)]);
    let (unit, name) = ("Nanometer".to_owned(), "1064".to_owned());
    let line = Band { unit, name, ..Band::new("", vec![mirror(3.1e-5)]) };
    Bsdf::new(Metadata::default(), vec![through(1.7e-5)], Lambertian::default())
        .with_bands(vec![solar, line])
}

#[test]
fn bands_come_back_bit_by_bit() {
    let bsdf = banded();
    let (again, remarks) = read(&text(&bsdf));
    assert!(remarks.is_empty(), "{remarks:?}");
    assert_eq!(again.components().len(), 1);
    for (a, b) in bsdf.bands().iter().zip(again.bands()) {
        let heads = |b: &Band| [&b.name, &b.unit, &b.source, &b.detector].map(Clone::clone);
        assert_eq!(heads(a), heads(b));
        assert_eq!(a.components.len(), b.components.len());
        for c in &a.components {
            let same = |d: &&Component| (d.incident, d.scattered) == (c.incident, c.scattered);
            let d = b.components.iter().find(same).unwrap();
            let [c, d] = [c, d].map(|c| c.distribution().downcast_ref::<KlemsMatrix>().unwrap());
            assert_eq!(c.values(), d.values());
        }
    }
    assert_eq!(text(&again), text(&bsdf));
    assert!(again.metadata().unread.is_empty());
}

/// WINDOW's engine splits at commas and nothing else: one after every value, a row a line.
#[test]
fn every_value_ends_with_a_comma() {
    let text = text(&banded());
    let data = text.split("<ScatteringData>\n").nth(1).unwrap();
    let rows: Vec<&str> =
        data.split("</ScatteringData>").next().unwrap().trim_end().lines().collect();
    assert_eq!(rows.len(), 77);
    for row in rows {
        assert_eq!(row.matches(',').count(), 41, "{row}");
        assert!(row.ends_with(',') && !row.contains(' '), "{row}");
    }
    for element in ["<WindowElement ", "<AngleBasis>", "<WavelengthData>", "<ScatteringData>"] {
        assert!(text.lines().any(|l| l.starts_with(element)), "{element} on a line of its own");
    }
}

/// A band that cannot be read is kept, and costs nothing of the rest.
#[test]
fn what_is_no_band_is_kept_as_it_was() {
    let good = text(&banded());
    let broken = good.replacen(">1064<", ">1064</Wavelength><Wavelength>9<", 1);
    let broken = broken.replacen("<Wavelength unit=\"Integral\">Solar<", "<Wavelength>CIE-u<", 1);
    let with = "<WavelengthData><Wavelength>FIR</Wavelength><WavelengthDataBlock>\
        <WavelengthDataDirection>Transmission Front</WavelengthDataDirection>\
        <ColumnAngleBasis>LBNL/Klems Quarter</ColumnAngleBasis>\
        <RowAngleBasis>LBNL/Klems Quarter</RowAngleBasis>\
        <ScatteringData>1 2 3</ScatteringData></WavelengthDataBlock></WavelengthData>\
        <WavelengthData><Wavelength>Visible</Wavelength><WavelengthDataBlock>\
        <WavelengthDataDirection>Absorbed Front</WavelengthDataDirection>\
        <ScatteringData>.5</ScatteringData></WavelengthDataBlock></WavelengthData></Layer>";
    let broken = broken.replacen("</Layer>", with, 1);
    let (bsdf, remarks) = read(&broken);
    assert!(remarks.iter().any(|r| r.starts_with("FIR: not read: expected 1681 values, found 3")));
    let bound = bsdf.metadata().bound();
    for name in ["CIE-u Transmission Front", "FIR Transmission Front", "Visible Absorbed Front"] {
        assert_eq!(bound.iter().filter(|b| *b == name).count(), 1, "{name} in {bound:?}");
    }
    let written = text(&bsdf);
    let (again, _) = read(&written);
    assert_eq!(again.metadata(), bsdf.metadata());
    assert_eq!(text(&again), written);
    assert!(bsdf.metadata().clone().unbound().bound().is_empty());
    assert!(bsdf.metadata().clone().unbound().unread.is_empty());
}

#[test]
fn bands_have_no_colour_and_one_structure() {
    let tree = TreeDistribution::new(TensorTree::constant(Rank::Four, 0.1).unwrap());
    let of = |component| banded().with_bands(vec![Band::new("Solar", vec![component])]);
    let refused = |bsdf: &Bsdf| write_to(bsdf, &mut Vec::new(), &EXACT).unwrap_err().to_string();
    let mixed = of(Component::new(Side::Front, Side::Front, tree));
    assert!(refused(&mixed).contains("band Solar: expected components of one kind"));
    let coloured = matrix(1e-5).with_colour(vec![0.1; 41 * 77], vec![0.1; 41 * 77]).unwrap();
    let coloured = of(Component::new(Side::Front, Side::Front, coloured));
    assert!(refused(&coloured).contains("without colour"));
}

#[test]
fn placeholders_are_no_knowledge() {
    let bsdf = banded();
    let fields = placeholders(bsdf.metadata());
    assert_eq!(fields.len(), 11);
    let written = text(&bsdf);
    assert!(written.contains("<Name>unnamed</Name>") && written.contains("<TIR>0.1</TIR>"));
    assert!(!written.contains("<Manufacturer></Manufacturer>"));
    let (again, _) = read(&written);
    assert_eq!(again.metadata(), bsdf.metadata());
    assert_eq!(text(&again), written);

    // A field edited by hand is known, though the comment still names it.
    let edited = written
        .replace("<Name>unnamed<", "<Name>Glass 12<")
        .replace("<Thickness unit=\"Meter\">0.001<", "<Thickness unit=\"Millimeter\">3<")
        .replace("<TIR>0.1<", "<TIR>0<");
    let (edited, _) = read(&edited);
    let metadata = edited.metadata();
    assert_eq!((metadata.name.as_str(), metadata.thickness), ("Glass 12", 0.003));
    assert_eq!(metadata.properties, [("TIR".to_owned(), "0".to_owned())]);
    let text = text(&edited);
    let comment = text.lines().find(|l| l.contains("placeholders")).unwrap();
    assert!(!comment.contains("Name") && !comment.contains("TIR"), "{comment}");
    assert!(comment.contains("Manufacturer") && text.contains("<TIR>0</TIR>"));

    // The same values without the comment are what somebody says of the material.
    let said = read(&written.replace("placeholders, not known", "all well known")).0;
    assert_eq!((said.metadata().name.as_str(), said.metadata().thickness), ("unnamed", 0.001));
    assert!(placeholders(said.metadata()).is_empty());
}

/// An empty element is as unknown as a missing one.
#[test]
fn empty_fields_get_placeholders() {
    let metadata = Metadata {
        name: "  ".into(),
        properties: vec![("TIR".into(), String::new()), ("Colour".into(), String::new())],
        ..Metadata::default()
    };
    let bsdf = Bsdf::new(metadata, banded().components().to_vec(), Lambertian::default());
    let text = text(&bsdf);
    assert_eq!(text.matches("<TIR>").count(), 1);
    assert!(text.contains("<TIR>0.1</TIR>") && text.contains("<Name>unnamed</Name>"));
    assert!(text.contains("<Colour></Colour>"));
}

/// Comments survive wherever they stand outside of data, and do not pile up.
#[test]
fn comments_survive_once() {
    let written = text(&banded());
    let commented = written
        .replacen("<Layer>", "<Layer><!-- in the layer -->", 1)
        .replacen("<Material>", "<Material><!-- of the material -->", 1)
        .replacen("<ScatteringData>", "<ScatteringData><!-- in data -->", 1)
        .replacen("</Layer>", "<Blind><!-- of a blind --></Blind></Layer>", 1)
        .replacen("<Optical>", "<!-- before --><Optical>", 1);
    let (bsdf, _) = read(&commented);
    assert_eq!(bsdf.metadata().comments, ["before", "in the layer", "of the material"]);
    let once = text(&bsdf);
    let (again, _) = read(&once);
    assert_eq!(again.metadata(), bsdf.metadata());
    assert_eq!(text(&again), once);
    assert_eq!(once.matches("of a blind").count(), 1);
}
