//! The command as a person uses it: files in, files and figures out, exit statuses.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::OnceLock;

use bsdfkit_simulate::{Goniophotometer, registry, write_measurements};
use bsdfkit_sphere::direction::from_degrees;
use serde_json::Value;

fn bsdf<S: AsRef<std::ffi::OsStr>>(arguments: &[S], input: &str) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_bsdf"))
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the command starts");
    let mut stdin = child.stdin.take().expect("a pipe");
    let input = input.to_owned();
    let writer = std::thread::spawn(move || {
        // A command that refuses its input closes the pipe.
        let _ = stdin.write_all(input.as_bytes());
    });
    let output = child.wait_with_output().expect("the command ends");
    writer.join().expect("the writer ends");
    output
}

/// Standard output of a command that succeeds.
fn ok(arguments: &[&str], input: &str) -> String {
    let output = bsdf(arguments, input);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {errors}");
    String::from_utf8(output.stdout).unwrap()
}

/// Standard error of a command that ends with `status`.
fn fails(arguments: &[&str], status: i32) -> String {
    let output = bsdf(arguments, "");
    let errors = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(status), "{arguments:?}: {errors}");
    assert!(!errors.contains("panicked"), "{errors}");
    errors
}

/// A specimen measured coarsely, fitted once for all tests.
struct Specimen {
    folder: tempfile::TempDir,
    /// What `fit --json` said.
    report: Value,
}

impl Specimen {
    fn path(&self, name: &str) -> String {
        self.folder.path().join(name).to_str().unwrap().to_owned()
    }
}

const MATERIAL: &str = "rough-dielectric";

fn specimen() -> &'static Specimen {
    static ONCE: OnceLock<Specimen> = OnceLock::new();
    ONCE.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let gonio = Goniophotometer {
            sweeps: 30,
            points_per_sweep: 120,
            spiral_points: 1000,
            ..Goniophotometer::default()
        };
        let all = registry();
        let material = all.iter().find(|m| m.name() == MATERIAL).unwrap();
        write_measurements(&folder.path().join("points"), &**material, &gonio, |_, _| Ok(()))
            .unwrap();
        let mut specimen = Specimen { folder, report: Value::Null };
        let path = |name| specimen.path(name);
        let (points, interpolant) = (path("points"), path("fit.safetensors"));
        let (tree, klems) = (path("tree.xml"), path("klems.xml"));
        let words = ["fit", &points, "-o", &interpolant, "--to", "klems-quarter", "-o", &klems];
        let more = ["-o", &tree, "--json", "--name", "A & B", "--max-error", "0.03"];
        let report = ok(&[&words[..], &more[..]].concat(), "");
        specimen.report = serde_json::from_str(&report).unwrap();
        specimen
    })
}

/// Directions inside what was measured; transmission.
fn rows() -> String {
    let mut rows = String::from("# theta_i phi_i theta_o phi_o\n\n");
    for theta in [5.0, 22.0, 40.0] {
        for k in 0..400 {
            let (theta_o, phi_o) = (100.0 + 4.0 * f64::from(k / 20), 18.0 * f64::from(k % 20));
            rows += &format!("{theta} 30 {theta_o} {phi_o}\n");
        }
    }
    rows
}

fn numbers(text: &str) -> Vec<f64> {
    text.split_whitespace().map(|w| w.parse().unwrap()).collect()
}

#[test]
fn the_truth_of_a_material_at_rows() {
    let rows = rows();
    let all = registry();
    for name in [MATERIAL, "grating-film"] {
        let material = all.iter().find(|m| m.name() == name).unwrap();
        let printed = numbers(&ok(&["eval", "--material", name], &rows));
        let lines = rows.lines().filter(|l| !l.is_empty() && !l.starts_with('#'));
        assert_eq!(printed.len(), lines.clone().count());
        for (line, printed) in lines.zip(printed) {
            let a = numbers(line);
            let f = material.eval(from_degrees(a[0], a[1]), from_degrees(a[2], a[3]));
            assert!((printed - f).abs() <= 1e-8 * f, "{line}: {printed} {f}");
        }
    }
    let error = fails(&["eval", "--material", "chalk"], 2);
    assert!(error.contains("expected one of brushed-metal"), "{error}");
    // one or the other
    fails(&["eval"], 2);
    fails(&["eval", "--material", MATERIAL, "tree.xml"], 2);
}

