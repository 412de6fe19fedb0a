//! One measurement written in every dialect reads the same.

use std::path::{Path, PathBuf};

use bsdfkit::{ErrorClass, Result};
use bsdfkit_measure::{Colorimetry, Measurement, ReadOptions, read};
use bsdfkit_sphere::direction::from_degrees;
use proptest::prelude::*;
use proptest::sample::select;

fn put(folder: &Path, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, bytes).unwrap();
    path
}

fn look(path: &Path) -> Result<Vec<Measurement>> {
    read(&[path.to_owned()], &ReadOptions { incomplete: true, ..Default::default() })
}

/// The one component of a file of this name and content.
fn only_in(name: &str, bytes: &[u8]) -> Measurement {
    let folder = tempfile::tempdir().unwrap();
    let text = String::from_utf8_lossy(bytes);
    let mut components =
        look(&put(folder.path(), name, bytes)).unwrap_or_else(|e| panic!("{e}\n{text}"));
    assert_eq!(components.len(), 1);
    components.remove(0)
}

fn only(text: &str) -> Measurement {
    only_in("data.txt", text.as_bytes())
}

/// The message about a file of that content, which must be one of the file.
fn refusal(bytes: &[u8]) -> String {
    let folder = tempfile::tempdir().unwrap();
    let error = look(&put(folder.path(), "data.txt", bytes)).unwrap_err();
    assert_eq!(error.class(), ErrorClass::Format, "{error}");
    error.to_string()
}

/// How the bytes of a file are made of its text.
#[derive(Clone, Copy, Debug)]
enum Encoding {
    Utf8,
    Utf8Mark,
    Latin1,
    Utf16 { little: bool, mark: bool },
}

const ENCODINGS: [Encoding; 7] = [
    Encoding::Utf8,
    Encoding::Utf8Mark,
    Encoding::Latin1,
    Encoding::Utf16 { little: true, mark: true },
    Encoding::Utf16 { little: true, mark: false },
    Encoding::Utf16 { little: false, mark: true },
    Encoding::Utf16 { little: false, mark: false },
];

impl Encoding {
    fn bytes(self, text: &str) -> Vec<u8> {
        match self {
            Self::Utf8 => text.as_bytes().to_vec(),
            Self::Utf8Mark => format!("\u{feff}{text}").into_bytes(),
            Self::Latin1 => text.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect(),
            Self::Utf16 { little, mark } => {
                let mark = if mark { "\u{feff}" } else { "" };
                let bytes = |u: u16| if little { u.to_le_bytes() } else { u.to_be_bytes() };
                format!("{mark}{text}").encode_utf16().flat_map(bytes).collect()
            }
        }
    }
}

/// How rows are parted, the decimal mark, and what ends a row.
const FORMS: [(&str, char, &str); 9] = [
    (" ", '.', ""),
    ("\t", '.', "\t"),
    (",", '.', ""),
    (", ", '.', ","),
    (";", '.', ";"),
    ("  ", ',', " "),
    ("\t", ',', ""),
    (";", ',', ""),
    (" ; ", ',', ";"),
];

/// A number of `thousandths` under a decimal mark.
fn spelt(thousandths: i64, mark: char) -> String {
    let sign = if thousandths < 0 { "-" } else { "" };
    let (whole, rest) = (thousandths.abs() / 1000, thousandths.abs() % 1000);
    if rest == 0 { format!("{sign}{whole}") } else { format!("{sign}{whole}{mark}{rest:03}") }
}

/// Rows of numbers, in thousandths.
fn rows(rows: &[Vec<i64>], (separator, mark, end): (&str, char, &str)) -> Vec<String> {
    let spell =
        |row: &Vec<i64>| row.iter().map(|&x| spelt(x, mark)).collect::<Vec<_>>().join(separator);
    rows.iter().map(|row| spell(row) + end).collect()
}

