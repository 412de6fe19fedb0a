//! What other layouts of a rank-4 tree would cost: bytes, cache lines and nanoseconds a look-up.
//!
//! ```text
//! bench_layout FILE        a compiled tree of rank 4, such as build/query/tree6.safetensors of `make bench-query`
//! ```
//!
//! Every layout holds the same values (f16: rounded) and answers the same random keys, four bits a level; the
//! arithmetic from directions to keys is left out, as it is the same for all. Look-ups begin at the root,
//! without the library's table of the first levels. "Abreast" are 64 at a time, a level of all after the
//! other, as batches go. Each figure is the best of nine runs; `DESIGN.md` says what came of it.

mod layouts;

use std::hint::black_box;
use std::time::Instant;

use bsdfkit::tree::TreeDistribution;
use bsdfkit::{Error, Result, container};
use half::f16;

use crate::layouts::{BRANCH, Inline, Layout, Tree};

const KEYS: usize = 1 << 20;
const ABREAST: usize = 64;
/// Bytes of a line of the cache.
const LINE: usize = 64;

fn look_up(layout: &impl Layout, key: u32, mut read: impl FnMut(usize)) -> f32 {
    let mut at = layout.root();
    for step in 0..layout.steps() {
        if at & BRANCH == 0 {
            break;
        }
        at = layout.step(at, key, step, &mut read);
    }
    layout.value(at, read)
}

fn best(mut run: impl FnMut()) -> f64 {
    let once = |_| {
        let start = Instant::now();
        run();
        start.elapsed().as_nanos() as f64 / KEYS as f64
    };
    (0..9).map(once).fold(f64::INFINITY, f64::min)
}

/// One line of the table; `expected` are the values of the layout as it is.
fn measure(name: &str, layout: &impl Layout, keys: &[u32], expected: &[f32]) {
    let mut lines = 0;
    for (key, expected) in keys.iter().zip(expected) {
        let mut last = usize::MAX;
        let found = look_up(layout, *key, |address| {
            lines += usize::from(address / LINE != last);
            last = address / LINE;
        });
        let off = (found - expected).abs();
        assert!(off <= 5e-4 * expected + 1e-7, "{name}: {found} for {expected}");
    }
    let alone = best(|| {
        let mut sum = 0;
        for key in keys {
            // No value has the highest bit: the next waits for it, and is the same.
            sum = look_up(layout, key ^ (sum >> 31), |_| ()).to_bits();
        }
        black_box(sum);
    });
    let mut out = vec![0.0; keys.len()];
    let abreast = best(|| {
        for (keys, out) in keys.chunks_exact(ABREAST).zip(out.chunks_exact_mut(ABREAST)) {
            let mut at = [layout.root(); ABREAST];
            for step in 0..layout.steps() {
                for (at, key) in at.iter_mut().zip(keys) {
                    if *at & BRANCH != 0 {
                        *at = layout.step(*at, *key, step, |_| ());
                    }
                }
            }
            for (out, at) in out.iter_mut().zip(at) {
                *out = layout.value(at, |_| ());
            }
        }
    });
    black_box(&out);
    let (megabytes, lines) = (layout.bytes() as f64 / 1e6, lines as f64 / keys.len() as f64);
    println!(
        "{name:44} {megabytes:7.2} MB {lines:6.2} lines {alone:7.1} ns {abreast:7.1} ns abreast"
    );
}

/// What a sample does a level: it adds up the scattered quadrants of one incident part of a branch, which
/// are slots `first · part + step · n` of it.
fn measure_quadrants(name: &str, slots: &[u32], keys: &[u32], first: usize, step: usize) {
    let nodes = slots.as_chunks::<16>().0;
    let mut out = vec![0.0; keys.len()];
    let taken = best(|| {
        for (key, out) in keys.iter().zip(&mut out) {
            let node = &nodes[((u64::from(*key) * nodes.len() as u64) >> 32) as usize];
            let part = first * (key & 3) as usize;
            let value = |n: usize| f32::from_bits(node[(part + step * n) & 15] & !BRANCH);
            *out = value(0) + value(1) + value(2) + value(3);
        }
    });
    black_box(&out);
    println!("{name:44} {:28} {taken:7.1} ns abreast", "");
}

fn main() -> Result<()> {
    let file = std::env::args().nth(1);
    let file = file.ok_or_else(|| Error::argument("expected: bench_layout FILE"))?;
    let bsdf = container::load(file)?;
    let tree = bsdf.components().first().and_then(|c| c.distribution().downcast_ref());
    let tree = tree.map(TreeDistribution::luminance).filter(|t| t.root_slot() & BRANCH != 0);
    let Some(tree) = tree.filter(|t| t.rank().dimensions() == 4) else {
        return Err(Error::argument("expected a tree of rank 4 with branches"));
    };
    let tree = Tree { slots: tree.slots(), root: tree.root_slot(), depth: tree.depth() };
    let mut state = 1_u64;
    let keys = (0..KEYS).map(|_| {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 32) as u32
    });
    let keys: Vec<u32> = keys.collect();
    let stored = Inline::<4> { slots: tree.slots.to_vec(), root: tree.root, depth: tree.depth };
    let expected: Vec<f32> = keys.iter().map(|key| look_up(&stored, *key, |_| ())).collect();
    measure("16 slots of 4 bytes, depth first (as stored)", &stored, &keys, &expected);
    let by_level = tree.by_level();
    measure("the same, level by level", &tree.placed(&by_level), &keys, &expected);
    let mut shuffled = by_level;
    for n in (1..shuffled.len()).rev() {
        shuffled.swap(n, keys[n % KEYS] as usize % (n + 1));
    }
    measure("the same, in any order", &tree.placed(&shuffled), &keys, &expected);
    measure("the same, identical subtrees shared", &tree.shared(), &keys, &expected);
    measure("the same, branches of 16 leaves in f16", &tree.blocks(), &keys, &expected);
    measure("4 slots: incident, then scattered quadrant", &tree.split::<2>(), &keys, &expected);
    measure("2 slots: one dimension after the other", &tree.split::<1>(), &keys, &expected);
    measure("branches with masks, leaves apart in f32", &tree.apart::<f32>(), &keys, &expected);
    measure("branches with masks, leaves apart in f16", &tree.apart::<f16>(), &keys, &expected);
    measure_quadrants("four quadrants side by side (as stored)", tree.slots, &keys, 4, 1);
    measure_quadrants("four quadrants by rows of the text", tree.slots, &keys, 1, 4);
    Ok(())
}
