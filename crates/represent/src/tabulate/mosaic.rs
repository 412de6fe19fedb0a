//! Adaptive samples of four neighbouring slices: a quadtree over the scattered directions.

use bsdfkit_sphere::concentric::disk_to_hemisphere;
use bsdfkit_sphere::{DVec2, DVec3, Side};

use crate::source::{Peak, Slice};

/// A root square of the quadtree and a point in it → scattered direction, uniform in projected solid angle.
pub(super) type Place<'a> = &'a (dyn Fn(usize, DVec2) -> DVec3 + 'a);

/// The inverse of [`Place`], for directions of the upper hemisphere.
pub(super) type Find<'a> = &'a (dyn Fn(DVec3) -> Option<(usize, DVec2)> + 'a);

/// Where cells are split because a slice says that a peak is there.
#[derive(Clone, Copy)]
pub(super) struct Seeding {
    /// Cells are split that are wider than this many of the peak's radii.
    pub(super) width: f64,
    /// How far from the peak's middle its seeds lie, in radii; 0 for the middle alone.
    pub(super) reach: f64,
}

/// How a [`Mosaic`] is sampled.
pub(super) struct Sampling<'a> {
    /// Where samples lie.
    pub(super) place: Place<'a>,
    /// In which root, and where in it, a direction lies.
    pub(super) find: Find<'a>,
    /// Number of root squares; projected solid angles sum to π.
    pub(super) roots: usize,
    /// Largest extent of each root in the projected disk.
    pub(super) width: &'a (dyn Fn(usize) -> f64 + 'a),
    /// Projected solid angle of each root over π.
    pub(super) measure: &'a (dyn Fn(usize) -> f64 + 'a),
    /// Level at which the quadtree starts.
    pub(super) start: u32,
    /// Deepest level.
    pub(super) deepest: u32,
    /// Cells up to this level take their four samples at the centres of their quadrants, deeper
    /// ones at their centre: there each slice is a cell of its own.
    pub(super) stratified: u32,
    /// Where in a quadrant of side 1 its sample lies.
    pub(super) within: DVec2,
    /// Which slice answers in each quadrant (bit 0 of the quadrant is x, bit 1 is y).
    pub(super) slice_of: [usize; 4],
    /// Values per direction that the slices return; the first steers.
    pub(super) channels: usize,
    /// How many of them are kept.
    pub(super) kept: usize,
    /// Which cells are refined whatever their spread.
    pub(super) seeding: Seeding,
    /// Cells are refined whose spread is above this share of the slice's flux.
    pub(super) threshold: f64,
    /// No refinement beyond so many values.
    pub(super) most: usize,
}

impl Sampling<'_> {
    /// Where in a cell of side 1 the sample of a quadrant lies.
    fn offset(&self, quadrant: usize) -> DVec2 {
        0.5 * (DVec2::new((quadrant & 1) as f64, (quadrant >> 1) as f64) + self.within)
    }
}

/// Four samples, one a slice, and four children or none.
#[derive(Clone, Copy)]
pub(super) struct Cell {
    /// f in 1/sr, one from each slice, each in a quadrant of its own.
    pub(super) samples: [f32; 4],
    /// Index of the first of four children; 0 for none.
    pub(super) children: u32,
}

impl Cell {
    pub(super) fn mean(&self) -> f64 {
        self.samples.iter().map(|&v| f64::from(v)).sum::<f64>() * 0.25
    }

    /// Mean |f − mean|.
    pub(super) fn spread(&self) -> f64 {
        let mean = self.mean();
        self.samples.iter().map(|&v| (f64::from(v) - mean).abs()).sum::<f64>() * 0.25
    }
}

/// A quadtree of samples over the scattered directions; siblings are four in a row, Z order.
pub(super) struct Mosaic {
    /// The start level's cells of every root in Z order, then quadruples of siblings.
    pub(super) cells: Vec<Cell>,
    /// Samples of the channels after the first, channels fastest, then cells.
    others: Vec<[f32; 4]>,
    /// Channels kept after the first.
    more: usize,
    /// Roots, level at which they start, and where in the quadrants of a cell the slices' samples lie.
    roots: usize,
    start: u32,
    offsets: [DVec2; 4],
    /// For each cell refined by its score the least score of it and its ancestors: the threshold
    /// below which it is refined.
    pub(super) scores: Vec<f64>,
    /// Number of cells refined because a peak was said to lie there.
    pub(super) seeded: usize,
    /// ∫ f cos θo dωo, the mean of the four slices.
    pub(super) hemispherical: f64,
}

/// A cell on the way to refinement.
#[derive(Clone, Copy)]
struct Candidate {
    cell: usize,
    root: usize,
    x: u32,
    y: u32,
    score: f64,
}

/// Share of its parent's spread that a cell is at least taken to have: four samples that agree by
/// chance hide no peak that their neighbours saw. A guess, not measured.
const INHERITED_SPREAD: f64 = 0.25;

