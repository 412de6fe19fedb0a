//! The scattered distribution of one incident direction: interpolated lobes, summed.

use std::f64::consts::PI;

use bsdfkit_sphere::{DVec3, Side};

use super::grid::Grid;
use super::mesh::{Face, Place, Unfold, rotate, slerp};
use super::node::SirLobe;
use super::plan::Migration;
use super::whole::Sir;
use crate::source::{Slice, Source};

/// Radius codes in π radians.
const CODES: f64 = 65536.0;
/// Fractions up to this are not followed. [reference]
const THRESHOLD: f64 = 1e-6;
/// Most lobes of one incident direction; beyond, the threshold rises and energy is lost. [reference default]
const MOST_LOBES: usize = 15_000;
/// A lobe reaches to squared grid distance 38/π² · N² σ². [reference]
const REACH: f64 = 38.0 / (PI * PI);
/// Tiles along a side of the square; each lists the lobes that reach it. 16 makes sums ten to fifty times shorter.
const TILES: usize = 16;

/// σ of a radius code, radians.
fn sigma(code: u16) -> f64 {
    (f64::from(code) + 0.5) * PI / CODES
}

/// Radius code of σ, truncated as the reference does.
fn radius_code(sigma: f64) -> u16 {
    (sigma * CODES / PI) as u16
}

/// Mass of a lobe above the horizon as the writer counts it: 2π p σ², less ½ exp(−z²/2σ²) within 2.8 σ.
///
/// Differs from: the true loss ½ erfc(z / σ√2); plans were balanced with this one.
pub(super) fn mass(lobe: &SirLobe) -> f64 {
    let (sigma, z) = (sigma(lobe.radius), lobe.centre.z.abs());
    let lost = if z < 2.8 * sigma { 0.5 * (-z * z / (2.0 * sigma * sigma)).exp() } else { 0.0 };
    2.0 * PI * lobe.peak * sigma * sigma * (1.0 - lost)
}

/// The cosine that turns DSF into BSDF: softened at the horizon. [reference]
fn soft_cosine(z: f64) -> f64 {
    0.98 * z.abs() + 0.02
}

/// The distribution of one incident direction.
///
/// Cost: made in O(lobes); a value costs the lobes that reach its tile.
#[derive(Debug)]
pub struct SirSlice {
    scattered: Option<Side>,
    channels: usize,
    floor: f64,
    grid: Grid,
    lobes: Vec<Reach>,
    starts: Vec<u32>,
    members: Vec<u32>,
}

/// A lobe ready to be summed.
#[derive(Clone, Copy, Debug)]
struct Reach {
    centre: DVec3,
    peak: f64,
    inverse_variance: f64,
    cell: [u16; 2],
    distance2: f64,
    colour: [f32; 2],
}

impl Sir {
    /// The distribution for light from `wi`; black when `wi` is on the wrong side, NaN when it is NaN.
    ///
    /// Beyond the measured incidences it is the file's grazing lobe, or the floor alone.
    pub fn slice(&self, wi: DVec3) -> SirSlice {
        let black = Side::of(wi) != self.incident || wi.is_nan();
        let lobes = if black { Vec::new() } else { self.lobes(wi) };
        let (starts, members) = tiles(&lobes, self.grid);
        SirSlice {
            scattered: (!black).then_some(self.scattered),
            channels: self.channels,
            floor: if wi.is_nan() { f64::NAN } else { self.floor },
            grid: self.grid,
            lobes: lobes.iter().map(|l| Reach::new(l, self.grid)).collect(),
            starts,
            members,
        }
    }

    /// Interpolated lobes at `wi`, centres rounded to the grid.
    fn lobes(&self, wi: DVec3) -> Vec<SirLobe> {
        let (folded, unfold) = self.mesh.fold(wi, &self.nodes);
        let mut lobes = match self.mesh.locate(folded, &self.nodes, &self.migrations) {
            Place::Outside => return self.grazing_lobe(wi).into_iter().collect(),
            Place::Node(node) => self.nodes[node].lobes.clone(),
            Place::Edge { migration, t } => self.along(&self.migrations[migration], t),
            Place::Face { face, s, t } => self.inside(&face, s, t),
        };
        for lobe in &mut lobes {
            let last = self.grid.resolution - 1;
            match unfold {
                Unfold::Mirror(x, y) => {
                    let flip = |c: u16, mirrored: bool| if mirrored { last - c } else { c };
                    lobe.cell = [flip(lobe.cell[0], x), flip(lobe.cell[1], y)];
                }
                Unfold::Rotate(0.0) => {}
                Unfold::Rotate(turn) => lobe.cell = self.grid.cell(rotate(lobe.centre, turn)),
            }
            lobe.centre = self.grid.centre(lobe.cell);
        }
        lobes
    }

