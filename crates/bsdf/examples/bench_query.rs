//! What queries cost: the half of `benches/query.py` that runs this library.
//!
//! ```text
//! bench_query make FOLDER            tree6.xml, tree3.xml, through6.xml, klems.xml, directions.f64
//! bench_query run FILE DIRECTIONS    one line of JSON a figure
//! bench_query floor FILE DIRECTIONS  the same: a tree's look-ups beside a chase of pointers
//! bench_query threads FILE DIRECTIONS the same: 1, 2 and 4 threads on one handle
//! ```
//!
//! `DIRECTIONS` holds pairs (wi, wo) of unit vectors as f64. `run` takes one thread unless
//! `RAYON_NUM_THREADS` says otherwise; each figure is the best of five runs over all pairs, or of
//! as many as half a second holds.

use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use bsdfkit::matrix::{KlemsBasis, KlemsMatrix};
use bsdfkit::tree::{Rank, TensorTree, TreeBuilder, TreeDistribution};
use bsdfkit::{
    Bsdf, Component, Components, DVec2, DVec3, Lambertian, Lookup, Metadata, Result, Side,
};
use bsdfkit::{container, xml};
use bsdfkit_sphere::concentric::square_to_hemisphere;

/// Pairs of directions: more than any cache holds.
const PAIRS: usize = 1 << 20;
/// Cells a dimension, 2^LOG2; of the isotropic tree, 2^ISOTROPIC_LOG2.
const LOG2: u32 = 6;
const ISOTROPIC_LOG2: u32 = 8;

/// SplitMix64. [Steele, Lea, Flood 2014]
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Uniform in projected solid angle, on the front.
    fn direction(&mut self) -> DVec3 {
        let square = DVec2::new(self.unit(), self.unit());
        square_to_hemisphere(square, Side::Front)
    }
}

/// A glossy anisotropic lobe about the mirror direction, over a broad one.
fn glossy(wi: DVec3, wo: DVec3) -> f32 {
    let h = (wi + wo).normalize();
    let slope = DVec2::new(h.x / 0.13, h.y / 0.22) / h.z;
    (1.2 * (-slope.length_squared()).exp() + 0.08 * h.z.powi(8) + 0.02) as f32
}

/// A cell that is one leaf, or 2^rank cells.
enum Cell {
    Leaf(f32),
    Branch(Vec<Cell>),
}

/// The tree of a function of finest cells (one number a dimension, the first `rank` of which count).
fn grow(
    value: &impl Fn([usize; 4]) -> f32,
    rank: Rank,
    log2: u32,
    level: u32,
    corner: [usize; 4],
) -> Cell {
    if level == log2 {
        return Cell::Leaf(value(corner));
    }
    let width = 1 << (log2 - level - 1);
    let children: Vec<Cell> = (0..rank.children())
        .map(|c| {
            let below = std::array::from_fn(|d| corner[d] + (c >> d & 1) * width);
            grow(value, rank, log2, level + 1, below)
        })
        .collect();
    let leaves = children.iter().map(|c| match c {
        Cell::Leaf(value) => Some(*value),
        Cell::Branch(_) => None,
    });
    let Some(values) = leaves.collect::<Option<Vec<f32>>>() else { return Cell::Branch(children) };
    let (low, high) = values.iter().fold((f32::MAX, 0.0_f32), |(l, h), v| (l.min(*v), h.max(*v)));
    // Merged where the contrast is low: this leaves about two million leaves.
    if high - low < 0.3 * (high + 0.1) {
        Cell::Leaf(values.iter().sum::<f32>() / values.len() as f32)
    } else {
        Cell::Branch(children)
    }
}

fn tree(rank: Rank, log2: u32, value: &impl Fn([usize; 4]) -> f32) -> Result<TensorTree> {
    let mut builder = TreeBuilder::new(rank);
    send(&grow(value, rank, log2, 0, [0; 4]), &mut builder)?;
    let tree = builder.finish()?;
    println!("{{\"leaves\": {}}}", tree.leaf_count());
    Ok(tree)
}

/// The centre of a cell of 2^log2 a side, on the front.
fn centre(log2: u32, x: usize, y: usize) -> DVec3 {
    let at = |n: usize| (n as f64 + 0.5) / f64::from(1 << log2);
    square_to_hemisphere(DVec2::new(at(x), at(y)), Side::Front)
}

fn send(cell: &Cell, builder: &mut TreeBuilder) -> Result<()> {
    match cell {
        Cell::Leaf(value) => builder.leaf(*value),
        Cell::Branch(children) => {
            builder.open_branch()?;
            children.iter().try_for_each(|c| send(c, builder))?;
            builder.close_branch()
        }
    }
}