fn same(a: &Measurement, b: &Measurement) {
    assert_eq!(
        (a.incident, a.scattered, &a.colorimetry),
        (b.incident, b.scattered, &b.colorimetry)
    );
    assert_eq!(a.sample_name, b.sample_name);
    assert_eq!(a.incidences.len(), b.incidences.len());
    for (a, b) in a.incidences.iter().zip(&b.incidences) {
        assert_eq!((a.wi, &a.wo, &a.values), (b.wi, &b.wo, &b.values));
    }
}

fn points() -> impl Strategy<Value = Vec<(i64, i64, i64)>> {
    proptest::collection::vec((0..89_000i64, -360_000..360_000i64, -50..9000i64), 1..12)
}

proptest! {
    #[test]
    fn mountain_files_read_the_same_in_every_dialect(
        (theta, phi) in (0..85_000i64, -180_000..180_000i64),
        points in points(),
        encoding in select(&ENCODINGS[..]),
        form in select(&FORMS[..]),
        line_end in select(&["\n", "\r\n", "\r"][..]),
        spelling in 0..5usize,
        comments in select(&[0, 3, 3000][..]),
        cosine in any::<bool>(),
    ) {
        let quantity = if cosine { "DSF" } else { "BSDF" };
        let table: Vec<Vec<i64>> = points.iter().map(|&(t, p, v)| vec![t, p, v]).collect();
        let plain = format!(
            "#sample_name \"Grünglas é\"\n#format: theta phi {quantity}\n#intheta {}\n#inphi {}\n#upphi 90\n{}\n",
            spelt(theta, '.'), spelt(phi, '.'), rows(&table, FORMS[0]).join("\n")
        );
        let quantity = if cosine { "CCBSDF" } else { "btdf" };
        let (t, p) = (spelt(theta, form.1), spelt(phi, form.1));
        let header = match spelling {
            0 => format!("#intheta{t}\n#inphi{p}\n#upphi90\n#format: theta phi {quantity}"),
            1 => format!("# Theta_In: {t}\n# Phi_In: {p}\n#upphi = 90\n#format theta, phi, {quantity}"),
            2 => format!("#theta_i [deg] = {t}\n#phi_i [deg] = {p}\n#UPPHI\t90\n#theta phi {quantity}"),
            3 => format!("#incident_angle {t} {p} deg\n#upphi 90°\n#format=theta [deg] phi [deg] {quantity} [1/sr]"),
            _ => format!("#incident_angle {t};{p}\n#upphi:90\n#Format:\ttheta\tphi\t{quantity}"),
        };
        let mut lines = vec!["#sample_name=\"Grünglas é\"".to_owned()];
        lines.extend((0..comments).map(|k| format!("# comment {k}: µ")));
        lines.extend(header.lines().map(str::to_owned));
        lines.extend(rows(&table, form));
        let other = encoding.bytes(&(lines.join(line_end) + line_end));
        same(&only_in("data", &other), &only(&plain));
    }

    #[test]
    fn tables_read_the_same_in_every_dialect(
        incidences in proptest::collection::vec((0..85_000i64, 0..180_000i64), 1..4),
        points in points(),
        encoding in select(&ENCODINGS[..]),
        form in select(&FORMS[..]),
        line_end in select(&["\n", "\r\n", "\r"][..]),
        spelling in 0..6usize,
        quoted in any::<bool>(),
    ) {
        let table: Vec<Vec<i64>> = points
            .iter()
            .enumerate()
            .map(|(k, &(t, p, v))| {
                let (theta, phi) = incidences[k % incidences.len()];
                vec![theta, phi, t, p, v]
            })
            .collect();
        let plain = format!("theta_i,phi_i,theta_o,phi_o,value\n{}\n", rows(&table, FORMS[2]).join("\n"));
        let names = match spelling {
            0 => ["theta_i", "phi_i", "theta_r", "phi_r", "brdf"],
            1 => ["THETA_IN", "PHI_IN", "THETA_OUT", "PHI_OUT", "BTDF"],
            2 => ["theta_i[deg]", "phi_i[deg]", "theta_s[deg]", "phi_s[deg]", "bsdf[1/sr]"],
            3 => ["theta_i (deg)", "phi_i (deg)", "theta_o (deg)", "phi_o (deg)", "value (1/sr)"],
            4 => ["θ_i", "φ_i", "θ_r", "φ_r", "f"],
            _ => ["incident_theta_deg", "incident_phi_deg", "scattered_theta_deg", "scattered_phi_deg", "µ"],
        };
        // Greek letters are not in Latin-1
        prop_assume!(spelling != 4 || !matches!(encoding, Encoding::Latin1));
        let separator = if form.0.trim().is_empty() { form.0 } else { form.0.trim() };
        let names = names.map(|n| if quoted { format!("\"{n}\"") } else { n.to_owned() });
        let mark = if spelling % 2 == 0 { "" } else { "# " };
        let mut lines = vec!["# é".to_owned(), String::new(), format!("{mark}{}", names.join(separator))];
        prop_assume!(!(spelling == 3 && quoted && separator.trim().is_empty() && separator != "\t"));
        lines.extend(rows(&table, form));
        let other = encoding.bytes(&(lines.join(line_end) + line_end));
        same(&only_in("data", &other), &only(&plain));
    }
}

