//! What is read from the command line and standard input, and how results, progress and faults are printed.

pub(crate) mod angles;
pub(crate) mod progress;
pub(crate) mod python;
pub(crate) mod queries;
pub(crate) mod rows;
pub(crate) mod spent;
pub(crate) mod stop;
pub(crate) mod table;
pub(crate) mod ward;
