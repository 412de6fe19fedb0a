//! Blocks that were read → components of the visible band and of further ones.
//!
//! A block that is 0 throughout says nothing where others say something: programs that must name
//! every direction write it for those that they do not know. It counts as absent.

use super::blocks::{Block, Channel, Data};
use super::document::Node;
use super::orientation;
use super::report::{Fault, Report};
use crate::matrix::{KlemsBasis, KlemsMatrix};
use crate::tree::TreeDistribution;
use crate::{Band, Component, Side};

/// Above this a component is reported to gain energy; the tolerance of Radiance's renderer.
const MOST_ENERGY: f64 = 1.01;

/// What all blocks of a layer make.
#[derive(Default)]
pub(super) struct Blocks {
    /// Of the visible band.
    pub(super) components: Vec<Component>,
    /// The further ones.
    pub(super) bands: Vec<Band>,
}

/// The components of all bands; a further band that has none is left out.
pub(super) fn assemble(
    mut data: Vec<(Block<'_, '_>, Data)>,
    mut bands: Vec<Band>,
    layer: Node<'_, '_>,
    report: &mut Report,
) -> Blocks {
    let visible = channels(&mut data, [Channel::Y, Channel::X, Channel::Z, Channel::U, Channel::V]);
    let dark = visible.iter().all(Channels::is_zero);
    let components = components("", visible, layer, report);
    for (n, band) in bands.iter_mut().enumerate() {
        let one = channels(&mut data, [Channel::Band(n)]);
        if !dark && !one.is_empty() && one.iter().all(Channels::is_zero) {
            let text = format!("{}: all values are 0: a dummy band, ignored", band.name);
            report.warn("dummy-band", layer.place(), text);
            continue;
        }
        let label = format!("{} ", band.name);
        band.components = self::components(&label, one, layer, report);
    }
    bands.retain(|b| !b.components.is_empty());
    Blocks { components, bands }
}

/// The channels of one pair of sides, the first one that of the value.
struct Channels {
    sides: (Side, Side),
    y: Option<Data>,
    colour: [Option<Data>; 4],
}

/// Takes the blocks of these channels out of `data`, in the order of the files' directions.
fn channels<const N: usize>(
    data: &mut Vec<(Block<'_, '_>, Data)>,
    wanted: [Channel; N],
) -> Vec<Channels> {
    let mut found = Vec::new();
    for sides in orientation::ALL {
        let mut take = |channel: Option<&Channel>| {
            let is =
                |(b, _): &(Block<'_, '_>, Data)| Some(&b.channel) == channel && b.sides == sides;
            data.iter().position(is).map(|at| data.remove(at).1)
        };
        let y = take(wanted.first());
        let colour = [1, 2, 3, 4].map(|n| take(wanted.get(n)));
        if y.is_some() || colour.iter().any(Option::is_some) {
            found.push(Channels { sides, y, colour });
        }
    }
    found
}

impl Data {
    fn is_zero(&self) -> bool {
        match self {
            Self::Matrix { values, .. } => values.iter().all(|&v| v == 0.0),
            Self::Tree(tree) => {
                let slots = tree.slots().iter().copied().chain([tree.root_slot()]);
                // A slot with its highest bit numbers a branch.
                let mut leaves = slots.filter(|slot| slot >> 31 == 0);
                leaves.all(|slot| slot == 0)
            }
        }
    }
}

impl Channels {
    /// Whether no light is scattered, whatever its chromaticity would be.
    fn is_zero(&self) -> bool {
        let [x, z, ..] = &self.colour;
        let dark = |data: &Option<Data>| data.as_ref().is_none_or(Data::is_zero);
        self.y.is_some() && [&self.y, x, z].into_iter().all(dark)
    }

    /// Drops colour that cannot be that of any light: X or v′ 0 throughout where Y is not.
    fn drop_dummy_colour(&mut self) -> Option<&'static str> {
        let [x, _, _, v] = &self.colour;
        let dummy = |data: &Option<Data>| data.as_ref().is_some_and(Data::is_zero);
        if !(dummy(x) || dummy(v)) || dummy(&self.y) {
            return None;
        }
        self.colour = [None, None, None, None];
        Some("its colour is 0 throughout, a dummy: read as grey")
    }
}