#[test]
fn guessed_encodings_are_told_with_their_line_once_for_many_files() {
    let folder = tempfile::tempdir().unwrap();
    for theta in [10, 20, 30] {
        let text = format!(
            "#format: theta phi BSDF\n#sample_name \"Verre d\u{e9}poli\"\n#incident_angle {theta} 0\n10 0 1\n"
        );
        put(folder.path(), &format!("t{theta}.txt"), &Encoding::Latin1.bytes(&text));
    }
    let m = look(folder.path()).unwrap().remove(0);
    assert_eq!(m.sample_name.as_deref(), Some("Verre dépoli"));
    let told: Vec<_> = m.notes.iter().filter(|n| n.contains("Windows-1252")).collect();
    assert_eq!(told.len(), 1, "{:?}", m.notes);
    assert!(
        told[0].contains("t10.txt:2 and 2 files more: not UTF-8: taken as Windows-1252 (Latin-1)"),
        "{told:?}"
    );
    // one line each of two encodings
    let mixed = [&b"#sample_name \"d\xe9poli\"\n#sample_label \"d\xc3\xa9poli\"\n#sample_name \"d\xc3\xa9poli 2\"\n"[..], b"#incident_angle 0 0\n#format: theta phi BSDF\n1 1 1\n"].concat();
    assert_eq!(only_in("a", &mixed).sample_name.as_deref(), Some("dépoli 2"));
}

#[test]
fn binary_data_are_refused() {
    for bytes in [&b"#intheta 3\n\x01\x02\xff\n"[..], b"#a\xe9\x07\n", b"\xff\xfe1", b"\x9f\x05"] {
        let message = refusal(bytes);
        assert!(
            message.contains("binary data") || message.contains("not valid UTF-16"),
            "{message}"
        );
    }
}

const HEAD: &str = "#intheta 30\n#inphi 0\n#upphi 90\n";

/// Without a #format line the suffix says what the values are, else they are BSDF; the guess is told.
#[test]
fn a_missing_format_is_guessed_and_told() {
    for (name, value) in
        [("a.txt", 0.25), ("a.brdf", 0.25), ("a.BSDF", 0.25), ("a.dsf", 0.5), ("a", 0.25)]
    {
        let m = only_in(name, format!("{HEAD}60 0 0.25\n").as_bytes());
        assert!((m.incidences[0].values[0] - value).abs() < 1e-7, "{name}");
        assert!(
            m.notes.iter().any(|n| n.contains("no line #format: values taken as")),
            "{:?}",
            m.notes
        );
    }
    // the names of the columns stand for it
    let m = only(&format!("{HEAD}#theta\tphi\tDSF\n60 0 0.25\n"));
    assert!((m.incidences[0].values[0] - 0.5).abs() < 1e-7);
    assert!(!m.notes.iter().any(|n| n.contains("format")), "{:?}", m.notes);
    // Mitsuba's exporter
    let m = only(
        "#phi_in0\n#theta_in30\n#datapoints_in_file2\n#sample_name \"a 30\"\n0 -180 0.3\n5 -140 0.3\n",
    );
    assert_eq!(
        (&m.incidences[0].values[..2], m.sample_name.as_deref()),
        (&[0.3, 0.3][..], Some("a 30"))
    );
    // more columns than there are colours: nothing says what they are
    let message = refusal(format!("{HEAD}60 0 0.25 0.25\n").as_bytes());
    assert!(message.contains(":4: expected a header line #format: theta phi BSDF"), "{message}");
    let xyz = only(&format!("#colorimetry: CIE-XYZ\n{HEAD}60 0 1 2 3\n"));
    assert_eq!(xyz.colorimetry, Colorimetry::Xyz);
}

