//! Incidences, edges and faces of a SIR file, and which of them an incident direction falls on.

use std::f64::consts::FRAC_PI_2;

use bsdfkit::{Error, Result};
use bsdfkit_sphere::DVec3;

use super::boxes::{BoundingBox, BoxTree};
use super::node::SirNode;
use super::plan::Migration;

/// A direction nearer than this to the end of an edge takes that node as it is, in radians. [reference]
const SNAP: f64 = 1e-3;
/// cos c − cos(a + b) below which a direction counts as on the edge: a band of half a degree at 15-degree edges. [reference]
const ON_EDGE: f64 = 2e-4;
/// How far beyond the first and last polar cosine of an isotropic set a direction still counts as inside. [reference]
const Z_SLACK: f64 = 1e-6;

/// What an incident direction falls on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Place {
    /// Beyond every measured incidence.
    Outside,
    /// At a node.
    Node(usize),
    /// At fraction `t` of the edge of a migration.
    Edge { migration: usize, t: f64 },
    /// In a face: fraction `s` from its first to its second node, then `t` on to the third.
    Face { face: Face, s: f64, t: f64 },
}

/// Three nodes in rising order and the migrations 0→1, 1→2, 0→2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Face {
    pub(super) nodes: [usize; 3],
    pub(super) edges: [usize; 3],
}

/// How lobes found at the folded direction come back to the asked one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Unfold {
    /// Mirror x, mirror y.
    Mirror(bool, bool),
    /// Rotate about +Z by this angle.
    Rotate(f64),
}

/// Edges and faces over the measured incidences. Knows no lobes.
#[derive(Debug)]
pub(super) struct Mesh {
    symmetry: i32,
    shape: Shape,
}

#[derive(Debug)]
enum Shape {
    /// Isotropic: migration k joins nodes k and k + 1.
    Chain { migrations: Vec<usize> },
    /// Everything else; the tree numbers edges first, then faces from the smallest to the largest.
    Faces { faces: Vec<Face>, edges: usize, tree: BoxTree },
}

impl Mesh {
    /// Finds the faces: every three edges that close are one, as the reference has it.
    ///
    /// Errors: format when a chain has a gap, an edge comes twice, or there are more faces than in any planar mesh.
    pub(super) fn new(symmetry: i32, nodes: &[SirNode], migrations: &[Migration]) -> Result<Mesh> {
        let mut pairs: Vec<(usize, usize, usize)> =
            migrations.iter().enumerate().map(|(k, m)| (m.from, m.to, k)).collect();
        pairs.sort_unstable();
        if let Some(w) = pairs.windows(2).find(|w| (w[0].0, w[0].1) == (w[1].0, w[1].1)) {
            let (from, to, _) = w[0];
            return Err(Error::format(format!(
                "expected one migration from {from} to {to}, found two"
            )));
        }
        let shape = if symmetry == 0 { chain(nodes, &pairs)? } else { faces(nodes, &pairs)? };
        Ok(Mesh { symmetry, shape })
    }

    pub(super) fn isotropic(&self) -> bool {
        self.symmetry == 0
    }

    /// `wi` moved into the measured range, and the way back.
    pub(super) fn fold(&self, wi: DVec3, nodes: &[SirNode]) -> (DVec3, Unfold) {
        if self.symmetry == 0 {
            let measured = nodes[nodes.len() - 1].incident.truncate();
            let turn = if wi.truncate().length_squared() == 0.0 || measured.length_squared() == 0.0
            {
                0.0
            } else {
                wi.y.atan2(wi.x) - measured.y.atan2(measured.x)
            };
            return (rotate(wi, -turn), Unfold::Rotate(turn));
        }
        // Quadrants 1 (x, y > 0), 2 (x < 0), 4 (both < 0), 8 (y < 0): a sign is free when both of its quadrants are in.
        let covers = |bits: i32| self.symmetry & bits != 0;
        let mirror = |value: f64, positive: i32, negative: i32| {
            (value < 0.0 && !covers(negative)) || (value > 0.0 && !covers(positive))
        };
        let (x, y) = (mirror(wi.x, 1 | 8, 2 | 4), mirror(wi.y, 1 | 2, 4 | 8));
        let flip = |value: f64, mirrored: bool| if mirrored { -value } else { value };
        (DVec3::new(flip(wi.x, x), flip(wi.y, y), wi.z), Unfold::Mirror(x, y))
    }