/// The values at the centres of patches.
fn glossy_matrix() -> Result<KlemsMatrix> {
    let basis = KlemsBasis::full();
    let centres: Vec<DVec3> = (0..basis.directions()).map(|k| basis.centre(k)).collect();
    // Rows are numbered by the travel direction.
    let incident = centres.iter().map(|w| DVec3::new(-w.x, -w.y, w.z));
    let values = incident.flat_map(|wi| centres.iter().map(move |wo| glossy(wi, *wo))).collect();
    KlemsMatrix::new(basis.clone(), basis, values)
}

fn make(folder: &Path) -> Result<()> {
    let side = 1 << LOG2;
    let square: Vec<DVec3> = (0..side * side).map(|n| centre(LOG2, n % side, n / side)).collect();
    let anisotropic = tree(Rank::Four, LOG2, &|[ix, iy, ox, oy]| {
        // The incident square is that of the travel direction: (−x, −y).
        let travel = square[ix + side * iy];
        glossy(DVec3::new(-travel.x, -travel.y, travel.z), square[ox + side * oy])
    })?;
    let isotropic = tree(Rank::Three, ISOTROPIC_LOG2, &|[ix, ox, oy, _]| {
        // The first coordinate is (1 − sin θ) / 2, and light travels to +X.
        let x = (ix as f64 + 0.5) / f64::from(1 << ISOTROPIC_LOG2);
        let sin = (1.0 - 2.0 * x).max(0.0);
        let wi = DVec3::new(-sin, 0.0, (1.0 - sin * sin).sqrt());
        glossy(wi, centre(ISOTROPIC_LOG2, ox, oy))
    })?;
    let (front, back) = (Side::Front, Side::Back);
    let of = |tree: &TensorTree| TreeDistribution::new(tree.clone());
    let files = [
        // Asked from the front, the second one is read in reverse.
        ("tree6.xml", Component::new(front, front, of(&anisotropic))),
        ("through6.xml", Component::new(back, front, of(&anisotropic))),
        ("tree3.xml", Component::new(front, front, of(&isotropic))),
        ("klems.xml", Component::new(front, front, glossy_matrix()?)),
    ];
    for (name, component) in files {
        let bsdf = Bsdf::new(Metadata::default(), vec![component], Lambertian::default());
        xml::write(&bsdf, folder.join(name), &xml::WriteOptions::default())?;
    }
    let mut random = Random(1);
    let directions = (0..2 * PAIRS).map(|_| random.direction());
    let bytes: Vec<u8> = directions.flat_map(|w| w.to_array()).flat_map(f64::to_le_bytes).collect();
    std::fs::write(folder.join("directions.f64"), bytes)
        .map_err(|e| bsdfkit::Error::io(folder.display(), &e))
}

/// Processor time of all threads so far, ns; wall time where the system does not tell.
fn processor_time() -> f64 {
    let threads = std::fs::read_dir("/proc/self/task").into_iter().flatten().flatten();
    let spent = threads.filter_map(|thread| {
        let text = std::fs::read_to_string(thread.path().join("schedstat")).ok()?;
        text.split_whitespace().next()?.parse::<f64>().ok()
    });
    let spent: f64 = spent.sum();
    if spent > 0.0 {
        return spent;
    }
    static START: std::sync::OnceLock<Instant> = std::sync::OnceLock::new();
    START.get_or_init(Instant::now).elapsed().as_nanos() as f64
}

/// Best of five runs, or of half a second: nanoseconds a result.
fn best(name: &str, results: usize, mut run: impl FnMut()) {
    let (begin, mut runs, mut least) = (Instant::now(), 0, f64::INFINITY);
    while runs < 5 || begin.elapsed().as_millis() < 500 {
        let start = processor_time();
        run();
        least = least.min((processor_time() - start) / results as f64);
        runs += 1;
    }
    println!("{{\"name\": \"{name}\", \"ns\": {least:.2}}}");
}

fn open(file: &Path) -> Result<Bsdf> {
    if file.extension().is_some_and(|e| e == "xml") {
        xml::read(file)
    } else {
        container::open(file)
    }
}

/// The pairs (wi, wo) of a file.
fn pairs(directions: &Path) -> Result<(Vec<DVec3>, Vec<DVec3>)> {
    let bytes =
        std::fs::read(directions).map_err(|e| bsdfkit::Error::io(directions.display(), &e))?;
    let numbers = bytes.as_chunks::<8>().0.iter().map(|b| f64::from_le_bytes(*b));
    let numbers: Vec<f64> = numbers.collect();
    let all = numbers.as_chunks::<3>().0.iter().map(|w| DVec3::from_array(*w));
    let all: Vec<DVec3> = all.collect();
    Ok(all.as_chunks::<2>().0.iter().map(|[wi, wo]| (*wi, *wo)).unzip())
}

