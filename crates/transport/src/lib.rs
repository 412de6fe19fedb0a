//! The transportation problem: exact plans by network simplex. Knows no optics.
