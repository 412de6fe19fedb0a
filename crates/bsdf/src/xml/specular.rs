//! Peaks of no width in a file: a block that Radiance and WINDOW pass over.
//!
//! The trees and matrices of the file hold each peak in narrow cells, as those programs want it. The block
//! `SpecularComponents`, the last but for what a reader did not know, says the law and the coefficient of each, and what
//! stood in the cells that the peak changed, so that reading gives back the peak and the values without it:
//!
//! - `SpecularComponent`: `Direction`, `Law` (A by rows and g of uo = A ui + g), `WidthDegrees`, `Residual` where it is
//!   known, `Rings`, `Azimuths`, `Coefficients` (Y, or X, Y and Z, of each node, azimuths fastest);
//! - `WithoutPeaks`: `Direction`, `Channel` (Y, u, v of trees; Y, X, Z of matrices), `Values`: a tree whose leaves of 1e38
//!   and more mean no change, or pairs of entry (incident · scattered count + scattered) and value. Without a channel there
//!   is nothing but the peak.

use std::io::Write;

use super::assemble::Blocks;
use super::document::{Node, clip};
use super::limits::Limits;
use super::orientation;
use super::report::{Fault, Report};
use super::scattering::{self, Scattering};
use super::text::{Numbers, TreeText};
use super::write::Writer;
use crate::matrix::KlemsMatrix;
use crate::specular::cells::{Below, InCells};
use crate::specular::{Curve, Law, Specular};
use crate::tree::{Rank, TensorTree, TreeDistribution};
use crate::{Component, Error, Result, Side, Xyz};

/// The element that holds all of it, in a layer.
pub(super) const BLOCK: &str = "SpecularComponents";

const TREE_CHANNELS: [&str; 3] = ["Y", "u", "v"];
const MATRIX_CHANNELS: [&str; 3] = ["Y", "X", "Z"];

impl<W: Write> Writer<'_, W> {
    /// The block, where there are peaks. `constant`: what is added to the values of a component.
    pub(super) fn specular(
        &mut self,
        peaks: &[Specular],
        in_cells: &InCells,
        constant: impl Fn((Side, Side)) -> f64,
    ) -> Result<()> {
        self.line(format_args!("<{BLOCK}>"))?;
        for peak in peaks {
            self.peak(peak)?;
        }
        for (sides, below) in &in_cells.changed {
            match below {
                Below::Nothing => self.without(*sides, None)?,
                Below::Trees(trees) => {
                    for (channel, tree) in TREE_CHANNELS.into_iter().zip(trees) {
                        self.without(*sides, Some(channel))?;
                        let constant = if channel == "Y" { constant(*sides) } else { 0.0 };
                        let digits = self.options.digits;
                        let numbers = Numbers::new(self.stream(), digits);
                        tree.visit(&mut TreeText::new(numbers, constant))?;
                        self.line("</Values>\n</WithoutPeaks>")?;
                    }
                }
                Below::Entries(channels) => {
                    for (channel, entries) in MATRIX_CHANNELS.into_iter().zip(channels) {
                        self.without(*sides, Some(channel))?;
                        let (constant, digits) = (constant(*sides), self.options.digits);
                        for (entry, value) in entries {
                            self.line(format_args!("{entry}"))?;
                            let mut numbers = Numbers::new(self.stream(), digits);
                            numbers.number(f64::from(*value) + constant)?;
                            numbers.raw(b"\n")?;
                        }
                        self.line("</Values>\n</WithoutPeaks>")?;
                    }
                }
            }
        }
        self.line(format_args!("</{BLOCK}>"))
    }

    fn without(&mut self, sides: (Side, Side), channel: Option<&str>) -> Result<()> {
        self.line("<WithoutPeaks>")?;
        self.element("Direction", orientation::direction(sides.0, sides.1))?;
        match channel {
            Some(channel) => {
                self.element("Channel", channel)?;
                self.line("<Values>")
            }
            None => self.line("</WithoutPeaks>"),
        }
    }

    fn peak(&mut self, peak: &Specular) -> Result<()> {
        self.line("<SpecularComponent>")?;
        self.element("Direction", orientation::direction(peak.incident, peak.scattered))?;
        let [[a, b], [c, d]] = peak.law.linear();
        let [x, y]: [f64; 2] = peak.law.offset().into();
        self.element("Law", &format!("{a} {b} {c} {d} {x} {y}"))?;
        self.element("WidthDegrees", &peak.width_degrees.to_string())?;
        if let Some(residual) = peak.residual {
            self.element("Residual", &residual.to_string())?;
        }
        let [rings, azimuths] = peak.coefficient.shape();
        self.element("Rings", &rings.to_string())?;
        self.element("Azimuths", &azimuths.to_string())?;
        self.line("<Coefficients>")?;
        let coloured = peak.coefficient.is_coloured();
        for ring in peak.coefficient.values().chunks(azimuths) {
            let text = |c: &Xyz| match coloured {
                true => format!("{} {} {}", c.x, c.y, c.z),
                false => c.y.to_string(),
            };
            self.line(ring.iter().map(text).collect::<Vec<_>>().join(" "))?;
        }
        self.line("</Coefficients>\n</SpecularComponent>")
    }
}

