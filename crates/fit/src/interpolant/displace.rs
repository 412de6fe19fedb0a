//! Displacement interpolation: one set of moving lobes from the plans of a triangle's edges.
//!
//! The three plans of a triangle do not agree round it. They are glued at each vertex in turn:
//! at v, a lobe i with partners j along one edge and k along the other gives triples (i, j, k)
//! with mass P(i,j) P(i,k) / mass(i). The three gluings are blended with the barycentric weights,
//! f(λ) = Σ_v λ_v f_v(λ). On an edge only its own plan is left, so the result is continuous, and
//! no vertex comes first.

use std::collections::HashMap;

use bsdfkit::DVec2;

use super::plan::{EdgePlan, Pair};
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

/// What the gluing at one corner says.
#[derive(Clone, Copy, Debug, Default)]
struct Row {
    /// Masses at the corners.
    masses: [f64; 3],
    /// Corners toward which the lobe is cut off instead of fading.
    cut: [bool; 3],
}

/// Half the width, in barycentric weight, of a cut. A guess: a tenth of the spacing.
const CUT: f64 = 0.05;

impl Mover {
    /// The mass at `lambda`, and what it were without cuts. A lobe that is missing at some of the
    /// corners fades toward them, or is cut off half-way there.
    fn mass(&self, lambda: [f64; 3]) -> (f64, f64) {
        let (mut mass, mut uncut) = (0.0, 0.0);
        for (row, l) in self.rows.iter().zip(lambda) {
            let sum: f64 = row.masses.iter().zip(lambda).map(|(m, l)| l * m).sum();
            let missing: f64 = row.cut.iter().zip(lambda).map(|(&c, l)| f64::from(c) * l).sum();
            let present = 1.0 - missing;
            let cut = if missing > 0.0 && present > 0.0 {
                ((present - 0.5) / (2.0 * CUT) + 0.5).clamp(0.0, 1.0) / present
            } else {
                1.0
            };
            uncut += l * sum;
            mass += l * sum * cut;
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
        Self::collect(all, corners)
    }

    /// The plan of a lone edge 0–1.
    pub fn of_edge(corners: [&LobeSet; 2], plan: &EdgePlan) -> Self {
        let mut all = HashMap::new();
        for p in &plan.pairs {
            let (i, j) = stands(p, 0, 1);
            let cut = [p.from.is_none(), p.to.is_none(), false].map(|c| c && plan.cliff);
            let row = Row { masses: [p.start, p.end, 0.0], cut };
            all.insert([i, j, i], [row, row, Row::default()]);
        }
        Self::collect(all, [corners[0], corners[1], corners[0]])
    }

    fn collect(all: HashMap<[Stand; 3], Rows>, corners: [&LobeSet; 3]) -> Self {
        let total = corners.map(LobeSet::total);
        let matters = |rows: &Rows| {
            rows.iter().any(|row| row.masses.iter().zip(total).any(|(x, t)| *x > NEGLIGIBLE * t))
        };
        let mut movers: Vec<Mover> = all
            .into_iter()
            .filter(|(_, rows)| matters(rows))
            .map(|(stands, rows)| Mover { stands, rows })
            .collect();
        movers.sort_by_key(|m| m.stands);
        Self { movers }
    }

    /// The moved lobes at barycentric weights `lambda`, each with its maps to the corners.
    ///
    /// `bend(v, i)`: how far, to first order, lobe i of corner v has moved at the query already
    /// (half of that is added with the corner's weight, which makes tracks of second order exact).
    pub fn at(
        &self,
        corners: [&LobeSet; 3],
        lambda: [f64; 3],
        bend: &dyn Fn(usize, usize) -> DVec2,
    ) -> Vec<Moved> {
        let lobe = |(corner, index): Stand| corners[corner as usize].lobes[index as usize];
        self.movers
            .iter()
            .filter_map(|m| {
                let (mass, _) = m.mass(lambda);
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

    /// Share of the lobes' mass that the cuts at `lambda` leave, in proportion to fading lobes'.
    pub fn cut(&self, lambda: [f64; 3]) -> f64 {
        let (mut mass, mut uncut) = (0.0, 0.0);
        for (m, u) in self.movers.iter().map(|m| m.mass(lambda)) {
            mass += m;
            uncut += u;
        }
        if uncut > 0.0 { mass / uncut } else { 1.0 }
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
                (a, stand_a, p.end * q.start / mass, to_a.cliff && p.to.is_none()),
                (c, stand_c, share * q.end, to_c.cliff && q.to.is_none()),
            ]);
        }
    }
    let alone = |plan: &EdgePlan, lobe: Option<u16>| {
        lobe.is_some() && plan.pairs.iter().any(|p| p.from.is_none() && p.to == lobe)
    };
    for p in &across.pairs {
        let (stand_a, stand_c) = stands(p, a, c);
        let (at_a, at_c) = ((a, stand_a, p.start, false), (c, stand_c, p.end, false));
        match (alone(to_a, p.from), alone(to_c, p.to)) {
            (true, true) => add([(v, stand_a, 0.0, to_a.cliff && to_c.cliff), at_a, at_c]),
            (true, false) => {
                let cut = across.cliff && p.to.is_none();
                add([(v, stand_a, 0.0, to_a.cliff), at_a, (c, stand_a, 0.0, cut)]);
            }
            (false, true) => {
                let cut = across.cliff && p.from.is_none();
                add([(v, stand_c, 0.0, to_c.cliff), (a, stand_c, 0.0, cut), at_c]);
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
            let moved = movers.at(corners, lambda, &STRAIGHT);
            for i in 0..50 {
                let q = DVec2::new(f64::from(i % 7) * 0.2 - 0.6, f64::from(i / 7) * 0.15 - 0.3);
                assert!((density(&moved, q) - c[v].density(q)).abs() < 1e-6);
            }
        }
        let mass = |m: &[Moved]| m.iter().map(|m| m.lobe.mass).sum::<f64>();
        let half = movers.at(corners, [0.5, 0.5, 0.0], &STRAIGHT);
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
            one.at([&c[0], &c[1], &c[2]], lambda, &STRAIGHT),
            two.at([&c[0], &c[1], &d], lambda, &STRAIGHT),
            edge.at([&c[0], &c[1], &c[0]], lambda, &STRAIGHT),
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
        let peaks = set(&[(0.3, 0.0, 0.0, 0.001), (0.4, 0.9, 0.0, 0.001)]);
        let c = [peaks.clone(), peaks, set(&[(0.3, 0.0, 0.0, 0.001)])];
        let corners = [&c[0], &c[1], &c[2]];
        let mut p = plans(&c);
        let mass = |p: &[EdgePlan; 3], third: f64| {
            let movers = Movers::of_triangle(corners, [&p[0], &p[1], &p[2]]);
            let lambda = [0.5 * (1.0 - third), 0.5 * (1.0 - third), third];
            let moved = movers.at(corners, lambda, &STRAIGHT);
            let second = moved.iter().filter(|m| m.lobe.mean.x > 0.5).map(|m| m.lobe.mass);
            (second.sum::<f64>(), movers.cut(lambda))
        };
        let faded = mass(&p, 0.3);
        assert!((faded.0 - 0.4 * 0.7).abs() < 1e-9 && (faded.1 - 1.0).abs() < 1e-12);
        p.iter_mut().for_each(|p| p.cliff = true);
        for (third, kept) in [(0.0, 0.4), (0.3, 0.4), (0.5, 0.2), (0.7, 0.0), (1.0, 0.0)] {
            let (second, cut) = mass(&p, third);
            assert!((second - kept).abs() < 1e-9, "{third}: {second}");
            let fading = 0.3 + 0.4 * (1.0 - third);
            assert!((cut - (0.3 + kept) / fading).abs() < 1e-9, "{third}: {cut}");
        }
    }

    #[test]
    fn the_order_of_corners_does_not_matter() {
        let c = corners();
        let p = plans(&c);
        let a = Movers::of_triangle([&c[0], &c[1], &c[2]], [&p[0], &p[1], &p[2]]);
        let (r0, r1, r2) = (p[0].reversed(), p[1].reversed(), p[2].reversed());
        let b = Movers::of_triangle([&c[1], &c[0], &c[2]], [&r0, &r2, &r1]);
        let x = a.at([&c[0], &c[1], &c[2]], [0.2, 0.3, 0.5], &STRAIGHT);
        let y = b.at([&c[1], &c[0], &c[2]], [0.3, 0.2, 0.5], &STRAIGHT);
        for i in 0..60 {
            let q = DVec2::new(f64::from(i % 10) * 0.15 - 0.7, f64::from(i / 10) * 0.2 - 0.4);
            assert!((density(&x, q) - density(&y, q)).abs() < 1e-9);
        }
    }
}
