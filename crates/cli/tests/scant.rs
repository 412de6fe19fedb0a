//! Measurements that show little, and fits that are not to be trusted between their incidences, as a person meets them.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use bsdfkit_simulate::{Goniophotometer, registry, write_measurements};
use bsdfkit_sphere::DVec3;
use bsdfkit_sphere::direction::from_degrees;
use serde_json::Value;

fn bsdf(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_bsdf")).args(arguments).output().expect("the command starts")
}

/// Standard output and error of what ends with `status`.
fn said(arguments: &[&str], status: i32) -> (String, String) {
    let output = bsdf(arguments);
    let [out, err] = [output.stdout, output.stderr].map(|b| String::from_utf8(b).expect("text"));
    assert_eq!(output.status.code(), Some(status), "{arguments:?}: {out} {err}");
    (out, err)
}

fn glossy(wi: DVec3, wo: DVec3) -> f64 {
    let specular = DVec3::new(-wi.x, -wi.y, wi.z.abs().copysign(wo.z));
    0.032 + 0.3 * (20.0 * (specular.dot(wo) - 1.0)).exp()
}

/// A table of the glossy specimen at 0, 20, 40 and 60 degrees, scattered to (θ, φ).
fn table(file: &Path, scan: &[(f64, f64)]) {
    let mut text = String::from("theta_i,phi_i,theta_o,phi_o,value\n");
    for theta_i in [0.0, 20.0, 40.0, 60.0] {
        for (theta, phi) in scan {
            let value = glossy(from_degrees(theta_i, 0.0), from_degrees(*theta, *phi));
            text += &format!("{theta_i},0,{theta},{phi},{value}\n");
        }
    }
    fs::write(file, text).expect("written");
}

#[test]
fn one_plane_is_told_by_info_check_and_fit_and_totals_are_marked() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = |name: &str| folder.path().join(name).to_str().expect("text").to_owned();
    let reflected: Vec<(f64, f64)> = (-16..=16).map(|k| (5.0 * f64::from(k), 180.0)).collect();
    let through: Vec<(f64, f64)> = reflected.iter().map(|&(t, phi)| (180.0 - t, phi)).collect();
    let files = [
        ("plane.csv", &reflected, "front reflection"),
        ("through.csv", &through, "front transmission"),
    ];
    for (name, scan, place) in files {
        let (file, fit) = (text(name), text("fit.safetensors"));
        table(Path::new(&file), scan);
        let words =
            "only one plane (azimuths 0 and 180, that of incidence) measured at 4 of 4 incidences";
        let (info, _) = said(&["info", &file], 0);
        assert!(info.contains(words), "{info}");
        let row = |start: &str| {
            info.lines().find(|l| l.trim_start().starts_with(start)).expect("a row").to_owned()
        };
        assert!(
            !row("0.0").contains('~') && row("60.0").contains('~') && row("60.0").contains('±'),
            "{info}"
        );
        assert!(!info.contains("approximate"), "{info}");
        let (check, _) = said(&["check", &file], 0);
        assert!(check.contains(&format!("remark: {place}: {words}")), "{check}");
        let (printed, warned) = said(&["fit", &file, "-o", &fit], 0);
        assert!(warned.contains(&format!("warning: {place}: {words}")), "{warned}");
        let figures = printed.lines().nth(1).expect("a row");
        assert_eq!(figures.matches('~').count(), 2, "{printed}");
        let (report, _) = said(&["fit", &file, "-o", &fit, "--json"], 0);
        let report: Value = serde_json::from_str(&report).expect("JSON");
        let one = &report["components"][0];
        assert_eq!(one["extrapolated_0_30_60_degrees"], serde_json::json!([false, true, true]));
        assert!(one["seen"].as_f64().is_some_and(|s| s < 0.1), "{one}");
        assert!(one["expected_error"].as_f64().is_some_and(|e| e < 0.1), "{one}");
        let (totals, _) = said(&["hemispherical", &fit, "--incident", "0", "--incident", "60"], 0);
        let marks: Vec<usize> = totals.lines().skip(1).map(|l| l.matches('~').count()).collect();
        assert_eq!(marks, [0, 1], "{totals}");
        let (kept, _) = said(&["info", &fit], 0);
        assert!(
            kept.contains("expected error: 0.0") && kept.contains("% of the hemisphere was seen"),
            "{kept}"
        );
        let (json, _) = said(&["info", "--json", &file], 0);
        let json: Value = serde_json::from_str(&json).expect("JSON");
        let incidences = &json["components"][0]["incidences"];
        assert_eq!(
            (&incidences[0]["extrapolated"], &incidences[3]["extrapolated"]),
            (&false.into(), &true.into())
        );
        assert!(incidences[3]["hemispherical_uncertainty"][0].as_f64().is_some_and(|u| u > 0.0));
    }
}

