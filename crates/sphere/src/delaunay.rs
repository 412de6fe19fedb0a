//! Delaunay triangulation of directions on one hemisphere: topology apart from positions. [Ren97]
//!
//! The spherical Delaunay triangulation is the convex hull of the points of the unit sphere. The
//! faces of the hull that are seen from far along the normal are kept: projected along the normal
//! into the disk (x, y), they are straight-edged triangles that cover the convex hull of the
//! projected points once. So one mesh serves the sphere and the disk in which BSDFs are stored,
//! and the hull's underside, which spans the rim from below, is no part of it.

mod hull;

use std::fmt;

use glam::{DVec2, DVec3};

/// Two points closer than this (chord of the unit sphere, 0.2″) are one point given twice.
///
/// Far above the 1e-8 at which rounding of z would decide over the mesh, far below what an
/// instrument tells apart; doubled, nothing measured would change.
const COINCIDENT: f64 = 1e-6;

/// Breadth over length of a set of points in the disk below which it is a chain, not an area.
///
/// A guess at how exactly an instrument keeps its plane of incidence (0.06°). Doubled, an oblique
/// narrow sector would be taken for a line.
const NARROW: f64 = 1e-3;

/// Four points lie on one circle if none is higher above the plane of the others than this share of
/// the product of the diagonals (eight times the height of the arc above a chord as long): 0.1 degrees
/// of play in a grid of 15.
const ROUND: f64 = 2e-3;

/// Which directions are joined to which: triangles, edges, boundary. Knows no position.
///
/// Vertices are numbered as the points given to [`Triangulation::new`]. Triangles are
/// counter-clockwise in the disk (x, y) seen from +Z, whichever side the points are on.
/// Points on one line of the disk (one plane of incidence) have no triangles: the mesh is then a
/// chain of edges ([`is_chain`](Self::is_chain)); a single point is a chain of no edge.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Triangulation {
    vertices: usize,
    triangles: Vec<[u32; 3]>,
    neighbours: Vec<[Option<u32>; 3]>,
    triangle_edges: Vec<[u32; 3]>,
    edges: Vec<[u32; 2]>,
    boundary: Vec<[u32; 2]>,
}

impl Triangulation {
    /// Joins unit vectors that lie on one hemisphere, front or back.
    ///
    /// The result depends on the points only, not on their order (but for the numbering); where
    /// four or more points share a circle, as all cells of a θ–φ grid do, the choice of the diagonal
    /// is symmetric about the planes of x and y.
    ///
    /// Errors: no points, a vector that is not of unit length (to 1e-3) or not finite, points on both
    /// sides, a point given twice.
    ///
    /// Cost: O(n log n) for scattered points, some 10 µs a point.
    ///
    /// ```
    /// use bsdfkit_sphere::{delaunay::Triangulation, direction::from_degrees};
    /// let points = [(0., 0.), (60., 0.), (60., 120.), (60., 240.)].map(|(t, p)| from_degrees(t, p));
    /// let mesh = Triangulation::new(&points)?;
    /// assert_eq!(mesh.triangles(), [[0, 1, 2], [0, 2, 3], [0, 3, 1]]);
    /// # Ok::<(), bsdfkit_sphere::delaunay::Unmeshable>(())
    /// ```
    pub fn new(points: &[DVec3]) -> Result<Triangulation, Unmeshable> {
        let points = upper_unit_vectors(points)?;
        if let Some(chain) = chain_order(&points) {
            let boundary: Vec<[u32; 2]> = chain.windows(2).map(|w| [w[0], w[1]]).collect();
            let mut edges: Vec<[u32; 2]> =
                boundary.iter().map(|&[a, b]| [a.min(b), a.max(b)]).collect();
            edges.sort_unstable();
            return Ok(Triangulation {
                vertices: points.len(),
                triangles: Vec::new(),
                neighbours: Vec::new(),
                triangle_edges: Vec::new(),
                edges,
                boundary,
            });
        }
        Ok(Triangulation::in_order(points.len(), hull::upper_hull(&points)))
    }