fn run(file: &Path, directions: &Path) -> Result<()> {
    // Wall time: processor time is not told finely enough. The file is in the system's cache.
    let (begin, mut times) = (Instant::now(), 0);
    let mut least = f64::INFINITY;
    while times < 15 || begin.elapsed().as_millis() < 200 {
        let start = Instant::now();
        drop(black_box(open(file)?));
        least = least.min(start.elapsed().as_nanos() as f64);
        times += 1;
    }
    println!("{{\"name\": \"open\", \"ns\": {least:.0}}}");
    let bsdf = open(file)?;
    if file.extension().is_some_and(|e| e == "xml") {
        container::save(&bsdf, file.with_extension("safetensors"))?;
    }
    let (wi, wo) = pairs(directions)?;
    let n = wi.len();
    let mut random = Random(2);
    let u: Vec<f64> = (0..n).map(|_| random.unit()).collect();
    let u2: Vec<DVec2> = (0..n).map(|_| DVec2::new(random.unit(), random.unit())).collect();
    let every = Components::ALL;

    let mut values = vec![0.0; n];
    best("eval_many", n, || bsdf.eval_many(&wi, &wo, &mut values).unwrap());
    let mut sum = 0.0;
    best("eval", n, || sum += (0..n).map(|k| bsdf.eval(wi[k], wo[k])).sum::<f64>());
    best("eval_many, one wi", n, || bsdf.eval_many(&wi[..1], &wo, &mut values).unwrap());
    best("pdf_many", n, || bsdf.pdf_many(&wi, &wo, every, &mut values).unwrap());
    best("directional_hemispherical_many", n, || {
        bsdf.directional_hemispherical_many(&wi, every, &mut values).unwrap();
    });
    let mut samples = vec![None; n];
    best("sample_many", n, || bsdf.sample_many(&wi, &u, every, &mut samples).unwrap());
    best("sample2_many", n, || bsdf.sample2_many(&wi, &u2, every, &mut samples).unwrap());
    best("sample", n, || {
        sum += (0..n).filter_map(|k| Some(bsdf.sample(wi[k], u[k], every)?.pdf)).sum::<f64>();
    });
    best("sample_many, one wi", n, || {
        bsdf.sample_many(&wi[..1], &u, every, &mut samples).unwrap();
    });
    black_box(sum);

    if bsdf.components()[0].distribution().downcast_ref::<TreeDistribution>().is_some() {
        let smooth = bsdf.with_lookup(Lookup::Smooth)?;
        let ((wi, wo), mut values, mut samples) = (pairs(directions)?, vec![0.0; n], vec![None; n]);
        let u: Vec<f64> = (0..n).map(|_| random.unit()).collect();
        best("eval_many, smooth", n, || smooth.eval_many(&wi, &wo, &mut values).unwrap());
        best("sample_many, smooth", n, || {
            smooth.sample_many(&wi, &u, every, &mut samples).unwrap();
        });
    }
    Ok(())
}

/// Lines that follow each other as in a tree: as many a level as it has branches, 16 words a line, each
/// the number of a line of the next level.
struct Chase {
    next: Vec<u32>,
    /// First line of each level.
    first: Vec<u32>,
}

impl Chase {
    fn new(tree: &TensorTree, random: &mut Random) -> Self {
        let branch = |slot: &u32| (*slot >> 31 == 1).then_some((*slot ^ 1 << 31) as usize);
        let mut level: Vec<usize> = branch(&tree.root_slot()).into_iter().collect();
        let mut first = vec![0];
        while !level.is_empty() {
            first.push(first[first.len() - 1] + level.len() as u32);
            let slots = level.iter().flat_map(|n| &tree.slots()[16 * n..][..16]);
            level = slots.filter_map(branch).collect();
        }
        let mut next = Vec::with_capacity(tree.slots().len());
        for bounds in first.windows(2) {
            let below = first.iter().find(|f| **f > bounds[1]).copied().unwrap_or(bounds[1] + 1);
            let below = |u: f64| bounds[1] + (u * f64::from(below - bounds[1])) as u32;
            next.extend((0..16 * (bounds[1] - bounds[0])).map(|_| below(random.unit())));
        }
        Self { next, first }
    }

    fn follow(&self, line: u32, word: usize) -> u32 {
        self.next.get(line as usize * 16 + word % 16).copied().unwrap_or(0)
    }
}

