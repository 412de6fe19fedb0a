//! The upper convex hull of points of the sphere, point by point, with exact predicates. [BW81]
//!
//! The region outside is covered by ghost triangles, one on each side of the outline, that share
//! one vertex at infinity; so a point outside is inserted as one inside is.

use glam::{DVec2, DVec3};
use robust::{Coord, Coord3D, orient2d, orient3d};

use crate::concentric::disk_to_square;
use crate::hilbert::fold;

/// The vertex at infinity.
const GHOST: u32 = u32::MAX;

/// How far the sphere is dented, along x² and along x y, so that four points on a circle are
/// none any more. The first, being even in x and in y, chooses the same diagonal in mirrored cells;
/// the second, much less, decides for the cells that are their own mirror image. Both are far above
/// rounding (1e-16) and, doubled, would still be far below what an instrument resolves.
const DENT: [f64; 2] = [1e-9, 1e-11];

/// A vertex this near (radians, 0.1°) to an edge of the outline, along which it bends by less than
/// `BEND`, is on the outline: the needle between is left out. Rounding moves the points of a straight
/// outline by 1e-16, an instrument by 1e-3; doubled, the rim between dense incidences would fray.
const PLAY: f64 = 2e-3;

/// Most that a needle may bend the outline inward (radians): where it bends, the nearest outline
/// point jumps by this share of its distance. A guess; doubled, the jump doubles; halved, an
/// outline of 10° steps keeps the needles of 0.1° of play.
const BEND: f64 = 0.2;

/// Counter-clockwise triangles that are seen from far along +Z. Points: upper unit vectors, no two
/// equal, not all on one line of the disk.
pub(super) fn upper_hull(points: &[DVec3]) -> Vec<[u32; 3]> {
    let mut order: Vec<u32> = (0..points.len() as u32).collect();
    let key = |i: u32| fold(disk_to_square(points[i as usize].truncate()));
    order.sort_by(|&i, &j| key(i).total_cmp(&key(j)).then(i.cmp(&j)));
    let Some(mut hull) = Hull::start(points, &mut order) else { return Vec::new() };
    for &p in &order {
        hull.insert(p);
    }
    hull.without_needles()
}

struct Hull {
    /// (x, y, height): the hull below `height` in the usual picture of Delaunay by lifting.
    points: Vec<Coord3D<f64>>,
    triangles: Vec<[u32; 3]>,
    /// Across the edge opposite vertex k.
    neighbours: Vec<[u32; 3]>,
    /// For each vertex, and the ghost last: the new triangle whose rim edge starts there.
    starting: Vec<u32>,
    /// Where the last point went: the next is near.
    last: u32,
}

impl Hull {
    /// A first triangle of three points taken out of `order`, with its ghosts.
    fn start(points: &[DVec3], order: &mut Vec<u32>) -> Option<Hull> {
        let lifted: Vec<Coord3D<f64>> = points
            .iter()
            .map(|p| Coord3D { x: p.x, y: p.y, z: p.x * (DENT[0] * p.x + DENT[1] * p.y) - p.z })
            .collect();
        let (a, b) = (*order.first()?, *order.get(1)?);
        let area = |c: u32| orient(&lifted, a, b, c);
        let c = order.iter().copied().max_by(|&c, &d| area(c).abs().total_cmp(&area(d).abs()))?;
        if area(c) == 0.0 {
            return None;
        }
        let (b, c) = if area(c) > 0.0 { (b, c) } else { (c, b) };
        order.retain(|&p| p != a && p != b && p != c);
        Some(Hull {
            starting: vec![0; lifted.len() + 1],
            points: lifted,
            triangles: vec![[a, b, c], [GHOST, c, b], [GHOST, a, c], [GHOST, b, a]],
            neighbours: vec![[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]],
            last: 0,
        })
    }

    /// Whether point `p` takes triangle `t` off the hull.
    fn conflicts(&self, t: u32, p: u32) -> bool {
        let t = self.triangles[t as usize];
        let at = |i: u32| self.points[i as usize];
        match t.iter().position(|&v| v == GHOST) {
            None => orient3d(at(t[0]), at(t[1]), at(t[2]), at(p)) > 0.0,
            Some(k) => {
                let (a, b) = (t[(k + 1) % 3], t[(k + 2) % 3]);
                let side = orient(&self.points, a, b, p);
                let (a, b, p) = (at(a), at(b), at(p));
                let before = (p.x - a.x) * (b.x - a.x) + (p.y - a.y) * (b.y - a.y);
                let after = (p.x - b.x) * (a.x - b.x) + (p.y - b.y) * (a.y - b.y);
                side > 0.0 || (side == 0.0 && before > 0.0 && after > 0.0)
            }
        }
    }

