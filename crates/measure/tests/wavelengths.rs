//! Spectra in files: columns, `#lambda`, a file a wavelength.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use bsdfkit_measure::{Colorimetry, Measurement, ReadOptions, read};

const POLAR: [f64; 4] = [5.0, 25.0, 45.0, 65.0];

/// A scan at `theta` of a material that is brighter at longer wavelengths; `off` degrees from where others look.
fn mountain(theta: f64, header: &str, nanometres: &[f64], off: f64) -> String {
    let mut text =
        format!("#format: theta phi BSDF\n#intheta {theta}\n#inphi 0\n#upphi 90\n{header}\n");
    for polar in POLAR {
        for phi in (0..360).step_by(30) {
            write!(text, "{} {phi}", polar + off).unwrap();
            nanometres.iter().for_each(|w| write!(text, " {}", value(*w, polar)).unwrap());
            text.push('\n');
        }
    }
    text
}

fn value(nanometres: f64, polar: f64) -> f64 {
    nanometres / 1000.0 + polar / 1e4
}

fn put(folder: &Path, name: &str, text: &str) -> PathBuf {
    let path = folder.join(name);
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    std::fs::write(&path, text).unwrap();
    path
}

fn look(paths: &[PathBuf]) -> bsdfkit::Result<Vec<Measurement>> {
    read(paths, &ReadOptions { incomplete: true, ..Default::default() })
}

/// Three bands at two incidences, whose values are those of [`value`].
fn expect_three_bands(m: &[Measurement]) {
    let [m] = m else { panic!("{} components", m.len()) };
    let Colorimetry::Spectral(bands) = &m.colorimetry else { panic!("{}", m.colorimetry) };
    assert_eq!(bands.nanometres(), [450.0, 550.0, 650.0]);
    assert_eq!((m.incidences.len(), m.incidences[0].wo.len()), (2, 4 * 12));
    for i in &m.incidences {
        for (k, w) in i.wo.iter().enumerate() {
            let polar = w.z.acos().to_degrees();
            for (band, found) in bands.nanometres().iter().zip(&i.point(k)[1..]) {
                let expected = value(*band, polar);
                assert!((f64::from(*found) - expected).abs() < 1e-5, "{band}: {found} {expected}");
            }
        }
    }
}

#[test]
fn a_header_names_the_wavelengths_of_columns() {
    let folder = tempfile::tempdir().unwrap();
    for theta in [20.0, 40.0] {
        // In any order.
        let text = mountain(theta, "#lambda 650 450 550", &[650.0, 450.0, 550.0], 0.0);
        put(folder.path(), &format!("{theta}.txt"), &text);
    }
    expect_three_bands(&look(&[folder.path().to_owned()]).unwrap());
}

#[test]
fn files_of_one_wavelength_each_become_a_spectrum() {
    let folder = tempfile::tempdir().unwrap();
    for theta in [20.0, 40.0] {
        for (n, w) in [550.0, 650.0, 450.0].into_iter().enumerate() {
            // Scans come back to within a hundredth of a degree.
            let text = mountain(theta, &format!("#lambda {w} nm"), &[w], 0.01 * n as f64);
            put(folder.path(), &format!("{theta} {w}.txt"), &text);
        }
    }
    expect_three_bands(&look(&[folder.path().to_owned()]).unwrap());
}

#[test]
fn wavelengths_are_given_with_the_paths() {
    let folder = tempfile::tempdir().unwrap();
    let mut paths = Vec::new();
    for w in [450.0, 550.0, 650.0] {
        for theta in [20.0, 40.0] {
            let mut text = mountain(theta, "", &[w], 0.0);
            if w == 550.0 {
                // Another order of points, and one more.
                let rows = text.split_off(text.find("\n\n").unwrap() + 2);
                let rows: Vec<&str> = rows.lines().rev().chain(["70 15 0.1"]).collect();
                text += &rows.join("\n");
            }
            put(folder.path(), &format!("{w}/{theta}.txt"), &text);
        }
        paths.push(format!("{w}nm={}", folder.path().join(format!("{w}")).display()).into());
    }
    expect_three_bands(&look(&paths).unwrap());
    // One alone is what it always was.
    let m = look(&paths[..1]).unwrap();
    assert_eq!(m[0].colorimetry, Colorimetry::Luminance);
    assert!(m[0].notes.iter().any(|n| n.contains("450 nm alone")), "{:?}", m[0].notes);
}

#[test]
fn what_cannot_be_one_spectrum_is_refused() {
    let refused = |files: &[(&str, String)], words: &[&str]| {
        let folder = tempfile::tempdir().unwrap();
        files.iter().for_each(|(name, text)| drop(put(folder.path(), name, text)));
        let message = look(&[folder.path().to_owned()]).unwrap_err().to_string();
        words.iter().for_each(|word| assert!(message.contains(word), "{word}: {message}"));
    };
    let one = |theta: f64, w: f64| mountain(theta, &format!("#lambda {w}"), &[w], 0.0);
    let a = || ("a.txt", one(20.0, 450.0));
    refused(
        &[a(), ("b.txt", mountain(20.0, "", &[550.0], 0.0))],
        &["b.txt", "expected a wavelength", "a.txt"],
    );
    refused(&[a(), ("b.txt", one(40.0, 550.0))], &["b.txt", "550 nm", "theta 20.0", "450 nm"]);
    refused(
        &[a(), ("b.txt", one(20.0, 550.0)), ("c.txt", one(40.0, 550.0))],
        &["550 nm", "expected the 1 incident directions of 450 nm, found 2"],
    );
    let off = mountain(20.0, "#lambda 550", &[550.0], 0.3);
    refused(&[a(), ("b.txt", off)], &["b.txt", "found 48 of 48 elsewhere"]);
    let colour = mountain(20.0, "#lambda 550\n#colorimetry CIE-XYZ", &[1.0, 1.0, 1.0], 0.0);
    refused(&[a(), ("b.txt", colour)], &["b.txt", "expected one value a point, found CIE XYZ"]);
    refused(&[("a.txt", mountain(20.0, "#lambda 550 inch", &[1.0], 0.0))], &["a.txt:5", "inch"]);
    let twice = mountain(20.0, "#lambda 550 550", &[1.0, 1.0], 0.0);
    refused(&[("a.txt", twice)], &["found 550 after 550"]);
}
