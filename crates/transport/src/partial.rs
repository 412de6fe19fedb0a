//! Partial transport: mass travels only as far as it is worth, the rest fades. [CM10]

use crate::network_simplex;
use crate::plan::{Flow, TransportPlan};
use crate::problem::{Invalid, Problem, check_costs, check_masses};

/// A plan that leaves mass behind: row sums + faded = supply, column sums + appeared = demand.
#[derive(Clone, Debug, PartialEq)]
pub struct PartialPlan {
    /// What travels; every pair costs less than tau.
    pub travelling: TransportPlan,
    /// Mass of each source that goes nowhere.
    pub faded: Vec<f64>,
    /// Mass of each target that comes from nowhere.
    pub appeared: Vec<f64>,
}

/// Finds min Σ cᵢⱼ xᵢⱼ + τ/2 (Σ faded + Σ appeared): mass travels only where that costs less than τ.
///
/// Totals need not be equal. Solved exactly as a balanced problem with one more source and one
/// more target, at cost τ/2 from each other one and 0 between them.
///
/// Shapes: `cost[i * demand.len() + j]`, as in [`Problem::new`].
///
/// Errors: as [`Problem::new`], but for the totals; `tau` negative or not finite.
pub fn solve(
    supply: &[f64],
    demand: &[f64],
    cost: &[f64],
    tau: f64,
) -> Result<PartialPlan, Invalid> {
    if !tau.is_finite() || tau < 0.0 {
        return Err(Invalid::Threshold { found: tau });
    }
    check_masses("supply", supply)?;
    check_masses("demand", demand)?;
    let (rows, columns) = (supply.len(), demand.len());
    check_costs(rows, columns, cost)?;
    // From tau on all costs are alike: too much. So they do not coarsen the others' rounding.
    let too_much = if tau > 0.0 { 2.0 * tau } else { 1.0 };
    let mut extended = Vec::with_capacity((rows + 1) * (columns + 1));
    for row in cost.chunks_exact(columns) {
        extended.extend(row.iter().map(|&c| if c < tau { c } else { too_much }));
        extended.push(tau / 2.0);
    }
    extended.extend(std::iter::repeat_n(tau / 2.0, columns));
    extended.push(0.0);
    let with = |masses: &[f64], other: &[f64]| -> Vec<f64> {
        masses.iter().copied().chain([other.iter().sum()]).collect()
    };
    let (supply, demand) = (with(supply, demand), with(demand, supply));
    let plan = network_simplex::solve(&Problem::new(&supply, &demand, &extended)?);

    let (mut faded, mut appeared) = (vec![0.0; rows], vec![0.0; columns]);
    let mut travelling = Vec::with_capacity(plan.entries().len());
    for &Flow { from, to, mass } in plan.entries() {
        match (from as usize == rows, to as usize == columns) {
            (false, false) => travelling.push(Flow { from, to, mass }),
            (false, true) => faded[from as usize] = mass,
            (true, false) => appeared[to as usize] = mass,
            (true, true) => {}
        }
    }
    let travelling = TransportPlan::new(travelling, rows, columns, plan.is_optimal());
    Ok(PartialPlan { travelling, faded, appeared })
}
