//! Puts the viewer's page into the crate where `make viewer` has built one.

use std::path::Path;

fn main() {
    let folder =
        Path::new(&std::env::var("CARGO_MANIFEST_DIR").expect("set by cargo")).join("page");
    let page = folder.join("viewer.html");
    println!("cargo::rerun-if-changed={}", folder.display());
    println!("cargo::rustc-check-cfg=cfg(page)");
    if page.is_file() {
        println!("cargo::rustc-cfg=page");
        println!("cargo::rustc-env=BSDFKIT_VIEWER_PAGE={}", page.display());
    }
}
