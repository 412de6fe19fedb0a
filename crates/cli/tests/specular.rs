//! Peaks of no width on the command line: separated, told, converted, found in cells.

use std::process::{Command, Output};

use bsdfkit_simulate::material::ClearGlass;
use bsdfkit_simulate::{Goniophotometer, write_measurements};
use serde_json::Value;

fn bsdf(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_bsdf")).args(arguments).output().unwrap()
}

fn ok(arguments: &[&str]) -> String {
    let output = bsdf(arguments);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {errors}");
    String::from_utf8(output.stdout).unwrap()
}

fn fails(arguments: &[&str], words: &str) {
    let output = bsdf(arguments);
    let errors = String::from_utf8(output.stderr).unwrap();
    assert_ne!(output.status.code(), Some(0), "{arguments:?}");
    assert!(errors.contains(words) && !errors.contains("panicked"), "{arguments:?}: {errors}");
}

#[test]
fn a_peak_goes_all_the_way() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let measurements = path("measurements");
    let gonio = Goniophotometer {
        sweeps: 24,
        points_per_sweep: 90,
        spiral_points: 800,
        ..Goniophotometer::default()
    };
    let glass = ClearGlass::default();
    write_measurements(measurements.as_ref(), &glass, &gonio, |_, _| Ok(())).unwrap();
    let (fitted, tree, klems) = (path("g.safetensors"), path("g.xml"), path("k.xml"));
    let said = ok(&[
        "fit",
        &measurements,
        "--aperture",
        "1",
        "-o",
        &fitted,
        "-o",
        &tree,
        "--to",
        "klems-full",
        "-o",
        &klems,
    ]);
    assert!(
        said.contains("front transmission: specular, straight through: coefficient 0.8"),
        "{said}"
    );

    for file in [&fitted, &tree, &klems] {
        let report: Value = serde_json::from_str(&ok(&["info", "--json", file])).unwrap();
        let components = report["components"].as_array().unwrap();
        let peak = components.iter().find(|c| c["law"] == "straight through").expect(file);
        let coefficient = peak["coefficient_0_30_60_degrees"][0].as_f64().unwrap();
        assert!((coefficient / 0.85 - 1.0).abs() < 0.01, "{file}: {coefficient}");
        // Of the samples that share, and the rest is the haze.
        let drawn = ok(&["sample", file, "--incident", "0,0", "-n", "1000"]);
        let peaks = drawn.lines().filter(|l| l.ends_with("specular_0")).count();
        assert!((935..955).contains(&peaks), "{file}: {peaks}");
    }

    // What another program would have written: cells alone.
    let text = std::fs::read_to_string(&klems).unwrap();
    let (from, to) = ("<SpecularComponents>", "</SpecularComponents>");
    let end = text.find(to).unwrap() + to.len();
    let bare = format!("{}{}", &text[..text.find(from).unwrap()], &text[end..]);
    let (cells, found, again) = (path("cells.xml"), path("found.xml"), path("again.xml"));
    std::fs::write(&cells, bare).unwrap();
    ok(&["convert", &cells, "--to", "klems-full", "--extract-peaks", "-o", &found]);
    ok(&["convert", &found, "--to", "klems-full", "--extract-peaks", "-o", &again]);
    let found = std::fs::read_to_string(found).unwrap();
    assert!(found.contains("<SpecularComponent>"));
    assert_eq!(std::fs::read_to_string(again).unwrap(), found);

    fails(
        &["convert", &fitted, "--extract-peaks", "-o", &again_of(&fitted)],
        "found an interpolant",
    );
    for (degrees, words) in
        [("45", "0.01 to 10 degrees"), ("0", "0.01 to 10"), ("-1", "0.01 to 10"), ("x", "invalid")]
    {
        fails(&["fit", &measurements, "--aperture", degrees, "-o", &tree], words);
    }
    fails(
        &["fit", &measurements, "--aperture", "1", "--signature", &tree, "-o", &tree],
        "cannot be used with",
    );
    fails(&["fit", &measurements, "--signature", &measurements, "-o", &tree], "the empty beam");
    fails(&["fit", &measurements, "--signature", &path("none.txt"), "-o", &tree], "none.txt");
}

fn again_of(path: &str) -> String {
    path.replace(".safetensors", "_again.xml")
}