#[test]
fn every_output_is_near_the_truth() {
    let specimen = specimen();
    let rows = rows();
    let all = registry();
    let material = all.iter().find(|m| m.name() == MATERIAL).unwrap();
    let truth: Vec<f64> = rows
        .lines()
        .filter(|l| !l.is_empty() && !l.starts_with('#'))
        .map(|line| {
            let a = numbers(line);
            let wo = from_degrees(a[2], a[3]);
            material.eval(from_degrees(a[0], a[1]), wo) * wo.z.abs()
        })
        .collect();
    let cosines: Vec<f64> = rows
        .lines()
        .filter(|l| !l.is_empty() && !l.starts_with('#'))
        .map(|l| numbers(l)[2].to_radians().cos().abs())
        .collect();
    let error = |file: &str, reading: &[&str]| {
        let values = numbers(&ok(&[&["eval", &specimen.path(file)], reading].concat(), &rows));
        assert_eq!(values.len(), truth.len(), "{file}");
        assert!(values.iter().all(|v| v.is_finite() && *v >= 0.0), "{file}");
        let errors = values.iter().zip(&cosines).zip(&truth).map(|((v, c), t)| (v * c - t).abs());
        errors.sum::<f64>() / truth.iter().sum::<f64>()
    };
    for (file, most) in [("fit.safetensors", 0.1), ("tree.xml", 0.2), ("klems.xml", 0.9)] {
        let error = error(file, &[]);
        assert!(error < most, "{file}: {error}");
    }
    // What a tree adds to the error of what it was made from.
    let fit = error("fit.safetensors", &[]);
    let [stored, smooth] = [&[][..], &["--smooth"]].map(|reading| error("tree.xml", reading) - fit);
    assert!(smooth < 0.6 * stored, "{fit} fit; {stored} more stored, {smooth} more smooth");
    assert_eq!(error("klems.xml", &[]), error("klems.xml", &["--smooth"]));
}

#[test]
fn the_report_tells_components_and_outputs() {
    let report = &specimen().report;
    let component = &report["components"][0];
    assert_eq!(component["component"], "front transmission");
    assert_eq!(component["symmetry"], "isotropic");
    assert_eq!(component["incidences"], 9);
    assert!(component["points"].as_u64().unwrap() > 20_000);
    assert!(component["fit_error"].as_f64().unwrap() < 0.05);
    for total in component["hemispherical_0_30_60_degrees"].as_array().unwrap() {
        assert!((0.3..1.0).contains(&total.as_f64().unwrap()), "{total}");
    }
    let kinds: Vec<&str> =
        report["outputs"].as_array().unwrap().iter().map(|o| o["kind"].as_str().unwrap()).collect();
    assert_eq!(kinds, ["interpolant", "klems-quarter", "tensor-tree"]);
}

#[test]
fn the_same_structure_is_copied_value_by_value() {
    let specimen = specimen();
    let rows = rows();
    for (file, copy, more) in
        [("tree.xml", "tree2.xml", None), ("klems.xml", "klems2.xml", Some("klems-quarter"))]
    {
        let (file, copy) = (specimen.path(file), specimen.path(copy));
        let mut words = vec!["convert", &file, "-o", &copy];
        words.extend(more.iter().flat_map(|kind| ["--to", kind]));
        assert!(ok(&words, "").contains("1 components copied"));
        assert_eq!(ok(&["eval", &file], &rows), ok(&["eval", &copy], &rows));
        assert!(fs::read_to_string(&copy).unwrap().contains("<Name>A &amp; B</Name>"));
    }
    let (tree, compiled) = (specimen.path("tree.xml"), specimen.path("compiled.safetensors"));
    ok(&["compile", &tree, "-o", &compiled], "");
    assert_eq!(ok(&["eval", &tree], &rows), ok(&["eval", &compiled], &rows));
    assert!(ok(&["info", &compiled], "").contains("compiled BSDF"));
}

#[test]
fn values_come_with_their_densities() {
    let specimen = specimen();
    let rows = rows();
    for file in ["tree.xml", "klems.xml", "fit.safetensors"] {
        let file = specimen.path(file);
        let both = ok(&["eval", "--pdf", &file], &rows);
        let (values, densities) = (ok(&["eval", &file], &rows), ok(&["pdf", &file], &rows));
        assert!(densities.lines().count() > 3);
        for ((both, value), density) in both.lines().zip(values.lines()).zip(densities.lines()) {
            let (f, pdf) = both.split_once(' ').unwrap();
            let [f, value] = [f, value].map(|number| number.parse::<f64>().unwrap());
            assert!((f - value).abs() <= 1e-6 * value, "{file}: {f} {value}");
            assert_eq!(pdf, density, "{file}");
        }
    }
    fails(&["eval", "--pdf", "--channels", "tree.xml"], 2);
}

#[test]
fn conversion_keeps_the_light() {
    let specimen = specimen();
    let total = |file: &str| {
        let path = specimen.path(file);
        let text = ok(&["hemispherical", &path, "--incident", "20,0", "--json"], "");
        let rows: Value = serde_json::from_str(&text).unwrap();
        rows[0]["transmittance"].as_f64().unwrap()
    };
    let (tree, half) = (specimen.path("tree.xml"), specimen.path("half.xml"));
    ok(&["convert", &tree, "--to", "klems-half", "-o", &half], "");
    let expected = total("fit.safetensors");
    for file in ["tree.xml", "klems.xml", "half.xml"] {
        assert!((total(file) / expected - 1.0).abs() < 0.05, "{file}: {}, {expected}", total(file));
    }
}

