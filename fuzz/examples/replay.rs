//! Runs a target on files, and says how long each takes: `cargo run --release -p bsdfkit-fuzz --example replay -- TARGET
//! FILE ...`.

use std::time::Instant;

use bsdfkit_fuzz::TARGETS;

fn main() {
    let mut words = std::env::args().skip(1);
    let name = words.next().unwrap_or_default();
    let target = TARGETS.iter().find(|t| t.name == name).expect("the name of a target");
    for file in words {
        let bytes = std::fs::read(&file).expect("a file");
        let start = Instant::now();
        (target.run)(&bytes);
        println!("{file}: {:.3} s", start.elapsed().as_secs_f64());
    }
}
