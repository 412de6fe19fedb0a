//! Displacement interpolation: one set of moving lobes from the plans of a triangle's edges.
//!
//! The three plans of a triangle do not agree round it. They are glued at each vertex in turn:
//! at v, a lobe i with partners j along one edge and k along the other gives triples (i, j, k)
//! with mass P(i,j) P(i,k) / mass(i). The three gluings are blended with the barycentric weights,
//! f(λ) = Σ_v λ_v f_v(λ). On an edge only its own plan is left, so the result is continuous, and
//! no vertex comes first.

use std::collections::HashMap;

use bsdfkit::DVec2;

use super::plan::{Cliff, EdgePlan, Pair};
use super::row::Row;
use crate::lobe::{Covariance, Lobe, LobeSet};

/// Which lobe stands for a moving lobe at a corner: lobe `1` of corner `0`.
/// A lobe that fades toward a corner is represented there by the lobe it came from.
type Stand = (u8, u16);

/// One moving lobe of a cell.
#[derive(Clone, Copy, Debug)]
struct Mover {
    stands: [Stand; 3],
    /// mass(λ) = Σ_v Σ_w λ_v λ_w rows[v].masses[w], but for cuts.
    rows: Rows,
}

/// What the gluings at the three corners say of one moving lobe.
type Rows = [Row; 3];

impl Mover {
    /// The mass at `lambda`, and what it were without cuts. A lobe that is missing at some of the
    /// corners fades toward them, or is cut off on the way there. `way` as in [`Movers::at`].
    fn mass(&self, lambda: [f64; 3], way: &dyn Fn(usize, usize) -> f64) -> (f64, f64) {
        // Past the rim: the mean of the corners that have the lobe.
        let (mut past, mut share) = (0.0, 0.0);
        for (v, &(corner, index)) in self.stands.iter().enumerate() {
            if corner as usize == v && lambda[v] > 0.0 {
                past += lambda[v] * way(v, index as usize);
                share += lambda[v];
            }
        }
        let past = if share > 0.0 { past / share } else { 0.0 };
        let (mut mass, mut uncut) = (0.0, 0.0);
        for (row, l) in self.rows.iter().zip(lambda) {
            let sum: f64 = row.masses.iter().zip(lambda).map(|(m, l)| l * m).sum();
            uncut += l * sum;
            mass += l * sum * row.kept(lambda, past);
        }
        (mass, uncut)
    }
}

/// All moving lobes of a triangle (or of an edge: third corner unused).
#[derive(Clone, Debug, Default)]
pub struct Movers {
    movers: Vec<Mover>,
}

/// Movers that never carry more than this share of a corner's mass are dropped.
const NEGLIGIBLE: f64 = 1e-5;

impl Movers {
    /// Glues the plans of edges 0–1, 1–2 and 2–0 of a triangle.
    pub fn of_triangle(corners: [&LobeSet; 3], plans: [&EdgePlan; 3]) -> Self {
        let mut all = HashMap::new();
        for v in 0..3 {
            let (a, c) = ((v + 1) % 3, (v + 2) % 3);
            // Plans as seen from v: v–a is plan v, c–v is plan c reversed.
            glue(&mut all, corners, [v, a, c], plans[v], &plans[c].reversed(), plans[a]);
        }
        Self::collect(all, corners, plans.map(|p| p.cliff))
    }

    /// The plan of a lone edge 0–1.
    pub fn of_edge(corners: [&LobeSet; 2], plan: &EdgePlan) -> Self {
        let mut all = HashMap::new();
        for p in &plan.pairs {
            let (i, j) = stands(p, 0, 1);
            let cut = [p.from.is_none(), p.to.is_none(), false].map(|c| c && plan.cliff.is_some());
            let row = Row::new([p.start, p.end, 0.0], cut);
            all.insert([i, j, i], [row, row, Row::default()]);
        }
        Self::collect(all, [corners[0], corners[1], corners[0]], [plan.cliff, None, None])
    }

    /// `cliffs`: of the edges 0–1, 1–2 and 2–0.
    fn collect(
        all: HashMap<[Stand; 3], Rows>,
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
            .map(|(stands, rows)| Mover { stands, rows: rows.map(|row| row.pulled(cliffs)) })
            .collect();
        movers.sort_by_key(|m| m.stands);
        Self { movers }
    }

    /// The moved lobes at barycentric weights `lambda`, each with its maps to the corners.
    ///
    /// `bend(v, i)`: how far, to first order, lobe i of corner v has moved at the query already
    /// (half of that is added with the corner's weight, which makes tracks of second order exact).
    /// `way(v, i)`: how far on its way past the rim to where it ends it is, 1 there.
    pub fn at(
        &self,
        corners: [&LobeSet; 3],
        lambda: [f64; 3],
        bend: &dyn Fn(usize, usize) -> DVec2,
        way: &dyn Fn(usize, usize) -> f64,
    ) -> Vec<Moved> {
        let lobe = |(corner, index): Stand| corners[corner as usize].lobes[index as usize];
        self.movers
            .iter()
            .filter_map(|m| {
                let mass = m.mass(lambda, way).0;
                (mass > 0.0).then(|| {
                    let mut curve = DVec2::ZERO;
                    for (v, &(corner, index)) in m.stands.iter().enumerate() {
                        if corner as usize == v && lambda[v] > 0.0 {
                            curve += 0.5 * lambda[v] * bend(v, index as usize);
                        }
                    }
                    Moved::new(mass, m.stands.map(lobe), lambda, curve)
                })
            })
            .collect()
    }

