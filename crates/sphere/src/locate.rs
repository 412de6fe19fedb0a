//! Which triangle of a mesh holds a point of the disk, and where in it.

use glam::DVec2;
use robust::{Coord, orient2d};

use crate::delaunay::Triangulation;

/// Most cells along a side of the look-up grid: 64² lists of a few triangles stay in cache.
const MOST_CELLS: f64 = 64.0;

/// Finds points in a [`Triangulation`] laid out straight-edged in the disk (x, y).
///
/// Cost: build O(n); a query tests the few triangles that touch one cell of a grid; a point
/// outside tests every outline edge, O(√n).
#[derive(Clone, Debug)]
pub struct Locator {
    positions: Vec<DVec2>,
    triangles: Vec<[u32; 3]>,
    outline: Vec<[u32; 2]>,
    /// Where the edges of the outline are.
    sides: Vec<OutlineSide>,
    corner: DVec2,
    cells_per_length: DVec2,
    cells: usize,
    /// Where each cell's triangles start in `listed`; one more at the end.
    starts: Vec<u32>,
    listed: Vec<u32>,
}

/// An edge of the outline in the disk.
#[derive(Clone, Copy, Debug)]
struct OutlineSide {
    start: DVec2,
    along: DVec2,
    /// 1 / |along|²; 0 of a point.
    per_length_squared: f64,
}

/// Where a point is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Location {
    /// In a triangle, sides included.
    Inside {
        /// Index in [`Triangulation::triangles`].
        triangle: u32,
        /// Weights of its vertices: none negative, sum 1; they reproduce the point.
        barycentric: [f64; 3],
    },
    /// Outside all triangles (of a chain: anywhere); the nearest point of the outline.
    Outside {
        /// Vertices of the nearest outline edge; the same one twice if the mesh is a single point.
        edge: [u32; 2],
        /// 0 at the first, 1 at the second.
        fraction: f64,
        /// How far it is, in the disk.
        distance: f64,
    },
}

impl Locator {
    /// Lays `mesh` out at `positions`, the (x, y) of the directions it was made from.
    ///
    /// `None` if there are not as many positions as vertices, or one is not finite.
    pub fn new(mesh: &Triangulation, positions: &[DVec2]) -> Option<Locator> {
        let fits = positions.len() == mesh.vertex_count() && !positions.is_empty();
        if !fits || !positions.iter().all(|p| p.is_finite()) {
            return None;
        }
        let corner = positions.iter().copied().fold(positions[0], DVec2::min);
        let extent = positions.iter().copied().fold(positions[0], DVec2::max) - corner;
        let side = (mesh.triangles().len() as f64).sqrt().ceil().clamp(1.0, MOST_CELLS);
        let mut locator = Locator {
            positions: positions.to_vec(),
            triangles: mesh.triangles().to_vec(),
            outline: mesh.boundary().to_vec(),
            sides: Vec::new(),
            corner,
            cells_per_length: side / extent.max(DVec2::splat(f64::MIN_POSITIVE)),
            cells: side as usize,
            starts: Vec::new(),
            listed: Vec::new(),
        };
        if locator.outline.is_empty() {
            locator.outline.push([0, 0]);
        }
        let side = |edge: &[u32; 2]| {
            let [start, end] = edge.map(|v| positions[v as usize]);
            let (along, length_squared) = (end - start, end.distance_squared(start));
            let per_length_squared = if length_squared > 0.0 { 1.0 / length_squared } else { 0.0 };
            OutlineSide { start, along, per_length_squared }
        };
        locator.sides = locator.outline.iter().map(side).collect();
        let mut lists = vec![Vec::new(); locator.cells * locator.cells];
        for (index, t) in (0_u32..).zip(mesh.triangles()) {
            let [a, b, c] = t.map(|v| positions[v as usize]);
            let (low, high) = (locator.cell(a.min(b).min(c)), locator.cell(a.max(b).max(c)));
            for row in low.1..=high.1 {
                for column in low.0..=high.0 {
                    lists[row * locator.cells + column].push(index);
                }
            }
        }
        locator.starts.push(0);
        for list in lists {
            locator.listed.extend(list);
            locator.starts.push(locator.listed.len() as u32);
        }
        Some(locator)
    }