/// The peaks of a block; the components of `blocks` get what they were without them.
pub(super) fn read(
    block: Node<'_, '_>,
    blocks: &mut Blocks,
    limits: &Limits,
    report: &mut Report,
) -> Vec<Specular> {
    let mut peaks = Vec::new();
    for node in block.children_named("SpecularComponent") {
        match read_peak(node) {
            Ok(peak) => peaks.push(peak),
            Err(text) => report.fault(Fault::format(node.place(), text)),
        }
    }
    for node in block.children_named("WithoutPeaks") {
        if let Err(text) = restore(node, blocks, limits) {
            report.fault(Fault::format(node.place(), text));
        }
    }
    peaks
}

fn text_of(node: Node<'_, '_>, name: &'static str) -> Result<String, String> {
    let child = node.child(name).ok_or_else(|| format!("expected {name}, found none"))?;
    Ok(child.text().trim().to_owned())
}

fn numbers(node: Node<'_, '_>, name: &'static str) -> Result<Vec<f64>, String> {
    let text = text_of(node, name)?;
    let number = |word: &str| {
        word.parse::<f64>().map_err(|_| format!("{name}: expected numbers, found {:?}", clip(word)))
    };
    text.split_ascii_whitespace().map(number).collect()
}

fn one(node: Node<'_, '_>, name: &'static str) -> Result<f64, String> {
    match numbers(node, name)?[..] {
        [number] => Ok(number),
        ref found => Err(format!("{name}: expected 1 number, found {}", found.len())),
    }
}

fn count(node: Node<'_, '_>, name: &'static str) -> Result<usize, String> {
    let text = text_of(node, name)?;
    text.parse().map_err(|_| format!("{name}: expected a count, found {:?}", clip(&text)))
}

fn sides(node: Node<'_, '_>) -> Result<(Side, Side), String> {
    let direction = text_of(node, "Direction")?;
    orientation::sides(&direction).ok_or_else(|| {
        let found = clip(&direction).into_owned();
        format!("Direction: expected Transmission or Reflection, Front or Back, found {found:?}")
    })
}

