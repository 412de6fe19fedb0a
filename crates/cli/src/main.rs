//! The command `bsdf`.
fn main() {}
