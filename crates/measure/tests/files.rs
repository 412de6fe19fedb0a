//! Every way a measurement file may be written, and every way it may be wrong.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use bsdfkit::{ErrorClass, Result};
use bsdfkit_measure::{Colorimetry, Measurement, ReadOptions, Side, Symmetry, read};
use bsdfkit_sphere::direction::{from_degrees, to_degrees};

/// A folder that goes when the test ends.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn put(&self, name: &str, text: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    }

    /// Reads everything, however few incidences.
    fn read(&self) -> Result<Vec<Measurement>> {
        look(self.0.path())
    }
}

fn look(path: &Path) -> Result<Vec<Measurement>> {
    read(&[path.to_owned()], &ReadOptions { incomplete: true, ..Default::default() })
}

fn read_text(text: &str) -> Result<Vec<Measurement>> {
    let folder = Folder::new();
    look(&folder.put("data.txt", text))
}

fn only(text: &str) -> Measurement {
    let mut components = read_text(text).unwrap_or_else(|e| panic!("{e}\n{text}"));
    assert_eq!(components.len(), 1);
    components.remove(0)
}

/// The message about `text`, without the path; its class is `format`.
fn refusal(text: impl AsRef<[u8]>) -> String {
    let folder = Folder::new();
    let path = folder.put("data.txt", text);
    let error = look(&path).unwrap_err();
    assert_eq!(error.class(), ErrorClass::Format, "{error}");
    let message = error.to_string();
    let rest = message.strip_prefix(&*path.to_string_lossy());
    rest.unwrap_or_else(|| panic!("the file is not named first: {message}")).to_owned()
}

const HEAD: &str = "#format: theta phi BSDF\n#intheta 30\n#inphi 0\n#upphi 90\n";

fn near(a: bsdfkit::DVec3, theta: f64, phi: f64) {
    let b = from_degrees(theta, phi);
    // Points are kept in single precision.
    assert!((a - b).length() < 1e-7, "{:?} instead of {theta} {phi}", to_degrees(a));
}

#[test]
fn header_keys_in_any_order_with_or_without_colon_and_blank() {
    for head in [
        "#sample_name \"a b\"\n#format: theta phi BSDF\n#intheta 30\n#inphi 40\n#upphi 90\n",
        "#upphi: 90\n#inphi: 40\n#intheta: 30\n#format theta phi brdf\n#sample_name: \"a b\"\n",
        "# Format: Theta Phi BTDF\r\n#\tincident_angle 30 40\r\n#upphi 90\r\n#whatever else\r\n# sample_name a b\r\n",
        "\u{feff}#incident_angle: 30 40\n#upphi :90\n#format:theta phi BSDF\n#\n#sample_name   \"a b\"\n\n",
    ] {
        let m = only(&format!("{head}20 10 0.5\n  25\t-10   1.5e-1 \n"));
        assert_eq!(m.sample_name.as_deref(), Some("a b"), "{head}");
        let i = &m.incidences[0];
        // one azimuth is isotropic: folded to azimuth 0
        near(i.wi, 30.0, 0.0);
        near(i.wo.at(0), 20.0, -30.0);
        near(i.wo.at(1), 25.0, -50.0);
        assert_eq!(i.values[..2], [0.5, 0.15]);
        assert_eq!((m.incident, m.scattered), (Side::Front, Side::Front));
    }
}

#[test]
fn up_turns_to_y_and_negative_theta_is_the_other_azimuth() {
    let text = |up: &str, incident: &str| {
        format!("#format: theta phi BSDF\n#incident_angle {incident}\n{up}10 0 1\n40 100 1\n")
    };
    for (up, turn) in
        [("", 90.0), ("#upphi 0\n", 90.0), ("#upphi 90\n", 0.0), ("#upphi 200\n", -110.0)]
    {
        // three azimuths that no mirror or rotation folds
        let folder = Folder::new();
        for (k, phi) in ["10", "130", "250"].iter().enumerate() {
            folder.put(&format!("{k}"), text(up, &format!("30 {phi}")));
        }
        folder.put("n", text(up, "-50 10"));
        let m = folder.read().unwrap().remove(0);
        assert_eq!(m.symmetry, Symmetry::None);
        let at = |theta: f64, phi: f64| {
            let wi = from_degrees(theta, phi + turn);
            m.incidences.iter().find(|i| (i.wi - wi).length() < 1e-12).expect("measured")
        };
        near(at(30.0, 130.0).wo.at(1), 40.0, 100.0 + turn);
        near(at(50.0, 190.0).wo.at(0), 10.0, turn);
    }
}