    /// Where `p` is. Continuous in `p`: weights across edges, nearest points across the outline.
    ///
    /// A point on an edge belongs to one of its triangles, always the same. NaN is outside, with
    /// `fraction` and `distance` NaN.
    ///
    /// Accuracy: the choice of the triangle is exact, so no point falls between two.
    pub fn locate(&self, p: DVec2) -> Location {
        let (column, row) = self.cell(p);
        let cell = row * self.cells + column;
        let listed = &self.listed[self.starts[cell] as usize..self.starts[cell + 1] as usize];
        for &triangle in listed {
            if let Some(barycentric) = self.barycentric(self.triangles[triangle as usize], p) {
                return Location::Inside { triangle, barycentric };
            }
        }
        self.nearest_on_outline(p)
    }

    /// Column and row of the grid cell that holds `p`, or of the nearest.
    fn cell(&self, p: DVec2) -> (usize, usize) {
        // The casts saturate, and take NaN to 0.
        let at = (p - self.corner) * self.cells_per_length;
        ((at.x as usize).min(self.cells - 1), (at.y as usize).min(self.cells - 1))
    }

    /// Weights of the corners of `t` at `p`, if p is inside or on a side.
    fn barycentric(&self, t: [u32; 3], p: DVec2) -> Option<[f64; 3]> {
        let [a, b, c] = t.map(|v| self.positions[v as usize]);
        let opposite_a = area(b, c, p);
        let opposite_b = area(c, a, p);
        let opposite_c = area(a, b, p);
        if !(opposite_a >= 0.0 && opposite_b >= 0.0 && opposite_c >= 0.0) {
            return None;
        }
        let sum = opposite_a + opposite_b + opposite_c;
        (sum > 0.0).then(|| [opposite_a / sum, opposite_b / sum, opposite_c / sum])
    }

    fn nearest_on_outline(&self, p: DVec2) -> Location {
        let (mut nearest, mut least) = (0, f64::INFINITY);
        for (k, side) in self.sides.iter().enumerate() {
            let from = p - side.start;
            let fraction = (from.dot(side.along) * side.per_length_squared).clamp(0.0, 1.0);
            let distance = (from - fraction * side.along).length_squared();
            if distance < least {
                (nearest, least) = (k, distance);
            }
        }
        let (edge, side) = (self.outline[nearest], self.sides[nearest]);
        let length_squared = side.along.length_squared();
        let fraction = if length_squared > 0.0 {
            ((p - side.start).dot(side.along) / length_squared).clamp(0.0, 1.0)
        } else {
            0.0 * (p - side.start).dot(p - side.start)
        };
        let distance = p.distance(side.start + fraction * side.along);
        Location::Outside { edge, fraction, distance }
    }
}

impl Location {
    /// Up to three vertices and their weights (sum 1); unused ones have weight 0.
    pub fn weights(&self, mesh: &Triangulation) -> [(u32, f64); 3] {
        match *self {
            Location::Inside { triangle, barycentric: [a, b, c] } => {
                let t = mesh.triangles()[triangle as usize];
                [(t[0], a), (t[1], b), (t[2], c)]
            }
            Location::Outside { edge: [a, b], fraction, .. } => {
                [(a, 1.0 - fraction), (b, fraction), (b, 0.0)]
            }
        }
    }
}

/// Twice the area of abp, its sign exact.
fn area(a: DVec2, b: DVec2, p: DVec2) -> f64 {
    let coord = |v: DVec2| Coord { x: v.x, y: v.y };
    orient2d(coord(a), coord(b), coord(p))
}
