//! The Hilbert curve on the unit square. [GL96]
