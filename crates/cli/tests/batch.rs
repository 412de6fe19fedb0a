//! Many materials at once: what is done is done once, one that fails stops no other, whatever is killed goes on.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

use bsdfkit_sphere::DVec3;
use bsdfkit_sphere::direction::from_degrees;
use serde_json::Value;

fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_bsdf"));
    command.args(arguments).stdin(Stdio::null());
    command
}

fn bsdf(arguments: &[&str]) -> Output {
    command(arguments).output().expect("the command starts")
}

/// Standard output and error of what ends with `status`.
fn said(arguments: &[&str], status: i32) -> (String, String) {
    let output = bsdf(arguments);
    let [out, err] = [output.stdout, output.stderr].map(|b| String::from_utf8(b).expect("text"));
    assert_eq!(output.status.code(), Some(status), "{arguments:?}: {out} {err}");
    assert!(!err.contains("panicked"), "{err}");
    (out, err)
}

/// A table of an isotropic specimen: the higher `gloss`, the narrower its peak.
fn table(gloss: f64) -> String {
    let mut text = String::from("theta_i,phi_i,theta_o,phi_o,value\n");
    for theta_i in [0.0, 30.0, 60.0] {
        let wi = from_degrees(theta_i, 0.0);
        let specular = DVec3::new(-wi.x, -wi.y, wi.z);
        for k in 0..12 {
            for j in 0..8 {
                let (theta, phi) = (5.0 + 10.0 * f64::from(j), 30.0 * f64::from(k));
                let near = specular.dot(from_degrees(theta, phi)) - 1.0;
                let value = 0.05 + 0.2 * (gloss * near).exp();
                text += &format!("{theta_i},0,{theta},{phi},{value}\n");
            }
        }
    }
    text
}

/// A folder with measurements `0` to `count`, and what a manifest may say of them.
struct Laboratory(tempfile::TempDir);

