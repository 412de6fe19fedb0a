//! Displacement interpolation: one set of moving lobes from the plans of a triangle's edges.
//!
//! The three plans of a triangle do not agree round it. They are glued at each vertex in turn:
//! at v, a lobe i with partners j along one edge and k along the other gives triples (i, j, k)
//! with mass P(i,j) P(i,k) / mass(i). The three gluings are blended with the barycentric weights,
//! f(λ) = Σ_v λ_v f_v(λ). A lobe that is missing at a corner is where those of the other corners take
//! it. So on an edge only its own plan and lobes are left: the result is continuous, and no vertex
//! comes first.

use std::collections::HashMap;

use bsdfkit::DVec2;

use crate::interpolant::motion::edge_plan::EdgePlan;
use crate::interpolant::motion::mover::{Mover, Partners, Rows, Way};
use crate::lobe::LobeSet;

pub(crate) use crate::interpolant::motion::moved::Moved;

/// All moving lobes of a triangle (or of an edge: third corner unused).
#[derive(Clone, Debug, Default)]
pub(crate) struct Movers {
    movers: Vec<Mover>,
}

/// Movers that never carry more than this share of a corner's mass are dropped.
const NEGLIGIBLE: f64 = 1e-5;

impl Movers {
    /// Glues the plans of edges 0–1, 1–2 and 2–0 of a triangle.
    pub(crate) fn of_triangle(corners: [&LobeSet; 3], plans: [&EdgePlan; 3]) -> Self {
        let mut all = HashMap::new();
        for v in 0..3 {
            let (a, c) = ((v + 1) % 3, (v + 2) % 3);
            // Plans as seen from v: v–a is plan v, c–v is plan c reversed.
            glue(&mut all, corners, [v, a, c], plans[v], &plans[c].reversed(), plans[a]);
        }
        Self::collect(all, corners)
    }

    /// The plan of a lone edge 0–1.
    pub(crate) fn of_edge(corners: [&LobeSet; 2], plan: &EdgePlan) -> Self {
        let mut all = HashMap::new();
        for p in &plan.pairs {
            let row = [p.start, p.end, 0.0];
            all.insert([p.from, p.to, None], [row, row, [0.0; 3]]);
        }
        Self::collect(all, [corners[0], corners[1], corners[0]])
    }

    fn collect(all: HashMap<Partners, Rows>, corners: [&LobeSet; 3]) -> Self {
        let total = corners.map(LobeSet::total);
        let matters = |rows: &Rows| {
            rows.iter().any(|row| row.iter().zip(total).any(|(x, t)| *x > NEGLIGIBLE * t))
        };
        let mut movers: Vec<Mover> = all
            .into_iter()
            .filter(|(_, rows)| matters(rows))
            .map(|(partners, rows)| Mover { partners, rows })
            .collect();
        movers.sort_by_key(|m| m.partners);
        Self { movers }
    }

    /// The moved lobes at barycentric weights `lambda`, each with its maps to the corners; with `near` those alone that may be
    /// seen at this place of the frame.
    ///
    /// `bend(v, i)`: how far, to first order, lobe i of corner v has moved at the query already
    /// (half of that is added with the corner's weight, which makes tracks of second order exact).
    pub(crate) fn at(
        &self,
        corners: [&LobeSet; 3],
        lambda: [f64; 3],
        bend: &impl Fn(usize, usize) -> DVec2,
        near: Option<DVec2>,
    ) -> Vec<Moved> {
        let ways = self.movers.iter().filter_map(|m| m.way(corners, lambda, bend, near));
        let ways: Vec<Way> = ways.collect();
        Way::moved(&ways)
    }
}

