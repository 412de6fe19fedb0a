//! What a file is made of.

use std::borrow::Cow;
use std::path::Path;

use bsdfkit::{Bsdf, Metadata, Result, Side};
use bsdfkit_represent::rgl::{self, Channels};
use bsdfkit_represent::tabulate::is_isotropic;
use bsdfkit_represent::{Source, Watch};

use crate::interpolant::Interpolant;

/// What is tabulated.
#[derive(Clone, Copy, Debug)]
pub enum Subject<'a> {
    /// Trees or matrices.
    Stored(&'a Bsdf),
    /// A function to be evaluated.
    Continuous(&'a Interpolant),
}

impl<'a> Subject<'a> {
    /// What answers queries.
    pub fn bsdf(self) -> Cow<'a, Bsdf> {
        match self {
            Self::Stored(bsdf) => Cow::Borrowed(bsdf),
            Self::Continuous(interpolant) => Cow::Owned(interpolant.bsdf()),
        }
    }

    /// Writes the reflection of the front as RGL's tables; returns what is left out, a sentence each.
    ///
    /// Errors and cost: [`rgl::write`].
    pub fn write_rgl(
        self,
        metadata: &Metadata,
        channels: Channels,
        path: &Path,
        watch: &Watch<'_>,
    ) -> Result<Vec<String>> {
        let isotropic = self.is_isotropic(Side::Front, Side::Front);
        rgl::write(&self.bsdf(), isotropic, metadata, channels, path, watch)
    }

    /// Whether azimuths count by their difference alone between these sides; also where nothing goes from one to the other.
    fn is_isotropic(self, incident: Side, scattered: Side) -> bool {
        let other = |from, to| (from, to) != (incident, scattered);
        match self {
            Self::Stored(bsdf) => {
                bsdf.components().iter().all(|c| other(c.incident, c.scattered) || is_isotropic(c))
            }
            Self::Continuous(interpolant) => {
                let mut parts = interpolant.components.iter();
                parts.all(|p| other(p.incident(), p.scattered()) || p.isotropic())
            }
        }
    }
}
