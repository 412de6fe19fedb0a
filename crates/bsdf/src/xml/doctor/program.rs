//! The programs that read our files.

use std::str::FromStr;

use crate::{Error, Result};

/// A program that a file may be for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Program {
    /// Radiance and what is built on its library.
    Radiance,
    /// WINDOW and what is built on its engine.
    Window,
    /// EnergyPlus, as what its objects are made of.
    EnergyPlus,
    /// frads: Radiance's matrices, and WINDOW's engine for glazing.
    Frads,
    /// honeybee-radiance.
    Honeybee,
    /// Mitsuba, by our plugin or RGL's tables.
    Mitsuba,
}

impl Program {
    /// Every one.
    pub const ALL: [Self; 6] = [
        Self::Radiance,
        Self::Window,
        Self::EnergyPlus,
        Self::Frads,
        Self::Honeybee,
        Self::Mitsuba,
    ];

    /// As the command and Python name it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Radiance => "radiance",
            Self::Window => "window",
            Self::EnergyPlus => "energyplus",
            Self::Frads => "frads",
            Self::Honeybee => "honeybee",
            Self::Mitsuba => "mitsuba",
        }
    }
}

impl FromStr for Program {
    type Err = Error;

    /// Errors: argument, for any other name.
    fn from_str(name: &str) -> Result<Self> {
        Self::ALL.into_iter().find(|program| program.name() == name).ok_or_else(|| {
            let names = Self::ALL.map(Self::name).join(", ");
            Error::argument(format!("program: expected one of {names}, found {name:?}"))
        })
    }
}