    /// What the folded direction `wi` falls on. Cost: O(log n), no allocation.
    pub(super) fn locate(&self, wi: DVec3, nodes: &[SirNode], migrations: &[Migration]) -> Place {
        match &self.shape {
            Shape::Chain { migrations: links } => {
                let z = wi.z.abs();
                let polar = |k: usize| nodes[k].incident.z.abs();
                if z > polar(0) + Z_SLACK || z < polar(links.len()) - Z_SLACK {
                    return Place::Outside;
                }
                if links.is_empty() {
                    return Place::Node(0);
                }
                let above = nodes[1..links.len()].partition_point(|n| n.incident.z.abs() > z);
                on_edge(wi, links[above], nodes, migrations)
            }
            Shape::Faces { faces, edges, tree } => {
                let mut first = u32::MAX;
                tree.visit(wi, |item| {
                    let hit = match (item as usize).checked_sub(*edges) {
                        Some(face) => in_face(wi, &faces[face], nodes),
                        None => near_edge(wi, &migrations[item as usize], nodes),
                    };
                    if hit {
                        first = first.min(item);
                    }
                });
                match (first as usize).checked_sub(*edges) {
                    _ if first == u32::MAX => Place::Outside,
                    None => on_edge(wi, first as usize, nodes, migrations),
                    Some(face) => {
                        let face = faces[face];
                        let [a, b, c] = face.nodes.map(|n| nodes[n].incident);
                        let s =
                            fraction(angle(a.cross(c), wi.cross(c)), angle(a.cross(c), b.cross(c)));
                        let p = slerp(a, b, s);
                        Place::Face { face, s, t: fraction(angle(p, wi), angle(p, c)) }
                    }
                }
            }
        }
    }
}

fn chain(nodes: &[SirNode], pairs: &[(usize, usize, usize)]) -> Result<Shape> {
    let fault = |k: usize, what: &str| {
        Error::format(format!(
            "isotropic interpolant: expected {what} between nodes {k} and {}, found none",
            k + 1
        ))
    };
    for (k, pair) in nodes.windows(2).enumerate() {
        if pair[0].incident.z.abs() <= pair[1].incident.z.abs() {
            return Err(fault(k, "a rising polar angle"));
        }
    }
    let migrations = (0..nodes.len() - 1)
        .map(|k| {
            let found = pairs.binary_search_by(|&(from, to, _)| (from, to).cmp(&(k, k + 1)));
            found.map(|at| pairs[at].2).map_err(|_| fault(k, "a migration"))
        })
        .collect::<Result<_>>()?;
    Ok(Shape::Chain { migrations })
}

