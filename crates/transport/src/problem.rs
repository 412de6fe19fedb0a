//! What is given: masses at sources, masses at targets, the cost of each pair.

use std::fmt;

/// Totals further apart than this share of the larger one are different totals.
///
/// Sums of a thousand f64 agree to 1e-13; doubled, it would hide a lobe lost by the caller sooner.
const TOTALS_AGREE: f64 = 1e-9;

/// A balanced transportation problem: min Σ cᵢⱼ xᵢⱼ with Σⱼ xᵢⱼ = supplyᵢ, Σᵢ xᵢⱼ = demandⱼ, x ≥ 0.
#[derive(Clone, Copy, Debug)]
pub struct Problem<'a> {
    supply: &'a [f64],
    demand: &'a [f64],
    cost: &'a [f64],
    supply_total: f64,
    demand_total: f64,
}

impl<'a> Problem<'a> {
    /// Checks and borrows; masses may be 0, costs negative.
    ///
    /// Shapes: `cost[i * demand.len() + j]` is from source i to target j.
    ///
    /// Errors: no source or no target, cost of another shape, a mass that is negative or not finite, a
    /// cost that is not finite, totals that differ by more than 1e-9 of the larger one. Demand is scaled
    /// to the total of supply.
    pub fn new(supply: &'a [f64], demand: &'a [f64], cost: &'a [f64]) -> Result<Self, Invalid> {
        check_masses("supply", supply)?;
        check_masses("demand", demand)?;
        check_costs(supply.len(), demand.len(), cost)?;
        let supply_total: f64 = supply.iter().sum();
        let demand_total: f64 = demand.iter().sum();
        let larger = supply_total.max(demand_total);
        if !larger.is_finite() || (supply_total - demand_total).abs() > TOTALS_AGREE * larger {
            return Err(Invalid::Totals { supply: supply_total, demand: demand_total });
        }
        Ok(Problem { supply, demand, cost, supply_total, demand_total })
    }

    /// Mass at each source.
    pub fn supply(&self) -> &'a [f64] {
        self.supply
    }

    /// Mass wanted at each target, as given.
    pub fn demand(&self) -> &'a [f64] {
        self.demand
    }

    /// Cost per mass, row-major: a row for each source.
    pub fn cost(&self) -> &'a [f64] {
        self.cost
    }

    /// Sum of supply.
    pub(crate) fn supply_total(&self) -> f64 {
        self.supply_total
    }

    /// Sum of demand as given.
    pub(crate) fn demand_total(&self) -> f64 {
        self.demand_total
    }
}

/// Masses must be there, few enough for 32-bit numbers, finite and not negative.
pub(crate) fn check_masses(name: &'static str, masses: &[f64]) -> Result<(), Invalid> {
    if masses.is_empty() {
        return Err(Invalid::Empty { name });
    }
    if u32::try_from(masses.len()).is_err() {
        return Err(Invalid::TooMany);
    }
    match masses.iter().position(|m| !m.is_finite() || *m < 0.0) {
        Some(index) => Err(Invalid::Mass { name, index, found: masses[index] }),
        None => Ok(()),
    }
}

/// Costs must be there for each pair, and finite.
pub(crate) fn check_costs(rows: usize, columns: usize, cost: &[f64]) -> Result<(), Invalid> {
    let expected = rows.checked_mul(columns).ok_or(Invalid::TooMany)?;
    if cost.len() != expected {
        return Err(Invalid::Shape { expected, found: cost.len() });
    }
    match cost.iter().position(|c| !c.is_finite()) {
        Some(index) => {
            let (from, to) = (index / columns, index % columns);
            Err(Invalid::Cost { from, to, found: cost[index] })
        }
        None => Ok(()),
    }
}

/// Why something is no transportation problem.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Invalid {
    /// No source or no target.
    Empty {
        /// "supply" or "demand".
        name: &'static str,
    },
    /// More sources or targets than can be numbered.
    TooMany,
    /// The cost matrix has not a cost for each pair.
    Shape {
        /// Sources times targets.
        expected: usize,
        /// Length of the cost slice.
        found: usize,
    },
    /// A mass that is negative or not finite.
    Mass {
        /// "supply" or "demand".
        name: &'static str,
        /// Which.
        index: usize,
        /// Its value.
        found: f64,
    },
    /// A cost that is not finite.
    Cost {
        /// Source.
        from: usize,
        /// Target.
        to: usize,
        /// Its value.
        found: f64,
    },
    /// Supply and demand differ, or their sum overflows.
    Totals {
        /// Sum of supply.
        supply: f64,
        /// Sum of demand.
        demand: f64,
    },
    /// The distance beyond which mass fades is negative or not finite.
    Threshold {
        /// Its value.
        found: f64,
    },
}

impl fmt::Display for Invalid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Invalid::Empty { name } => write!(f, "{name}: expected at least one mass, found none"),
            Invalid::TooMany => write!(f, "expected fewer than 2^32 sources and targets"),
            Invalid::Shape { expected, found } => {
                write!(f, "cost: expected {expected} values (sources times targets), found {found}")
            }
            Invalid::Mass { name, index, found } => {
                write!(f, "{name}[{index}]: expected a finite mass of at least 0, found {found}")
            }
            Invalid::Cost { from, to, found } => {
                write!(f, "cost[{from}][{to}]: expected a finite number, found {found}")
            }
            Invalid::Totals { supply, demand } => {
                write!(f, "expected equal totals, found supply {supply} and demand {demand}")
            }
            Invalid::Threshold { found } => {
                write!(f, "tau: expected a finite number of at least 0, found {found}")
            }
        }
    }
}

impl std::error::Error for Invalid {}