#[test]
fn dsf_loses_its_cosine_and_the_horizon() {
    let head = HEAD.replace("BSDF", "DSF");
    let m = only(&format!("{head}60 0 0.25\n0 0 0.5\n90 10 0.1\n-90 10 0\n"));
    let values = &m.incidences[0].values;
    assert!((values[0] - 0.5).abs() < 1e-7 && values[1] == 0.5 && values.len() == 2);
    assert!(m.notes.iter().any(|n| n.contains("2 rows at the horizon dropped")), "{:?}", m.notes);
}

#[test]
fn colours() {
    let xyz = only(&format!("{HEAD}#colorimetry: CIE-XYZ\n10 0 0.1 0.2 0.3\n"));
    assert_eq!(xyz.colorimetry, Colorimetry::Xyz);
    assert_eq!(xyz.incidences[0].point(0), [0.1, 0.2, 0.3]);
    let y = only(&format!("#colorimetry CIE-y\n{HEAD}10 0 0.1\n"));
    assert_eq!(y.colorimetry, Colorimetry::Luminance);
}

#[test]
fn four_components_from_one_folder() {
    let folder = Folder::new();
    for (name, theta_i, theta_o) in [
        ("a", 30, 20),
        ("b", 30, 160),
        ("c", 150, 20),
        ("d", 150, 160),
        ("e", 10, 20),
        ("f", 170, 160),
    ] {
        let text =
            format!("#format: theta phi BSDF\n#incident_angle {theta_i} 0\n{theta_o} 5 0.25\n");
        folder.put(name, text);
    }
    folder.put("notes.md", "Measured on a Tuesday.\n");
    folder.put("meta.json", "{\"a\": 1}\n");
    folder.put(".hidden", b"\0\0");
    std::fs::create_dir(folder.0.path().join("old")).unwrap();
    let components = folder.read().unwrap();
    let found: Vec<_> =
        components.iter().map(|c| (c.incident, c.scattered, c.incidences.len())).collect();
    let (f, b) = (Side::Front, Side::Back);
    assert_eq!(found, [(f, f, 2), (f, b, 1), (b, b, 2), (b, f, 1)]);
    let skipped = components[0].notes.iter().filter(|n| n.contains("skipped")).count();
    assert_eq!(skipped, 4, "{:?}", components[0].notes);
}

#[test]
fn both_sides_in_one_file_are_split_and_said() {
    let components = read_text(&format!("{HEAD}20 0 0.1\n160 0 0.2\n30 0 0.3\n")).unwrap();
    assert_eq!(components.len(), 2);
    assert_eq!(components[0].incidences[0].values, [0.1, 0.3]);
    assert_eq!(components[1].incidences[0].values, [0.2]);
    for c in &components {
        assert!(c.notes.iter().any(|n| n.contains("points on both sides, split")), "{:?}", c.notes);
    }
}

#[test]
fn files_of_one_incidence_are_merged_whatever_cell_they_fall_in() {
    let folder = Folder::new();
    for (name, theta) in [("a", "30"), ("b", "30.04"), ("c", "30.2")] {
        folder.put(
            name,
            format!("{}20 0 0.1\n", HEAD.replace("intheta 30", &format!("intheta {theta}"))),
        );
    }
    let m = folder.read().unwrap().remove(0);
    assert_eq!(m.incidences.iter().map(|i| i.wo.len()).collect::<Vec<_>>(), [2, 1]);
    assert_eq!(m.incidences[0].files.len(), 2);
    assert!(m.notes.iter().any(|n| n.contains("merged with")), "{:?}", m.notes);
    // the same file twice is one measurement, not two
    let a = folder.0.path().join("a");
    let again = read(&[a.clone(), a], &ReadOptions { incomplete: true, ..Default::default() });
    let again = again.unwrap().remove(0);
    assert_eq!(again.points(), 1);
    assert!(again.notes.iter().any(|n| n.contains("read once")));
}