/// Levels that look-ups skip by a table of a few lines.
const SKIPPED: u32 = 3;

/// Look-ups beside as many dependent lines of as many bytes, with nothing to compute.
fn floor(file: &Path, directions: &Path) -> Result<()> {
    const ABREAST: usize = 64;
    let bsdf = open(file)?;
    let component = &bsdf.components()[0];
    let Some(tree) = component.distribution().downcast_ref::<TreeDistribution>() else {
        return Err(bsdfkit::Error::argument("expected a file of a tree"));
    };
    let tree = tree.luminance();
    let (wi, wo) = pairs(directions)?;
    let n = wi.len();
    let random = &mut Random(3);
    let chase = Chase::new(tree, random);
    // Each look-up's lines below the table, and the line where it begins.
    let level = |(wi, wo): (&DVec3, &DVec3)| tree.leaf_at(*wi, *wo).1.saturating_sub(SKIPPED);
    let lines: Vec<u32> = wi.iter().zip(&wo).map(level).collect();
    let begin = chase.first[(SKIPPED as usize).min(chase.first.len() - 1)];
    let end = chase.first.get(SKIPPED as usize + 1).map_or(begin + 1, |end| *end);
    let start = |_| begin + (random.unit() * f64::from(end - begin)) as u32;
    let start: Vec<u32> = (0..n).map(start).collect();
    let deepest = lines.iter().copied().max().unwrap_or(0);
    let mut out = vec![0; n];
    best("chase", n, || {
        let mut at = 0;
        for k in 0..n {
            // No line has the highest bit: it waits for the last one, and changes nothing.
            at = start[k] ^ at >> 31;
            (0..lines[k]).for_each(|level| at = chase.follow(at, k + level as usize));
            out[k] = at;
        }
    });
    best("chase, abreast", n, || {
        for first in (0..n).step_by(ABREAST) {
            let block = first..n.min(first + ABREAST);
            out[block.clone()].copy_from_slice(&start[block.clone()]);
            for level in 0..deepest {
                for k in block.clone() {
                    let below = chase.follow(out[k], k + level as usize);
                    out[k] = if level < lines[k] { below } else { out[k] };
                }
            }
        }
    });
    black_box(&out);
    let mean = lines.iter().map(|n| f64::from(*n)).sum::<f64>() / n as f64;
    println!("{{\"name\": \"lines\", \"count\": {:.2}}}", 1.0 + mean);
    println!("{{\"name\": \"bytes\", \"count\": {}}}", 4 * chase.next.len());
    Ok(())
}

/// 1, 2 and 4 threads on one handle, by the clock; their answers are compared.
fn threads(file: &Path, directions: &Path) -> Result<()> {
    let bsdf = open(file)?;
    let (wi, wo) = pairs(directions)?;
    let mut random = Random(2);
    let u: Vec<f64> = wi.iter().map(|_| random.unit()).collect();
    let mut first = None;
    for count in [1, 2, 4] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build();
        let pool = pool.map_err(|e| bsdfkit::Error::argument(e.to_string()))?;
        let (mut values, mut samples) = (vec![0.0; wi.len()], vec![None; wi.len()]);
        let clock = |name: &str, run: &mut (dyn FnMut() + Send)| {
            let mut least = f64::INFINITY;
            for _ in 0..7 {
                let start = Instant::now();
                pool.install(&mut *run);
                least = least.min(start.elapsed().as_nanos() as f64 / wi.len() as f64);
            }
            println!("{{\"name\": \"{name}, {count} threads\", \"ns\": {least:.2}}}");
        };
        clock("eval_many", &mut || bsdf.eval_many(&wi, &wo, &mut values).unwrap());
        clock("sample_many", &mut || {
            bsdf.sample_many(&wi, &u, Components::ALL, &mut samples).unwrap();
        });
        let answers = (values, samples);
        let same = first.get_or_insert_with(|| answers.clone()) == &answers;
        println!("{{\"name\": \"same answers, {count} threads\", \"count\": {}}}", u8::from(same));
    }
    Ok(())
}

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match arguments.as_slice() {
        ["make", folder] => make(Path::new(folder)),
        ["run", file, directions] => run(Path::new(file), Path::new(directions)),
        ["floor", file, directions] => floor(Path::new(file), Path::new(directions)),
        ["threads", file, directions] => threads(Path::new(file), Path::new(directions)),
        _ => Err(bsdfkit::Error::argument(
            "expected: make FOLDER, or run, floor or threads FILE DIRECTIONS",
        )),
    }
}
