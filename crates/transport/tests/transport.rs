//! Plans against a linear-programming solver, against the residual graph, and their sums.

use bsdfkit_transport::{Flow, Invalid, Problem, TransportPlan, network_simplex, partial};
use microlp::{ComparisonOp, OptimizationDirection};
use proptest::collection::vec;
use proptest::prelude::*;

/// A reproducible stream of numbers in [0, 1).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn many(&mut self, n: usize) -> Vec<f64> {
        (0..n).map(|_| self.next()).collect()
    }
}

/// `masses` scaled to sum 1.
fn normalised(masses: &[f64]) -> Vec<f64> {
    let total: f64 = masses.iter().sum();
    masses.iter().map(|m| m / total).collect()
}

fn solve(supply: &[f64], demand: &[f64], cost: &[f64]) -> TransportPlan {
    let plan = network_simplex::solve(&Problem::new(supply, demand, cost).expect("problem"));
    assert!(plan.is_optimal());
    check_sums(&plan, supply, demand);
    plan
}

fn check_sums(plan: &TransportPlan, supply: &[f64], demand: &[f64]) {
    let total: f64 = supply.iter().sum();
    let close = |sums: &[f64], masses: &[f64]| {
        sums.len() == masses.len()
            && sums.iter().zip(masses).all(|(s, m)| (s - m).abs() <= 1e-9 * total)
    };
    assert!(close(&plan.row_sums(), supply), "{:?} is not {supply:?}", plan.row_sums());
    assert!(close(&plan.column_sums(), demand), "{:?} is not {demand:?}", plan.column_sums());
    assert!(plan.entries().len() < supply.len() + demand.len());
    assert!(plan.entries().iter().all(|f| f.mass > 0.0));
    assert!(plan.entries().is_sorted_by_key(|f| (f.from, f.to)));
}

fn least(lp: &microlp::Problem) -> f64 {
    match lp.solve() {
        Ok(microlp::SolveOutcome::Solution(solution)) => solution.objective(),
        other => panic!("no optimum: {other:?}"),
    }
}

/// The oracle: the same as a linear program.
fn lp_cost(supply: &[f64], demand: &[f64], cost: &[f64]) -> f64 {
    let mut lp = microlp::Problem::new(OptimizationDirection::Minimize);
    let x: Vec<_> = cost.iter().map(|&c| lp.add_var(c, (0.0, f64::INFINITY))).collect();
    let (n, m) = (supply.len(), demand.len());
    for i in 0..n {
        let row: Vec<_> = (0..m).map(|j| (x[i * m + j], 1.0)).collect();
        lp.add_constraint(row, ComparisonOp::Eq, supply[i]);
    }
    // The last column follows from the others: rounding must not make it contradict them.
    for j in 0..m - 1 {
        let column: Vec<_> = (0..n).map(|i| (x[i * m + j], 1.0)).collect();
        lp.add_constraint(column, ComparisonOp::Eq, demand[j]);
    }
    least(&lp)
}

/// How exactly the linear program is solved: its solver allows each constraint 1e-9 or so, and was
/// seen 1.4e-9 above an optimum of exactly −1. That ours is optimal the residual cycles tell.
const LP_TOLERANCE: f64 = 1e-8;

/// A plan is optimal if and only if no cycle of its residual graph has negative cost.
fn has_no_cheaper_cycle(plan: &TransportPlan, cost: &[f64]) -> bool {
    let (n, m) = (plan.rows(), plan.columns());
    let slack = 1e-11 * cost.iter().fold(0.0_f64, |a, c| a.max(c.abs()));
    let (mut source, mut target) = (vec![0.0; n], vec![0.0; m]);
    for _ in 0..n + m {
        let mut changed = false;
        for i in 0..n {
            for j in 0..m {
                if source[i] + cost[i * m + j] < target[j] - slack {
                    target[j] = source[i] + cost[i * m + j];
                    changed = true;
                }
            }
        }
        for f in plan.entries() {
            let (i, j) = (f.from as usize, f.to as usize);
            if target[j] - cost[i * m + j] < source[i] - slack {
                source[i] = target[j] - cost[i * m + j];
                changed = true;
            }
        }
        if !changed {
            return true;
        }
    }
    false
}