#[test]
fn tables_with_any_separator_and_order() {
    let rows = [
        ("theta_o", "phi_o", "value", "phi_i", "theta_i"),
        ("20", "10", "0.5", "0", "30"),
        ("150", "0", "-0.1", "0", "30"),
    ];
    for separator in [",", "\t", ";", "  ", " , "] {
        let mut text = String::from("# a comment\n\n");
        for (a, b, c, d, e) in rows {
            writeln!(text, "{}", [a, b, c, d, e].join(separator)).unwrap();
        }
        let components = read_text(&text).unwrap_or_else(|e| panic!("{e}: {separator:?}"));
        assert_eq!(components.len(), 2, "{separator:?}");
        assert_eq!(components[0].incidences[0].values[0], 0.5);
        near(components[0].incidences[0].wo.at(0), 20.0, 10.0);
        assert_eq!(components[1].incidences[0].values, [-0.1]);
    }
}

#[test]
fn tables_hold_many_incidences_and_channels() {
    let head = "theta_i,phi_i,theta_o,phi_o";
    let text = format!("{head},Z,X,Y\n10,0,5,0,3,1,2\n20,0,5,0,6,4,5\n10,0,6,0,9,7,8\n");
    let m = only(&text);
    assert_eq!(m.colorimetry, Colorimetry::Xyz);
    assert_eq!(m.incidences[0].values, [1.0, 2.0, 3.0, 7.0, 8.0, 9.0]);
    assert_eq!(m.incidences[1].values, [4.0, 5.0, 6.0]);
    let m = only(&format!("{head},450nm,650nm\n10,0,5,0,3,1\n"));
    let Colorimetry::Spectral(bands) = &m.colorimetry else { panic!("{}", m.colorimetry) };
    assert_eq!(bands.nanometres(), [450.0, 650.0]);
    // The eye sees between the two.
    let [guide, bands @ ..] = &m.incidences[0].values[..] else { panic!("no values") };
    assert!(bands == [3.0, 1.0] && (1.5..2.5).contains(guide), "{guide} {bands:?}");
}

