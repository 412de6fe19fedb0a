//! What a file holds: a stored BSDF or an interpolant.

use std::borrow::Cow;

use bsdfkit::tree::{Rank, TreeDistribution};
use bsdfkit::{Bsdf, Component, DVec3, Side};
use bsdfkit_fit::interpolant::Interpolant;
use bsdfkit_fit::tabulate::{Slice, Source};

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

    /// What answers the five verbs.
    pub(crate) fn bsdf(&self) -> Cow<'_, Bsdf> {
        match self {
            Self::Stored(bsdf) => Cow::Borrowed(bsdf),
            Self::Continuous(interpolant) => Cow::Owned(interpolant.bsdf()),
        }
    }
}

/// A stored component as a continuous BSDF, to be tabulated anew.
pub(crate) struct Retabulated<'a>(pub(crate) &'a Component);

impl Source for Retabulated<'_> {
    fn incident(&self) -> Side {
        self.0.incident
    }

    fn scattered(&self) -> Side {
        self.0.scattered
    }

    fn isotropic(&self) -> bool {
        let tree = self.0.distribution().downcast_ref::<TreeDistribution>();
        tree.is_some_and(|t| t.luminance().rank() == Rank::Three)
    }

    fn slice<'a>(&'a self, wi: DVec3) -> Box<dyn Slice + 'a> {
        Box::new(RetabulatedSlice { component: self.0, wi })
    }
}

struct RetabulatedSlice<'a> {
    component: &'a Component,
    wi: DVec3,
}

impl Slice for RetabulatedSlice<'_> {
    fn eval(&self, wo: &[DVec3], out: &mut [f32]) {
        for (value, &w) in out.iter_mut().zip(wo) {
            *value = self.component.distribution().value(self.wi, w) as f32;
        }
    }
}