fn squared_distances(a: &[[f64; 2]], b: &[[f64; 2]]) -> Vec<f64> {
    let one = |p: &[f64; 2], q: &[f64; 2]| (p[0] - q[0]).powi(2) + (p[1] - q[1]).powi(2);
    a.iter().flat_map(|p| b.iter().map(move |q| one(p, q))).collect()
}

fn points(random: &mut Random, n: usize) -> Vec<[f64; 2]> {
    (0..n).map(|_| [random.next(), random.next()]).collect()
}

/// (supply, demand, cost) of up to 7 × 7; integers make ties and degenerate bases.
fn small() -> impl Strategy<Value = (Vec<f64>, Vec<f64>, Vec<f64>)> {
    (1_usize..8, 1_usize..8, any::<bool>()).prop_flat_map(|(n, m, integers)| {
        let mass = (0_i32..4, 0.0_f64..1.0)
            .prop_map(move |(i, x)| if integers { f64::from(i) } else { x });
        let cost = (-2_i32..4, -1.0_f64..1.0)
            .prop_map(move |(i, x)| if integers { f64::from(i) } else { x });
        (vec(mass.clone(), n), vec(mass, m), vec(cost, n * m))
    })
}

proptest! {
    #[test]
    fn as_cheap_as_a_linear_program((supply, demand, cost) in small()) {
        prop_assume!(supply.iter().sum::<f64>() > 0.0 && demand.iter().sum::<f64>() > 0.0);
        let (supply, demand) = (normalised(&supply), normalised(&demand));
        let plan = solve(&supply, &demand, &cost);
        let (ours, oracle) = (plan.cost(&cost), lp_cost(&supply, &demand, &cost));
        prop_assert!((ours - oracle).abs() < LP_TOLERANCE, "{ours} is not {oracle}");
        prop_assert!(has_no_cheaper_cycle(&plan, &cost));
    }

    #[test]
    fn partial_as_cheap_as_a_linear_program((supply, demand, cost) in small(), tau in 0.0_f64..2.5) {
        let tau = if tau < 0.5 { tau } else { tau.round() };
        let plan = partial::solve(&supply, &demand, &cost, tau).expect("plan");
        let (faded, appeared) = (&plan.faded, &plan.appeared);
        let (n, m) = (supply.len(), demand.len());
        for (i, sum) in plan.travelling.row_sums().iter().enumerate() {
            prop_assert!((sum + faded[i] - supply[i]).abs() < 1e-9);
        }
        for (j, sum) in plan.travelling.column_sums().iter().enumerate() {
            prop_assert!((sum + appeared[j] - demand[j]).abs() < 1e-9);
        }
        for f in plan.travelling.entries() {
            prop_assert!(cost[f.from as usize * m + f.to as usize] < tau);
        }
        let left: f64 = faded.iter().chain(appeared).sum();
        let ours = plan.travelling.cost(&cost) + 0.5 * tau * left;
        // Directly: min Σ (c − τ) x with sums at most the masses.
        let mut lp = microlp::Problem::new(OptimizationDirection::Minimize);
        let x: Vec<_> = cost.iter().map(|&c| lp.add_var(c - tau, (0.0, 10.0))).collect();
        for i in 0..n {
            let row: Vec<_> = (0..m).map(|j| (x[i * m + j], 1.0)).collect();
            lp.add_constraint(row, ComparisonOp::Le, supply[i]);
        }
        for j in 0..m {
            let column: Vec<_> = (0..n).map(|i| (x[i * m + j], 1.0)).collect();
            lp.add_constraint(column, ComparisonOp::Le, demand[j]);
        }
        let total: f64 = supply.iter().chain(&demand).sum();
        let oracle = least(&lp) + 0.5 * tau * total;
        prop_assert!((ours - oracle).abs() < LP_TOLERANCE, "{ours} is not {oracle}");
    }

    #[test]
    fn masses_of_very_different_size(exponents in vec((-12.0_f64..0.0, -12.0_f64..0.0), 2..40), seed in any::<u64>()) {
        let supply = normalised(&exponents.iter().map(|e| 10_f64.powf(e.0)).collect::<Vec<_>>());
        let demand = normalised(&exponents.iter().map(|e| 10_f64.powf(e.1)).collect::<Vec<_>>());
        let cost = Random(seed).many(supply.len() * demand.len());
        let plan = solve(&supply, &demand, &cost);
        prop_assert!(has_no_cheaper_cycle(&plan, &cost));
    }
}