    /// The same points joined along other diagonals, where these are no less Delaunay.
    ///
    /// Four neighbours on one circle, as in every cell of a θ–φ grid, may be joined along either
    /// diagonal. `prefers(other, joined)` decides whether `other` replaces `joined`; every edge is
    /// asked about once at most, in the order of [`edges`](Self::edges).
    ///
    /// `points`: those that the mesh was made of.
    #[must_use]
    pub fn with_diagonals(
        self,
        points: &[DVec3],
        mut prefers: impl FnMut([u32; 2], [u32; 2]) -> bool,
    ) -> Triangulation {
        if self.is_chain() {
            return self;
        }
        let mut triangles = self.triangles;
        for &[a, b] in &self.edges {
            let sides: Vec<usize> = (0..triangles.len())
                .filter(|&t| triangles[t].contains(&a) && triangles[t].contains(&b))
                .collect();
            let &[s, t] = sides.as_slice() else { continue };
            let opposite = |t: usize| triangles[t].into_iter().find(|&v| v != a && v != b);
            let (Some(c), Some(d)) = (opposite(s), opposite(t)) else { continue };
            let quad = [a, c, b, d].map(|v| points[v as usize]);
            if is_flippable(quad) && prefers([c.min(d), c.max(d)], [a, b]) {
                let place = |v: u32| points[v as usize].truncate();
                let with = |v: u32| {
                    let turn = (place(d) - place(c)).perp_dot(place(v) - place(c));
                    if turn > 0.0 { [c, d, v] } else { [d, c, v] }
                };
                (triangles[s], triangles[t]) = (with(a), with(b));
            }
        }
        Self::in_order(self.vertices, triangles)
    }

