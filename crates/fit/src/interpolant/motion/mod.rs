//! How lobes correspond along edges and travel inside a cell. [WKB14 §2.2]

pub(crate) mod cell_movers;
pub(crate) mod edge_plan;
pub(crate) mod hypothesis;
pub(crate) mod moved;
pub(crate) mod mover;
pub(crate) mod tracks;
