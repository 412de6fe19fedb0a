//! What a file holds: a stored BSDF or an interpolant.

use std::borrow::Cow;

use bsdfkit::{Bsdf, Side};
use bsdfkit_fit::deliver::Subject;
use bsdfkit_fit::interpolant::Interpolant;
use bsdfkit_represent::Source;

/// A BSDF in either form.
#[derive(Clone, Debug)]
pub(crate) enum Surface {
    /// Trees or matrices.
    Stored(Box<Bsdf>),
    /// A function to be evaluated.
    Continuous(Interpolant),
}

/// Both sides.
pub(crate) const SIDES: [Side; 2] = [Side::Front, Side::Back];

impl Surface {
    /// Pairs of sides (incident, scattered) that hold data.
    pub(crate) fn pairs(&self) -> Vec<(Side, Side)> {
        match self {
            Self::Stored(b) => b.components().iter().map(|c| (c.incident, c.scattered)).collect(),
            Self::Continuous(i) => {
                i.components.iter().map(|p| (p.incident(), p.scattered())).collect()
            }
        }
    }

    /// Sides from which light is known to be scattered.
    pub(crate) fn incident_sides(&self) -> Vec<Side> {
        let pairs = self.pairs();
        SIDES.into_iter().filter(|&s| pairs.iter().any(|&(incident, _)| incident == s)).collect()
    }

    /// What is tabulated of it.
    pub(crate) fn subject(&self) -> Subject<'_> {
        match self {
            Self::Stored(bsdf) => Subject::Stored(bsdf),
            Self::Continuous(interpolant) => Subject::Continuous(interpolant),
        }
    }

    /// What answers the five verbs.
    pub(crate) fn bsdf(&self) -> Cow<'_, Bsdf> {
        self.subject().bsdf()
    }
}
