//! Rows of two directions gathered by incident direction.

use std::collections::HashMap;

use bsdfkit_sphere::direction;

use super::block::{Block, HORIZON_COSINE, Remark};

/// One incident direction a row is no goniophotometer's table, and each costs a block of memory.
pub(super) const MOST_INCIDENCES: usize = 20_000;

/// Rows so far.
#[derive(Default)]
pub(super) struct Gathered {
    blocks: Vec<Block>,
    /// Incident (θ, φ) as written → block.
    index: HashMap<(u64, u64), usize>,
    horizon: u64,
}

impl Gathered {
    /// Adds one row: (θ, φ) in degrees of the incident and of the scattered direction, both away from the surface, and its
    /// values. Rows that scatter along the horizon are counted and left out.
    ///
    /// Errors: the message for light that comes along the horizon, and for too many incident directions.
    pub(super) fn take(
        &mut self,
        incident: (f64, f64),
        scattered: (f64, f64),
        values: &[f32],
    ) -> Result<(), String> {
        let key = (incident.0.to_bits(), incident.1.to_bits());
        let at = match self.index.get(&key) {
            Some(&at) => at,
            None => {
                let wi = direction::from_degrees(incident.0, incident.1);
                if wi.z.abs() < HORIZON_COSINE {
                    return Err(format!(
                        "theta_i: expected a direction off the horizon, found {} degrees",
                        incident.0
                    ));
                }
                if self.blocks.len() == MOST_INCIDENCES {
                    return Err(format!(
                        "expected at most {MOST_INCIDENCES} incident directions, found more"
                    ));
                }
                self.blocks.push(Block::new(wi));
                self.index.insert(key, self.blocks.len() - 1);
                self.blocks.len() - 1
            }
        };
        let wo = direction::from_degrees(scattered.0, scattered.1);
        if wo.z.abs() < HORIZON_COSINE {
            self.horizon += 1;
            return Ok(());
        }
        let block = &mut self.blocks[at];
        block.wo.push(wo);
        block.values.extend_from_slice(values);
        Ok(())
    }

    /// The blocks, and what was left out.
    pub(super) fn finish(mut self, remarks: &mut Vec<Remark>) -> Vec<Block> {
        self.blocks.iter_mut().for_each(Block::shrink_to_fit);
        if self.horizon > 0 {
            remarks.push(Remark::of_file(format!("{} rows at the horizon dropped", self.horizon)));
        }
        self.blocks
    }
}
