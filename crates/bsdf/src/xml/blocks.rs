//! `WavelengthData`: data blocks found, read in parallel, and put together as components.

use rayon::prelude::*;

use super::angle_bases::AngleBases;
use super::document::{Node, clip};
use super::limits::Limits;
use super::material::{LAYER, keep, short_text};
use super::orientation;
use super::report::{Fault, Report};
use super::scattering::{self, Refusal, Scattering};
use crate::matrix::{KlemsBasis, KlemsMatrix};
use crate::tree::{Rank, TensorTree, TreeDistribution};
use crate::{Component, ErrorClass, Metadata, Side};

/// How a file numbers directions (`IncidentDataStructure`); one for all its blocks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Structure {
    /// Text rows are scattered directions.
    Columns,
    /// Text rows are incident directions.
    Rows,
    Tree(Rank),
}

impl Structure {
    pub(crate) fn parse(text: &str) -> Option<Self> {
        match text.to_ascii_lowercase().as_str() {
            "columns" => Some(Self::Columns),
            "rows" => Some(Self::Rows),
            "tensortree3" => Some(Self::Tree(Rank::Three)),
            "tensortree4" => Some(Self::Tree(Rank::Four)),
            _ => None,
        }
    }
}

/// The channels that make a component.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Channel {
    Y,
    X,
    Z,
    U,
    V,
}

impl Channel {
    fn parse(wavelength: &str, structure: Structure) -> Option<Self> {
        let tree = matches!(structure, Structure::Tree(_));
        match wavelength.to_ascii_lowercase().as_str() {
            "visible" | "cie-y" => Some(Self::Y),
            "cie-x" if !tree => Some(Self::X),
            "cie-z" if !tree => Some(Self::Z),
            "cie-u" if tree => Some(Self::U),
            "cie-v" if tree => Some(Self::V),
            _ => None,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Y => "Visible",
            Self::X => "CIE-X",
            Self::Z => "CIE-Z",
            Self::U => "CIE-u",
            Self::V => "CIE-v",
        }
    }
}

/// A data block of a known channel and direction.
struct Block<'d, 'a> {
    node: Node<'d, 'a>,
    channel: Channel,
    sides: (Side, Side),
}

/// The data of one block.
enum Data {
    Matrix { incident: KlemsBasis, scattered: KlemsBasis, values: Vec<f32> },
    Tree(TensorTree),
}

/// Reads all blocks of a layer.
pub(crate) fn read_components<'d, 'a>(
    layer: Node<'d, 'a>,
    structure: Structure,
    bases: &AngleBases<'d, 'a>,
    limits: &Limits,
    metadata: &mut Metadata,
    report: &mut Report,
) -> Vec<Component> {
    let mut blocks: Vec<Block<'d, 'a>> = Vec::new();
    let mut other_channels: Vec<String> = Vec::new();
    for wavelength_data in layer.children_named("WavelengthData") {
        let found = find_blocks(wavelength_data, structure, limits, metadata, report);
        other_channels.extend(found.other_channel);
        for block in found.blocks {
            let twin = |b: &Block<'_, '_>| b.channel == block.channel && b.sides == block.sides;
            if let Some(at) = blocks.iter().position(twin) {
                let text = format!(
                    "a second {} block of {}; the first one is ignored",
                    block.channel.name(),
                    orientation::direction(block.sides.0, block.sides.1)
                );
                report.warn(block.node.place(), text);
                blocks.remove(at);
            }
            blocks.push(block);
        }
    }
    if blocks.is_empty() && !report.has_faults() {
        let text = match other_channels.as_slice() {
            [] => "expected WavelengthData with a data block, found none".to_owned(),
            names => format!("expected Wavelength Visible, found only {}", clip(&names.join(", "))),
        };
        report.fault(Fault::format(layer.place(), text));
    }

    let read_one = |block: &Block<'_, '_>| read_block(block, structure, bases, limits);
    // Handing a lone block to other threads would take longer than reading a matrix.
    let read: Vec<_> = match blocks.as_slice() {
        [block] => vec![read_one(block)],
        _ => blocks.par_iter().map(read_one).collect(),
    };
    let mut data: Vec<(Block<'d, 'a>, Data)> = Vec::new();
    for (block, read) in blocks.into_iter().zip(read) {
        match read {
            Ok(read) => {
                for text in read.warnings {
                    report.warn(block.node.place(), text);
                }
                data.push((block, read.data));
            }
            Err(fault) => report.fault(fault),
        }
    }
    if report.has_faults() {
        return Vec::new();
    }
    assemble(data, layer, report)
}