#[test]
fn bad_files_name_line_expected_and_found() {
    let html = "<!DOCTYPE html>\n<html><body>404</body></html>\n";
    let table = "theta_i,phi_i,theta_o,phi_o,value\n";
    for (text, parts) in [
        (String::new(), vec![":0: expected a measurement, found an empty file"]),
        ("\n \n".to_owned(), vec!["found an empty file"]),
        (html.to_owned(), vec![": looks like a web page (HTML)"]),
        ("PK\u{3}\u{4}\0\0".to_owned(), vec![": looks like a ZIP archive: unpack it"]),
        ("PQ\u{3}\u{4}\0\0".to_owned(), vec![":1: expected text, found binary data"]),
        (
            "hello there\n".to_owned(),
            vec![": expected a Mountain file or a table", "\"hello there\""],
        ),
        ("10 0 0.5\n".to_owned(), vec![":1: expected a header line #intheta or #incident_angle"]),
        ("#intheta 3\n#inphi 0\n1 1 1 1\n".to_owned(), vec![":3: expected a header line #format"]),
        (
            "#format: theta phi BSDF\n#intheta 3\n1 1 1\n".to_owned(),
            vec![":3: expected a header line #inphi"],
        ),
        (
            "#format: theta phi XYZ\n".to_owned(),
            vec![":1: format: expected theta phi and one of DSF", "\"theta phi XYZ\""],
        ),
        (
            "#incident_angle 30\n".to_owned(),
            vec![":1: incident_angle: phi: expected a number, found \"\""],
        ),
        ("#intheta thirty\n".to_owned(), vec![":1: intheta: expected a number, found \"thirty\""]),
        (
            "#colorimetry: RGB\n".to_owned(),
            vec![":1: colorimetry: expected CIE-Y or CIE-XYZ, found \"RGB\""],
        ),
        (HEAD.to_owned(), vec![":4: expected rows", "found the end of the file"]),
        (
            HEAD.replace("intheta 30", "intheta 90") + "1 1 1\n",
            vec![":5: intheta: expected an incident direction off the horizon"],
        ),
        (format!("{HEAD}1 1 1\n1 1 nan\n"), vec![":6: value: expected a finite number, found NaN"]),
        (
            format!("{HEAD}1e6 1 1\n"),
            vec![":5: theta: expected degrees from -720 to 720, found 1000000"],
        ),
        (format!("{HEAD}1 1 -inf\n"), vec![":5: value: expected a finite number, found -inf"]),
        (format!("{HEAD}1 1 1e999\n"), vec![":5: value: expected a finite number, found inf"]),
        (format!("{HEAD}1 1 1\n1 1\n"), vec![":6: expected 3 columns, found 2 in \"1 1\""]),
        (format!("{HEAD}1 1 1 1 1\n"), vec![":5: expected 3 columns, found 5 in \"1 1 1 1 1\""]),
        (format!("{HEAD}1 1 1\n#intheta 40\n"), vec![":6: expected header lines before the data"]),
        (
            format!("#datapoints_in_file: 100\n{HEAD}1 1 1\n"),
            vec!["expected 100 rows (datapoints_in_file), found 1: is the file truncated?"],
        ),
        (format!("{table}1,1,1\n"), vec![":2: expected 5 columns, found 3"]),
        (table.to_owned(), vec![":1: expected rows after the column names"]),
        (format!("{table}1,1,1,1,x\n"), vec![":2: value: expected a number, found \"x\""]),
        (format!("{table}90,1,1,1,1\n"), vec![":2: theta_i: expected a direction off the horizon"]),
        (table.replace(",phi_o", ""), vec![":1: expected a column phi_o, found the columns"]),
        (table.replace(",value", ""), vec![":1: expected a column of values"]),
        (table.replace("value", "value,value"), vec![":1: expected each column once", "\"value\""]),
    ] {
        let message = refusal(&text);
        for part in parts {
            assert!(message.contains(part), "expected {part:?} in {message:?}");
        }
    }
}

#[test]
fn bytes_that_are_no_text() {
    assert!(refusal([0xff, 0xfe, 0x31]).contains("not valid UTF-16"));
    assert!(
        refusal(vec![b'1'; 100_000])
            .contains(":1: expected a line of text, found more than 65536 bytes")
    );
}

#[test]
fn missing_files_and_folders_without_measurements() {
    let folder = Folder::new();
    let missing = look(&folder.0.path().join("nowhere")).unwrap_err();
    assert_eq!(missing.class(), ErrorClass::Io);
    assert!(missing.to_string().contains("nowhere: "), "{missing}");
    let long = look(Path::new(&"x".repeat(10_000))).unwrap_err();
    assert_eq!(long.class(), ErrorClass::Io);
    let empty = folder.read().unwrap_err();
    assert!(empty.to_string().contains("expected measurement files, found none"), "{empty}");
    let nothing = read(&[], &ReadOptions::default()).unwrap_err();
    assert_eq!(nothing.class(), ErrorClass::Argument);
    // one damaged file in a folder is not passed over
    folder.put("a", format!("{HEAD}1 1 1\n"));
    folder.put("b", "");
    assert!(folder.read().unwrap_err().to_string().contains("found an empty file"));
}

#[test]
fn files_of_other_colours_do_not_mix() {
    let folder = Folder::new();
    folder.put("a", format!("{HEAD}1 1 1\n"));
    folder.put("b", format!("{HEAD}#colorimetry: CIE-XYZ\n1 1 1 1 1\n"));
    let message = folder.read().unwrap_err().to_string();
    assert!(
        message.contains("b: expected luminance as in the files before, found CIE XYZ"),
        "{message}"
    );
}