#[test]
fn signals_of_a_detector_are_no_measurement() {
    let message = refusal(
        format!("#pgII [uA] data\n{HEAD}#format: theta\tphi\t[uA]\n60 0 1e-6\n").as_bytes(),
    );
    assert!(message.contains("not calibrated; export them as DSF or BSDF"), "{message}");
    let message = refusal(b"theta_i,phi_i,theta_o,phi_o,signal [mV]\n1,1,1,1,1\n");
    assert!(
        message.contains("expected values in 1/sr, found a column \"signal [mv]\""),
        "{message}"
    );
}

#[test]
fn radians_are_turned_into_degrees() {
    let half = std::f64::consts::FRAC_PI_6;
    let m =
        only(&format!("theta_i [rad],phi_i_deg,theta_o(rad),phi_o,value\n{half},0,{half},90,1\n"));
    let at = |theta, phi| from_degrees(theta, phi);
    assert!((m.incidences[0].wi - at(30.0, 0.0)).length() < 1e-12);
    assert!((m.incidences[0].wo.at(0) - at(30.0, 90.0)).length() < 1e-7);
    let m = only(&format!(
        "#intheta {half} rad\n#inphi 0\n#upphi 90\n#format: theta [rad] phi [deg] BSDF\n{half} 90 1\n"
    ));
    assert!((m.incidences[0].wi - at(30.0, 0.0)).length() < 1e-12);
    assert!((m.incidences[0].wo.at(0) - at(30.0, 90.0)).length() < 1e-7);
    let message = refusal(b"theta_i [mm],phi_i,theta_o,phi_o,value\n1,1,1,1,1\n");
    assert!(
        message.contains(":1: theta_i: expected an angle in deg or rad, found the unit \"mm\""),
        "{message}"
    );
}

#[test]
fn columns_with_the_cosine_are_divided() {
    for name in ["dsf", "CCBSDF", "ccbrdf [1/sr]", "brdf*cos", "cosine-corrected BTDF"] {
        let m = only(&format!("theta_i,phi_i,theta_o,phi_o,{name}\n30,0,60,0,0.25\n30,0,90,0,1\n"));
        assert_eq!(m.points(), 1, "{name}");
        assert!((m.incidences[0].values[0] - 0.5).abs() < 1e-7, "{name}");
    }
    let m = only("theta_i,phi_i,theta_o,phi_o,ccbsdf_450nm,bsdf_650nm\n30,0,60,0,0.25,0.25\n");
    assert!((m.incidences[0].values[0] - 0.5).abs() < 1e-7);
    assert_eq!(m.incidences[0].values[1], 0.25);
}

