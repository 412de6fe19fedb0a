//! `WavelengthData`: data blocks found and read in parallel.

use rayon::prelude::*;

use super::angle_bases::AngleBases;
use super::document::{Node, clip};
use super::kept::{BLOCKS, keep, keep_block};
use super::limits::Limits;
use super::material::short_text;
use super::orientation;
use super::report::{Fault, Report};
use super::scattering::{self, Refusal, Scattering};
use crate::matrix::KlemsBasis;
use crate::tree::{Rank, TensorTree};
use crate::{Band, ErrorClass, Metadata, Side};

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

/// The channels that make a component: of the visible band five, of a further band one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Channel {
    Y,
    X,
    Z,
    U,
    V,
    /// That of the further band with this number.
    Band(usize),
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

    fn name(self, bands: &[Band]) -> &str {
        match self {
            Self::Y => "Visible",
            Self::X => "CIE-X",
            Self::Z => "CIE-Z",
            Self::U => "CIE-u",
            Self::V => "CIE-v",
            Self::Band(n) => &bands[n].name,
        }
    }
}

/// A data block of a known channel and direction.
pub(super) struct Block<'d, 'a> {
    /// The `WavelengthData` that it stands in.
    data: Node<'d, 'a>,
    node: Node<'d, 'a>,
    pub(super) channel: Channel,
    pub(super) sides: (Side, Side),
}

/// The data of one block.
pub(super) enum Data {
    Matrix { incident: KlemsBasis, scattered: KlemsBasis, values: Vec<f32> },
    Tree(TensorTree),
}

/// Reads all blocks of a layer; with them the further bands, without components yet. A fault of a further band is a warning, and the block is kept as it
/// was written: the visible band does not need it.
pub(super) fn read_blocks<'d, 'a>(
    layer: Node<'d, 'a>,
    structure: Structure,
    bases: &AngleBases<'d, 'a>,
    limits: &Limits,
    metadata: &mut Metadata,
    report: &mut Report,
) -> (Vec<(Block<'d, 'a>, Data)>, Vec<Band>) {
    let mut blocks: Vec<Block<'d, 'a>> = Vec::new();
    let mut found = Found { bands: Vec::new(), other_wavelengths: Vec::new() };
    for wavelength_data in layer.children_named("WavelengthData") {
        let here = found.blocks(wavelength_data, structure, limits, metadata, report);
        for block in here {
            let twin = |b: &Block<'_, '_>| b.channel == block.channel && b.sides == block.sides;
            if let Some(at) = blocks.iter().position(twin) {
                let text = format!(
                    "a second {} block of {}; the first one is ignored",
                    block.channel.name(&found.bands),
                    orientation::direction(block.sides.0, block.sides.1)
                );
                report.warn("duplicate-block", block.node.place(), text);
                blocks.remove(at);
            }
            blocks.push(block);
        }
    }
    let visible = |b: &Block<'_, '_>| !matches!(b.channel, Channel::Band(_));
    if !blocks.iter().any(visible) && !report.has_faults() {
        let text = match found.other_wavelengths.as_slice() {
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
                for (code, text) in read.warnings {
                    report.warn(code, block.node.place(), text);
                }
                data.push((block, read.data));
            }
            Err(fault) if visible(&block) => report.fault(fault),
            Err(fault) => {
                let name = block.channel.name(&found.bands);
                let text = format!("{name}: not read: {}", fault.text);
                report.warn("band-not-read", fault.place, text);
                keep_block(metadata, block.data, block.node);
            }
        }
    }
    (data, found.bands)
}

/// What the blocks seen so far belong to.
struct Found {
    /// Further bands, without components yet.
    bands: Vec<Band>,
    /// The wavelengths that are not the visible band's.
    other_wavelengths: Vec<String>,
}

