//! What the build script of the C library tells its sources.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-env=BSDFKIT_ABI_VERSION=1");
}
