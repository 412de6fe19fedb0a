//! Radiance's interpolants.

use bsdfkit_fit::interpolant::Interpolant;
use bsdfkit_represent::sir::{Plans, Sir, SirLimits};

use crate::ask::{Trust, ask};

/// Any bytes as a SIR file, plans as they stand and repaired.
pub fn sir(bytes: &[u8]) {
    let stored = Sir::from_bytes(bytes, Plans::AsStored, SirLimits::default());
    let repaired = Interpolant::from_sir(bytes);
    assert_eq!(stored.is_ok(), repaired.is_ok());
    if let Ok(interpolant) = repaired {
        ask(&interpolant.bsdf(), Trust::Checked);
    }
}
