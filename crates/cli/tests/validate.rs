//! `bsdf validate` and `bsdf plan` as a person uses them.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use bsdfkit_simulate::{Goniophotometer, registry, write_measurements};
use serde_json::Value;

fn bsdf(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_bsdf")).args(arguments).output().expect("the command starts")
}

fn ok(arguments: &[&str]) -> String {
    let output = bsdf(arguments);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {errors}");
    String::from_utf8(output.stdout).expect("text")
}

fn json(path: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(path).expect("written")).expect("JSON")
}

/// Nine incidences of rough glass.
fn measurements(folder: &Path) {
    let gonio = Goniophotometer {
        sweeps: 24,
        points_per_sweep: 90,
        spiral_points: 800,
        ..Goniophotometer::default()
    };
    let all = registry();
    let material = all.iter().find(|m| m.name() == "rough-dielectric").expect("there");
    write_measurements(folder, &**material, &gonio, |_, _| Ok(())).expect("written");
}

#[test]
fn errors_are_tabled_drawn_and_written_and_directions_planned() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    let text = |name: &str| path(name).to_str().expect("text").to_owned();
    measurements(&path("points"));
    let (points, report, picture) = (text("points"), text("errors.json"), text("errors.png"));
    let words = ["validate", &points, "--json", &report, "--picture", &picture];
    let table = ok(&[&words[..], &["--incident", "25,40"]].concat());
    assert!(table.starts_with("front transmission: 9 incidences"), "{table}");
    assert!(table.contains("  interpolated: 8 incidences"), "{table}");
    assert!(table.contains("  * extrapolated: 1 incidences"), "{table}");
    assert!(table.contains("expected at theta 25 phi 40: L1 0.0"), "{table}");
    let report = json(&path("errors.json"));
    let incidences = report[0]["incidences"].as_array().expect("a list");
    assert_eq!(incidences.len(), 9);
    for i in incidences {
        let l1 = i["l1"].as_f64().expect("a number");
        assert!((0.0..0.6).contains(&l1), "{i}");
        assert!(i["fit_l1"].as_f64().expect("a number") < 0.05, "{i}");
        assert!(!i["peaks"].as_array().expect("a list").is_empty(), "{i}");
    }
    assert!(report[0]["expected"][0]["l1"].as_f64().is_some_and(|l1| l1 > 0.0));
    assert_eq!(fs::read(path("errors.png")).expect("written")[..4], *b"\x89PNG");

    let next = text("next.json");
    let words = ["plan", &points, "--budget", "3", "--max-theta", "70", "--json", &next];
    let lines = ok(&words);
    let directions: Vec<Vec<f64>> = lines
        .lines()
        .filter(|l| !l.starts_with("  scan"))
        .map(|l| l.split('#').next().unwrap_or("").split_whitespace())
        .map(|words| words.map(|w| w.parse().expect("a number")).collect())
        .collect();
    assert_eq!(directions.len(), 3, "{lines}");
    assert!(directions.iter().all(|d| d.len() == 2 && d[0] <= 70.0), "{lines}");
    let next = json(&path("next.json"));
    let listed = next["incidences"].as_array().expect("a list");
    for (one, line) in listed.iter().zip(&directions) {
        assert!((one["theta_degrees"].as_f64().expect("a number") - line[0]).abs() < 0.01);
    }
}

#[test]
fn directions_to_begin_with_need_no_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("first.json");
    let file = file.to_str().expect("text");
    let asked = ["plan", "--symmetry", "bilateral-y", "--max-theta", "72", "--budget", "7"];
    let lines = ok(&[&asked[..], &["--json", file]].concat());
    let listed = json(std::path::Path::new(file));
    let listed = listed["incidences"].as_array().expect("a list");
    assert_eq!((lines.lines().count(), listed.len()), (7, 7), "{lines}");
    for (line, one) in lines.lines().zip(listed) {
        let words: Vec<f64> =
            line.split_whitespace().map(|w| w.parse().expect("a number")).collect();
        assert!(
            words.len() == 2 && words[0] <= 72.0 && (0.0..=180.0).contains(&words[1]),
            "{line}"
        );
        assert!((one["theta_degrees"].as_f64().expect("a number") - words[0]).abs() < 0.01);
    }
    // Of transmitted light alone, other ones.
    let through = ok(&[&asked[..], &["--transmission"]].concat());
    assert!(through.lines().count() == 7 && through != lines, "{through}");
    for (words, expected) in [
        (vec!["plan", file, "--transmission"], "--transmission"),
        (vec!["plan"], "expected files, or --symmetry and --max-theta"),
        (vec!["plan", "--symmetry", "none"], "expected files, or --symmetry and --max-theta"),
        (
            vec!["plan", "--symmetry", "bilateral", "--max-theta", "70"],
            "bilateral-x or bilateral-y",
        ),
        (vec!["plan", "--symmetry", "none", "--max-theta", "95"], "largest theta"),
    ] {
        let output = bsdf(&words);
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{words:?}: {error}");
        assert!(error.contains(expected), "{words:?}: {error}");
    }
}

#[test]
fn what_cannot_be_validated_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("one.txt");
    let head = "#format: theta phi BSDF\n#intheta 20\n#inphi 0\n";
    let rows: String = (0..60).map(|k| format!("{} {} 0.2\n", k, 6 * k)).collect();
    fs::write(&file, format!("{head}{rows}")).expect("written");
    let file = file.to_str().expect("text");
    for verb in ["validate", "plan"] {
        let output = bsdf(&[verb, file, "--symmetry", "none"]);
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(matches!(output.status.code(), Some(2 | 4)), "{verb}: {error}");
        assert!(error.contains("expected") && !error.contains("panicked"), "{verb}: {error}");
        assert_eq!(bsdf(&[verb, "no_such_folder"]).status.code(), Some(3));
    }
    let output = bsdf(&["validate", file, "--picture", "no/such/folder/out.png"]);
    assert_eq!(output.status.code(), Some(3));
    assert_eq!(bsdf(&["plan", file, "--budget", "0"]).status.code(), Some(2));
}
