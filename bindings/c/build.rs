//! Reads the ABI's number from the header, and gives the shared library a name that says it.

fn main() {
    let header = "include/bsdfkit.h";
    println!("cargo::rerun-if-changed={header}");
    let text = std::fs::read_to_string(header).expect("the header is part of the package");
    let abi = text
        .lines()
        .find_map(|line| line.strip_prefix("#define BSDFKIT_ABI_VERSION "))
        .expect("the header defines BSDFKIT_ABI_VERSION");
    println!("cargo::rustc-env=BSDFKIT_ABI_VERSION={abi}");
    match std::env::var("CARGO_CFG_TARGET_OS").as_deref() {
        Ok("linux" | "android" | "freebsd") => {
            println!("cargo::rustc-cdylib-link-arg=-Wl,-soname,libbsdfkit.so.{abi}");
        }
        Ok("macos") => {
            let name = format!("@rpath/libbsdfkit.{abi}.dylib");
            println!("cargo::rustc-cdylib-link-arg=-Wl,-install_name,{name}");
        }
        _ => {}
    }
}