impl Laboratory {
    fn new(count: usize) -> Self {
        let laboratory = Self(tempfile::tempdir().expect("a folder"));
        for k in 0..count {
            laboratory.write(&format!("measured/{k}/points.csv"), &table(2.0 + k as f64));
        }
        laboratory
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn text(&self, name: &str) -> String {
        self.path(name).to_str().expect("text").to_owned()
    }

    fn write(&self, name: &str, text: &str) {
        let path = self.path(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("made");
        fs::write(path, text).expect("written");
    }

    /// All of them, as TOML.
    fn manifest(&self, count: usize) -> String {
        let mut text = String::from(
            "[defaults]\noutputs = [\"interpolant\", \"klems-quarter\"]\nsymmetry = \"isotropic\"\nlicence = \"CC0-1.0\"\n",
        );
        for k in 0..count {
            text += &format!(
                "\n[[material]]\nname = \"m{k}\"\nmeasurements = [\"measured/{k}\"]\ntitle = \"No. {k}\"\n"
            );
        }
        self.write("all.toml", &text);
        self.text("all.toml")
    }

    fn batch(&self, manifest: &str, to: &str, status: i32) -> (String, String) {
        said(&["batch", manifest, "-o", &self.text(to), "--jobs", "2"], status)
    }

    /// Every BSDF below `to`, by its path there.
    fn made(&self, to: &str) -> BTreeMap<String, Vec<u8>> {
        let mut made = BTreeMap::new();
        for folder in
            fs::read_dir(self.path(to)).expect("a folder").map(|e| e.expect("an entry").path())
        {
            if !folder.is_dir() || folder.file_name().is_some_and(|n| n == ".part") {
                continue;
            }
            for file in
                fs::read_dir(&folder).expect("a folder").map(|e| e.expect("an entry").path())
            {
                let kept = file.extension().is_some_and(|e| e == "xml" || e == "safetensors");
                if kept {
                    let name =
                        file.strip_prefix(self.path(to)).expect("within").display().to_string();
                    made.insert(name, fs::read(&file).expect("read"));
                }
            }
        }
        made
    }
}

/// Lines on standard error that tell of a job.
fn told(err: &str) -> Vec<&str> {
    let mut lines: Vec<&str> =
        err.lines().filter(|l| l.contains(": done, ") || l.contains(": failed: ")).collect();
    lines.sort_unstable();
    lines
}

#[test]
fn one_that_fails_stops_no_other_and_what_is_done_is_done_once() {
    let laboratory = Laboratory::new(4);
    let manifest = laboratory.manifest(4);
    laboratory.write("measured/2/points.csv", "theta_i,phi_i,theta_o,phi_o,value\n1,2,3,<b>,5\n");
    let (out, err) = laboratory.batch(&manifest, "fitted", 1);
    assert_eq!(told(&err).len(), 4, "{err}");
    assert!(out.contains("3 done, 1 failed, 0 to do"), "{out}");
    assert!(out.contains("m2: ") && out.contains("points.csv"), "{out}");
    let made = laboratory.made("fitted");
    let names: Vec<&str> = made.keys().map(|k| &**k).collect();
    assert_eq!(
        names,
        [
            "m0/m0.klems-quarter.xml",
            "m0/m0.safetensors",
            "m1/m1.klems-quarter.xml",
            "m1/m1.safetensors",
            "m3/m3.klems-quarter.xml",
            "m3/m3.safetensors"
        ]
    );
    let record: Value =
        serde_json::from_slice(&fs::read(laboratory.path("fitted/m0/m0.json")).expect("a record"))
            .expect("JSON");
    assert_eq!(record, serde_json::json!({"name": "No. 0", "licence": "CC0-1.0"}));
    let xml = String::from_utf8(made["m0/m0.klems-quarter.xml"].clone()).expect("text");
    assert!(xml.contains("No. 0"));
    assert!(
        fs::read_to_string(laboratory.path("fitted/m2/m2.log"))
            .expect("a log")
            .starts_with("bsdf fit ")
    );
    let page = fs::read_to_string(laboratory.path("fitted/summary.html")).expect("a page");
    assert!(
        page.contains("3 done, 1 failed") && page.contains("&lt;b&gt;") && !page.contains("<b>")
    );
    let csv = fs::read_to_string(laboratory.path("fitted/summary.csv")).expect("a table");
    let statuses: Vec<&str> = csv.lines().skip(1).filter_map(|l| l.split(',').nth(1)).collect();
    assert_eq!(statuses, ["done", "done", "failed", "done"]);
    // The one that failed is tried again, the others are not; nor are they when all is well.
    let (_, err) = laboratory.batch(&manifest, "fitted", 1);
    assert!(matches!(told(&err)[..], [line] if line.starts_with("m2: failed")), "{err}");
    laboratory.write("measured/2/points.csv", &table(4.0));
    let (_, err) = laboratory.batch(&manifest, "fitted", 0);
    assert!(matches!(told(&err)[..], [line] if line.starts_with("m2: done")), "{err}");
    assert!(told(&laboratory.batch(&manifest, "fitted", 0).1).is_empty());
    // Another content, another setting, a file that is gone: each makes its material's work again.
    laboratory.write("measured/0/points.csv", &table(30.0));
    fs::remove_file(laboratory.path("fitted/m1/m1.safetensors")).expect("removed");
    let text = fs::read_to_string(&manifest).expect("read");
    fs::write(
        &manifest,
        text.replace("title = \"No. 3\"", "title = \"No. 3\"\ngrazing-limit = 70"),
    )
    .expect("written");
    let (_, err) = laboratory.batch(&manifest, "fitted", 0);
    let names: Vec<&str> = told(&err).iter().map(|l| &l[..2]).collect();
    assert_eq!(names, ["m0", "m1", "m3"], "{err}");
    let changed = laboratory.made("fitted");
    assert_eq!(changed["m1/m1.safetensors"], made["m1/m1.safetensors"]);
    assert_ne!(changed["m0/m0.safetensors"], made["m0/m0.safetensors"]);
    assert_ne!(changed["m3/m3.safetensors"], made["m3/m3.safetensors"]);
}

#[test]
fn csv_asks_for_the_same_as_toml_and_fit_makes_the_same() {
    let laboratory = Laboratory::new(2);
    let toml = laboratory.manifest(2);
    let csv = "name;measurements;outputs;symmetry;licence;title
m0;measured/0/*.csv;interpolant | klems-quarter;isotropic;CC0-1.0;No. 0
m1;measured/1/points.csv;interpolant | klems-quarter;isotropic;CC0-1.0;No. 1\n";
    laboratory.write("all.csv", csv);
    laboratory.batch(&toml, "a", 0);
    laboratory.batch(&laboratory.text("all.csv"), "b", 0);
    let made = laboratory.made("a");
    assert!(made == laboratory.made("b") && made.len() == 4);
    let alone = laboratory.text("alone.safetensors");
    let measured = laboratory.text("measured/0");
    said(&["fit", &measured, "--symmetry", "isotropic", "--name", "No. 0", "-o", &alone], 0);
    assert!(fs::read(alone).expect("read") == made["m0/m0.safetensors"]);
    let (out, _) = said(&["batch", &toml, "-o", &laboratory.text("a"), "--json"], 0);
    let lines: Value = serde_json::from_str(&out).expect("JSON");
    let energy = lines[0]["energy"].as_f64().expect("a number");
    assert!(energy > 0.1 && energy < 1.0, "{energy}");
    assert_eq!(lines[1]["points"], 3 * 96);
}

/// Waits until `path` is there.
fn wait_for(path: &Path, process: &mut Child) {
    while !path.exists() {
        assert!(
            process.try_wait().expect("a process").is_none(),
            "it ended before {}",
            path.display()
        );
        std::thread::sleep(Duration::from_millis(2));
    }
}

#[test]
fn what_was_killed_goes_on_to_the_same_files() {
    let laboratory = Laboratory::new(4);
    let manifest = laboratory.manifest(4);
    laboratory.batch(&manifest, "whole", 0);
    let expected = laboratory.made("whole");
    assert_eq!(expected.len(), 8);
    for cache in [false, true] {
        let to = format!("killed-{cache}");
        let (folder, kept) = (laboratory.text(&to), laboratory.text("cache"));
        let mut words = vec!["batch", &manifest, "-o", &folder, "--jobs", "1"];
        words.extend(cache.then_some(["--cache", &kept]).into_iter().flatten());
        let mut line = command(&words);
        let mut process =
            line.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("it starts");
        wait_for(&laboratory.path(&format!("{to}/m0/.batch.json")), &mut process);
        wait_for(&laboratory.path(&format!("{to}/.part/m1/m1.log")), &mut process);
        process.kill().expect("killed");
        process.wait().expect("ended");
        // Whatever is there is whole.
        for (name, bytes) in laboratory.made(&to) {
            assert!(expected[&name] == bytes, "{name}");
        }
        let (_, err) = said(&words, 0);
        assert!(told(&err).len() < 4, "{err}");
        assert!(laboratory.made(&to) == expected);
        assert!(!laboratory.path(&format!("{to}/.part")).exists());
    }
}

/// Processes of this machine that were started with `word` in their words.
#[cfg(target_os = "linux")]
fn started_with(word: &str) -> Vec<String> {
    let processes = fs::read_dir("/proc").expect("a folder").filter_map(Result::ok);
    let lines = processes.filter_map(|p| fs::read(p.path().join("cmdline")).ok());
    let lines = lines.map(|line| String::from_utf8_lossy(&line).replace('\0', " "));
    lines.filter(|line| line.contains(word)).collect()
}

#[cfg(target_os = "linux")]
#[test]
fn fits_of_a_batch_that_was_killed_end() {
    let laboratory = Laboratory::new(1);
    let (measured, folder) = (laboratory.text("many"), laboratory.text("orphans"));
    // Some ten seconds of a fit.
    said(&["simulate", "brushed-metal", "-o", &measured], 0);
    let manifest = laboratory.text("slow.toml");
    let text = "[[material]]\nname = \"slow\"\nmeasurements = [\"many\"]\n";
    fs::write(&manifest, text).expect("written");
    let mut line = command(&["batch", &manifest, "-o", &folder, "--jobs", "1"]);
    let mut process = line.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("it starts");
    wait_for(&laboratory.path("orphans/.part/slow/slow.log"), &mut process);
    let part = laboratory.text("orphans/.part");
    let wait = |wanted: bool| {
        let start = std::time::Instant::now();
        while started_with(&part).is_empty() == wanted {
            assert!(start.elapsed().as_secs() < 60, "{:?}", started_with(&part));
            std::thread::sleep(Duration::from_millis(5));
        }
        start.elapsed()
    };
    wait(true);
    process.kill().expect("killed");
    process.wait().expect("ended");
    let took = wait(false);
    assert!(took < Duration::from_secs(2), "the fit went on for {took:?}");
}

#[cfg(unix)]
#[test]
fn who_is_asked_to_end_says_that_it_can_go_on() {
    let laboratory = Laboratory::new(4);
    let manifest = laboratory.manifest(4);
    let folder = laboratory.text("stopped");
    let words = ["batch", &manifest, "-o", &folder, "--jobs", "1"];
    let mut line = command(&words);
    let mut process =
        line.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
    wait_for(&laboratory.path("stopped/m0/.batch.json"), &mut process);
    wait_for(&laboratory.path("stopped/.part/m1/m1.log"), &mut process);
    let signal = Command::new("kill").args(["-INT", &process.id().to_string()]).status();
    assert!(signal.expect("kill").success());
    let output = process.wait_with_output().expect("it ends");
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{text}");
    assert!(text.contains("the same command goes on"), "{text}");
    assert!(String::from_utf8_lossy(&output.stdout).contains("0 failed"));
    assert!(laboratory.path("stopped/summary.html").exists());
    assert!(told(&said(&words, 0).1).len() < 4);
    assert_eq!(laboratory.made("stopped").len(), 8);
}

#[test]
fn manifests_that_are_wrong_start_nothing() {
    let laboratory = Laboratory::new(1);
    let one = "[[material]]\nname = \"a\"\nmeasurements = \"measured/0\"\n";
    let cases = [
        ("", "expected at least one material, found none"),
        (
            "[[material]]\nname = \"a\"\n",
            "line 1: a: measurements: expected files or folders, found none",
        ),
        (
            "[[material]]\nmeasurements = \"measured/0\"\n",
            "line 1: name: expected a text, found none",
        ),
        (
            "[[material]]\nname = \"../a\"\nmeasurements = \"measured/0\"\n",
            "line 2: name: expected letters",
        ),
        (
            "[[material]]\nname = \"a\"\nmeasurements = \"none/*.txt\"\n",
            "line 3: a: measurements: ",
        ),
        ("[[material]]\nname = \"a\"\nmeasurements = \"measured/1\"\n", "found nothing"),
        (
            &format!("{one}\n{one}")
                .replace("\n\n[[material]]\nname = \"a\"", "\n\n[[material]]\nname = \"A\""),
            "line 5: name: expected a name of its own, found \"A\", as on line 1",
        ),
        (
            &format!("{one}symetry = \"none\"\n"),
            "line 4: expected a key of name, measurements, outputs, title",
        ),
        (&format!("{one}symmetry = \"round\"\n"), "line 4: a: symmetry: "),
        (&format!("{one}max_leaves = \"many\"\n"), "line 4: a: max_leaves: "),
        (
            &format!("{one}reversed = 3\n"),
            "line 4: a: reversed: expected true or false, found \"3\"",
        ),
        (
            &format!("{one}outputs = [\"obj\"]\n"),
            "line 4: a: outputs: expected a form (tensor-tree",
        ),
        (&format!("{one}outputs = []\n"), "line 4: a: outputs: expected at least one"),
        (
            &format!("{one}outputs = [\"window\", \"window\"]\n"),
            "expected each file once, found \"window\" again",
        ),
        (&format!("{one}licence = \"mine\"\n"), "line 4: a: record: licence: expected an SPDX"),
        (&format!("{one}signature = \"none.csv\"\n"), "line 4: a: signature: "),
        (
            &format!("{one}aperture = 1\nsignature = \"measured/0/points.csv\"\n"),
            "a: cannot stand beside",
        ),
        (&format!("[defaults]\nname = \"x\"\n{one}"), "line 2: expected a key of outputs, title"),
        ("[[material]\n", "line 1: "),
    ];
    for (k, (text, words)) in cases.iter().enumerate() {
        laboratory.write("bad.toml", text);
        let output =
            bsdf(&["batch", &laboratory.text("bad.toml"), "-o", &laboratory.text("never")]);
        let err = String::from_utf8_lossy(&output.stderr);
        assert!(matches!(output.status.code(), Some(2..=5)), "{k}: {text}: {err}");
        assert!(err.contains(words) && err.contains("bad.toml"), "{k}: {text}: {err}");
        assert!(!laboratory.path("never").exists(), "{k}");
    }
    let bad = "name,measurements,symmetry\na,measured/0,round\nb,measured/0\n";
    laboratory.write("bad.csv", bad);
    let (_, err) =
        said(&["batch", &laboratory.text("bad.csv"), "-o", &laboratory.text("never")], 4);
    assert!(err.contains("line 3: expected 3 cells, as the head has, found 2"), "{err}");
    let manifest = laboratory.text("bad.txt");
    fs::write(&manifest, one).expect("written");
    let (_, err) = said(&["batch", &manifest, "-o", &laboratory.text("never")], 2);
    assert!(err.contains("named .toml or .csv"), "{err}");
}

#[test]
fn a_scheduler_needs_the_python_package_and_says_so() {
    let laboratory = Laboratory::new(1);
    let manifest = laboratory.manifest(1);
    let to = laboratory.text("never");
    let mut line = command(&["batch", &manifest, "-o", &to, "--scheduler", "tcp://127.0.0.1:1"]);
    let output = line.env("BSDFKIT_PYTHON", "no-such-interpreter").output().expect("it starts");
    let err = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{err}");
    assert!(err.contains("[dask]") && err.contains("BSDFKIT_PYTHON"), "{err}");
}