/// Channels of equal sides become one component.
fn components(
    label: &str,
    channels: Vec<Channels>,
    layer: Node<'_, '_>,
    report: &mut Report,
) -> Vec<Component> {
    let real: Vec<(Side, Side)> =
        channels.iter().filter(|c| !c.is_zero()).map(|c| c.sides).collect();
    let mut components = Vec::new();
    for mut channel in channels {
        let (incident, scattered) = channel.sides;
        let direction = format!("{label}{}", orientation::direction(incident, scattered));
        if !real.is_empty() && channel.is_zero() {
            let opposite = (scattered, incident);
            let (code, answer) = if incident != scattered && real.contains(&opposite) {
                let other = orientation::direction(scattered, incident);
                ("dummy-transmission", format!("{other} reversed answers"))
            } else {
                ("dummy-block", "nothing is scattered that way".to_owned())
            };
            let text = format!("{direction}: all values are 0: a dummy block, ignored; {answer}");
            report.warn(code, layer.place(), text);
            continue;
        }
        if let Some(text) = channel.drop_dummy_colour() {
            report.warn("dummy-colour", layer.place(), format!("{direction}: {text}"));
        }
        let Some(y) = channel.y else {
            let text = format!("{direction} has colour but no Wavelength Visible");
            report.fault(Fault::format(layer.place(), text));
            continue;
        };
        match combine(channel.sides, y, channel.colour) {
            Ok((component, warning)) => {
                if let Some(text) = warning {
                    report.warn("half-colour", layer.place(), format!("{direction}: {text}"));
                }
                if report.wants_warnings() {
                    warn_of_energy(&component, &direction, layer, report);
                }
                components.push(component);
            }
            Err(e) => report.fault(Fault::format(layer.place(), format!("{direction}: {e}"))),
        }
    }
    components
}

fn warn_of_energy(
    component: &Component,
    direction: &str,
    layer: Node<'_, '_>,
    report: &mut Report,
) {
    let most = component.distribution().max_total(0.0);
    if most == 0.0 {
        report.warn("dark", layer.place(), format!("{direction}: no light is scattered"));
    }
    if most > MOST_ENERGY {
        let percent = 100.0 * most;
        let text = format!("{direction}: up to {percent:.1} % of the light is scattered");
        report.warn("energy", layer.place(), text);
    }
}

/// The component of one channel or three, and what was left out.
fn combine(
    (incident, scattered): (Side, Side),
    y: Data,
    [x, z, u, v]: [Option<Data>; 4],
) -> crate::Result<(Component, Option<&'static str>)> {
    match y {
        Data::Tree(y) => {
            let (tree, warning) = match (u, v) {
                (Some(Data::Tree(u)), Some(Data::Tree(v))) => {
                    (TreeDistribution::with_chromaticity(y, u, v)?, None)
                }
                (None, None) => (TreeDistribution::new(y), None),
                _ => (
                    TreeDistribution::new(y),
                    Some("one of CIE-u and CIE-v is missing: read as grey"),
                ),
            };
            Ok((Component::new(incident, scattered, tree), warning))
        }
        Data::Matrix { incident: wi, scattered: wo, values } => {
            let grey = KlemsMatrix::new(wi.clone(), wo.clone(), values)?;
            let same = |i: &KlemsBasis, s: &KlemsBasis| *i == wi && *s == wo;
            let (matrix, warning) = match (x, z) {
                (
                    Some(Data::Matrix { incident: xi, scattered: xs, values: x }),
                    Some(Data::Matrix { incident: zi, scattered: zs, values: z }),
                ) if same(&xi, &xs) && same(&zi, &zs) => (grey.with_colour(x, z)?, None),
                (None, None) => (grey, None),
                (Some(_), Some(_)) => {
                    (grey, Some("CIE-X and CIE-Z have other bases than Visible: read as grey"))
                }
                _ => (grey, Some("one of CIE-X and CIE-Z is missing: read as grey")),
            };
            Ok((Component::new(incident, scattered, matrix), warning))
        }
    }
}
