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

use std::collections::HashMap;
use std::hint::black_box;
use std::time::Instant;

use bsdfkit::tree::TreeDistribution;
use bsdfkit::{Error, Result, container};
use half::f16;

const KEYS: usize = 1 << 20;
const ABREAST: usize = 64;
const BRANCH: u32 = 1 << 31;
/// Bytes of a line of the cache.
const LINE: usize = 64;

/// A layout. `at` is a slot: a leaf without its highest bit, else what the layout makes of it.
trait Layout {
    /// Steps from the root to the deepest leaf.
    fn steps(&self) -> u32;
    fn root(&self) -> u32;
    /// The slot below a branch, for step number `step`; tells the address that it reads.
    fn step(&self, at: u32, key: u32, step: u32, read: impl FnMut(usize)) -> u32;
    /// The value of a leaf's slot.
    fn value(&self, at: u32, read: impl FnMut(usize)) -> f32;
    fn bytes(&self) -> usize;
}

fn address<T>(element: &T) -> usize {
    std::ptr::from_ref(element) as usize
}

/// The four bits of a level: incident y, x, scattered y, x.
fn part(key: u32, level: u32) -> usize {
    (key >> (4 * (7 - level)) & 15) as usize
}

/// 2^BITS children a branch, inline: a slot is a branch's number or a value's bits.
struct Inline<const BITS: u32> {
    slots: Vec<u32>,
    root: u32,
    depth: u32,
}

impl<const BITS: u32> Layout for Inline<BITS> {
    fn steps(&self) -> u32 {
        self.depth * 4 / BITS
    }
    fn root(&self) -> u32 {
        self.root
    }
    fn step(&self, at: u32, key: u32, step: u32, mut read: impl FnMut(usize)) -> u32 {
        let child = key >> (32 - BITS * (step + 1)) & ((1 << BITS) - 1);
        let slot = &self.slots[(at << BITS | child) as usize];
        read(address(slot));
        *slot
    }
    fn value(&self, at: u32, _: impl FnMut(usize)) -> f32 {
        f32::from_bits(at)
    }
    fn bytes(&self) -> usize {
        4 * self.slots.len()
    }
}

/// A value of a leaf in an array.
trait Stored: Copy {
    fn of(value: f32) -> Self;
    fn get(self) -> f32;
}

impl Stored for f32 {
    fn of(value: f32) -> Self {
        value
    }
    fn get(self) -> f32 {
        self
    }
}

impl Stored for f16 {
    fn of(value: f32) -> Self {
        Self::from_f32(value)
    }
    fn get(self) -> f32 {
        self.to_f32()
    }
}

/// Branches and leaves apart: a branch says which of its children are branches; both lie side by side.
#[derive(Clone, Copy, Default)]
struct Masked {
    branches: u32,
    leaves: u32,
    mask: u16,
}

struct Apart<T> {
    nodes: Vec<Masked>,
    leaves: Vec<T>,
    depth: u32,
}

impl<T: Stored> Layout for Apart<T> {
    fn steps(&self) -> u32 {
        self.depth
    }
    fn root(&self) -> u32 {
        BRANCH
    }
    fn step(&self, at: u32, key: u32, step: u32, mut read: impl FnMut(usize)) -> u32 {
        let node = &self.nodes[(at ^ BRANCH) as usize];
        read(address(node));
        let child = part(key, step);
        let before = node.mask & ((1 << child) - 1);
        if node.mask >> child & 1 == 1 {
            BRANCH | (node.branches + before.count_ones())
        } else {
            node.leaves + child as u32 - before.count_ones()
        }
    }
    fn value(&self, at: u32, mut read: impl FnMut(usize)) -> f32 {
        let leaf = &self.leaves[at as usize];
        read(address(leaf));
        leaf.get()
    }
    fn bytes(&self) -> usize {
        size_of_val(&*self.nodes) + size_of_val(&*self.leaves)
    }
}

/// As [`Inline`], but a branch of 16 leaves is a block of their values in f16: half a line.
struct Blocks {
    slots: Vec<u32>,
    blocks: Vec<[f16; 16]>,
    depth: u32,
}

/// Marks a slot that holds the number of a block.
const BLOCK: u32 = BRANCH | 1 << 30;

impl Layout for Blocks {
    fn steps(&self) -> u32 {
        self.depth
    }
    fn root(&self) -> u32 {
        BRANCH
    }
    fn step(&self, at: u32, key: u32, step: u32, mut read: impl FnMut(usize)) -> u32 {
        let child = part(key, step);
        if at & BLOCK == BLOCK {
            let leaf = &self.blocks[(at ^ BLOCK) as usize][child];
            read(address(leaf));
            return leaf.to_f32().to_bits();
        }
        let slot = &self.slots[((at ^ BRANCH) << 4) as usize | child];
        read(address(slot));
        *slot
    }
    fn value(&self, at: u32, _: impl FnMut(usize)) -> f32 {
        f32::from_bits(at)
    }
    fn bytes(&self) -> usize {
        4 * self.slots.len() + size_of_val(&*self.blocks)
    }
}

