//! Verbs that the Python package does: what is handed over, and what is said where it is not there.

#![cfg(unix)]

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Command, Output};

fn bsdf(python: &Path, words: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_bsdf"));
    command.env("BSDFKIT_PYTHON", python).args(words).output().unwrap()
}

/// A program that stands for an interpreter which lacks the packages `missing`.
fn interpreter(folder: &Path, missing: &str) -> std::path::PathBuf {
    let path = folder.join("python");
    let script = format!(
        "#!/bin/sh\nif [ \"$1\" = -c ]; then echo {missing}; exit; fi\nfor w in \"$@\"; do echo \"<$w>\"; done\n\
         [ -x \"$BSDFKIT_COMMAND\" ] && exit 4\n"
    );
    fs::write(&path, script).unwrap();
    fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
    path
}

#[test]
fn other_kinds_and_reports_are_handed_over_as_they_are() {
    let folder = tempfile::tempdir().unwrap();
    let python = interpreter(folder.path(), "");
    for (words, module) in [
        (["plot", "a b.xml", "--kind", "lobe", "--incident", "-3,x", "-h"], "bsdfkit.plot"),
        (["report", "a b.xml", "--kind", "lobe", "--incident", "-3,x", "-h"], "bsdfkit._report"),
    ] {
        let ran = bsdf(&python, &words);
        let printed = String::from_utf8(ran.stdout).unwrap();
        let expected =
            format!("<-m>\n<{module}>\n<a b.xml>\n<--kind>\n<lobe>\n<--incident>\n<-3,x>\n<-h>\n");
        assert_eq!(printed, expected);
        // Its status is ours, and it is told where we are.
        assert_eq!(ran.status.code(), Some(4));
    }
}

#[test]
fn what_is_missing_is_said_with_what_to_install() {
    let folder = tempfile::tempdir().unwrap();
    let lacking = interpreter(folder.path(), "matplotlib bsdfkit");
    for (python, words) in [
        (lacking.as_path(), "lacks matplotlib and bsdfkit"),
        (Path::new("/no/such/python"), "could not run /no/such/python"),
    ] {
        for verb in ["plot", "report"] {
            let ran = bsdf(python, &[verb, "a.xml", "--kind", "slice", "-o", "a.png"]);
            let said = String::from_utf8(ran.stderr).unwrap();
            assert_eq!(ran.status.code(), Some(2), "{said}");
            assert!(said.contains(words) && said.contains("pip install"), "{said}");
            assert!(said.contains("BSDFKIT_PYTHON"), "{said}");
        }
    }
}

#[test]
fn panels_need_no_python() {
    let ran = bsdf(Path::new("/no/such/python"), &["plot", "--help"]);
    let said = String::from_utf8(ran.stdout).unwrap();
    assert!(ran.status.success() && said.contains("--measurements"), "{said}");
    let ran = bsdf(
        Path::new("/no/such/python"),
        &["plot", "missing.xml", "--incident", "3,0", "-o", "a.png"],
    );
    assert_eq!(ran.status.code(), Some(3));
}
