//! Runs a target on files, and says how long each takes: `cargo run --release -p bsdfkit-fuzz --example replay -- TARGET
//! FILE ...`; without files on damaged copies of the corpus, as the test does.

use std::time::Instant;

use bsdfkit_fuzz::mutate::{Random, damaged};
use bsdfkit_fuzz::{TARGETS, corpus};

fn main() {
    let mut words = std::env::args().skip(1);
    let name = words.next().unwrap_or_default();
    let target = TARGETS.iter().find(|t| t.name == name).expect("the name of a target");
    let files: Vec<String> = words.collect();
    if !files.is_empty() {
        for file in files {
            let bytes = std::fs::read(&file).expect("a file");
            let start = Instant::now();
            (target.run)(&bytes);
            println!("{file}: {:.3} s", start.elapsed().as_secs_f64());
        }
        return;
    }
    let corpus: Vec<_> = corpus::files(&name).iter().map(|p| std::fs::read(p).unwrap()).collect();
    let mut random = Random(std::env::var("SEED").map_or(21, |s| s.parse().expect("a number")));
    let (mut total, mut worst) = (0.0, 0.0);
    for k in 0.. {
        let bytes = &corpus[k % corpus.len()];
        let other = &corpus[random.bits() as usize % corpus.len()];
        let copy = damaged(bytes, other, &mut random);
        std::fs::write(format!("/tmp/replay-{name}"), &copy).unwrap();
        let start = Instant::now();
        (target.run)(&copy);
        let seconds = start.elapsed().as_secs_f64();
        total += seconds;
        if seconds > worst {
            worst = seconds;
            println!("{k}: {seconds:.3} s, {} bytes; in all {total:.1} s", copy.len());
            std::fs::write(format!("/tmp/replay-{name}-worst"), &copy).unwrap();
        }
    }
}