#[test]
fn large_plans_are_optimal() {
    let mut random = Random(7);
    for (n, m) in [(24, 24), (60, 200), (200, 60), (150, 150)] {
        let (a, b) = (points(&mut random, n), points(&mut random, m));
        let (supply, demand) = (normalised(&random.many(n)), normalised(&random.many(m)));
        let cost = squared_distances(&a, &b);
        assert!(has_no_cheaper_cycle(&solve(&supply, &demand, &cost), &cost), "{n} × {m}");
    }
}

/// Equal masses on two lattices, integer costs: every basis is degenerate and ties abound.
#[test]
fn assignment_of_lattices_is_optimal() {
    let lattice: Vec<[f64; 2]> = (0..196).map(|i| [f64::from(i % 14), f64::from(i / 14)]).collect();
    let turned: Vec<[f64; 2]> = lattice.iter().map(|p| [p[1] + 3.0, -p[0]]).collect();
    let masses = vec![1.0; lattice.len()];
    let cost = squared_distances(&lattice, &turned);
    let plan = solve(&masses, &masses, &cost);
    assert!(has_no_cheaper_cycle(&plan, &cost));
    // The lattices are translates of each other, and translation is then the cheapest way.
    assert_eq!(plan.cost(&cost), 196.0 * (3.0 * 3.0 + 13.0 * 13.0));
}

/// Two costs and equal masses: nearly every step moves no mass, where a simplex may cycle.
#[test]
fn degenerate_steps_come_to_an_end() {
    let mut random = Random(3);
    for n in [50, 150, 300] {
        let cost: Vec<f64> =
            random.many(n * n).iter().map(|x| (x * 40.0).floor().min(1.0)).collect();
        let plan = solve(&vec![1.0; n], &vec![1.0; n], &cost);
        assert!(has_no_cheaper_cycle(&plan, &cost));
        assert!(plan.entries().iter().all(|f| (f.mass - 1.0).abs() < 1e-12));
    }
}

#[test]
fn translation_does_not_change_the_plan() {
    let mut random = Random(11);
    let (a, b) = (points(&mut random, 40), points(&mut random, 50));
    let (supply, demand) = (normalised(&random.many(40)), normalised(&random.many(50)));
    let moved: Vec<[f64; 2]> = b.iter().map(|p| [p[0] + 0.7, p[1] - 1.3]).collect();
    let plan = solve(&supply, &demand, &squared_distances(&a, &b));
    let after = solve(&supply, &demand, &squared_distances(&a, &moved));
    let pairs = |p: &TransportPlan| p.entries().iter().map(|f| (f.from, f.to)).collect::<Vec<_>>();
    assert_eq!(pairs(&plan), pairs(&after));
    for (f, g) in plan.entries().iter().zip(after.entries()) {
        assert!((f.mass - g.mass).abs() < 1e-14);
    }
}

#[test]
fn one_source_or_one_target() {
    let masses = [0.25, 0.0, 0.75];
    let to_many = solve(&[1.0], &masses, &[3.0, 1.0, 2.0]);
    let expected = [Flow { from: 0, to: 0, mass: 0.25 }, Flow { from: 0, to: 2, mass: 0.75 }];
    assert_eq!(to_many.entries(), expected);
    assert_eq!(to_many.row(0), expected);
    let from_many = solve(&masses, &[1.0], &[3.0, 1.0, 2.0]);
    assert_eq!(from_many.row(2), [Flow { from: 2, to: 0, mass: 0.75 }]);
    assert_eq!(from_many.row(1), []);
    assert_eq!(from_many.cost(&[3.0, 1.0, 2.0]), 2.25);
    assert!(from_many.cost(&[1.0]).is_nan());
}

#[test]
fn no_mass_no_flow() {
    let plan = solve(&[0.0, 0.0], &[0.0], &[1.0, 2.0]);
    assert_eq!((plan.entries(), plan.rows(), plan.columns()), (&[][..], 2, 1));
    let partial = partial::solve(&[0.0, 0.0], &[3.0], &[1.0, 2.0], 5.0).expect("plan");
    assert_eq!((partial.faded, partial.appeared), (vec![0.0, 0.0], vec![3.0]));
}

