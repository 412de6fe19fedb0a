//! The forms that files have.

use std::str::FromStr;

use bsdfkit::matrix::KlemsBasis;
use bsdfkit::{Error, Result};

use bsdfkit_represent::rgl::Channels;

/// The form of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Tensor trees.
    TensorTree,
    /// Klems matrices of 145 directions.
    KlemsFull,
    /// Of 77.
    KlemsHalf,
    /// Of 41.
    KlemsQuarter,
    /// The render form.
    Render,
    /// The interpolant itself.
    Interpolant,
    /// [RGL's](bsdfkit_represent::rgl) tables in RGB.
    RglRgb,
    /// The same in wavelengths.
    RglSpectral,
}

impl Kind {
    /// Every one.
    pub const ALL: [Self; 8] = [
        Self::TensorTree,
        Self::KlemsFull,
        Self::KlemsHalf,
        Self::KlemsQuarter,
        Self::Render,
        Self::Interpolant,
        Self::RglRgb,
        Self::RglSpectral,
    ];

    /// As the command and Python name it.
    pub fn name(self) -> &'static str {
        match self {
            Self::TensorTree => "tensor-tree",
            Self::KlemsFull => "klems-full",
            Self::KlemsHalf => "klems-half",
            Self::KlemsQuarter => "klems-quarter",
            Self::Render => "render",
            Self::Interpolant => "interpolant",
            Self::RglRgb => "rgl-rgb",
            Self::RglSpectral => "rgl-spectral",
        }
    }

    /// Whether a file of it is a container; else it is XML.
    pub fn is_container(self) -> bool {
        matches!(self, Self::Render | Self::Interpolant)
    }

    /// The basis of a matrix.
    pub fn basis(self) -> Option<KlemsBasis> {
        match self {
            Self::KlemsFull => Some(KlemsBasis::full()),
            Self::KlemsHalf => Some(KlemsBasis::half()),
            Self::KlemsQuarter => Some(KlemsBasis::quarter()),
            Self::TensorTree
            | Self::Render
            | Self::Interpolant
            | Self::RglRgb
            | Self::RglSpectral => None,
        }
    }

    /// The channels of RGL's tables.
    pub fn channels(self) -> Option<Channels> {
        match self {
            Self::RglRgb => Some(Channels::Rgb),
            Self::RglSpectral => Some(Channels::Spectral),
            _ => None,
        }
    }
}

impl FromStr for Kind {
    type Err = Error;

    /// Errors: argument, for any other name.
    fn from_str(name: &str) -> Result<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name).ok_or_else(|| {
            let names = Self::ALL.map(Self::name).join(", ");
            Error::argument(format!("kind: expected one of {names}, found {name:?}"))
        })
    }
}
