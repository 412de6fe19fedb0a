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

use crate::interpolant::motion::cut::Row;
use crate::interpolant::motion::edge_plan::{Cliff, EdgePlan};
use crate::interpolant::motion::mover::{Mover, Partners, Rows};
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
        Self::collect(all, corners, plans.map(|p| p.cliff))
    }

    /// The plan of a lone edge 0–1.
    pub(crate) fn of_edge(corners: [&LobeSet; 2], plan: &EdgePlan) -> Self {
        let mut all = HashMap::new();
        for p in &plan.pairs {
            let cut = [p.from.is_none(), p.to.is_none(), false].map(|c| c && plan.cliff.is_some());
            let row = Row::new([p.start, p.end, 0.0], cut);
            all.insert([p.from, p.to, None], [row, row, Row::default()]);
        }
        Self::collect(all, [corners[0], corners[1], corners[0]], [plan.cliff, None, None])
    }

    /// `cliffs`: of the edges 0–1, 1–2 and 2–0.
    fn collect(
        all: HashMap<Partners, Rows>,
        corners: [&LobeSet; 3],
        cliffs: [Option<Cliff>; 3],
    ) -> Self {
        let total = corners.map(LobeSet::total);
        let matters = |rows: &Rows| {
            rows.iter().any(|row| row.masses.iter().zip(total).any(|(x, t)| *x > NEGLIGIBLE * t))
        };
        let mut movers: Vec<Mover> = all
            .into_iter()
            .filter(|(_, rows)| matters(rows))
            .map(|(partners, rows)| Mover { partners, rows: rows.map(|row| row.pulled(cliffs)) })
            .collect();
        movers.sort_by_key(|m| m.partners);
        Self { movers }
    }

    /// The moved lobes at barycentric weights `lambda`, each with its maps to the corners.
    ///
    /// `bend(v, i)`: how far, to first order, lobe i of corner v has moved at the query already
    /// (half of that is added with the corner's weight, which makes tracks of second order exact).
    /// `way(v, i)`: how far on its way past the rim to where it ends it is, 1 there.
    pub(crate) fn at(
        &self,
        corners: [&LobeSet; 3],
        lambda: [f64; 3],
        bend: &dyn Fn(usize, usize) -> DVec2,
        way: &dyn Fn(usize, usize) -> f64,
    ) -> Vec<Moved> {
        let moved = |m: &Mover| {
            let mass = m.mass(lambda, way).0;
            (mass > 0.0).then(|| m.moved(mass, corners, lambda, bend))
        };
        self.movers.iter().filter_map(moved).collect()
    }

    /// The mass at `lambda`, and what it were without the cuts; `way` as in [`at`](Self::at).
    pub(crate) fn masses(&self, lambda: [f64; 3], way: &dyn Fn(usize, usize) -> f64) -> [f64; 2] {
        self.movers.iter().fold([0.0; 2], |[mass, uncut], mover| {
            let (m, u) = mover.mass(lambda, way);
            [mass + m, uncut + u]
        })
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
    // A corner, the lobe there, its mass, and whether it is cut off there.
    let mut add = |at: [(usize, Option<u16>, f64, bool); 3]| {
        let mut partners = [None; 3];
        at.iter().for_each(|&(corner, lobe, ..)| partners[corner] = lobe);
        let row = &mut all.entry(partners).or_default()[v];
        for (corner, _, mass, cut) in at {
            row.masses[corner] += mass;
            row.cut[corner] |= cut;
        }
    };
    for p in &to_a.pairs {
        let Some(i) = p.from else { continue };
        let mass = corners[v].lobes[i as usize].mass;
        for q in to_c.pairs.iter().filter(|q| q.from == Some(i)) {
            add([
                (v, p.from, p.start / mass * q.start, false),
                (a, p.to, p.end * q.start / mass, to_a.cliff.is_some() && p.to.is_none()),
                (c, q.to, p.start / mass * q.end, to_c.cliff.is_some() && q.to.is_none()),
            ]);
        }
    }
    let [off_a, off_c, off] = [to_a, to_c, across].map(|plan| plan.cliff.is_some());
    let alone = |plan: &EdgePlan, lobe: Option<u16>| {
        lobe.is_some() && plan.pairs.iter().any(|p| p.from.is_none() && p.to == lobe)
    };
    for p in &across.pairs {
        let (at_a, at_c) = ((a, p.from, p.start, false), (c, p.to, p.end, false));
        match (alone(to_a, p.from), alone(to_c, p.to)) {
            (true, true) => add([(v, None, 0.0, off_a && off_c), at_a, at_c]),
            (true, false) => {
                add([(v, None, 0.0, off_a), at_a, (c, None, 0.0, off && p.to.is_none())]);
            }
            (false, true) => {
                add([(v, None, 0.0, off_c), (a, None, 0.0, off && p.from.is_none()), at_c]);
            }
            (false, false) => {}
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

    const INSIDE: fn(usize, usize) -> f64 = |_, _| 0.0;

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
            let moved = movers.at(corners, lambda, &STRAIGHT, &INSIDE);
            for i in 0..50 {
                let q = DVec2::new(f64::from(i % 7) * 0.2 - 0.6, f64::from(i / 7) * 0.15 - 0.3);
                assert!((density(&moved, q) - c[v].density(q)).abs() < 1e-6);
            }
        }
        let mass = |m: &[Moved]| m.iter().map(|m| m.lobe.mass).sum::<f64>();
        let half = movers.at(corners, [0.5, 0.5, 0.0], &STRAIGHT, &INSIDE);
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
            one.at([&c[0], &c[1], &c[2]], lambda, &STRAIGHT, &INSIDE),
            two.at([&c[0], &c[1], &d], lambda, &STRAIGHT, &INSIDE),
            edge.at([&c[0], &c[1], &c[0]], lambda, &STRAIGHT, &INSIDE),
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
            let inside = triangle.at(corners, lambda, &bend, &INSIDE);
            let bend = |k: usize, i: usize| bend([v, next, v][k], i);
            let ends = [corners[v], corners[next], corners[v]];
            let lone = edge.at(ends, [0.4, 0.6, 0.0], &bend, &INSIDE);
            for i in 0..100 {
                let q = DVec2::new(f64::from(i % 10) * 0.2 - 0.9, f64::from(i / 10) * 0.1 - 0.4);
                let (x, y) = (density(&inside, q), density(&lone, q));
                assert!((x - y).abs() < 1e-5 * (1.0 + y), "edge {v} at {q}: {x} {y}");
            }
        }
    }

    #[test]
    fn a_peak_missing_at_one_corner_is_cut_off_half_way() {
        // The second peak of two corners has no partner at the third.
        let (c, mut p) = cut_off([None; 3]);
        let corners = [&c[0], &c[1], &c[2]];
        let mass = |p: &[EdgePlan; 3], third: f64| {
            let movers = Movers::of_triangle(corners, [&p[0], &p[1], &p[2]]);
            let lambda = [0.5 * (1.0 - third), 0.5 * (1.0 - third), third];
            let moved = movers.at(corners, lambda, &STRAIGHT, &INSIDE);
            let second = moved.iter().filter(|m| m.lobe.mean.x > 0.5).map(|m| m.lobe.mass);
            {
                let [mass, uncut] = movers.masses(lambda, &INSIDE);
                (second.sum::<f64>(), mass / uncut)
            }
        };
        let faded = mass(&p, 0.3);
        assert!((faded.0 - 0.4 * 0.7).abs() < 1e-9 && (faded.1 - 1.0).abs() < 1e-12);
        p.iter_mut().for_each(|p| p.cliff = Some(Cliff { gone: 0.5, new: 0.5 }));
        for (third, kept) in [(0.0, 0.4), (0.3, 0.4), (0.5, 0.2), (0.7, 0.0), (1.0, 0.0)] {
            let (second, cut) = mass(&p, third);
            assert!((second - kept).abs() < 1e-9, "{third}: {second}");
            let fading = 0.3 + 0.4 * (1.0 - third);
            assert!((cut - (0.3 + kept) / fading).abs() < 1e-9, "{third}: {cut}");
        }
    }

    /// Two corners with a second peak, one without, and the plans, cut off at these places.
    fn cut_off(cliffs: [Option<Cliff>; 3]) -> ([LobeSet; 3], [EdgePlan; 3]) {
        let peaks = set(&[(0.3, 0.0, 0.0, 0.001), (0.4, 0.9, 0.0, 0.001)]);
        let c = [peaks.clone(), peaks, set(&[(0.3, 0.0, 0.0, 0.001)])];
        let mut p = plans(&c);
        p.iter_mut().zip(cliffs).for_each(|(plan, cliff)| plan.cliff = cliff);
        (c, p)
    }

    #[test]
    fn cuts_pass_where_the_edges_have_them() {
        // Gone after 0.2 of the way 1 to 2, and new after 0.7 of the way 2 to 0.
        let at = |gone, new| Some(Cliff { gone, new });
        let (c, p) = cut_off([None, at(0.2, 0.9), at(0.1, 0.7)]);
        let corners = [&c[0], &c[1], &c[2]];
        let movers = Movers::of_triangle(corners, [&p[0], &p[1], &p[2]]);
        let second = |lambda: [f64; 3]| {
            let moved = movers.at(corners, lambda, &STRAIGHT, &INSIDE);
            moved.iter().filter(|m| m.lobe.mean.x > 0.5).map(|m| m.lobe.mass).sum::<f64>() / 0.4
        };
        for (lambda, share) in [
            ([0.0, 0.9, 0.1], 1.0),
            ([0.0, 0.8, 0.2], 0.5),
            ([0.0, 0.7, 0.3], 0.0),
            ([0.8, 0.0, 0.2], 1.0),
            ([0.7, 0.0, 0.3], 0.5),
            ([0.6, 0.0, 0.4], 0.0),
            // Half-way between both: the cut is straight.
            ([0.35, 0.4, 0.25], 0.5),
            ([0.5, 0.5, 0.0], 1.0),
        ] {
            assert!((second(lambda) - share).abs() < 1e-9, "{lambda:?}: {}", second(lambda));
        }
        // The lone edge has it where the triangle has.
        let (edge, lone) = ([&c[1], &c[2]], Movers::of_edge([&c[1], &c[2]], &p[1]));
        for way in [0.15, 0.2, 0.23] {
            let mass = lone.masses([1.0 - way, way, 0.0], &INSIDE)[0];
            let moved =
                lone.at([edge[0], edge[1], edge[0]], [1.0 - way, way, 0.0], &STRAIGHT, &INSIDE);
            let sum: f64 = moved.iter().map(|m| m.lobe.mass).sum();
            assert!((mass - sum).abs() < 1e-12);
            assert!((mass - 0.3 - 0.4 * second([0.0, 1.0 - way, way])).abs() < 1e-9, "{way}");
        }
    }

    #[test]
    fn past_the_rim_lobes_end_where_they_must() {
        let (c, p) = cut_off([None; 3]);
        let edge = Movers::of_edge([&c[0], &c[1]], &p[0]);
        let corners = [&c[0], &c[1], &c[0]];
        // The second lobe's way to its end, at either corner.
        for (ways, left) in [([0.5, 0.5], 1.0), ([0.8, 1.2], 0.5), ([1.0, 1.4], 0.0)] {
            let way = |v: usize, i: usize| if i == 1 { ways[v] } else { 0.0 };
            let moved = edge.at(corners, [0.5, 0.5, 0.0], &STRAIGHT, &way);
            let mass: f64 = moved.iter().map(|m| m.lobe.mass).sum();
            assert!((mass - 0.3 - 0.4 * left).abs() < 1e-9, "{ways:?}: {mass}");
        }
    }

    #[test]
    fn the_order_of_corners_does_not_matter() {
        let c = corners();
        let p = plans(&c);
        let a = Movers::of_triangle([&c[0], &c[1], &c[2]], [&p[0], &p[1], &p[2]]);
        let (r0, r1, r2) = (p[0].reversed(), p[1].reversed(), p[2].reversed());
        let b = Movers::of_triangle([&c[1], &c[0], &c[2]], [&r0, &r2, &r1]);
        let x = a.at([&c[0], &c[1], &c[2]], [0.2, 0.3, 0.5], &STRAIGHT, &INSIDE);
        let y = b.at([&c[1], &c[0], &c[2]], [0.3, 0.2, 0.5], &STRAIGHT, &INSIDE);
        for i in 0..60 {
            let q = DVec2::new(f64::from(i % 10) * 0.15 - 0.7, f64::from(i / 10) * 0.2 - 0.4);
            assert!((density(&x, q) - density(&y, q)).abs() < 1e-9);
        }
    }
}