fn read_peak(node: Node<'_, '_>) -> Result<Specular, String> {
    let (incident, scattered) = sides(node)?;
    let refused = |e: Error| e.to_string();
    let law = match numbers(node, "Law")?[..] {
        [a, b, c, d, x, y] => Law::affine([[a, b], [c, d]], [x, y]).map_err(refused)?,
        ref found => return Err(format!("Law: expected 6 numbers, found {}", found.len())),
    };
    let (rings, azimuths) = (count(node, "Rings")?, count(node, "Azimuths")?);
    let table = numbers(node, "Coefficients")?;
    let nodes = rings.saturating_mul(azimuths);
    let values: Vec<Xyz> = if table.len() == nodes {
        table.iter().map(|y| Xyz::grey(*y)).collect()
    } else if Some(table.len()) == nodes.checked_mul(3) {
        table.as_chunks::<3>().0.iter().map(|[x, y, z]| Xyz::new(*x, *y, *z)).collect()
    } else {
        let found = table.len();
        return Err(format!(
            "Coefficients: expected {rings} × {azimuths} numbers, or three times as many, found {found}"
        ));
    };
    let coefficient = Curve::new(rings, azimuths, values).map_err(refused)?;
    let residual = match node.child("Residual") {
        Some(_) => Some(one(node, "Residual")?).filter(|r| r.is_finite()),
        None => None,
    };
    let width_degrees = one(node, "WidthDegrees")?;
    let peak = Specular { incident, scattered, law, coefficient, width_degrees, residual };
    peak.expect_sound().map_err(refused)?;
    Ok(peak)
}

/// Takes the peaks out of a component again.
fn restore(node: Node<'_, '_>, blocks: &mut Blocks, limits: &Limits) -> Result<(), String> {
    let sides = sides(node)?;
    let at = blocks.components.iter().position(|c| (c.incident, c.scattered) == sides);
    let name = orientation::direction(sides.0, sides.1);
    let at = at.ok_or_else(|| format!("expected data for {name}, found none"))?;
    if node.child("Channel").is_none() {
        blocks.components.remove(at);
        return Ok(());
    }
    let channel = text_of(node, "Channel")?;
    let values = node.child("Values").ok_or_else(|| "expected Values, found none".to_owned())?;
    let values = values.text();
    let refused = |e: Error| e.to_string();
    let distribution = blocks.components[at].distribution();
    let unknown = || format!("Channel: found {:?}, which {name} does not have", clip(&channel));
    let new = if let Some(tree) = distribution.downcast_ref::<TreeDistribution>() {
        let channels = tree_channels(tree);
        let number = TREE_CHANNELS.iter().position(|c| *c == channel);
        let number = number.filter(|n| *n < channels.len()).ok_or_else(unknown)?;
        let rank: Rank = channels[0].rank();
        let Scattering { data, .. } =
            scattering::tree(&values, rank, limits).map_err(|refusal| refusal.text)?;
        let mut channels: Vec<TensorTree> = channels.into_iter().cloned().collect();
        channels[number] = channels[number].restored(&data).map_err(refused)?;
        let mut channels = channels.into_iter();
        let tree = match (channels.next(), channels.next(), channels.next()) {
            (Some(y), Some(u), Some(v)) => {
                TreeDistribution::with_chromaticity(y, u, v).map_err(refused)?
            }
            (Some(y), ..) => TreeDistribution::new(y),
            _ => return Err(unknown()),
        };
        Component::new(sides.0, sides.1, tree)
    } else if let Some(matrix) = distribution.downcast_ref::<KlemsMatrix>() {
        let number = MATRIX_CHANNELS.iter().position(|c| *c == channel).ok_or_else(unknown)?;
        if number > 0 && matrix.chromatic().is_none() {
            return Err(unknown());
        }
        let Scattering { data, .. } =
            scattering::numbers(&values, limits).map_err(|refusal| refusal.text)?;
        let pairs = data.as_chunks::<2>();
        if !pairs.1.is_empty() {
            return Err(format!("Values: expected pairs, found {} numbers", data.len()));
        }
        let entries = pairs.0.iter().map(|[entry, value]| (*entry as usize, f64::from(*value)));
        let entries: Vec<(usize, f64)> = entries.collect();
        let mut channels: [&[(usize, f64)]; 3] = [&[]; 3];
        channels[number] = &entries;
        Component::new(sides.0, sides.1, matrix.changed(channels, false).map_err(refused)?)
    } else {
        return Err(unknown());
    };
    blocks.components[at] = new;
    Ok(())
}

fn tree_channels(tree: &TreeDistribution) -> Vec<&TensorTree> {
    let colour = tree.chromaticity().into_iter().flatten();
    std::iter::once(tree.luminance()).chain(colour).collect()
}
