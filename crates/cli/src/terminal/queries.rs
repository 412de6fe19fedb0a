//! Queries on standard input: rows of directions, as angles or as vectors, and of numbers.

use std::io;

use bsdfkit::{DVec3, Error, Result};
use bsdfkit_sphere::direction;
use clap::Args;

use crate::terminal::angles::Angles;
use crate::terminal::rows::Rows;

/// How directions are written in rows.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct Notation {
    /// Directions in rows are vectors `x y z` of any length, not angles `theta phi` in degrees; all numbers
    /// are printed with 17 digits
    #[arg(long)]
    vectors: bool,
}

impl Notation {
    fn width(self) -> usize {
        if self.vectors { 3 } else { 2 }
    }

    /// Errors: argument: no direction.
    fn direction(self, numbers: &[f64]) -> Result<DVec3> {
        match *numbers {
            [x, y, z] => match DVec3::new(x, y, z) {
                // To normalise it again would change its last bit.
                w if (w.length_squared() - 1.0).abs() < 1e-12 => Ok(w),
                w => w.try_normalize().ok_or_else(|| {
                    let text = format!("vector: expected a length above 0, found {x} {y} {z}");
                    Error::argument(text)
                }),
            },
            [theta, phi] => Angles::new(theta, phi).map(Angles::direction),
            _ => Err(Error::argument("expected a direction")),
        }
    }

    /// A number as rows have it: nine digits keep every bit of what is stored, 17 of what is computed.
    pub(crate) fn number(self, x: f64) -> String {
        if self.vectors { format!("{x:.16e}") } else { format!("{x:.8e}") }
    }

    /// A direction as rows have it.
    pub(crate) fn text(self, w: DVec3) -> String {
        if self.vectors {
            return w.to_array().map(|x| self.number(x)).join(" ");
        }
        let (theta, phi) = direction::to_degrees(w);
        format!("{theta:.6} {phi:.6}")
    }
}

/// Most numbers in a row.
const MOST: usize = 8;

/// Rows of `D` directions, then of `N` numbers.
pub(crate) struct Queries<const D: usize, const N: usize = 0> {
    rows: Rows<MOST>,
    notation: Notation,
}

impl<const D: usize, const N: usize> Queries<D, N> {
    /// Rows of standard input.
    pub(crate) fn new(notation: Notation) -> Self {
        Self { rows: Rows::new(io::stdin(), D * notation.width() + N), notation }
    }

    /// The next rows; empty only at the end. Unit vectors stay as they are.
    ///
    /// Errors: as [`Rows::block`]; format with the line where a row has no direction.
    pub(crate) fn block(&mut self) -> Result<Vec<([DVec3; D], [f64; N])>> {
        let width = self.notation.width();
        let rows = self.rows.block()?;
        let one = |(line, row): (usize, [f64; MOST])| {
            let mut directions = [DVec3::ZERO; D];
            for (direction, numbers) in directions.iter_mut().zip(row.chunks_exact(width)) {
                *direction = self.notation.direction(numbers).map_err(|e| {
                    let row = format!("standard input: line {line}");
                    Error::format(e.to_string()).context(row)
                })?;
            }
            let mut numbers = [0.0; N];
            numbers.copy_from_slice(&row[D * width..][..N]);
            Ok((directions, numbers))
        };
        rows.into_iter().map(one).collect()
    }
}