fn faces(nodes: &[SirNode], pairs: &[(usize, usize, usize)]) -> Result<Shape> {
    let most = 4 * nodes.len();
    let out = |node: usize| {
        let start = pairs.partition_point(|p| p.0 < node);
        let end = pairs.partition_point(|p| p.0 <= node);
        &pairs[start..end]
    };
    let mut faces = Vec::new();
    for &(a, b, ab) in pairs {
        let (from_a, from_b) = (out(a), out(b));
        let (fewer, more) =
            if from_a.len() < from_b.len() { (from_a, from_b) } else { (from_b, from_a) };
        for &(_, c, first) in fewer {
            let Ok(at) = more.binary_search_by(|p| p.1.cmp(&c)) else { continue };
            let second = more[at].2;
            let (ac, bc) =
                if from_a.len() < from_b.len() { (first, second) } else { (second, first) };
            faces.push(Face { nodes: [a, b, c], edges: [ab, bc, ac] });
            if faces.len() > most {
                let count = nodes.len();
                return Err(Error::format(format!(
                    "expected a planar mesh of {count} nodes, found more than {most} faces"
                )));
            }
        }
    }
    // Three edges around a fourth node close too, but are no face: the smaller ones come first and win.
    let area = |f: &Face| {
        let [a, b, c] = f.nodes.map(|n| nodes[n].incident);
        (b - a).cross(c - a).length()
    };
    faces.sort_by(|f, g| area(f).total_cmp(&area(g)));
    let mut edges: Vec<(usize, BoundingBox)> = pairs
        .iter()
        .map(|&(a, b, k)| {
            let (a, b) = (nodes[a].incident, nodes[b].incident);
            let reach = (a.dot(b) - ON_EDGE).max(-1.0).acos() * 0.5;
            (k, BoundingBox::of_cap((a + b).normalize_or_zero(), reach))
        })
        .collect();
    edges.sort_unstable_by_key(|e| e.0);
    let boxes: Vec<BoundingBox> = edges
        .into_iter()
        .map(|e| e.1)
        .chain(faces.iter().map(|f| {
            let corners = f.nodes.map(|n| nodes[n].incident);
            let middle = (corners[0] + corners[1] + corners[2]).normalize_or_zero();
            BoundingBox::of_cap(
                middle,
                corners.iter().map(|&c| angle(middle, c)).fold(0.0, f64::max),
            )
        }))
        .collect();
    Ok(Shape::Faces { faces, edges: pairs.len(), tree: BoxTree::new(boxes) })
}

/// The place on the edge of a migration, ends snapped.
fn on_edge(wi: DVec3, migration: usize, nodes: &[SirNode], migrations: &[Migration]) -> Place {
    let Migration { from, to, .. } = migrations[migration];
    let (a, b) = (nodes[from].incident, nodes[to].incident);
    if angle(a, wi) < SNAP {
        Place::Node(from)
    } else if angle(b, wi) < SNAP {
        Place::Node(to)
    } else {
        Place::Edge { migration, t: fraction(angle(a, wi), angle(a, b)) }
    }
}

fn near_edge(wi: DVec3, edge: &Migration, nodes: &[SirNode]) -> bool {
    let (a, b) = (nodes[edge.from].incident, nodes[edge.to].incident);
    let (to_a, to_b) = (angle(a, wi), angle(b, wi));
    to_a < FRAC_PI_2 && to_b < FRAC_PI_2 && a.dot(b) - (to_a + to_b).cos() < ON_EDGE
}

fn in_face(wi: DVec3, face: &Face, nodes: &[SirNode]) -> bool {
    let [a, b, c] = face.nodes.map(|n| nodes[n].incident);
    let turn = a.cross(b).dot(c).signum();
    [(a, b), (b, c), (c, a)].iter().all(|(p, q)| p.cross(*q).dot(wi) * turn > 0.0)
}

fn fraction(part: f64, whole: f64) -> f64 {
    if whole > 0.0 { (part / whole).min(1.0) } else { 0.0 }
}

/// Angle between two vectors, accurate for small ones too.
pub(super) fn angle(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}

/// The point at fraction `t` of the great circle from `a` to `b`; `a` itself where the circle is not defined.
pub(super) fn slerp(a: DVec3, b: DVec3, t: f64) -> DVec3 {
    let across = (b - a * a.dot(b)).normalize_or_zero();
    let (sin, cos) = (angle(a, b) * t).sin_cos();
    if across == DVec3::ZERO { a } else { a * cos + across * sin }
}

