//! A tree as a distribution: luminance, and optional chromaticity in trees of their own.

use super::node::TensorTree;
use crate::error::{Error, Result};

/// A BSDF component stored as tensor trees.
#[derive(Debug)]
pub struct TreeDistribution {
    luminance: TensorTree,
    /// CIE 1976 u′ and v′.
    chromaticity: Option<[TensorTree; 2]>,
}

impl TreeDistribution {
    /// A colourless one; values in 1/sr.
    pub fn new(luminance: TensorTree) -> Self {
        Self { luminance, chromaticity: None }
    }

    /// A coloured one: trees of Y (1/sr), u′ and v′, of equal rank but any shape.
    pub fn with_chromaticity(luminance: TensorTree, u: TensorTree, v: TensorTree) -> Result<Self> {
        for (tree, name) in [(&u, "u′"), (&v, "v′")] {
            if tree.rank() != luminance.rank() {
                return Err(Error::argument(format!(
                    "{name} tree: expected rank {}, found {}",
                    luminance.rank().dimensions(),
                    tree.rank().dimensions()
                )));
            }
        }
        Ok(Self { luminance, chromaticity: Some([u, v]) })
    }

    /// The tree of Y, 1/sr.
    pub fn luminance(&self) -> &TensorTree {
        &self.luminance
    }

    /// The trees of CIE 1976 u′ and v′.
    pub fn chromaticity(&self) -> Option<&[TensorTree; 2]> {
        self.chromaticity.as_ref()
    }
}