/// The tree as the library stores it.
struct Tree<'a> {
    slots: &'a [u32],
    root: u32,
    depth: u32,
}

impl Tree<'_> {
    fn children(&self, branch: u32) -> &[u32] {
        &self.slots[((branch ^ BRANCH) as usize) << 4..][..16]
    }

    /// Branches, level by level.
    fn by_level(&self) -> Vec<u32> {
        let (mut order, mut first) = (vec![self.root], 0);
        while first < order.len() {
            let below = self.children(order[first]).iter().filter(|s| **s & BRANCH != 0);
            let below: Vec<u32> = below.copied().collect();
            order.extend(below);
            first += 1;
        }
        order
    }

    /// Branches renumbered in the given order.
    fn placed(&self, order: &[u32]) -> Inline<4> {
        let place: HashMap<u32, u32> =
            order.iter().enumerate().map(|(n, b)| (*b, n as u32 | BRANCH)).collect();
        let moved = |s: &u32| if s & BRANCH == 0 { *s } else { place[s] };
        let slots = order.iter().flat_map(|b| self.children(*b)).map(moved).collect();
        Inline { slots, root: place[&self.root], depth: self.depth }
    }

    /// Every subtree that occurs again is stored once.
    fn shared(&self) -> Inline<4> {
        let (mut known, mut slots, mut place) = (HashMap::new(), Vec::new(), HashMap::new());
        for branch in self.by_level().into_iter().rev() {
            let moved = |s: &u32| if s & BRANCH == 0 { *s } else { place[s] };
            let node: Vec<u32> = self.children(branch).iter().map(moved).collect();
            let next = slots.len() as u32 >> 4 | BRANCH;
            let found = *known.entry(node.clone()).or_insert(next);
            if found == next {
                slots.extend(node);
            }
            place.insert(branch, found);
        }
        Inline { slots, root: place[&self.root], depth: self.depth }
    }

    /// Each branch as a tree of branches of 2^BITS; equal leaves side by side become one.
    fn split<const BITS: u32>(&self) -> Inline<BITS> {
        let mut made = Inline { slots: Vec::new(), root: BRANCH, depth: self.depth };
        let root = self.split_into(&mut made, self.root, 0, 4);
        Inline { root, ..made }
    }

    /// Children from number `from` on, 2^bits of them, of a branch: the slot that leads to them.
    fn split_into<const B: u32>(&self, to: &mut Inline<B>, at: u32, from: u32, bits: u32) -> u32 {
        if at & BRANCH == 0 {
            return at;
        }
        if bits == 0 {
            let child = self.children(at)[from as usize];
            return self.split_into(to, child, 0, if child & BRANCH == 0 { 0 } else { 4 });
        }
        let place = to.slots.len();
        to.slots.resize(place + (1 << B), 0);
        for child in 0..1 << B {
            let below = self.split_into(to, at, from + (child << (bits - B)), bits - B);
            to.slots[place + child as usize] = below;
        }
        let first = to.slots[place];
        if first & BRANCH == 0 && to.slots[place..].iter().all(|s| *s == first) {
            to.slots.truncate(place);
            return first;
        }
        place as u32 >> B | BRANCH
    }

    fn blocks(&self) -> Blocks {
        let is_block = |b: u32| self.children(b).iter().all(|s| s & BRANCH == 0);
        let (mut inner, mut blocks, mut place) = (Vec::new(), Vec::new(), HashMap::new());
        for branch in self.by_level() {
            if is_block(branch) && branch != self.root {
                place.insert(branch, blocks.len() as u32 | BLOCK);
                let value = |k: usize| f16::from_f32(f32::from_bits(self.children(branch)[k]));
                blocks.push(std::array::from_fn(value));
            } else {
                place.insert(branch, inner.len() as u32 | BRANCH);
                inner.push(branch);
            }
        }
        let moved = |s: &u32| if s & BRANCH == 0 { *s } else { place[s] };
        let slots = inner.iter().flat_map(|b| self.children(*b)).map(moved).collect();
        Blocks { slots, blocks, depth: self.depth }
    }

    fn apart<T: Stored>(&self) -> Apart<T> {
        let (mut nodes, mut leaves, mut branches) = (Vec::new(), Vec::new(), 1);
        for branch in self.by_level() {
            let mut node = Masked { branches, leaves: leaves.len() as u32, mask: 0 };
            for (child, slot) in self.children(branch).iter().enumerate() {
                if slot & BRANCH == 0 {
                    leaves.push(T::of(f32::from_bits(*slot)));
                } else {
                    node.mask |= 1 << child;
                    branches += 1;
                }
            }
            nodes.push(node);
        }
        Apart { nodes, leaves, depth: self.depth }
    }
}

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
