//! Each target over its corpus, and over damaged copies of it: what `make fuzz` does for hours, in seconds.

use std::panic::{AssertUnwindSafe, catch_unwind};

use bsdfkit_fuzz::mutate::{Random, damaged};
use bsdfkit_fuzz::{TARGETS, Target, corpus};

/// Runs a target; where it panics, keeps what broke it for libFuzzer to run again.
fn run(target: &Target, what: &str, bytes: &[u8]) {
    let result = catch_unwind(AssertUnwindSafe(|| (target.run)(bytes)));
    if result.is_err() {
        let kept = std::env::temp_dir().join(format!("bsdfkit-fuzz-{}", target.name));
        std::fs::write(&kept, bytes).expect("a folder for files");
        panic!("{}: {what}; the bytes are in {}", target.name, kept.display());
    }
}

/// Copies a target.
fn copies(target: &Target) -> usize {
    match std::env::var("BSDFKIT_FUZZ_COPIES") {
        Ok(count) => count.parse().expect("BSDFKIT_FUZZ_COPIES is a number"),
        Err(_) => match target.name {
            "container" | "tables" | "c_abi" => 400,
            "container_parts" => 1000,
            _ => 3000,
        },
    }
}

fn short(name: &str) {
    let target = TARGETS.iter().find(|t| t.name == name).expect("a target of that name");
    let files: Vec<_> =
        corpus::files(name).into_iter().map(|p| (std::fs::read(&p).unwrap(), p)).collect();
    assert!(!files.is_empty(), "{name}: no corpus");
    for (bytes, path) in &files {
        run(target, &path.display().to_string(), bytes);
    }
    let mut random = Random(20);
    for k in 0..copies(target) {
        let (bytes, path) = &files[k % files.len()];
        let other = &files[random.bits() as usize % files.len()].0;
        let copy = damaged(bytes, other, &mut random);
        run(target, &format!("copy {k}, of {}", path.display()), &copy);
    }
}

macro_rules! short {
    ($($name:ident)*) => {$(
        #[test]
        fn $name() {
            short(stringify!($name));
        }
    )*};
}

short! { measurement tables xml xml_parts container container_parts sir record c_abi }