    /// A triangle that `p` takes off, found by walking toward it from the last one.
    fn walk(&self, p: u32) -> Option<u32> {
        let mut t = self.last;
        // The walk over a Delaunay mesh never returns; the bound is for what rounding may undo.
        for _ in 0..self.triangles.len() {
            let corners = self.triangles[t as usize];
            let toward = (0..3).find(|&k| {
                let (a, b) = (corners[(k + 1) % 3], corners[(k + 2) % 3]);
                match corners.iter().position(|&v| v == GHOST) {
                    None => orient(&self.points, a, b, p) < 0.0,
                    Some(ghost) => k == ghost && orient(&self.points, a, b, p) <= 0.0,
                }
            });
            match toward {
                Some(k) => t = self.neighbours[t as usize][k],
                None => break,
            }
        }
        let all = 0..self.triangles.len() as u32;
        std::iter::once(t).chain(all).find(|&t| self.conflicts(t, p))
    }

    /// Replaces all triangles that `p` takes off by the fan from `p` to their rim.
    ///
    /// A point that takes off none is within rounding of the hull of its neighbours, and left out.
    fn insert(&mut self, p: u32) {
        let Some(first) = self.walk(p) else { return };
        let mut taken = vec![first];
        let mut rim = Vec::new();
        let mut next = 0;
        while let Some(&t) = taken.get(next) {
            next += 1;
            for k in 0..3 {
                let across = self.neighbours[t as usize][k];
                if taken.contains(&across) {
                    continue;
                }
                if self.conflicts(across, p) {
                    taken.push(across);
                } else {
                    let corners = self.triangles[t as usize];
                    rim.push((corners[(k + 1) % 3], corners[(k + 2) % 3], across));
                }
            }
        }
        let mut free = taken.iter().copied();
        let mut fan = Vec::with_capacity(rim.len());
        for (a, b, across) in rim {
            let new = free.next().unwrap_or(self.triangles.len() as u32);
            if new as usize == self.triangles.len() {
                self.triangles.push([0; 3]);
                self.neighbours.push([0; 3]);
            }
            fan.push((new, [p, a, b], across));
            let slot = self.slot(a);
            self.starting[slot] = new;
        }
        for &(new, corners, across) in &fan {
            let outer = self.triangles[across as usize];
            let facing = (0..3).find(|&k| outer[k] != corners[1] && outer[k] != corners[2]);
            if let Some(k) = facing {
                self.neighbours[across as usize][k] = new;
            }
        }
        for (new, corners, across) in fan {
            let after = self.starting[self.slot(corners[2])];
            self.triangles[new as usize] = corners;
            self.neighbours[new as usize][0] = across;
            self.neighbours[new as usize][1] = after;
            self.neighbours[after as usize][2] = new;
            self.last = new;
        }
    }

    fn slot(&self, vertex: u32) -> usize {
        (vertex as usize).min(self.points.len())
    }

    /// The real triangles, less those along the outline that are needles.
    fn without_needles(&self) -> Vec<[u32; 3]> {
        let mut outside: Vec<bool> = self.triangles.iter().map(|t| t.contains(&GHOST)).collect();
        let mut on_outline = vec![false; self.points.len()];
        for v in self.triangles.iter().filter(|t| t.contains(&GHOST)).flatten() {
            if *v != GHOST {
                on_outline[*v as usize] = true;
            }
        }
        let mut open: Vec<u32> = (0..self.triangles.len() as u32).collect();
        while let Some(t) = open.pop() {
            let corners = self.triangles[t as usize];
            let neighbours = self.neighbours[t as usize];
            let mut open_sides = (0..3).filter(|&k| outside[neighbours[k] as usize]);
            let (Some(k), None) = (open_sides.next(), open_sides.next()) else { continue };
            let apex = corners[k];
            if !outside[t as usize] && !on_outline[apex as usize] && self.is_needle(corners, k) {
                on_outline[apex as usize] = true;
                outside[t as usize] = true;
                open.extend(neighbours);
            }
        }
        let inside = self.triangles.iter().zip(outside).filter(|(_, outside)| !outside);
        inside.map(|(t, _)| *t).collect()
    }

    /// Whether corner k is on the opposite edge, as far as an instrument can tell.
    fn is_needle(&self, corners: [u32; 3], k: usize) -> bool {
        let at = |k: usize| {
            let p = self.points[corners[k % 3] as usize];
            DVec2::new(p.x, p.y)
        };
        let (apex, a, b) = (at(k), at(k + 1), at(k + 2));
        let (forward, area) = ((a - apex).dot(b - apex), (a - apex).perp_dot(b - apex));
        // Heights on the sphere are foreshortened in the disk.
        let along = (b - a).normalize_or_zero();
        let shortening = (1.0 - along.perp_dot(apex).powi(2)).max(0.0).sqrt();
        area < BEND * -forward && area < PLAY * shortening * (b - a).length()
    }
}

/// Twice the area of triangle abc in the disk, its sign exact: positive if counter-clockwise.
fn orient(points: &[Coord3D<f64>], a: u32, b: u32, c: u32) -> f64 {
    let at = |i: u32| {
        let p = points[i as usize];
        Coord { x: p.x, y: p.y }
    };
    orient2d(at(a), at(b), at(c))
}
