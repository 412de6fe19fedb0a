//! Smooth numbers over incident directions: what energy is interpolated with, and how f goes on past the rim.

pub(crate) mod cells;
pub(crate) mod energy;
pub(crate) mod multiquadric;
pub(crate) mod past_rim;
pub(crate) mod profile;