    /// Mass of the lobes at `lambda` with the cuts, and what it were without them; `way` as in
    /// [`at`](Self::at).
    pub fn masses(&self, lambda: [f64; 3], way: &dyn Fn(usize, usize) -> f64) -> (f64, f64) {
        self.movers.iter().fold((0.0, 0.0), |(mass, uncut), mover| {
            let (m, u) = mover.mass(lambda, way);
            (mass + m, uncut + u)
        })
    }

    /// Number of moving lobes.
    pub fn len(&self) -> usize {
        self.movers.len()
    }

    /// Whether nothing moves.
    pub fn is_empty(&self) -> bool {
        self.movers.is_empty()
    }
}

/// The stands of a pair at both of its ends.
fn stands(p: &Pair, from: usize, to: usize) -> (Stand, Stand) {
    let (from, to) = (from as u8, to as u8);
    match (p.from, p.to) {
        (Some(i), Some(j)) => ((from, i), (to, j)),
        (Some(i), None) => ((from, i), (from, i)),
        (None, j) => ((to, j.unwrap_or(0)), (to, j.unwrap_or(0))),
    }
}

/// Adds the gluing at corner `v` of its plans toward `a` and toward `c`; lobes of `a` and `c` that
/// have no partner at `v` go from one to the other as the plan `across`, a–c, has them.
fn glue(
    all: &mut HashMap<[Stand; 3], Rows>,
    corners: [&LobeSet; 3],
    [v, a, c]: [usize; 3],
    to_a: &EdgePlan,
    to_c: &EdgePlan,
    across: &EdgePlan,
) {
    // A corner, what stands for the lobe there, its mass, and whether it is cut off there.
    let mut add = |at: [(usize, Stand, f64, bool); 3]| {
        let mut key = [(0, 0); 3];
        at.iter().for_each(|&(corner, stand, ..)| key[corner] = stand);
        let row = &mut all.entry(key).or_default()[v];
        for (corner, _, mass, cut) in at {
            row.masses[corner] += mass;
            row.cut[corner] |= cut;
        }
    };
    for p in &to_a.pairs {
        let (stand_v, stand_a) = stands(p, v, a);
        let Some(i) = p.from else { continue };
        let mass = corners[v].lobes[i as usize].mass;
        for q in to_c.pairs.iter().filter(|q| q.from == Some(i)) {
            let stand_c = stands(q, v, c).1;
            let share = p.start / mass;
            add([
                (v, stand_v, share * q.start, false),
                (a, stand_a, p.end * q.start / mass, to_a.cliff.is_some() && p.to.is_none()),
                (c, stand_c, share * q.end, to_c.cliff.is_some() && q.to.is_none()),
            ]);
        }
    }
    let [off_a, off_c, off] = [to_a, to_c, across].map(|plan| plan.cliff.is_some());
    let alone = |plan: &EdgePlan, lobe: Option<u16>| {
        lobe.is_some() && plan.pairs.iter().any(|p| p.from.is_none() && p.to == lobe)
    };
    for p in &across.pairs {
        let (stand_a, stand_c) = stands(p, a, c);
        let (at_a, at_c) = ((a, stand_a, p.start, false), (c, stand_c, p.end, false));
        match (alone(to_a, p.from), alone(to_c, p.to)) {
            (true, true) => add([(v, stand_a, 0.0, off_a && off_c), at_a, at_c]),
            (true, false) => {
                let cut = off && p.to.is_none();
                add([(v, stand_a, 0.0, off_a), at_a, (c, stand_a, 0.0, cut)]);
            }
            (false, true) => {
                let cut = off && p.from.is_none();
                add([(v, stand_c, 0.0, off_c), (a, stand_c, 0.0, cut), at_c]);
            }
            (false, false) => {}
        }
    }
}

/// A lobe on its way, and the affine optimal-transport maps back to where it came from.
#[derive(Clone, Copy, Debug)]
pub struct Moved {
    /// The lobe at the queried incidence.
    pub lobe: Lobe,
    /// Inverse covariance.
    pub precision: Covariance,
    /// Peak value, mass / (2π √det Σ).
    pub peak: f64,
    /// Per corner: centre there, and A with q_v = centre_v + A (q − centre).
    pub maps: [(DVec2, Covariance); 3],
}

impl Moved {
    fn new(mass: f64, at: [Lobe; 3], lambda: [f64; 3], curve: DVec2) -> Self {
        let mut mean = curve;
        for v in 0..3 {
            mean += lambda[v] * at[v].mean;
        }
        let parts = [0, 1, 2].map(|v| (lambda[v], at[v].covariance));
        let covariance = Covariance::barycentre(&parts);
        Self {
            lobe: Lobe { mass, mean, covariance },
            precision: covariance.inverse(),
            peak: mass / (std::f64::consts::TAU * covariance.determinant().sqrt()),
            maps: at.map(|l| (l.mean, covariance.transport_to(l.covariance))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
                let (mass, uncut) = movers.masses(lambda, &INSIDE);
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
            let mass = lone.masses([1.0 - way, way, 0.0], &INSIDE).0;
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