/// `w` turned about +Z by `angle`.
pub(super) fn rotate(w: DVec3, angle: f64) -> DVec3 {
    let (sin, cos) = angle.sin_cos();
    DVec3::new(w.x * cos - w.y * sin, w.x * sin + w.y * cos, w.z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bsdfkit_sphere::direction::{from_degrees, to_degrees};

    fn node(theta: f64, phi: f64) -> SirNode {
        SirNode { incident: from_degrees(theta, phi), total: 1.0, lobes: Vec::new() }
    }

    fn join(pairs: &[(usize, usize)]) -> Vec<Migration> {
        pairs.iter().map(|&(from, to)| Migration { from, to, plan: Default::default() }).collect()
    }

    #[test]
    fn folds_into_the_covered_quadrants() {
        let nodes = [node(0.0, 0.0), node(50.0, 10.0), node(50.0, 80.0)];
        for bits in [1, 2, 4, 8, 3, 6, 9, 12, 15] {
            let mesh = Mesh::new(bits, &nodes, &[]).unwrap();
            for phi in (5..360).step_by(10) {
                let asked = from_degrees(40.0, f64::from(phi));
                let (folded, unfold) = mesh.fold(asked, &nodes);
                let quadrant = 1 << (to_degrees(folded).1 / 90.0) as i32;
                assert!(bits & quadrant != 0, "{bits}: {phi} went to quadrant {quadrant}");
                let Unfold::Mirror(x, y) = unfold else { panic!("a mesh mirrors") };
                let sign = |mirrored| if mirrored { -1.0 } else { 1.0 };
                assert_eq!(folded * DVec3::new(sign(x), sign(y), 1.0), asked);
            }
        }
    }

    #[test]
    fn an_isotropic_chain_turns_to_the_measured_plane() {
        let nodes = [node(0.0, 0.0), node(30.0, 20.0), node(60.0, 20.0)];
        let migrations = join(&[(1, 2), (0, 1)]);
        let mesh = Mesh::new(0, &nodes, &migrations).unwrap();
        let place = |theta: f64| {
            let (folded, unfold) = mesh.fold(from_degrees(theta, 170.0), &nodes);
            assert_eq!(unfold, Unfold::Rotate(150_f64.to_radians()));
            mesh.locate(folded, &nodes, &migrations)
        };
        let Place::Edge { migration: 0, t } = place(42.0) else { panic!("{:?}", place(42.0)) };
        assert!((t - 0.4).abs() < 1e-12);
        let Place::Edge { migration: 1, t } = place(9.0) else { panic!("{:?}", place(9.0)) };
        assert!((t - 0.3).abs() < 1e-12);
        assert_eq!(place(30.01), Place::Node(1));
        assert_eq!(place(61.0), Place::Outside);
        let gap = Mesh::new(0, &nodes, &migrations[..1]).unwrap_err().to_string();
        assert_eq!(
            gap,
            "isotropic interpolant: expected a migration between nodes 0 and 1, found none"
        );
    }

    #[test]
    fn the_smaller_of_two_closed_triples_is_the_face() {
        // Node 3 splits face 0 1 2 in three; 0 1 2 closes too but must not win.
        let nodes = [node(60.0, 0.0), node(60.0, 120.0), node(60.0, 240.0), node(0.0, 0.0)];
        let migrations = join(&[(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]);
        let mesh = Mesh::new(15, &nodes, &migrations).unwrap();
        let place = mesh.locate(from_degrees(20.0, 60.0), &nodes, &migrations);
        let Place::Face { face, s, t } = place else { panic!("{place:?}") };
        assert_eq!((face.nodes, face.edges), ([0, 1, 3], [0, 4, 3]));
        // Half way around; the foot on edge 0 1 is tan θ = tan 60° cos 60° from the pole.
        assert!((s - 0.5).abs() < 1e-12);
        let foot = (60_f64.to_radians().tan() * 0.5).atan().to_degrees();
        assert!((t - (1.0 - 20.0 / foot)).abs() < 1e-12, "{t}");
        assert_eq!(mesh.locate(from_degrees(75.0, 60.0), &nodes, &migrations), Place::Outside);
    }
}