#[test]
fn radiance_interpolants_are_read() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/golden/sir");
    let file = folder.join("diel.sir");
    let file = file.to_str().unwrap();
    let values = numbers(&ok(&["eval", file], &rows()));
    assert!(values.iter().all(|v| v.is_finite()) && values.iter().any(|&v| v > 0.1));
    assert!(ok(&["info", file], "").contains("Radiance interpolant"));
    let again = fails(&["convert", file, file, "-o", &specimen().path("twice.xml")], 2);
    assert!(again.contains("second"), "{again}");
}

#[test]
fn drawn_directions_carry_the_hemispherical_value() {
    let specimen = specimen();
    let smooth = ("tree.xml", Some("--smooth"));
    let files = ["fit.safetensors", "tree.xml", "klems.xml"].map(|file| (file, None));
    for (file, reading) in files.into_iter().chain([smooth]) {
        let path = specimen.path(file);
        let words = ["sample", path.as_str(), "--incident", "30,10", "-n", "100"];
        let words: Vec<&str> = words.into_iter().chain(reading).collect();
        let text = ok(&words, "");
        assert_eq!(text, ok(&words, ""), "same seed, same directions");
        let rows: Vec<Vec<f64>> = text.lines().map(numbers).collect();
        assert_eq!(rows.len(), 100);
        let words = ["hemispherical", path.as_str(), "--stdin"].into_iter().chain(reading);
        let totals = numbers(&ok(&words.collect::<Vec<_>>(), "30 10\n"));
        let mean = rows.iter().map(|row| row[2]).sum::<f64>() / rows.len() as f64;
        for row in &rows {
            assert!(row[0] > 90.0 && row[3] > 0.0, "{file}: {row:?}");
            // An interpolant is drawn from by a table near it: there weights are right in the mean.
            let (weight, off) = if file.ends_with(".xml") { (row[2], 1e-3) } else { (mean, 0.05) };
            assert!((weight - totals[1]).abs() < off * totals[1], "{file}: {row:?} {totals:?}");
        }
    }
}

#[test]
fn every_figure_is_json_on_request() {
    let specimen = specimen();
    let path = |name| specimen.path(name);
    let (tree, points, fit) = (path("tree.xml"), path("points"), path("fit.safetensors"));
    let picture = path("picture.png");
    let commands: [&[&str]; 9] = [
        &["info", &tree, "--json"],
        &["info", &fit, "--json"],
        &["info", &points, "--json"],
        &["check", &tree, "--json"],
        &["check", &points, "--json"],
        &["hemispherical", &fit, "--json"],
        &["solid-angle", &tree, "--json"],
        &["simulate", "--list", "--json"],
        &["plot", &fit, "--incident", "20,5", "--material", MATERIAL, "-o", &picture, "--json"],
    ];
    for words in commands {
        let text = ok(words, "");
        let parsed: Value =
            serde_json::from_str(&text).unwrap_or_else(|e| panic!("{words:?}: {e}"));
        assert!(!parsed.is_null());
    }
    assert_eq!(fs::read(&picture).unwrap()[..4], *b"\x89PNG");
}

#[test]
fn check_judges_energy() {
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/golden/badxml");
    let (good, bad) = (golden.join("00_good_matrix.xml"), golden.join("39_energy_3000pct.xml"));
    assert!(ok(&["check", good.to_str().unwrap()], "").contains(": good"));
    let output = bsdf(&["check", good.to_str().unwrap(), bad.to_str().unwrap()], "");
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(
        text.contains("fault: front: scatters") && text.contains("expected at most 1"),
        "{text}"
    );
    let unreadable = golden.join("09_too_few_values.xml");
    let error = fails(&["check", unreadable.to_str().unwrap()], 4);
    assert!(error.contains("expected"), "{error}");
}

#[test]
fn bad_xml_ends_with_a_message() {
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/golden/badxml");
    let expected: Value =
        serde_json::from_str(&fs::read_to_string(golden.join("expect.json")).unwrap()).unwrap();
    for (name, verdict) in expected.as_object().unwrap() {
        let path = golden.join(name);
        if !path.exists() || verdict != "error" {
            continue;
        }
        let output = bsdf(&["info".as_ref(), path.as_os_str()], "");
        let error = String::from_utf8(output.stderr).unwrap();
        let status = output.status.code();
        assert!(matches!(status, Some(3..=5)), "{name}: {status:?} {error}");
        assert!(error.starts_with("bsdf: ") && error.contains(name.as_str()), "{name}: {error}");
    }
}

