//! A sparse transport plan as SIR files store it, and the entry that its writer loses.

use bsdfkit::{Error, Result};

use super::bytes::Bytes;
use super::node::SirNode;

/// Smaller fractions are never used by the reference, so they are not kept. Doubling it loses 1e-6 of a lobe.
const SMALLEST: f64 = 1e-6;

/// More entries per lobe than this are refused: a vertex of the transport polytope has at most one.
const MOST_PER_LOBE: usize = 16;

/// A transport plan along a mesh edge; row i of `plan` says where lobe i of node `from` goes.
#[derive(Clone, Debug)]
pub struct Migration {
    /// Index of the source node, below `to`.
    pub from: usize,
    /// Index of the target node.
    pub to: usize,
    /// Fractions of each source lobe; rows sum to one.
    pub plan: Plan,
}

/// Part of a source lobe that goes to target lobe `to`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanEntry {
    /// Index of the target lobe.
    pub to: u32,
    /// Fraction of the source lobe's mass.
    pub fraction: f32,
}

/// A matrix of fractions, rows = source lobes, in compressed rows; rows without entries take no memory.
///
/// Cost: [`Plan::row`] is O(log rows). Each row is sorted by falling fraction.
#[derive(Clone, Debug, Default)]
pub struct Plan {
    rows: Vec<u32>,
    starts: Vec<u32>,
    entries: Vec<PlanEntry>,
}

impl Plan {
    /// Entries of source lobe `from`, the largest fraction first.
    pub fn row(&self, from: usize) -> &[PlanEntry] {
        match self.rows.binary_search_by(|&r| (r as usize).cmp(&from)) {
            Ok(k) => &self.entries[self.starts[k] as usize..self.starts[k + 1] as usize],
            Err(_) => &[],
        }
    }

    /// Number of entries.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Whether nothing goes anywhere.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// From (row, column, fraction) in any order, each pair once.
    fn from_entries(mut entries: Vec<(u32, PlanEntry)>) -> Plan {
        entries.sort_by(|(r, a), (s, b)| {
            r.cmp(s).then(b.fraction.total_cmp(&a.fraction)).then(a.to.cmp(&b.to))
        });
        let mut plan = Plan::default();
        for (row, entry) in entries {
            if plan.rows.last() != Some(&row) {
                plan.rows.push(row);
                plan.starts.push(plan.entries.len() as u32);
            }
            plan.entries.push(entry);
        }
        plan.starts.push(plan.entries.len() as u32);
        plan
    }

    /// Reads a run-length coded row-major matrix: zeros to skip (255: skip only), value, and so on.
    pub(super) fn parse(
        bytes: &mut Bytes,
        from: &SirNode,
        to: &SirNode,
    ) -> Result<Vec<(u32, PlanEntry)>> {
        let (rows, columns) = (from.lobes.len() as u64, to.lobes.len() as u64);
        let most = (from.lobes.len() + to.lobes.len()).saturating_mul(MOST_PER_LOBE);
        let mut entries = Vec::new();
        let mut at = 0_u64;
        loop {
            let zeros = bytes.u8("zeros in a plan")?;
            at += u64::from(zeros);
            if zeros == 255 {
                if at > rows * columns {
                    return Err(Error::format(format!(
                        "byte {}: expected a plan of {rows} × {columns}, found a run past its end",
                        bytes.offset() - 1
                    )));
                }
                continue;
            }
            if at >= rows * columns {
                return Ok(entries);
            }
            let offset = bytes.offset();
            let fraction = bytes.float("fraction in a plan")?;
            if fraction.abs() > 2.0 {
                return Err(Error::format(format!(
                    "byte {offset}: expected a fraction from 0 to 1 in a plan, found {fraction}"
                )));
            }
            if fraction > SMALLEST {
                let entry = PlanEntry { to: (at % columns) as u32, fraction: fraction as f32 };
                entries.push(((at / columns) as u32, entry));
            }
            if entries.len() > most {
                return Err(Error::limit(format!(
                    "byte {offset}: expected at most {most} entries in a plan of {rows} × {columns}, found more"
                )));
            }
            at += 1;
        }
    }