/// Of a Z-order number: the even bits, packed.
pub(super) fn even_bits(z: u32) -> u32 {
    (0..16).fold(0, |x, bit| x | ((z >> (2 * bit)) & 1) << bit)
}

impl Mosaic {
    /// Samples four slices, coarse first, finer where they vary.
    pub(super) fn sample(slices: [&dyn Slice; 4], by: &Sampling<'_>) -> Self {
        let side = 1u32 << (2 * by.start);
        let mut wave: Vec<Candidate> = (0..by.roots)
            .flat_map(|root| (0..side).map(move |z| (root, z)))
            .enumerate()
            .map(|(cell, (root, z))| Candidate {
                cell,
                root,
                x: even_bits(z),
                y: even_bits(z >> 1),
                score: f64::INFINITY,
            })
            .collect();
        let mut mosaic = Self {
            cells: vec![Cell { samples: [0.0; 4], children: 0 }; wave.len()],
            others: vec![[0.0; 4]; wave.len() * (by.kept - 1)],
            more: by.kept - 1,
            roots: by.roots,
            start: by.start,
            offsets: [DVec2::ZERO; 4],
            scores: Vec::new(),
            seeded: 0,
            hemispherical: 0.0,
        };
        for quadrant in 0..4 {
            mosaic.offsets[by.slice_of[quadrant]] = by.offset(quadrant);
        }
        let seeds = seeds(slices, by);
        let mut spent = 4 * wave.len();
        let mut level = by.start;
        mosaic.fill(slices, by, &wave, level);
        mosaic.hemispherical = std::f64::consts::PI
            * wave
                .iter()
                .map(|c| area(by, c.root, level) * mosaic.cells[c.cell].mean())
                .sum::<f64>();
        while level < by.deepest {
            mosaic.score(by, &mut wave, level);
            for c in &mut wave {
                if seeds.binary_search(&(level, c.root, c.x, c.y)).is_ok() {
                    c.score = f64::INFINITY;
                }
            }
            wave.retain(|c| c.score > by.threshold);
            let room = by.most.saturating_sub(spent) / 16;
            if wave.len() > room {
                wave.sort_by(|a, b| b.score.total_cmp(&a.score).then(a.cell.cmp(&b.cell)));
                wave.truncate(room);
            }
            if wave.is_empty() {
                break;
            }
            spent += 16 * wave.len();
            let mut next = Vec::with_capacity(4 * wave.len());
            for c in &wave {
                if c.score.is_finite() {
                    mosaic.scores.push(c.score);
                } else {
                    mosaic.seeded += 1;
                }
                let first = mosaic.cells.len();
                mosaic.cells[c.cell].children = first as u32;
                for child in 0..4 {
                    mosaic.cells.push(Cell { samples: [0.0; 4], children: 0 });
                    mosaic.others.extend(std::iter::repeat_n([0.0; 4], by.kept - 1));
                    let (x, y) = (2 * c.x + (child & 1), 2 * c.y + (child >> 1));
                    next.push(Candidate { cell: first + child as usize, x, y, ..*c });
                }
            }
            level += 1;
            mosaic.fill(slices, by, &next, level);
            for (c, four) in wave.iter().zip(next.chunks_exact(4)) {
                let mean = four.iter().map(|k| mosaic.cells[k.cell].mean()).sum::<f64>() * 0.25;
                let gain = mean - mosaic.cells[c.cell].mean();
                mosaic.hemispherical += std::f64::consts::PI * area(by, c.root, level - 1) * gain;
            }
            wave = next;
        }
        mosaic
    }

    /// Number of values it took.
    pub(super) fn spent(&self) -> usize {
        4 * self.cells.len()
    }

    /// Mean f over root `root`, of all four slices.
    pub(super) fn mean_of_root(&self, root: usize, channel: usize) -> f64 {
        let cells = 1usize << (2 * self.start);
        (root * cells..(root + 1) * cells).map(|cell| self.mean_of(cell, channel)).sum::<f64>()
            / cells as f64
    }

    fn mean_of(&self, cell: usize, channel: usize) -> f64 {
        match self.cells[cell].children as usize {
            0 if channel == 0 => self.cells[cell].mean(),
            0 => {
                let samples = self.others[cell * self.more + channel - 1];
                samples.iter().map(|&v| f64::from(v)).sum::<f64>() * 0.25
            }
            first => {
                (first..first + 4).map(|child| self.mean_of(child, channel)).sum::<f64>() * 0.25
            }
        }
    }