    /// One neutral lobe where the mirror, or the straight line through, sends the light.
    fn grazing_lobe(&self, wi: DVec3) -> Option<SirLobe> {
        let grazing = self.grazing?;
        let z = self.scattered.sign() * wi.z.abs();
        let cell = self.grid.cell(DVec3::new(-wi.x, -wi.y, z));
        let peak = grazing.value * soft_cosine(z);
        let centre = self.grid.centre(cell);
        Some(SirLobe { peak, radius: radius_code(grazing.sigma), cell, colour: [1.0; 2], centre })
    }

    /// A lobe between others: variance and colour are mixed linearly, mass is `scale` times that of `source`.
    fn between(
        &self,
        source: &SirLobe,
        scale: f64,
        centre: DVec3,
        parts: &[(f64, &SirLobe)],
    ) -> SirLobe {
        let variance: f64 = parts.iter().map(|(w, l)| w * sigma(l.radius).powi(2)).sum();
        let colour = |k: usize| parts.iter().map(|(w, l)| *w as f32 * l.colour[k]).sum();
        let cell = self.grid.cell(centre);
        SirLobe {
            peak: source.peak * scale * sigma(source.radius).powi(2) / variance,
            radius: radius_code(variance.sqrt()),
            cell,
            colour: [colour(0), colour(1)],
            centre: self.grid.centre(cell),
        }
    }

    fn along(&self, edge: &Migration, t: f64) -> Vec<SirLobe> {
        let [a, b] = [edge.from, edge.to].map(|n| &self.nodes[n]);
        let ratio = 1.0 - t + t * b.total / a.total;
        let followed = |i: usize, threshold: f64| {
            edge.plan.row(i).iter().take_while(move |e| f64::from(e.fraction) > threshold)
        };
        let threshold = within_limit(|threshold| {
            (0..a.lobes.len()).try_fold(0, |n, i| at_most(n + followed(i, threshold).count()))
        });
        let mut lobes = Vec::new();
        for (i, from) in a.lobes.iter().enumerate() {
            for entry in followed(i, threshold) {
                let to = &b.lobes[entry.to as usize];
                let centre = slerp(from.centre, to.centre, t);
                lobes.push(self.between(
                    from,
                    f64::from(entry.fraction) * ratio,
                    centre,
                    &[(1.0 - t, from), (t, to)],
                ));
            }
        }
        lobes
    }

    fn inside(&self, face: &Face, s: f64, t: f64) -> Vec<SirLobe> {
        let [a, b, c] = face.nodes.map(|n| &self.nodes[n]);
        let via_b = s * (b.total / a.total) * (1.0 - t + t * c.total / b.total);
        let via_c = (1.0 - s) * (1.0 - t + t * c.total / a.total);
        let threshold =
            within_limit(|threshold| self.triples(face, via_b, via_c, threshold, |_, _, _, _| {}));
        let mut lobes = Vec::new();
        let mut middle = (usize::MAX, usize::MAX, DVec3::ZERO);
        let _ = self.triples(face, via_b, via_c, threshold, |i, j, k, weight| {
            let [x, y, z] = [&a.lobes[i], &b.lobes[j], &c.lobes[k]];
            if (middle.0, middle.1) != (i, j) {
                middle = (i, j, slerp(x.centre, y.centre, s));
            }
            let parts = [((1.0 - s) * (1.0 - t), x), (s * (1.0 - t), y), (t, z)];
            lobes.push(self.between(x, weight, slerp(middle.2, z.centre, t), &parts));
        });
        lobes
    }

    /// Every lobe i, j, k of the face's nodes that plans join i→j and then j→k or i→k, with its weight; `None` past
    /// [`MOST_LOBES`].
    ///
    /// Rows fall, so following stops at the first entry below the threshold and hostile plans cannot take long.
    fn triples(
        &self,
        face: &Face,
        via_b: f64,
        via_c: f64,
        threshold: f64,
        mut found: impl FnMut(usize, usize, usize, f64),
    ) -> Option<usize> {
        let [ab, bc, ac] = face.edges.map(|m| &self.migrations[m].plan);
        let sources = self.nodes[face.nodes[0]].lobes.len();
        let mut count = 0;
        let mut weights = vec![0.0; self.nodes[face.nodes[2]].lobes.len()];
        let mut touched = Vec::new();
        for i in 0..sources {
            for first in ab.row(i).iter().take_while(|e| f64::from(e.fraction) > threshold) {
                let j = first.to as usize;
                for (row, factor) in [(bc.row(j), via_b), (ac.row(i), via_c)] {
                    let row = if factor > 0.0 { row } else { &[] };
                    for entry in row.iter().take_while(|e| f64::from(e.fraction) > threshold) {
                        let k = entry.to as usize;
                        if weights[k] == 0.0 {
                            touched.push(k);
                        }
                        weights[k] += f64::from(entry.fraction) * factor;
                    }
                }
                count = at_most(count + touched.len())?;
                for k in touched.drain(..) {
                    found(i, j, k, f64::from(first.fraction) * weights[k]);
                    weights[k] = 0.0;
                }
            }
        }
        Some(count)
    }
}

impl Source for Sir {
    fn incident(&self) -> Side {
        Sir::incident(self)
    }