#[test]
fn rubbish_instead_of_measurements_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out.xml");
    let out = out.to_str().unwrap();
    let refused = |content: &[u8], status: i32, words: &str| {
        let path: PathBuf = folder.path().join("points.txt");
        fs::write(&path, content).unwrap();
        let error = fails(&["fit", path.to_str().unwrap(), "-o", out], status);
        assert!(error.contains("points.txt") || error.contains(words), "{error}");
        assert!(error.contains(words), "expected {words:?} in {error}");
        assert!(!Path::new(out).exists());
    };
    let head = "#format: theta phi BSDF\n#intheta 20\n#inphi 0\n";
    refused(b"", 4, "empty");
    refused(b"<html><body>404</body></html>\n", 4, "HTML");
    refused(&[0, 159, 146, 150, 0, 1, 2, 3, 255, 10], 4, "expected");
    refused(b"#intheta 20\n#inphi 0\n10 0 0.5 0.5\n", 4, "#format");
    refused(format!("{head}10 0 nan\n").as_bytes(), 4, "points.txt:4: value");
    refused(format!("{head}10 0\n").as_bytes(), 4, "points.txt:4:");
    refused(head.as_bytes(), 4, "expected");
}

#[test]
fn the_status_tells_whose_fault_it_is() {
    let specimen = specimen();
    let (points, tree) = (specimen.path("points"), specimen.path("tree.xml"));
    let nowhere = specimen.path("no/such/folder/out.xml");
    assert!(fails(&["fit", &points, "-o", &nowhere], 3).contains("out.xml"));
    assert!(fails(&["eval", "no_such_file.xml"], 3).contains("no_such_file.xml"));
    assert!(fails(&["eval", &points], 2).contains("found a measurement: `fit`"));
    assert!(fails(&["fit", &points, "-o", "out.txt"], 2).contains(".safetensors"));
    fails(&["fit", &points], 2);
    fails(&["paint"], 2);
    assert!(fails(&["simulate", "cheese", "-o", "x"], 2).contains("fabric"));
    let interpolant = specimen.path("of_tree.safetensors");
    assert!(fails(&["convert", &tree, "-o", &interpolant], 2).contains("bsdf compile"));
    let wrong = ["fit", &points, "-o", &interpolant, "--symmetry", "round"];
    assert!(fails(&wrong, 2).contains("quadrilateral"));
    let output = bsdf(&["eval", &tree], "10 0 170 0\n10 0 170\n");
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(4));
    assert!(error.contains("standard input: line 2: expected 4 numbers, found 3"), "{error}");
}

#[test]
fn a_closed_pipe_is_no_fault() {
    let tree = specimen().path("tree.xml");
    let mut child = Command::new(env!("CARGO_BIN_EXE_bsdf"))
        .args(["sample", &tree, "--incident", "30,0", "-n", "200000"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert!(output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn a_view_of_what_is_stored_is_made_of_its_bands() {
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/golden/compiled");
    let path = |name: &str| golden.join(name).to_str().unwrap().to_owned();
    let tree = path("spectral_tree.safetensors");
    let numbers = |text: String| -> Vec<f64> {
        text.split_whitespace().map(|word| word.parse().unwrap()).collect()
    };
    // 450, 550 and 650 nm.
    let rows = "30 0 20 170\n70 40 60 200\n";
    let asked = |words: &[&str]| numbers(ok(&[&["eval", &tree], words].concat(), rows));
    let bands = asked(&["--bands"]);
    assert_eq!(bands.len(), 6);
    let near = |found: f64, expected: f64| {
        assert!((found - expected).abs() <= 1e-6 * expected.abs(), "{found} {expected}");
    };
    for (k, found) in asked(&["--view", "550nm"]).into_iter().enumerate() {
        near(found, bands[3 * k + 1]);
    }
    for (k, found) in asked(&["--view", "600nm"]).into_iter().enumerate() {
        near(found, 0.5 * (bands[3 * k + 1] + bands[3 * k + 2]));
    }
    for (k, found) in asked(&["--view", "mean"]).into_iter().enumerate() {
        near(found, bands[3 * k..][..3].iter().sum::<f64>() / 3.0);
    }
    let total = |words: &[&str]| {
        numbers(ok(&[&["hemispherical", &tree, "--stdin"], words].concat(), "30 0\n"))[0]
    };
    let three = ["450nm", "550nm", "650nm"].map(|view| total(&["--view", view]));
    near(total(&["--view", "mean"]), three.iter().sum::<f64>() / 3.0);
    assert!(three[0] != three[2], "{three:?}");
    let text = fails(&["eval", &path("t4_tf.safetensors"), "--view", "solar"], 2);
    assert!(text.contains("a stored BSDF without bands"), "{text}");
}
