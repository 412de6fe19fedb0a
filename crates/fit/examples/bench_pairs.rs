//! What one value of an interpolant costs at random pairs of directions, on one core.
//!
//!     bsdf simulate brushed-metal -o measured && bsdf fit measured -o brushed-metal.safetensors
//!     cargo run --release -p bsdfkit-fit --example bench_pairs -- [--against OLD] FILE.safetensors ...
//!
//! `OLD`: this example built from another commit. It is run in turn with this one on each file, and the values of both
//! are compared: printed are the time of either, in µs a value, and by how much the values differ at most, relative to
//! themselves and to a ten-thousandth of their mean.
//!
//! Pairs are uniform in projected solid angle, independent of each other, so that nothing is asked twice of one incident direction.
//! Of each twenty pairs the fastest of nine runs counts, so that a machine which does other things, too, tells the same.

use std::io::{Read, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

use bsdfkit::{Bsdf, DVec2, DVec3, Side};
use bsdfkit_fit::interpolant::Interpolant;
use bsdfkit_represent::Source;
use bsdfkit_simulate::random::Random;
use bsdfkit_sphere::concentric::square_to_hemisphere;

const PAIRS: usize = 6_000;
const BLOCK: usize = 20;
const RUNS: usize = 9;
/// Its words ask for numbers in binary on the standard output instead of a table.
const RAW: &str = "--raw";

fn main() {
    let mut words: Vec<String> = std::env::args().skip(1).collect();
    if words.first().is_some_and(|w| w == RAW) {
        let (micro, values) = measured(Path::new(&words[1]));
        let mut out = std::io::stdout().lock();
        for number in std::iter::once(micro).chain(values) {
            out.write_all(&number.to_le_bytes()).expect("written");
        }
        return;
    }
    let old = (words.first().is_some_and(|w| w == "--against")).then(|| {
        words.remove(0);
        words.remove(0)
    });
    println!("{:<32} {:>8} {:>8} {:>8} {:>10}", "", "before", "now", "times", "difference");
    let mut times = Vec::new();
    for file in &words {
        let name = Path::new(file).file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let before = old.as_ref().map(|old| raw(old, file));
        let (micro, values) = measured(Path::new(file));
        let Some((old, others)) = before else {
            println!("{name:<32} {:>8} {micro:>8.2}", "");
            continue;
        };
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let off = |(a, b): (&f64, &f64)| (a - b).abs() / (b.abs() + 1e-4 * mean);
        let off = values.iter().zip(&others).map(off).fold(0.0, f64::max);
        times.push(old / micro);
        println!("{name:<32} {old:>8.2} {micro:>8.2} {:>8.1} {off:>10.1e}", old / micro);
    }
    if !times.is_empty() {
        let mean = times.iter().map(|t: &f64| t.ln()).sum::<f64>() / times.len() as f64;
        println!("{:<32} {:>26.1}", "geometric mean", mean.exp());
    }
}

/// What another build of this says of a file.
fn raw(program: &str, file: &str) -> (f64, Vec<f64>) {
    let child = Command::new(program).args([RAW, file]).stdout(Stdio::piped()).spawn();
    let mut bytes = Vec::new();
    let mut child = child.expect("the other build runs");
    child.stdout.take().expect("piped").read_to_end(&mut bytes).expect("read");
    assert!(child.wait().expect("ended").success(), "{program} {RAW} {file}");
    let mut numbers = bytes.chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().expect("8")));
    (numbers.next().expect("a time"), numbers.collect())
}

/// µs a value, and the values.
fn measured(file: &Path) -> (f64, Vec<f64>) {
    let interpolant = Interpolant::open(file).expect("an interpolant");
    let bsdf = interpolant.bsdf();
    let mut random = Random::new(7);
    let mut direction =
        |side: Side| square_to_hemisphere(DVec2::new(random.unit(), random.unit()), side);
    let sides: Vec<(Side, Side)> =
        interpolant.components.iter().map(|p| (p.incident(), p.scattered())).collect();
    let pairs: Vec<(DVec3, DVec3)> = (0..PAIRS)
        .map(|k| sides[k % sides.len()])
        .map(|(from, to)| (direction(from), direction(to)))
        .collect();
    let mut values = vec![0.0; pairs.len()];
    let mut fastest = vec![f64::INFINITY; PAIRS / BLOCK];
    for _ in 0..RUNS {
        let blocks = values.chunks_mut(BLOCK).zip(pairs.chunks(BLOCK));
        for (fastest, (values, pairs)) in fastest.iter_mut().zip(blocks) {
            *fastest = timed(&bsdf, pairs, values).min(*fastest);
        }
    }
    (fastest.iter().sum::<f64>() / fastest.len() as f64, values)
}

/// µs a value.
fn timed(bsdf: &Bsdf, pairs: &[(DVec3, DVec3)], values: &mut [f64]) -> f64 {
    let start = Instant::now();
    for (value, (wi, wo)) in values.iter_mut().zip(pairs) {
        *value = bsdf.eval(*wi, *wo);
    }
    start.elapsed().as_secs_f64() * 1e6 / pairs.len() as f64
}