    /// Calls `f` with root, point in it, share of the root and values by channel of every sample
    /// of a stratified mosaic that counts.
    pub(super) fn for_each_sample(&self, mut f: impl FnMut(usize, DVec2, f64, &[f64])) {
        let side = 1u32 << self.start;
        let mut stack: Vec<(usize, usize, DVec2, f64)> = (0..self.roots * (side * side) as usize)
            .map(|c| {
                let z = c as u32 % (side * side);
                let corner = DVec2::new(even_bits(z).into(), even_bits(z >> 1).into());
                (c, c / (side * side) as usize, corner / f64::from(side), 1.0 / f64::from(side))
            })
            .collect();
        let mut values = vec![0.0; 1 + self.more];
        while let Some((cell, root, corner, width)) = stack.pop() {
            match self.cells[cell].children as usize {
                0 => {
                    for slice in 0..4 {
                        values[0] = self.cells[cell].samples[slice].into();
                        for (v, o) in values[1..].iter_mut().zip(&self.others[cell * self.more..]) {
                            *v = o[slice].into();
                        }
                        f(
                            root,
                            corner + width * self.offsets[slice],
                            0.25 * width * width,
                            &values,
                        );
                    }
                }
                first => stack.extend((0..4).map(|child| {
                    let offset = DVec2::new((child & 1) as f64, (child >> 1) as f64);
                    (first + child, root, corner + 0.5 * width * offset, 0.5 * width)
                })),
            }
        }
    }

    /// Evaluates the cells of one wave, one batch per slice.
    fn fill(&mut self, slices: [&dyn Slice; 4], by: &Sampling<'_>, wave: &[Candidate], level: u32) {
        let scale = 1.0 / f64::from(1u32 << level);
        let mut directions = Vec::with_capacity(wave.len());
        let mut values = vec![0.0f32; wave.len() * by.channels];
        for quadrant in 0..4 {
            let offset =
                if level <= by.stratified { by.offset(quadrant) } else { DVec2::splat(0.5) };
            directions.clear();
            directions.extend(wave.iter().map(|c| {
                (by.place)(c.root, (DVec2::new(c.x.into(), c.y.into()) + offset) * scale)
            }));
            let slice = by.slice_of[quadrant];
            slices[slice].eval(&directions, &mut values);
            for (c, value) in wave.iter().zip(values.chunks_exact(by.channels)) {
                let clean = |v: f32| if v.is_finite() { v.max(0.0) } else { 0.0 };
                self.cells[c.cell].samples[slice] = clean(value[0]);
                for channel in 1..by.kept {
                    self.others[c.cell * self.more + channel - 1][slice] = clean(value[channel]);
                }
            }
        }
    }

    /// Scores candidates, four siblings at a time: their share of the flux that a finer level may move.
    fn score(&self, by: &Sampling<'_>, wave: &mut [Candidate], level: u32) {
        let flux = self.hemispherical.max(f64::MIN_POSITIVE);
        let siblings = if level == 0 { 1 } else { 4 };
        for four in wave.chunks_exact_mut(siblings) {
            let n = four.len() as f64;
            let mean = four.iter().map(|c| self.cells[c.cell].mean()).sum::<f64>() / n;
            let samples = four.iter().flat_map(|c| self.cells[c.cell].samples);
            let parent = samples.map(|v| (f64::from(v) - mean).abs()).sum::<f64>() / (4.0 * n);
            for c in four {
                let spread = self.cells[c.cell].spread().max(INHERITED_SPREAD * parent);
                let share = std::f64::consts::PI * area(by, c.root, level) * spread / flux;
                c.score = c.score.min(share);
            }
        }
    }
}

/// Cells (level, root, x, y) that are split whatever their score, sorted: those at the peaks of
/// any of the slices that are wider than the peak.
fn seeds(slices: [&dyn Slice; 4], by: &Sampling<'_>) -> Vec<(u32, usize, u32, u32)> {
    let mut peaks: Vec<Peak> = Vec::new();
    for slice in slices {
        slice.peaks(&mut peaks);
    }
    let mut seeds = Vec::new();
    for peak in peaks {
        let radius = peak.radius.max(1e-6);
        // Three by three places, of which the fifth is the middle.
        for k in if by.seeding.reach > 0.0 { 0..9 } else { 4..5 } {
            let offset = DVec2::new(f64::from(k % 3) - 1.0, f64::from(k / 3) - 1.0);
            let p = peak.direction.truncate() + by.seeding.reach * radius * offset;
            if p.is_nan() {
                continue;
            }
            // Beyond the horizon: the rim is nearest.
            let p = p / p.length().max(1.0);
            let Some((root, at)) = (by.find)(disk_to_hemisphere(p, Side::Front)) else {
                continue;
            };
            let width = (by.width)(root);
            for level in by.start..by.deepest {
                let cells = 1u32 << level;
                if width <= by.seeding.width * radius * f64::from(cells) {
                    break;
                }
                let cell = |x: f64| ((x * f64::from(cells)) as u32).min(cells - 1);
                seeds.push((level, root, cell(at.x), cell(at.y)));
            }
        }
    }
    seeds.sort_unstable();
    seeds.dedup();
    seeds
}

/// Share of the hemisphere's projected solid angle that a cell of `level` in `root` has.
fn area(by: &Sampling<'_>, root: usize, level: u32) -> f64 {
    (by.measure)(root) / f64::from(1u32 << (2 * level))
}