#[test]
fn mass_fades_beyond_tau() {
    // Two peaks exchange energy: 0.3 vanishes at one and appears at the other, far away.
    let near_far = [0.01, 4.0, 4.0, 0.01];
    let plan = partial::solve(&[0.8, 0.2], &[0.5, 0.5], &near_far, 0.1).expect("plan");
    let pairs: Vec<_> = plan.travelling.entries().iter().map(|f| (f.from, f.to)).collect();
    assert_eq!(pairs, [(0, 0), (1, 1)]);
    assert!((plan.faded[0] - 0.3).abs() < 1e-15 && (plan.appeared[1] - 0.3).abs() < 1e-15);
    // With a longer reach it travels.
    let plan = partial::solve(&[0.8, 0.2], &[0.5, 0.5], &near_far, 5.0).expect("plan");
    assert_eq!(plan.travelling.entries().len(), 3);
    assert!(plan.faded.iter().chain(&plan.appeared).all(|m| *m < 1e-15));
}

#[test]
fn extreme_numbers_end_well() {
    for size in [1e-300, 1e-150, 1e150, 1e300] {
        let masses = [size, 2.0 * size, 3.0 * size];
        let other = [3.0 * size, size, 2.0 * size];
        let cost: Vec<f64> = (0..9).map(|k| f64::from(k * 7 % 5) * size).collect();
        let plan = solve(&masses, &other, &cost);
        assert!(has_no_cheaper_cycle(&plan, &cost), "{size}");
    }
    // A mass far below a unit of the whole still arrives, whole.
    let plan = solve(&[1.0, 1e-25], &[1.0, 1e-25], &[0.0, 1.0, 1.0, 0.0]);
    assert_eq!(plan.row_sums(), [1.0, 1e-25]);
    let plan = solve(&[1e-320, 1.0], &[0.5, 0.5], &[1.0, 2.0, 3.0, 5e-324]);
    assert!(plan.entries().iter().all(|f| f.mass.is_finite()));
}

#[test]
fn rubbish_is_refused() {
    let fault = |s: &[f64], d: &[f64], c: &[f64]| Problem::new(s, d, c).err();
    assert_eq!(fault(&[], &[1.0], &[]), Some(Invalid::Empty { name: "supply" }));
    assert_eq!(fault(&[1.0], &[], &[]), Some(Invalid::Empty { name: "demand" }));
    assert_eq!(fault(&[1.0], &[1.0], &[]), Some(Invalid::Shape { expected: 1, found: 0 }));
    assert_eq!(
        fault(&[1.0], &[2.0, -1.0], &[0.0, 0.0]),
        Some(Invalid::Mass { name: "demand", index: 1, found: -1.0 })
    );
    assert!(matches!(fault(&[f64::NAN], &[1.0], &[0.0]), Some(Invalid::Mass { .. })));
    assert!(matches!(fault(&[1.0], &[1.0], &[f64::INFINITY]), Some(Invalid::Cost { .. })));
    assert!(matches!(fault(&[1.0], &[1.1], &[0.0]), Some(Invalid::Totals { .. })));
    assert!(matches!(fault(&[1e308; 3], &[1e308; 3], &[0.0; 9]), Some(Invalid::Totals { .. })));
    let tau = partial::solve(&[1.0], &[1.0], &[0.0], -1.0).err();
    assert_eq!(tau, Some(Invalid::Threshold { found: -1.0 }));
    let message = Invalid::Mass { name: "demand", index: 1, found: -1.0 }.to_string();
    assert_eq!(message, "demand[1]: expected a finite mass of at least 0, found -1");
}

#[test]
fn six_hundred_lobes_take_no_time() {
    for n in [24, 64, 200, 600] {
        let mut random = Random(n as u64);
        let (a, b) = (points(&mut random, n), points(&mut random, n));
        let (supply, demand) = (normalised(&random.many(n)), normalised(&random.many(n)));
        let cost = squared_distances(&a, &b);
        let start = std::time::Instant::now();
        let plan = solve(&supply, &demand, &cost);
        let took = start.elapsed();
        println!("{n} × {n}: {took:?}, {} flows", plan.entries().len());
        assert!(took.as_secs_f64() < 2.0, "{n} × {n} took {took:?}");
    }
}