struct Found<'d, 'a> {
    blocks: Vec<Block<'d, 'a>>,
    /// The wavelength, when it is none that makes a component.
    other_channel: Option<String>,
}

/// The blocks of one `WavelengthData`; what is not read is kept in `metadata`.
fn find_blocks<'d, 'a>(
    data: Node<'d, 'a>,
    structure: Structure,
    limits: &Limits,
    metadata: &mut Metadata,
    report: &mut Report,
) -> Found<'d, 'a> {
    let mut found = Found { blocks: Vec::new(), other_channel: None };
    let Some(wavelength) = data.child("Wavelength") else {
        report.fault(Fault::format(data.place(), "expected Wavelength, found none"));
        return found;
    };
    let wavelength = short_text(wavelength, limits, report);
    let Some(channel) = Channel::parse(&wavelength, structure) else {
        keep(metadata, LAYER, data.verbatim());
        found.other_channel = Some(wavelength);
        return found;
    };
    for node in data.children_named("WavelengthDataBlock") {
        let Some(direction) = node.child("WavelengthDataDirection") else {
            let text = "expected WavelengthDataDirection, found none";
            report.fault(Fault::format(node.place(), text));
            continue;
        };
        let text = short_text(direction, limits, report);
        if let Some(sides) = orientation::sides(&text) {
            found.blocks.push(Block { node, channel, sides });
        } else if text.to_ascii_lowercase().starts_with("absorbed") {
            let others = data.children().filter(|c| c.name() != "WavelengthDataBlock");
            let header: Vec<&str> = others.map(Node::verbatim).collect();
            let (header, block) = (header.join("\n"), node.verbatim());
            let kept = format!("<WavelengthData>\n{header}\n{block}\n</WavelengthData>");
            keep(metadata, LAYER, &kept);
        } else {
            let text = format!(
                "expected Transmission or Reflection, Front or Back, found {:?}",
                clip(&text)
            );
            report.fault(Fault::format(direction.place(), text));
        }
    }
    found
}

struct Read {
    data: Data,
    warnings: Vec<String>,
}