impl Found {
    /// The blocks of one `WavelengthData`; what is not read is kept in `metadata`.
    fn blocks<'d, 'a>(
        &mut self,
        data: Node<'d, 'a>,
        structure: Structure,
        limits: &Limits,
        metadata: &mut Metadata,
        report: &mut Report,
    ) -> Vec<Block<'d, 'a>> {
        let mut blocks = Vec::new();
        let Some(wavelength) = data.child("Wavelength") else {
            report.fault(Fault::format(data.place(), "expected Wavelength, found none"));
            return blocks;
        };
        let unit = wavelength.attribute("unit").unwrap_or_else(|| "Integral".to_owned());
        let wavelength = short_text(wavelength, limits, report);
        let visible = Channel::parse(&wavelength, structure);
        let channel = visible.or_else(|| self.band(data, &wavelength, unit, limits, report));
        let Some(channel) = channel else {
            keep(metadata, BLOCKS, data.verbatim());
            self.other_wavelengths.push(wavelength);
            return blocks;
        };
        if visible.is_none() {
            self.other_wavelengths.push(wavelength);
        }
        for node in data.children_named("WavelengthDataBlock") {
            let Some(direction) = node.child("WavelengthDataDirection") else {
                let text = "expected WavelengthDataDirection, found none";
                report.fault(Fault::format(node.place(), text));
                continue;
            };
            let text = short_text(direction, limits, report);
            if let Some(sides) = orientation::sides(&text) {
                blocks.push(Block { data, node, channel, sides });
            } else if is_absorbed(&text) {
                keep_block(metadata, data, node);
            } else {
                let text = format!(
                    "expected Transmission or Reflection, Front or Back, found {:?}",
                    clip(&text)
                );
                report.fault(Fault::format(direction.place(), text));
            }
        }
        blocks
    }

    /// The channel of a further band, of whose blocks at least one and each has a direction that is
    /// known; colour in a form of which the structure knows nothing is none.
    fn band(
        &mut self,
        data: Node<'_, '_>,
        name: &str,
        unit: String,
        limits: &Limits,
        report: &mut Report,
    ) -> Option<Channel> {
        let text = |name| {
            let text = data.child(name).map(Node::text).unwrap_or_default();
            let text = text.trim();
            (text.len() <= limits.text_bytes).then(|| text.to_owned())
        };
        let is_known = |block: Node<'_, '_>| {
            let direction = block.child("WavelengthDataDirection").map(Node::text);
            let direction = direction.as_deref().map_or("", str::trim);
            orientation::sides(direction).is_some() || is_absorbed(direction)
        };
        let mut blocks = data.children_named("WavelengthDataBlock").peekable();
        blocks.peek()?;
        let colour = name.get(..4).is_some_and(|start| start.eq_ignore_ascii_case("cie-"));
        if name.is_empty() || colour || !blocks.all(is_known) {
            return None;
        }
        let same = |b: &Band| b.is(name) && b.unit.eq_ignore_ascii_case(&unit);
        let number = match self.bands.iter().position(same) {
            Some(number) => number,
            None if self.bands.len() == limits.bands => {
                let text = format!("more than {} spectral bands", limits.bands);
                report.fault(Fault::limit(data.place(), text));
                return None;
            }
            None => {
                let (source, detector) = (text("SourceSpectrum")?, text("DetectorSpectrum")?);
                let (name, components) = (name.to_owned(), Vec::new());
                self.bands.push(Band { name, unit, source, detector, components });
                self.bands.len() - 1
            }
        };
        Some(Channel::Band(number))
    }
}

/// Whether a direction is that of absorbed light: a value an incident direction.
fn is_absorbed(direction: &str) -> bool {
    direction
        .get(..6)
        .is_some_and(|start| ["absorb", "absorp"].iter().any(|a| start.eq_ignore_ascii_case(a)))
}

struct Read {
    data: Data,
    warnings: Vec<(&'static str, String)>,
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
                let text = "73 × 73 values: the Klems Half of Radiance before 2022".to_owned();
                warnings.push(("half-73", text));
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
        warnings.push(("negative", format!("{negative} negative values read as 0")));
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
