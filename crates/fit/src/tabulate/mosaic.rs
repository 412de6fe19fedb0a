//! Adaptive samples of four neighbouring slices: a quadtree over the scattered directions.

use bsdfkit_sphere::{DVec2, DVec3};

use super::source::Slice;

/// A root square of the quadtree and a point in it → scattered direction, uniform in projected solid angle.
pub(super) type Place<'a> = &'a (dyn Fn(usize, DVec2) -> DVec3 + 'a);

/// How a [`Mosaic`] is sampled.
pub(super) struct Sampling<'a> {
    /// Where samples lie.
    pub(super) place: Place<'a>,
    /// Number of root squares; projected solid angles sum to π.
    pub(super) roots: usize,
    /// Projected solid angle of each root over π.
    pub(super) measure: &'a (dyn Fn(usize) -> f64 + 'a),
    /// Level at which the quadtree starts.
    pub(super) start: u32,
    /// Deepest level.
    pub(super) deepest: u32,
    /// Cells up to this level take their four samples at the centres of their quadrants, deeper
    /// ones at their centre: there each slice is a cell of its own.
    pub(super) stratified: u32,
    /// Which slice answers in each quadrant (bit 0 of the quadrant is x, bit 1 is y).
    pub(super) slice_of: [usize; 4],
    /// Values per direction that the slices return; the first is used.
    pub(super) channels: usize,
    /// Cells are refined whose spread is above this share of the slice's flux.
    pub(super) threshold: f64,
    /// No refinement beyond so many values.
    pub(super) most: usize,
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
    /// For each refined cell the least score of it and its ancestors: the threshold below which
    /// it is refined.
    pub(super) scores: Vec<f64>,
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
            scores: Vec::new(),
            hemispherical: 0.0,
        };
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
                mosaic.scores.push(c.score);
                let first = mosaic.cells.len();
                mosaic.cells[c.cell].children = first as u32;
                for child in 0..4 {
                    mosaic.cells.push(Cell { samples: [0.0; 4], children: 0 });
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

    /// Mean f over root `root`, of all four slices, of a mosaic that starts at `start`.
    pub(super) fn mean_of_root(&self, root: usize, start: u32) -> f64 {
        let cells = 1usize << (2 * start);
        (root * cells..(root + 1) * cells).map(|cell| self.mean_of(cell)).sum::<f64>()
            / cells as f64
    }

    fn mean_of(&self, cell: usize) -> f64 {
        match self.cells[cell].children as usize {
            0 => self.cells[cell].mean(),
            first => (first..first + 4).map(|child| self.mean_of(child)).sum::<f64>() * 0.25,
        }
    }

    /// Evaluates the cells of one wave, one batch per slice.
    fn fill(&mut self, slices: [&dyn Slice; 4], by: &Sampling<'_>, wave: &[Candidate], level: u32) {
        let scale = 1.0 / f64::from(1u32 << level);
        let mut directions = Vec::with_capacity(wave.len());
        let mut values = vec![0.0f32; wave.len() * by.channels];
        for quadrant in 0..4 {
            let offset = if level <= by.stratified {
                DVec2::new(0.25 + 0.5 * (quadrant & 1) as f64, 0.25 + 0.5 * (quadrant >> 1) as f64)
            } else {
                DVec2::splat(0.5)
            };
            directions.clear();
            directions.extend(wave.iter().map(|c| {
                (by.place)(c.root, (DVec2::new(c.x.into(), c.y.into()) + offset) * scale)
            }));
            let slice = by.slice_of[quadrant];
            slices[slice].eval(&directions, &mut values);
            for (c, value) in wave.iter().zip(values.chunks_exact(by.channels)) {
                let v = value[0];
                self.cells[c.cell].samples[slice] = if v.is_finite() { v.max(0.0) } else { 0.0 };
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

/// Share of the hemisphere's projected solid angle that a cell of `level` in `root` has.
fn area(by: &Sampling<'_>, root: usize, level: u32) -> f64 {
    (by.measure)(root) / f64::from(1u32 << (2 * level))
}