    /// The same without triangles of the rim that are flatter than `cosine` says: those whose angle opposite the rim, between
    /// `places` in the plane, has a smaller cosine. What was a notch of the rim is one again. No vertex is lost.
    ///
    /// Cost: the number of triangles, for each one that goes.
    ///
    /// ```
    /// use bsdfkit_sphere::{DVec2, delaunay::Triangulation, direction::from_degrees};
    /// // A notch at the normal: the triangle across it is flat.
    /// let points = [(0., 0.), (60., 80.), (60., 260.), (60., 180.)].map(|(t, p)| from_degrees(t, p));
    /// let places = points.map(|w| w.truncate());
    /// let mesh = Triangulation::new(&points)?.without_flat_rim(&places, -0.7);
    /// assert_eq!(mesh.triangles(), [[0, 1, 3], [0, 3, 2]]);
    /// # Ok::<(), bsdfkit_sphere::delaunay::Unmeshable>(())
    /// ```
    #[must_use]
    pub fn without_flat_rim(self, places: &[DVec2], cosine: f64) -> Triangulation {
        let mut mesh = self;
        loop {
            let mut on_rim = vec![false; mesh.vertices];
            let mut uses = vec![0usize; mesh.vertices];
            mesh.boundary.iter().flatten().for_each(|&v| on_rim[v as usize] = true);
            mesh.triangles.iter().flatten().for_each(|&v| uses[v as usize] += 1);
            let flatness = |t: usize| {
                let edge = (0..3).find(|&k| mesh.neighbours[t][k].is_none())?;
                let [c, a, b] = [0, 1, 2].map(|k| mesh.triangles[t][(edge + k) % 3] as usize);
                let spare = !on_rim[c] && uses[a] > 1 && uses[b] > 1;
                let [p, q] = [a, b].map(|v| (places[v] - places[c]).normalize_or_zero());
                (spare && p.dot(q) < cosine).then(|| p.dot(q))
            };
            let flat = (0..mesh.triangles.len()).filter_map(|t| Some((flatness(t)?, t)));
            let Some((_, t)) = flat.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))) else {
                return mesh;
            };
            let mut triangles = mesh.triangles;
            triangles.remove(t);
            mesh = Self::in_order(mesh.vertices, triangles);
        }
    }

    /// From counter-clockwise triangles in any order.
    fn in_order(vertices: usize, mut triangles: Vec<[u32; 3]>) -> Triangulation {
        for t in &mut triangles {
            let smallest = (0..3).min_by_key(|&k| t[k]).unwrap_or(0);
            t.rotate_left(smallest);
        }
        triangles.sort_unstable();
        Triangulation::from_triangles(vertices, triangles)
    }

    /// Derives edges, neighbours and boundary from counter-clockwise triangles.
    fn from_triangles(vertices: usize, triangles: Vec<[u32; 3]>) -> Triangulation {
        // Every side as (ends in order, triangle, place in it); the two sides of an edge meet.
        let mut sides: Vec<([u32; 2], u32, usize)> = (0_u32..)
            .zip(&triangles)
            .flat_map(|(index, t)| {
                (0..3).map(move |k| {
                    let (a, b) = (t[(k + 1) % 3], t[(k + 2) % 3]);
                    ([a.min(b), a.max(b)], index, k)
                })
            })
            .collect();
        sides.sort_unstable();
        let mut neighbours = vec![[None; 3]; triangles.len()];
        let mut triangle_edges = vec![[0; 3]; triangles.len()];
        let mut edges = Vec::new();
        let mut boundary = Vec::new();
        for shared in sides.chunk_by(|s, t| s.0 == t.0) {
            for &(_, t, k) in shared {
                triangle_edges[t as usize][k] = edges.len() as u32;
            }
            edges.push(shared[0].0);
            match *shared {
                [(_, s, j), (_, t, k), ..] => {
                    neighbours[s as usize][j] = Some(t);
                    neighbours[t as usize][k] = Some(s);
                }
                [(_, t, k)] => {
                    let t = triangles[t as usize];
                    boundary.push([t[(k + 1) % 3], t[(k + 2) % 3]]);
                }
                [] => {}
            }
        }
        let boundary = in_sequence(vertices, &boundary);
        Triangulation { vertices, triangles, neighbours, triangle_edges, edges, boundary }
    }

    /// How many points were given: vertices are 0..this.
    pub fn vertex_count(&self) -> usize {
        self.vertices
    }

    /// Vertices of each triangle, counter-clockwise seen from +Z, the smallest first; sorted.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// For each triangle, the one on the other side of the edge opposite its vertex k.
    pub fn neighbours(&self) -> &[[Option<u32>; 3]] {
        &self.neighbours
    }

    /// For each triangle, the index in [`edges`](Self::edges) of the edge opposite its vertex k.
    pub fn triangle_edges(&self) -> &[[u32; 3]] {
        &self.triangle_edges
    }

    /// Every edge once, smaller vertex first; sorted.
    pub fn edges(&self) -> &[[u32; 2]] {
        &self.edges
    }

    /// Index in [`edges`](Self::edges) of the edge between two vertices, in either order.
    pub fn edge_between(&self, a: u32, b: u32) -> Option<u32> {
        self.edges.binary_search(&[a.min(b), a.max(b)]).ok().map(|index| index as u32)
    }

    /// The edges with a triangle on one side only, one after the other, the mesh on their left.
    ///
    /// Of a chain: its edges from one end to the other.
    pub fn boundary(&self) -> &[[u32; 2]] {
        &self.boundary
    }

    /// Whether all points lie on a line of the disk, so that there are no triangles.
    pub fn is_chain(&self) -> bool {
        self.triangles.is_empty()
    }
}

/// Whether the corners of a quadrilateral, in sequence, are on one circle (to [`ROUND`]) and its
/// projection into the disk is convex, so that either diagonal will do.
fn is_flippable([a, b, c, d]: [DVec3; 4]) -> bool {
    let normal = (c - a).cross(d - b);
    let size = (c - a).length() * (d - b).length();
    let lift = normal.dot(b - a).abs();
    let [p, q, r, s] = [a, b, c, d].map(DVec3::truncate);
    let turns =
        [(p, q, r), (q, r, s), (r, s, p), (s, p, q)].map(|(u, v, w)| (v - u).perp_dot(w - v));
    let convex = turns.iter().all(|t| *t > 0.0) || turns.iter().all(|t| *t < 0.0);
    convex && lift < ROUND * size * size
}

