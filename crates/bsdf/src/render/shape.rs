//! The form of a layer's tables.

use serde::{Deserialize, Serialize};

use super::drawing::BLOCK;
use super::frame::Frame;
use super::polar::{distance, scale};
use crate::{Error, Result};

/// The form of a layer's tables.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Shape {
    /// Where its peak goes.
    pub frame: Frame,
    /// Cells of values about the peak; 0 of a layer that is drawn from alone.
    pub angles: usize,
    /// Cells of values from the peak outward.
    pub radii: usize,
    /// Distance from the peak from which on cells widen in proportion to it.
    pub core: f64,
    /// Distance from the peak of the last values; beyond, they are those there.
    pub far: f64,
    /// Cells of colour about the peak; 0 for grey ones.
    pub colour_angles: usize,
    /// Cells of colour from the peak outward.
    pub colour_radii: usize,
    /// Cells of densities about the peak.
    pub drawn_angles: usize,
    /// Cells of densities from the peak to the horizon, a multiple of 4.
    pub drawn_radii: usize,
    /// 1/sr of values that count 1.
    pub value_unit: f64,
    /// Of densities that count 1.
    pub drawn_unit: f64,
}

impl Shape {
    /// Most cells along any coordinate.
    pub const MOST: usize = 1024;

    /// Errors: argument.
    pub fn check(&self) -> Result<()> {
        let sides = [
            ("angles", self.angles, 0),
            ("radii", self.radii, usize::from(self.angles > 0)),
            ("colour_angles", self.colour_angles, 0),
            ("colour_radii", self.colour_radii, usize::from(self.colour_angles > 0)),
            ("drawn_angles", self.drawn_angles, 1),
            ("drawn_radii", self.drawn_radii, BLOCK),
        ];
        for (name, found, least) in sides {
            if !(least..=Self::MOST).contains(&found) {
                let most = Self::MOST;
                return Err(Error::argument(format!(
                    "{name}: expected {least} to {most}, found {found}"
                )));
            }
        }
        if !self.drawn_radii.is_multiple_of(BLOCK) {
            let found = self.drawn_radii;
            return Err(Error::argument(format!(
                "drawn_radii: expected a multiple of {BLOCK}, found {found}"
            )));
        }
        let numbers = [
            ("core", self.core),
            ("far", self.far),
            ("value_unit", self.value_unit),
            ("drawn_unit", self.drawn_unit),
        ];
        if !(-2.0..=2.0).contains(&self.frame.factor) {
            let found = self.frame.factor;
            return Err(Error::argument(format!("factor: expected -2 to 2, found {found}")));
        }
        for (name, found) in numbers {
            if !(1e-12..=1e12).contains(&found) {
                return Err(Error::argument(format!(
                    "{name}: expected 1e-12 to 1e12, found {found}"
                )));
            }
        }
        Ok(())
    }

    /// Elements of each array: values, colour, density, sums, running sums.
    pub(crate) fn lengths(&self, nodes: usize) -> [Vec<usize>; 5] {
        let none = || vec![0];
        let drawn = self.drawn_angles + 1;
        [
            match self.angles {
                0 => none(),
                angles => vec![nodes, angles + 1, self.radii + 1],
            },
            match self.colour_angles {
                0 => none(),
                angles => vec![nodes, angles + 1, self.colour_radii + 1, 2],
            },
            vec![nodes, drawn, self.drawn_radii + 1],
            vec![nodes, drawn, self.drawn_radii / BLOCK + 1],
            vec![nodes, drawn],
        ]
    }

    /// The distance from the peak at a radial coordinate of values, 0 to 1.
    pub fn distance(&self, t: f64) -> f64 {
        distance(t * scale(self.far / self.core), self.core)
    }
}
