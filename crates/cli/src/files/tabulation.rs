//! How trees are tabulated and interpolants stored.

use bsdfkit::spectrum::View;
use bsdfkit_fit::deliver::Order;
use bsdfkit_fit::interpolant::Encoding;
use bsdfkit_represent::tabulate::{Reciprocity, TreeSettings};
use clap::{Args, ValueEnum};

use crate::files::target::Target;

/// Most leaves of a tree.
const MAX_LEAVES: u64 = TreeSettings::MOST_LEAVES as u64;

/// How trees are tabulated and interpolants stored.
#[derive(Args, Clone, Debug)]
pub(crate) struct Tabulation {
    /// Share of the scattered light that the tree may put in a wrong place (L1), beyond what its
    /// source does, and that an incidence may have too much or too little of in all: the smallest such tree; what is not reached is said. Means of a matrix are found
    /// as well [default: 0.01]
    #[arg(long, value_name = "E")]
    max_error: Option<f64>,
    /// Most values in a tree, 7 bytes each: the best such tree [default: 3000000 for anisotropic
    /// and 70000 for isotropic materials, 1000000 for an isotropic component beside an anisotropic
    /// one; with --max-error 16777216]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=MAX_LEAVES))]
    max_leaves: Option<u64>,
    /// Deepest level of the tree: its leaves are at least 2^-N wide
    #[arg(long, value_name = "N")]
    max_depth: Option<u32>,
    /// Average f(wi, wo) and f(wo, wi) of reflection: auto in trees made of measurements and interpolants,
    /// where both agree
    #[arg(long, value_name = "WHEN", default_value = "auto")]
    reciprocity: When,
    /// What is made of the bands of a spectrum: photopic, melanopic, xyz or colour (each with -d65, -a or -e), solar, nir, mean, or a
    /// wavelength as 550nm; interpolants keep all bands [default: colour in daylight, and for WINDOW and EnergyPlus the sun's energy
    /// beside it where the bands reach that far]
    #[arg(long, value_name = "VIEW")]
    view: Option<View>,
    /// Interpolants in a tenth to a half of the space, within 2 % of their values
    #[arg(long)]
    compact: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum When {
    Auto,
    On,
    Off,
}

impl Tabulation {
    /// How interpolants are stored.
    pub(crate) fn encoding(&self) -> Encoding {
        if self.compact { Encoding::Compact } else { Encoding::Plain }
    }

    /// The same of another view.
    pub(crate) fn seen_as(&self, view: View) -> Self {
        Self { view: Some(view), ..self.clone() }
    }

    /// What is asked for of a target.
    pub(crate) fn order(&self, target: &Target) -> Order {
        Order {
            consumer: target.consumer,
            max_error: self.max_error,
            max_leaves: self.max_leaves.map(|n| n as usize),
            max_depth: self.max_depth,
            reciprocity: match self.reciprocity {
                When::Auto => Reciprocity::Auto,
                When::On => Reciprocity::On,
                When::Off => Reciprocity::Off,
            },
            view: self.view,
            bands: target.is_container(),
            ..Order::new(target.kind)
        }
    }
}