fn read_block(
    block: &Block<'_, '_>,
    structure: Structure,
    bases: &AngleBases<'_, '_>,
    limits: &Limits,
) -> Result<Read, Fault> {
    let node = block.node;
    if let Some(kind) = node.child("ScatteringDataType") {
        let text = kind.text();
        let text = text.trim();
        if !["", "BTDF", "BRDF", "BSDF"].iter().any(|known| known.eq_ignore_ascii_case(text)) {
            let text = format!("expected data in 1/sr (BTDF), found {:?}", clip(text));
            return Err(Fault::format(kind.place(), text));
        }
    }
    let Some(scattering) = node.child("ScatteringData") else {
        return Err(Fault::format(node.place(), "expected ScatteringData, found none"));
    };
    let text = scattering.text();
    let refuse = |refusal: Refusal| {
        let place = match (refusal.at, &text) {
            (Some(at), std::borrow::Cow::Borrowed(_)) => scattering.place_in_text(at),
            _ => scattering.place(),
        };
        match refusal.class {
            ErrorClass::Limit => Fault::limit(place, refusal.text),
            _ => Fault::format(place, refusal.text),
        }
    };
    let mut warnings = Vec::new();
    let (data, negative) = match structure {
        Structure::Tree(rank) => {
            let basis = node.child("AngleBasis").map(|n| n.text().trim().to_owned());
            if let Some(name) = basis.filter(|n| !n.eq_ignore_ascii_case("LBNL/Shirley-Chiu")) {
                let text =
                    format!("expected angle basis LBNL/Shirley-Chiu, found {:?}", clip(&name));
                return Err(Fault::format(node.place(), text));
            }
            let Scattering { data, negative } =
                scattering::tree(&text, rank, limits).map_err(refuse)?;
            (Data::Tree(data), negative)
        }
        Structure::Columns | Structure::Rows => {
            let mut incident = find_basis(node, "ColumnAngleBasis", bases)?;
            let mut scattered = find_basis(node, "RowAngleBasis", bases)?;
            let Scattering { data: values, negative } =
                scattering::numbers(&text, limits).map_err(refuse)?;
            if values.len() == 73 * 73
                && [&incident, &scattered]
                    .iter()
                    .all(|b| **b == KlemsBasis::half() && !bases.is_own(b))
            {
                incident = KlemsBasis::half_73();
                scattered = KlemsBasis::half_73();
                warnings.push("73 × 73 values: the Klems Half of Radiance before 2022".to_owned());
            }
            let (rows, columns) = (incident.directions(), scattered.directions());
            let expected = rows.saturating_mul(columns);
            if values.len() != expected {
                let text = format!("expected {expected} values, found {}", values.len());
                return Err(Fault::format(scattering.place(), text));
            }
            let values = match structure {
                Structure::Columns => scattering::transposed(values, columns, rows),
                _ => values,
            };
            (Data::Matrix { incident, scattered, values }, negative)
        }
    };
    if negative > 0 {
        warnings.push(format!("{negative} negative values read as 0"));
    }
    Ok(Read { data, warnings })
}

fn find_basis(
    block: Node<'_, '_>,
    element: &str,
    bases: &AngleBases<'_, '_>,
) -> Result<KlemsBasis, Fault> {
    let Some(node) = block.child(element) else {
        return Err(Fault::format(block.place(), format!("expected {element}, found none")));
    };
    let name = node.text();
    bases.find(name.trim()).ok_or_else(|| {
        let text = format!("angle basis {:?} is not defined", clip(name.trim()));
        Fault::format(node.place(), text)
    })
}

/// Channels of equal sides become one component.
fn assemble(
    mut data: Vec<(Block<'_, '_>, Data)>,
    layer: Node<'_, '_>,
    report: &mut Report,
) -> Vec<Component> {
    let mut components = Vec::new();
    for (incident, scattered) in orientation::ALL {
        let direction = orientation::direction(incident, scattered);
        let mut take = |channel| {
            let wanted = |(b, _): &(Block<'_, '_>, Data)| {
                b.channel == channel && b.sides == (incident, scattered)
            };
            data.iter().position(wanted).map(|at| data.remove(at).1)
        };
        let y = take(Channel::Y);
        let colour = [Channel::X, Channel::Z, Channel::U, Channel::V].map(&mut take);
        let Some(y) = y else {
            if colour.iter().any(Option::is_some) {
                let text = format!("{direction} has colour but no Wavelength Visible");
                report.fault(Fault::format(layer.place(), text));
            }
            continue;
        };
        match combine((incident, scattered), y, colour) {
            Ok((component, warning)) => {
                if let Some(text) = warning {
                    report.warn(layer.place(), format!("{direction}: {text}"));
                }
                if report.wants_warnings() {
                    let most = component.distribution().max_total(0.0);
                    if most == 0.0 {
                        report.warn(layer.place(), format!("{direction}: no light is scattered"));
                    }
                    if most > MOST_ENERGY {
                        let percent = 100.0 * most;
                        let text =
                            format!("{direction}: up to {percent:.1} % of the light is scattered");
                        report.warn(layer.place(), text);
                    }
                }
                components.push(component);
            }
            Err(e) => report.fault(Fault::format(layer.place(), format!("{direction}: {e}"))),
        }
    }
    components
}

/// Above this a component is reported to gain energy; the tolerance of Radiance's renderer.
const MOST_ENERGY: f64 = 1.01;

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
