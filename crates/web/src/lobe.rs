//! One hemisphere of scattered light as a mesh that is fine where the light goes.

use std::collections::HashMap;

use bsdfkit::{Bsdf, DVec2, DVec3, Side};
use bsdfkit_sphere::concentric::{disk_to_hemisphere, hemisphere_to_square, square_to_disk};
use wasm_bindgen::prelude::wasm_bindgen;

use crate::selection::Selection;

/// Levels of the mesh everywhere: 32 × 32 quads, some 6 degrees each.
const COARSEST: usize = 5;
/// A quad with more samples is divided. With 16 of 4096, a mesh has some thousand vertices more than the coarsest one.
const CROWDED: usize = 16;
/// How far inside the rim its vertices are asked for: at the horizon itself sides are ambiguous.
const RIM: f64 = 1.0 - 1e-6;

/// Vertices as directions with f in 1/sr, and triangles without gaps between them.
#[wasm_bindgen]
#[derive(Clone, Debug)]
pub struct Lobe {
    directions: Vec<f32>,
    values: Vec<f32>,
    triangles: Vec<u32>,
}

#[wasm_bindgen]
impl Lobe {
    /// Unit vectors, three numbers each.
    #[wasm_bindgen(getter)]
    pub fn directions(&self) -> Vec<f32> {
        self.directions.clone()
    }

    /// f of each vertex, 1/sr.
    #[wasm_bindgen(getter)]
    pub fn values(&self) -> Vec<f32> {
        self.values.clone()
    }

    /// Numbers of vertices, three a triangle, counter-clockwise seen from outside.
    #[wasm_bindgen(getter)]
    pub fn triangles(&self) -> Vec<u32> {
        self.triangles.clone()
    }
}

impl Lobe {
    /// Quads of the concentric square, divided down to 2^−`finest` where so many samples of f(wi, ·) on `side` crowd.
    ///
    /// Where nothing of f is drawn as samples, the mesh is the coarsest one.
    /// Cost: `samples` samples and a query a vertex.
    pub(crate) fn new(
        bsdf: &Bsdf,
        wi: DVec3,
        side: Side,
        selection: &Selection,
        (finest, samples): (usize, usize),
    ) -> Self {
        let finest = finest.clamp(COARSEST, 14);
        let components = selection.to_side(wi, side);
        let u: Vec<f64> = (0..samples).map(|k| (k as f64 + 0.5) / samples as f64).collect();
        let mut drawn = vec![None; samples];
        bsdf.sample_many(&[wi], &u, components, &mut drawn).expect("one sample for each number");
        let squares = drawn.iter().flatten().map(|s| hemisphere_to_square(s.wo));
        let mut mesh = Quads::new(finest);
        mesh.divide([0, 0], 0, &squares.collect::<Vec<_>>());
        mesh.finish(
            |square| disk_to_hemisphere(square_to_disk(square) * RIM, side),
            side,
            |wo| selection.values(bsdf, wi, wo),
        )
    }
}

/// Corners are counted in quads of the finest level.
type Corner = [u32; 2];

struct Quads {
    finest: usize,
    /// Lower corner and level.
    quads: Vec<(Corner, usize)>,
    vertices: HashMap<Corner, u32>,
    corners: Vec<Corner>,
}

impl Quads {
    fn new(finest: usize) -> Self {
        Self { finest, quads: Vec::new(), vertices: HashMap::new(), corners: Vec::new() }
    }

    fn vertex(&mut self, corner: Corner) -> u32 {
        let next = self.corners.len() as u32;
        *self.vertices.entry(corner).or_insert_with(|| {
            self.corners.push(corner);
            next
        })
    }

    fn divide(&mut self, [x, y]: Corner, level: usize, samples: &[DVec2]) {
        let width = 1_u32 << (self.finest - level);
        if level < COARSEST || (level < self.finest && samples.len() > CROWDED) {
            let half = width / 2;
            let middle = DVec2::new(f64::from(x + half), f64::from(y + half)) / self.cells();
            for quadrant in 0..4 {
                let (right, upper) = (quadrant & 1 == 1, quadrant & 2 == 2);
                let inside = |s: &&DVec2| (s.x >= middle.x) == right && (s.y >= middle.y) == upper;
                let samples: Vec<DVec2> = samples.iter().filter(inside).copied().collect();
                let corner = [x + u32::from(right) * half, y + u32::from(upper) * half];
                self.divide(corner, level + 1, &samples);
            }
            return;
        }
        for corner in [[x, y], [x + width, y], [x + width, y + width], [x, y + width]] {
            self.vertex(corner);
        }
        self.quads.push(([x, y], level));
    }

    fn cells(&self) -> f64 {
        f64::from(1_u32 << self.finest)
    }

    /// The vertices on the edge from `a` to `b`, `b` left out: its own and those of smaller neighbours.
    fn edge(&self, a: Corner, b: Corner, out: &mut Vec<u32>) {
        let middle = [a[0].midpoint(b[0]), a[1].midpoint(b[1])];
        if middle != a && middle != b && self.vertices.contains_key(&middle) {
            self.edge(a, middle, out);
            self.edge(middle, b, out);
        } else {
            out.push(self.vertices[&a]);
        }
    }

    fn finish(
        mut self,
        direction: impl Fn(DVec2) -> DVec3,
        side: Side,
        values: impl Fn(&[DVec3]) -> Vec<f64>,
    ) -> Lobe {
        let mut triangles = Vec::new();
        let mut around = Vec::new();
        for k in 0..self.quads.len() {
            let ([x, y], level) = self.quads[k];
            let width = 1_u32 << (self.finest - level);
            let ring = [[x, y], [x + width, y], [x + width, y + width], [x, y + width]];
            around.clear();
            for n in 0..4 {
                self.edge(ring[n], ring[(n + 1) % 4], &mut around);
            }
            if side == Side::Back {
                around.reverse();
            }
            if let &[a, b, c, d] = &around[..] {
                triangles.extend([a, b, c, a, c, d]);
                continue;
            }
            let centre = self.vertex([x + width / 2, y + width / 2]);
            for n in 0..around.len() {
                triangles.extend([centre, around[n], around[(n + 1) % around.len()]]);
            }
        }
        let scale = 1.0 / self.cells();
        let wo: Vec<DVec3> = self
            .corners
            .iter()
            .map(|&[x, y]| direction(DVec2::new(f64::from(x), f64::from(y)) * scale))
            .collect();
        let values = values(&wo).into_iter().map(|f| f as f32).collect();
        let directions = wo.iter().flat_map(DVec3::to_array).map(|c| c as f32).collect();
        Lobe { directions, values, triangles }
    }
}