#[test]
fn one_detector_direction_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = |name: &str| folder.path().join(name).to_str().expect("text").to_owned();
    let (file, out) = (text("one.csv"), text("one.xml"));
    for scan in [vec![(30.0, 180.0)], vec![(30.0, 180.0); 20], vec![(150.0, 0.0)]] {
        table(Path::new(&file), &scan);
        let (_, error) = said(&["fit", &file, "-o", &out], 4);
        assert!(
            error.contains("one.csv: incidence theta 0.0 phi 0.0: expected points in at least 7"),
            "{error}"
        );
        assert!(
            error.contains("found one direction (theta ") && error.contains("at 4 of 4"),
            "{error}"
        );
        assert!(!Path::new(&out).exists());
        let (check, _) = said(&["check", &file], 1);
        assert!(check.contains(": bad") && check.contains("fault: front"), "{check}");
        let (info, _) = said(&["info", &file], 0);
        assert!(info.contains("only one direction") && info.contains("unknown"), "{info}");
    }
}

#[test]
fn half_a_hemisphere_is_a_bound() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("half.csv");
    // Askew to the plane of incidence: no mirror shows the other half.
    let ring = |k: i32| (0..=12).map(move |n| (10.0 * f64::from(k), 40.0 + 15.0 * f64::from(n)));
    table(&file, &(0..=8).flat_map(ring).collect::<Vec<_>>());
    let file = file.to_str().expect("text");
    let (info, _) = said(&["info", file], 0);
    assert!(info.contains("only half the hemisphere (azimuths 40 to 220)"), "{info}");
    assert!(info.contains('>'), "{info}");
    let (_, warned) = said(&["fit", file, "-o", &format!("{file}.safetensors")], 0);
    assert!(warned.contains("only half the hemisphere"), "{warned}");
}

/// Few points of each: what is told does not depend on how many.
fn simulated(name: &str, folder: &Path) {
    let gonio = Goniophotometer {
        sweeps: 30,
        points_per_sweep: 120,
        spiral_points: 1000,
        ..Goniophotometer::default()
    };
    let all = registry();
    let material = all.iter().find(|m| m.name() == name).expect("there");
    write_measurements(folder, &**material, &gonio, |_, _| Ok(())).expect("written");
}

#[test]
fn a_retro_reflective_sheet_at_three_angles_fits_and_warns_and_rough_glass_does_not() {
    for (name, warns) in [("retro-sheet", true), ("rough-dielectric", false)] {
        let folder = tempfile::tempdir().expect("a folder");
        let points = folder.path().join("points");
        simulated(name, &points);
        if warns {
            for theta in ["20", "60"] {
                let named = format!("i_{theta}");
                let all = std::fs::read_dir(&points).expect("a folder").map(|f| f.expect("a file"));
                let of = all.filter(|f| f.file_name().to_string_lossy().starts_with(&named));
                of.for_each(|f| std::fs::remove_file(f.path()).expect("removed"));
            }
        }
        let (points, fit) = (points.to_str().expect("text"), folder.path().join("fit.safetensors"));
        let fit = fit.to_str().expect("text");
        let (report, warned) = said(&["fit", points, "-o", fit, "--json"], 0);
        let report: Value = serde_json::from_str(&report).expect("JSON");
        let one = &report["components"][0];
        let [at, between] =
            ["fit_error", "expected_error"].map(|k| one[k].as_f64().expect("a number"));
        assert!(at < 5e-3, "{name}: {at}");
        assert_eq!(between > 0.2, warns, "{name}: {between}");
        let told = warned.contains("warning")
            && warned.contains("`bsdf validate` shows where, `bsdf plan` says");
        assert_eq!(told, warns, "{warned}");
        assert_eq!(one["extrapolated_0_30_60_degrees"], serde_json::json!([false, false, false]));
        let (info, _) = said(&["info", fit], 0);
        assert!(info.contains(&format!("expected error: {between:.5}")), "{info} {between}");
    }
}