/// Numbers that no function has, or single precision does not hold.
#[test]
fn values_beyond_all_measure_are_refused() {
    for (format, value) in [("BSDF", "1.1e30"), ("BSDF", "-1e308"), ("DSF", "1e30")] {
        let head = HEAD.replace("BSDF", format);
        let error = read_text(&format!("{head}60 0 1\n89 0 {value}\n")).unwrap_err().to_string();
        assert!(error.contains("value: expected f of at most 1e30"), "{error}");
    }
}

#[test]
fn negative_values_are_kept_and_counted() {
    let m = only(&format!("{HEAD}1 1 1\n2 1 -0.5\n"));
    assert_eq!(m.incidences[0].values, [1.0, -0.5]);
    assert_eq!(m.quality().incidences[0].negatives, 1);
}

#[test]
fn points_past_a_grazing_limit_can_be_cut() {
    let mut m = only(&format!("{HEAD}10 0 1\n80 5 2\n70 -5 3\n70 5 4\n"));
    // At the limit is within it.
    assert_eq!(m.cut_grazing(80.0).unwrap(), 0);
    assert_eq!(m.cut_grazing(75.0).unwrap(), 1);
    assert_eq!((m.incidences[0].wo.len(), &m.incidences[0].values[..]), (3, &[1.0, 3.0, 4.0][..]));
    assert!((m.largest_incident_degrees() - 30.0).abs() < 1e-9);
    let error = m.cut_grazing(5.0).unwrap_err().to_string();
    assert!(
        error.contains("grazing limit 5: expected points within it at incidence theta 30.0"),
        "{error}"
    );
}

proptest::proptest! {
    /// Lines drawn from what files are made of, whole or cut: an error or a measurement, never a panic.
    #[test]
    fn no_text_makes_the_reader_panic(
        lines in proptest::collection::vec(
            proptest::sample::select(vec![
                "#format: theta phi BSDF", "#format: theta phi DSF", "#intheta 30", "#intheta -180", "#inphi 1e300",
                "#incident_angle 0 0", "#upphi 1e308", "#colorimetry: CIE-XYZ", "#datapoints_in_file: 3", "#", "",
                "1 1 1", "91 1 1", "90 0 0", "180 0 -1e308", "0 0 1e308", "1 1 1 1 1", "1e300 1e300 1", "-1 -1 -1",
                "theta_i,phi_i,theta_o,phi_o,value", "1,2,3,4,5", "0,0,0,0,1e308", "1,2,179,4,-5", "é", ",,,,",
            ]),
            0..14,
        ),
        cut in 0usize..400,
    ) {
        let text: Vec<u8> = lines.join("\n").into_bytes();
        let folder = Folder::new();
        folder.put("a", &text[..cut.min(text.len())]);
        folder.put("b", &text);
        let _ = folder.read().map(|components| components.iter().for_each(|c| {
            assert!(c.incidences.iter().all(|i| !i.wo.is_empty()));
            c.quality();
        }));
    }
}

#[test]
fn more_rows_than_allowed() {
    let folder = Folder::new();
    let path = folder.put("a", format!("{HEAD}{}", "1 1 1\n".repeat(10_000)));
    let options = ReadOptions { most_bytes: 80_000, incomplete: true, ..Default::default() };
    let error = read(&[path], &options).unwrap_err();
    assert_eq!(error.class(), ErrorClass::Limit);
    assert!(error.to_string().contains("expected points of at most 0.08 MB"), "{error}");
}

#[test]
fn a_specimen_mounted_back_to_front_turns_about_its_up_axis() {
    let folder = Folder::new();
    let path = folder.put("a", format!("{HEAD}20 90 1\n").replace("inphi 0", "inphi 90"));
    let options = ReadOptions {
        incomplete: true,
        reversed: true,
        symmetry: "none".parse().ok(),
        ..Default::default()
    };
    let m = read(&[path], &options).unwrap().remove(0);
    assert_eq!((m.incident, m.scattered), (Side::Back, Side::Back));
    near(m.incidences[0].wi, 150.0, 90.0);
    near(m.incidences[0].wo.at(0), 160.0, 90.0);
}