    fn scattered(&self) -> Side {
        Sir::scattered(self)
    }

    fn isotropic(&self) -> bool {
        Sir::isotropic(self)
    }

    fn channels(&self) -> usize {
        Sir::channels(self)
    }

    fn is_measured(&self, wi: DVec3) -> bool {
        let (folded, _) = self.mesh.fold(wi, &self.nodes);
        self.mesh.locate(folded, &self.nodes, &self.migrations) != Place::Outside
    }

    fn slice<'a>(&'a self, wi: DVec3) -> Box<dyn Slice + 'a> {
        Box::new(Sir::slice(self, wi))
    }
}

impl Slice for SirSlice {
    fn eval(&self, wo: &[DVec3], out: &mut [f32]) {
        SirSlice::eval(self, wo, out);
    }
}

fn at_most(count: usize) -> Option<usize> {
    (count <= MOST_LOBES).then_some(count)
}

/// The first threshold at which `count` stays within the limit.
fn within_limit(count: impl Fn(f64) -> Option<usize>) -> f64 {
    let mut threshold = THRESHOLD;
    while count(threshold).is_none() {
        threshold = 2.0 * threshold + 1e-5;
    }
    threshold
}

impl Reach {
    fn new(lobe: &SirLobe, grid: Grid) -> Reach {
        let variance = sigma(lobe.radius).powi(2);
        Reach {
            centre: lobe.centre,
            peak: lobe.peak,
            inverse_variance: 1.0 / variance,
            cell: lobe.cell,
            distance2: REACH * f64::from(grid.resolution).powi(2) * variance,
            colour: lobe.colour,
        }
    }
}

/// Compressed lists of the lobes that reach each tile.
fn tiles(lobes: &[SirLobe], grid: Grid) -> (Vec<u32>, Vec<u32>) {
    let n = f64::from(grid.resolution);
    let span = |lobe: &SirLobe, axis: usize| {
        let reach = REACH.sqrt() * n * sigma(lobe.radius);
        let centre = f64::from(lobe.cell[axis]);
        let tile = |c: f64| tile_of(c.clamp(0.0, n - 1.0) as u16, grid);
        tile((centre - reach).floor())..=tile((centre + reach).ceil())
    };
    let covered = |lobe: &SirLobe| {
        let columns = span(lobe, 1);
        span(lobe, 0).flat_map(move |x| columns.clone().map(move |y| x * TILES + y))
    };
    let mut starts = vec![0_u32; TILES * TILES + 1];
    for lobe in lobes {
        covered(lobe).for_each(|tile| starts[tile + 1] += 1);
    }
    for k in 1..starts.len() {
        starts[k] += starts[k - 1];
    }
    let mut next = starts.clone();
    let mut members = vec![0; starts[TILES * TILES] as usize];
    for (index, lobe) in lobes.iter().enumerate() {
        for tile in covered(lobe) {
            members[next[tile] as usize] = index as u32;
            next[tile] += 1;
        }
    }
    (starts, members)
}

fn tile_of(coordinate: u16, grid: Grid) -> usize {
    usize::from(coordinate) * TILES / usize::from(grid.resolution)
}

impl SirSlice {
    /// f(wi, wo) in 1/sr for each of `wo`; 0 on the wrong side, NaN for NaN.
    ///
    /// Shapes: `out` holds `wo.len()` × channels values, channels fastest: luminance, then (in colour) X and Z.
    pub fn eval(&self, wo: &[DVec3], out: &mut [f32]) {
        for (&w, values) in wo.iter().zip(out.chunks_exact_mut(self.channels)) {
            if w.is_nan() || self.floor.is_nan() {
                values.fill(f32::NAN);
            } else if self.scattered == Some(Side::of(w)) {
                self.value(w, values);
            } else {
                values.fill(0.0);
            }
        }
    }

    fn value(&self, w: DVec3, values: &mut [f32]) {
        let [x, y] = self.grid.cell(w);
        let tile = tile_of(x, self.grid) * TILES + tile_of(y, self.grid);
        let members = &self.members[self.starts[tile] as usize..self.starts[tile + 1] as usize];
        let mut sum = [0.0; 3];
        for lobe in members.iter().map(|&m| &self.lobes[m as usize]) {
            let dx = f64::from(lobe.cell[0]) - f64::from(x);
            let dy = f64::from(lobe.cell[1]) - f64::from(y);
            if dx * dx + dy * dy > lobe.distance2 {
                continue;
            }
            let value = lobe.peak * ((w.dot(lobe.centre) - 1.0) * lobe.inverse_variance).exp();
            sum[0] += value;
            sum[1] += value * f64::from(lobe.colour[0]);
            sum[2] += value * f64::from(lobe.colour[1]);
        }
        let bsdf = sum.map(|s| s / soft_cosine(w.z));
        let floored = bsdf[0] < self.floor;
        for (out, value) in values.iter_mut().zip(bsdf) {
            *out = if floored { self.floor } else { value } as f32;
        }
    }
}
