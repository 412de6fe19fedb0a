//! What is found: which mass goes where.

/// Mass that goes from one source to one target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flow {
    /// Source.
    pub from: u32,
    /// Target.
    pub to: u32,
    /// How much, above 0.
    pub mass: f64,
}

/// A sparse plan; row sums are the source masses, column sums the target masses.
#[derive(Clone, Debug, PartialEq)]
pub struct TransportPlan {
    entries: Vec<Flow>,
    rows: usize,
    columns: usize,
    optimal: bool,
}

impl TransportPlan {
    pub(crate) fn new(mut entries: Vec<Flow>, rows: usize, columns: usize, optimal: bool) -> Self {
        entries.sort_unstable_by_key(|f| (f.from, f.to));
        TransportPlan { entries, rows, columns, optimal }
    }

    /// All flows by source, then target: at most rows + columns − 1, none of mass 0.
    pub fn entries(&self) -> &[Flow] {
        &self.entries
    }

    /// How many sources.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// How many targets.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// The flows that leave source `from`.
    ///
    /// Cost: O(log entries).
    pub fn row(&self, from: u32) -> &[Flow] {
        let start = self.entries.partition_point(|f| f.from < from);
        let length = self.entries[start..].partition_point(|f| f.from == from);
        &self.entries[start..start + length]
    }

    /// Mass that leaves each source.
    pub fn row_sums(&self) -> Vec<f64> {
        let mut sums = vec![0.0; self.rows];
        for f in &self.entries {
            sums[f.from as usize] += f.mass;
        }
        sums
    }

    /// Mass that reaches each target.
    pub fn column_sums(&self) -> Vec<f64> {
        let mut sums = vec![0.0; self.columns];
        for f in &self.entries {
            sums[f.to as usize] += f.mass;
        }
        sums
    }

    /// Σ mass · cost; NaN if `cost` is not rows × columns long.
    pub fn cost(&self, cost: &[f64]) -> f64 {
        let at = |f: &Flow| cost.get(f.from as usize * self.columns + f.to as usize);
        if cost.len() != self.rows * self.columns {
            return f64::NAN;
        }
        self.entries.iter().filter_map(|f| at(f).map(|c| c * f.mass)).sum()
    }

    /// Whether no cheaper plan exists; false only if the solver ran into its bound on steps.
    pub fn is_optimal(&self) -> bool {
        self.optimal
    }
}
