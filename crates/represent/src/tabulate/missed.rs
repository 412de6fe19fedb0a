//! A target that was not reached: the same words whoever asked for it.

use std::fmt::{self, Display, Formatter};

/// What stood in the way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limit {
    /// More than so many leaves would be needed.
    Leaves(usize),
    /// Leaves below this level would be needed.
    Depth(u32),
    /// More than so many values of the source would be needed.
    Samples(usize),
    /// So many incident patches or rings vary too much to be averaged in the steps that there are.
    Averaging(usize),
}

/// A largest L1 that was to be reached, by request or by default, and was not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Missed {
    /// The L1 to be reached.
    pub target: f64,
    /// Why it was not.
    pub limit: Limit,
}

impl Display for Missed {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "target L1 {} not reached: ", self.target)?;
        match self.limit {
            Limit::Leaves(leaves) => write!(f, "it takes more than {leaves} leaves"),
            Limit::Depth(level) => write!(f, "it takes leaves deeper than level {level}"),
            Limit::Samples(samples) => {
                write!(f, "it takes more than {samples} values of the source")
            }
            Limit::Averaging(rows) => {
                write!(f, "{rows} incident patches or rings vary too much to be averaged")
            }
        }
    }
}