/// The points, normalised and turned to the upper side, if they can be meshed.
fn upper_unit_vectors(points: &[DVec3]) -> Result<Vec<DVec3>, Unmeshable> {
    if let Some(index) =
        points.iter().position(|p| (p.length() - 1.0).abs() >= 1e-3 || !p.is_finite())
    {
        return Err(Unmeshable::NotUnit { index });
    }
    let extreme =
        (0..points.len()).max_by(|&i, &j| points[i].z.abs().total_cmp(&points[j].z.abs()));
    let Some(extreme) = extreme else { return Err(Unmeshable::Empty) };
    let side = if points[extreme].z < 0.0 { -1.0 } else { 1.0 };
    // A horizontal direction computed from degrees may sink by a rounding error.
    if let Some(other) = points.iter().position(|p| p.z * side < -COINCIDENT) {
        return Err(Unmeshable::BothSides {
            first: extreme.min(other),
            second: extreme.max(other),
        });
    }
    let upper: Vec<DVec3> =
        points.iter().map(|p| DVec3::new(p.x, p.y, (p.z * side).max(0.0)).normalize()).collect();
    let mut by_x: Vec<usize> = (0..upper.len()).collect();
    by_x.sort_by(|&i, &j| upper[i].x.total_cmp(&upper[j].x).then(i.cmp(&j)));
    for (k, &i) in by_x.iter().enumerate() {
        let near = by_x[k + 1..].iter().take_while(|&&j| upper[j].x - upper[i].x < COINCIDENT);
        if let Some(&j) = near.clone().find(|&&j| upper[i].distance(upper[j]) < COINCIDENT) {
            return Err(Unmeshable::Duplicate { first: i.min(j), second: i.max(j) });
        }
    }
    Ok(upper)
}

/// The points in order along a line of the disk, if they all lie on one.
fn chain_order(points: &[DVec3]) -> Option<Vec<u32>> {
    let disk: Vec<DVec2> = points.iter().map(|p| p.truncate()).collect();
    let farthest = |from: DVec2| {
        let far =
            |a: &DVec2, b: &DVec2| from.distance_squared(*a).total_cmp(&from.distance_squared(*b));
        disk.iter().copied().max_by(far).unwrap_or(from)
    };
    let one = farthest(disk[0]);
    let along = farthest(one) - one;
    let breadth = disk.iter().map(|&p| along.perp_dot(p - one).abs()).fold(0.0, f64::max);
    if breadth > NARROW * along.length_squared() {
        return None;
    }
    // From the end with the smaller x, then y: the order of the points does not matter.
    let along = if (along.x, along.y) < (0.0, 0.0) { -along } else { along };
    let mut order: Vec<u32> = (0..points.len() as u32).collect();
    order.sort_by(|&i, &j| along.dot(disk[i as usize]).total_cmp(&along.dot(disk[j as usize])));
    Some(order)
}

/// Directed edges, each vertex left as often as entered, → the same, loop by loop.
fn in_sequence(vertices: usize, edges: &[[u32; 2]]) -> Vec<[u32; 2]> {
    let mut next = vec![None; vertices];
    for &[a, b] in edges {
        next[a as usize] = Some(b);
    }
    let mut sequence = Vec::with_capacity(edges.len());
    for start in 0..vertices {
        let mut from = start;
        while let Some(to) = next[from].take() {
            sequence.push([from as u32, to]);
            from = to as usize;
        }
    }
    sequence
}

/// Why points cannot be joined to a mesh; indices are those of the points given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Unmeshable {
    /// No points.
    Empty,
    /// A vector whose length is not 1, or not a number.
    NotUnit {
        /// Its index.
        index: usize,
    },
    /// Two points on different sides of the surface.
    BothSides {
        /// The smaller index.
        first: usize,
        /// The larger index.
        second: usize,
    },
    /// Two points that are the same direction.
    Duplicate {
        /// The smaller index.
        first: usize,
        /// The larger index.
        second: usize,
    },
}

impl fmt::Display for Unmeshable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Unmeshable::Empty => write!(f, "expected at least one direction, found none"),
            Unmeshable::NotUnit { index } => {
                write!(f, "direction {index}: expected a unit vector, found another length")
            }
            Unmeshable::BothSides { first, second } => {
                write!(f, "directions {first} and {second}: expected one side, found both")
            }
            Unmeshable::Duplicate { first, second } => {
                write!(
                    f,
                    "directions {first} and {second}: expected different ones, found one twice"
                )
            }
        }
    }
}

impl std::error::Error for Unmeshable {}