#[test]
fn columns_beside_the_values_are_left_out_or_refused() {
    // as pandas writes the number of a row
    let m = only(
        ",theta_i,phi_i,theta_r,phi_r,brdf,uncertainty\n0,30,0,20,0,0.5,0.1\n1,30,0,25,0,0.6,0.1\n",
    );
    assert_eq!(m.incidences[0].values, [0.5, 0.6]);
    assert!(
        m.notes.iter().any(|n| n.contains("columns left out: \"\", \"uncertainty\"")),
        "{:?}",
        m.notes
    );
    for (names, part) in [
        ("theta_i,phi_i,theta_o,phi_o,wavelength,brdf", "one column a wavelength (450nm)"),
        (
            "theta_i,phi_i,theta_o,phi_o,theta_d,brdf",
            "angles of the incident and the scattered direction",
        ),
        (
            "theta_i,phi_i,theta_o,theta_r,phi_o,brdf",
            "expected each column once, found \"theta_o\" and \"theta_r\"",
        ),
    ] {
        let message = refusal(format!("{names}\n1,1,1,1,1,1\n").as_bytes());
        assert!(message.contains(part), "{message}");
    }
}

#[test]
fn decimal_commas_between_commas_are_refused_with_advice() {
    let names = "theta_i,phi_i,theta_o,phi_o,value\n";
    let message = refusal(format!("{names}30,0,20,0,1\n30,5,0,20,0,0,25\n").as_bytes());
    assert!(message.contains(":3: expected 5 columns, found 7"), "{message}");
    assert!(message.contains("semicolons, tabs or blanks must part the columns"), "{message}");
    // quotes part them, too
    let m = only(&format!("{names}\"30,5\",\"0\",\"20\",\"0\",\"0,25\"\n"));
    assert_eq!(m.incidences[0].values, [0.25]);
    // one file has one decimal mark
    let message = refusal(
        format!("{}30,5;0;20;0;0,25\n30,5;0;20;0;0.25\n", names.replace(',', ";")).as_bytes(),
    );
    assert!(
        message.contains(":3: value: expected a number with a decimal comma, found \"0.25\""),
        "{message}"
    );
    let message = refusal(format!("{}30.5;0;20;0;1,250\n", names.replace(',', ";")).as_bytes());
    assert!(
        message.contains("expected a number with a decimal point, found \"1,250\""),
        "{message}"
    );
}

/// As Excel writes it where commas are decimal.
#[test]
fn a_sheet_saved_as_csv() {
    let m = only_in(
        "a.csv",
        b"sep=;\r\nTheta_I [\xb0];Phi_I [\xb0];Theta_R [\xb0];Phi_R [\xb0];CCBRDF [1/sr]\r\n30,5;0;60;0;0,25\r\n\x1a",
    );
    assert!((m.incidences[0].wi - from_degrees(30.5, 0.0)).length() < 1e-12);
    assert!((m.incidences[0].values[0] - 0.5).abs() < 1e-7);
    assert!(m.notes.iter().any(|n| n.contains("a.csv:2: not UTF-8")), "{:?}", m.notes);
}

/// As the program Mountain writes its files: many keys, tabs, sentences.
#[test]
fn a_header_of_mountain_itself() {
    let m = only(
        "#pgII [DSF] data read from database by \"mountain\"\n#see the web for pgII gonio-photometer and BSDF details\n\
         #mountain-version\t\"V3.2.3\"\n#measured_at\t\"2018-01-16 01:21:28\"\n#integrated_value\t0.026\t6.3\n\
         #sample_label\t\"paper0\"\n#sample_name\t\"Golden_glossy_paper\"\n#beamshape\t\"det,f=300,a=1\"\n\
         #column\tdaq\n#incident_angle\t26.8421\t0\n#intheta\t26.8421\n#inphi\t0\n#upphi\t90\n#front_integral\t0.0263\n\
         #mountain_minimum_angle\t0.0014 [deg]\n#datapoints_in_file\t1\n#format: theta\tphi\tDSF\n60.0\t0.0\t2.5e-01\n",
    );
    assert_eq!(m.sample_name.as_deref(), Some("Golden_glossy_paper"));
    assert!((m.incidences[0].wi - from_degrees(26.8421, 0.0)).length() < 1e-12);
    assert!((m.incidences[0].values[0] - 0.5).abs() < 1e-7);
    assert_eq!(m.notes.len(), 1, "one incidence alone is noted: {:?}", m.notes);
}