    /// The plan of parsed entries; true when a lost entry was put back.
    ///
    /// Row i must sum to 1 and column j to its share of the target, so one lost entry lacks the same mass in exactly
    /// one row and one column. Nothing is invented: where the two deficits differ, the plan stays as it is.
    pub(super) fn build(
        mut entries: Vec<(u32, PlanEntry)>,
        repair: Option<(&[f64], &[f64])>,
    ) -> (Plan, bool) {
        let lost = repair.and_then(|(supply, demand)| lost_entry(&entries, supply, demand));
        if let Some((row, entry)) = lost {
            match entries.iter_mut().find(|(r, e)| *r == row && e.to == entry.to) {
                Some((_, found)) => found.fraction += entry.fraction,
                None => entries.push((row, entry)),
            }
        }
        (Plan::from_entries(entries), lost.is_some())
    }
}

/// Where one row and one column lack the same mass.
fn lost_entry(
    entries: &[(u32, PlanEntry)],
    supply: &[f64],
    demand: &[f64],
) -> Option<(u32, PlanEntry)> {
    // A plan with far fewer entries than a vertex of the polytope lacks more than one.
    if entries.len() + 2 < supply.len().max(demand.len()) {
        return None;
    }
    let mut rows = supply.to_vec();
    let mut columns = demand.to_vec();
    for (row, entry) in entries {
        let mass = supply[*row as usize] * f64::from(entry.fraction);
        rows[*row as usize] -= mass;
        columns[entry.to as usize] -= mass;
    }
    let (row, lacking) = largest(&rows)?;
    let (column, wanted) = largest(&columns)?;
    // Masses are stored as 32-bit fractions; 1e-6 is a few of their steps, 2 % covers the dropped residuals.
    let agree = (lacking - wanted).abs() < 1e-6 + 0.02 * lacking.abs();
    (agree && lacking > 2e-6).then(|| {
        (row as u32, PlanEntry { to: column as u32, fraction: (lacking / supply[row]) as f32 })
    })
}

fn largest(values: &[f64]) -> Option<(usize, f64)> {
    values.iter().copied().enumerate().max_by(|a, b| a.1.total_cmp(&b.1))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(row: u32, to: u32, fraction: f32) -> (u32, PlanEntry) {
        (row, PlanEntry { to, fraction })
    }

    #[test]
    fn a_lost_entry_comes_back_where_row_and_column_lack_it() {
        // Masses (0.5, 0.5) → (0.2, 0.3, 0.5): 0→0 0.2, 0→1 0.3 and 1→2 0.5; each in turn is lost.
        let whole = vec![entry(0, 0, 0.4), entry(0, 1, 0.6), entry(1, 2, 1.0)];
        let (supply, demand) = ([0.5, 0.5], [0.2, 0.3, 0.5]);
        for k in 0..whole.len() {
            let mut rest = whole.clone();
            let (row, gone) = rest.remove(k);
            let (plan, repaired) = Plan::build(rest, Some((&supply, &demand)));
            assert!(repaired);
            let back =
                plan.row(row as usize).iter().find(|e| e.to == gone.to).expect("the entry is back");
            assert!((back.fraction - gone.fraction).abs() < 1e-6);
        }
        let (plan, repaired) = Plan::build(whole, Some((&supply, &demand)));
        assert!(!repaired && plan.len() == 3);
    }

    #[test]
    fn rows_fall() {
        let (plan, _) =
            Plan::build(vec![entry(3, 0, 0.1), entry(1, 5, 1.0), entry(3, 2, 0.9)], None);
        assert_eq!(plan.row(3).iter().map(|e| e.to).collect::<Vec<_>>(), [2, 0]);
        assert_eq!(plan.row(1).len(), 1);
        assert!(plan.row(0).is_empty() && plan.row(9).is_empty());
    }
}