/// Adds the gluing at corner `v` of its plans toward `a` and toward `c`; lobes of `a` and `c` that
/// have no partner at `v` go from one to the other as the plan `across`, a–c, has them.
fn glue(
    all: &mut HashMap<Partners, Rows>,
    corners: [&LobeSet; 3],
    [v, a, c]: [usize; 3],
    to_a: &EdgePlan,
    to_c: &EdgePlan,
    across: &EdgePlan,
) {
    // A corner, the lobe there, and its mass.
    let mut add = |at: [(usize, Option<u16>, f64); 3]| {
        let mut partners = [None; 3];
        at.iter().for_each(|&(corner, lobe, _)| partners[corner] = lobe);
        let row = &mut all.entry(partners).or_default()[v];
        at.iter().for_each(|&(corner, _, mass)| row[corner] += mass);
    };
    for p in &to_a.pairs {
        let Some(i) = p.from else { continue };
        let mass = corners[v].lobes[i as usize].mass;
        for q in to_c.pairs.iter().filter(|q| q.from == Some(i)) {
            add([
                (v, p.from, p.start / mass * q.start),
                (a, p.to, p.end * q.start / mass),
                (c, q.to, p.start / mass * q.end),
            ]);
        }
    }
    // What of its mass a lobe without partner at v keeps there.
    let alone = |plan: &EdgePlan, lobe: Option<u16>| {
        let pair =
            plan.pairs.iter().find(|p| lobe.is_some() && p.from.is_none() && p.to == lobe)?;
        Some(pair.start / pair.end.max(1e-300))
    };
    let lone = |partner: Option<u16>, mass: f64| if partner.is_none() { mass } else { 0.0 };
    for p in &across.pairs {
        let (at_a, at_c) = ((a, p.from, p.start), (c, p.to, p.end));
        match (alone(to_a, p.from), alone(to_c, p.to)) {
            (Some(kept), Some(_)) => add([(v, None, kept * p.start), at_a, at_c]),
            (Some(kept), None) => {
                add([(v, None, kept * p.start), at_a, (c, None, lone(p.to, p.end))]);
            }
            (None, Some(kept)) => {
                add([(v, None, kept * p.end), (a, None, lone(p.from, p.start)), at_c]);
            }
            (None, None) => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lobe::{Covariance, Lobe};

    fn set(lobes: &[(f64, f64, f64, f64)]) -> LobeSet {
        let lobe = |&(mass, x, y, s): &(f64, f64, f64, f64)| Lobe {
            mass,
            mean: DVec2::new(x, y),
            covariance: Covariance { xx: s, xy: 0.3 * s, yy: 2.0 * s },
        };
        LobeSet { floor: 0.0, lobes: lobes.iter().map(lobe).collect() }
    }

    fn corners() -> [LobeSet; 3] {
        [
            set(&[(0.3, 0.0, 0.0, 0.01), (0.2, 0.1, 0.4, 0.002), (0.05, -0.8, 0.0, 0.01)]),
            set(&[(0.4, 0.1, 0.05, 0.02), (0.1, 0.2, 0.5, 0.004)]),
            set(&[(0.2, -0.1, 0.1, 0.01), (0.2, 0.0, 0.5, 0.003), (0.3, 0.9, 0.1, 0.01)]),
        ]
    }

    fn plans(c: &[LobeSet; 3]) -> [EdgePlan; 3] {
        [0, 1, 2].map(|v| EdgePlan::between(&c[v], &c[(v + 1) % 3], 0.2))
    }

    const STRAIGHT: fn(usize, usize) -> DVec2 = |_, _| DVec2::ZERO;

    fn density(moved: &[Moved], q: DVec2) -> f64 {
        moved.iter().map(|m| m.lobe.density(q)).sum()
    }

    #[test]
    fn corners_are_reproduced_and_mass_is_interpolated_on_edges() {
        let c = corners();
        let p = plans(&c);
        let corners = [&c[0], &c[1], &c[2]];
        let movers = Movers::of_triangle(corners, [&p[0], &p[1], &p[2]]);
        for v in 0..3 {
            let mut lambda = [0.0; 3];
            lambda[v] = 1.0;
            let moved = movers.at(corners, lambda, &STRAIGHT, None);
            for i in 0..50 {
                let q = DVec2::new(f64::from(i % 7) * 0.2 - 0.6, f64::from(i / 7) * 0.15 - 0.3);
                assert!((density(&moved, q) - c[v].density(q)).abs() < 1e-6);
            }
        }
        let mass = |m: &[Moved]| m.iter().map(|m| m.lobe.mass).sum::<f64>();
        let half = movers.at(corners, [0.5, 0.5, 0.0], &STRAIGHT, None);
        assert!((mass(&half) - 0.5 * (0.55 + 0.5)).abs() < 1e-4, "{}", mass(&half));
    }

    #[test]
    fn the_shared_edge_of_two_triangles_is_continuous() {
        let c = corners();
        let d = set(&[(0.3, 0.3, -0.2, 0.02)]);
        let p = plans(&c);
        let one = Movers::of_triangle([&c[0], &c[1], &c[2]], [&p[0], &p[1], &p[2]]);
        let (pd1, pd0) = (EdgePlan::between(&c[1], &d, 0.2), EdgePlan::between(&d, &c[0], 0.2));
        let two = Movers::of_triangle([&c[0], &c[1], &d], [&p[0], &pd1, &pd0]);
        let edge = Movers::of_edge([&c[0], &c[1]], &p[0]);
        let lambda = [0.3, 0.7, 0.0];
        let (a, b, e) = (
            one.at([&c[0], &c[1], &c[2]], lambda, &STRAIGHT, None),
            two.at([&c[0], &c[1], &d], lambda, &STRAIGHT, None),
            edge.at([&c[0], &c[1], &c[0]], lambda, &STRAIGHT, None),
        );
        for i in 0..60 {
            let q = DVec2::new(f64::from(i % 10) * 0.15 - 0.7, f64::from(i / 10) * 0.2 - 0.4);
            let (x, y, z) = (density(&a, q), density(&b, q), density(&e, q));
            assert!((x - y).abs() < 1e-5 && (x - z).abs() < 1e-5, "{q}: {x} {y} {z}");
        }
    }

    #[test]
    fn a_lobe_missing_at_a_corner_does_not_break_the_edges() {
        // The second lobes are partners of each other, or of none.
        let c = [
            set(&[(0.3, 0.0, 0.0, 0.01), (0.4, 0.8, 0.0, 0.01)]),
            set(&[(0.3, 0.1, 0.0, 0.01)]),
            set(&[(0.3, 0.0, 0.1, 0.01), (0.5, 0.8, 0.3, 0.02), (0.1, -0.8, 0.0, 0.02)]),
        ];
        let p = plans(&c);
        assert!(p[2].pairs.iter().any(|p| p.from == Some(1) && p.to == Some(1)));
        assert!(p[1].pairs.iter().any(|p| p.from.is_none() && p.to == Some(1)));
        let corners = [&c[0], &c[1], &c[2]];
        let triangle = Movers::of_triangle(corners, [&p[0], &p[1], &p[2]]);
        let bend = |v: usize, i: usize| 0.1 * DVec2::new(v as f64 - 1.0, 0.5 * i as f64);
        for v in 0..3 {
            let next = (v + 1) % 3;
            let edge = Movers::of_edge([corners[v], corners[next]], &p[v]);
            let mut lambda = [0.0; 3];
            (lambda[v], lambda[next]) = (0.4, 0.6);
            let inside = triangle.at(corners, lambda, &bend, None);
            let bend = |k: usize, i: usize| bend([v, next, v][k], i);
            let ends = [corners[v], corners[next], corners[v]];
            let lone = edge.at(ends, [0.4, 0.6, 0.0], &bend, None);
            for i in 0..100 {
                let q = DVec2::new(f64::from(i % 10) * 0.2 - 0.9, f64::from(i / 10) * 0.1 - 0.4);
                let (x, y) = (density(&inside, q), density(&lone, q));
                assert!((x - y).abs() < 1e-5 * (1.0 + y), "edge {v} at {q}: {x} {y}");
            }
        }
    }

    #[test]
    fn the_order_of_corners_does_not_matter() {
        let c = corners();
        let p = plans(&c);
        let a = Movers::of_triangle([&c[0], &c[1], &c[2]], [&p[0], &p[1], &p[2]]);
        let (r0, r1, r2) = (p[0].reversed(), p[1].reversed(), p[2].reversed());
        let b = Movers::of_triangle([&c[1], &c[0], &c[2]], [&r0, &r2, &r1]);
        let x = a.at([&c[0], &c[1], &c[2]], [0.2, 0.3, 0.5], &STRAIGHT, None);
        let y = b.at([&c[1], &c[0], &c[2]], [0.3, 0.2, 0.5], &STRAIGHT, None);
        for i in 0..60 {
            let q = DVec2::new(f64::from(i % 10) * 0.15 - 0.7, f64::from(i / 10) * 0.2 - 0.4);
            assert!((density(&x, q) - density(&y, q)).abs() < 1e-9);
        }
    }
}
