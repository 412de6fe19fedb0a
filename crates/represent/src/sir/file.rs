//! The SIR file: a text header, then nodes, then migrations. Layout: the reference's `.sir` of pabopto2bsdf.

use std::path::Path;

use bsdfkit::limits::read_file;
use bsdfkit::{Error, Result};
use bsdfkit_sphere::{DVec3, Side};

use super::bytes::Bytes;
use super::grid::Grid;
use super::mesh::Mesh;
use super::node::{SirLobe, SirNode};
use super::plan::{Migration, Plan};
use super::slice;
use super::whole::{GrazingLobe, Sir};

/// What a SIR file may cost before it is refused.
#[derive(Clone, Copy, Debug)]
pub struct SirLimits {
    /// Largest file in bytes. Reading takes at most ten times as much memory.
    pub bytes: u64,
}

impl Default for SirLimits {
    /// 256 MiB: an order of magnitude above 60 incidences of 5000 lobes.
    fn default() -> Self {
        Self { bytes: 256 << 20 }
    }
}

/// Whether transport plans are taken as they stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Plans {
    /// As in the file: answers what Radiance answers.
    AsStored,
    /// The entry that Radiance's solver loses in nearly every plan is put back where row and column lack the same mass.
    Repaired,
}

impl Sir {
    /// Reads a file with [`SirLimits::default`], plans repaired.
    ///
    /// Errors: io; format with byte offset, expected, found; limit when the file is too large.
    pub fn read(path: &Path) -> Result<Sir> {
        let limits = SirLimits::default();
        let bytes = read_file(path, limits.bytes)?;
        Sir::from_bytes(&bytes, Plans::Repaired, limits).map_err(|e| e.context(path.display()))
    }

    /// Reads a file's content.
    ///
    /// Errors: format with byte offset, expected, found; limit when `bytes` is too large.
    pub fn from_bytes(bytes: &[u8], plans: Plans, limits: SirLimits) -> Result<Sir> {
        parse(bytes, plans, limits)
    }
}

/// Bytes of a header line that the reference reads at most.
const LONGEST_LINE: usize = 2047;
/// Bytes of a lobe in the file: peak 5, colour 2, radius 2, cell 4.
const LOBE_BYTES: usize = 13;
/// The code of equal energy; anything else is a colour.
const NEUTRAL: u16 = 49750;
/// Bounds of plausible totals and peaks; they keep every product of four of them finite.
const PLAUSIBLE: std::ops::RangeInclusive<f64> = 1e-9..=1e9;

struct Header {
    name: String,
    symmetry: i32,
    incident: Side,
    scattered: Side,
    channels: usize,
    resolution: u16,
    floor: f64,
    grazing: Option<GrazingLobe>,
}

/// Reads a whole file. Everything allocated is proportional to bytes already seen.
fn parse(content: &[u8], plans: Plans, limits: SirLimits) -> Result<Sir> {
    if content.len() as u64 > limits.bytes {
        return Err(Error::limit(format!("expected at most {} bytes, found more", limits.bytes)));
    }
    let mut bytes = Bytes::new(content);
    let header = header(&mut bytes)?;
    let offset = bytes.offset();
    let magic = bytes.u16("magic number")?;
    if magic != 0x5A3C {
        return Err(Error::format(format!(
            "byte {offset}: magic number: expected 0x5a3c, found {magic:#06x}"
        )));
    }
    let grid = Grid { resolution: header.resolution, side: header.scattered };
    let nodes = nodes(&mut bytes, &header, grid)?;
    let (migrations, repaired) = migrations(&mut bytes, &nodes, plans)?;
    let mesh = Mesh::new(header.symmetry, &nodes, &migrations)?;
    Ok(Sir {
        name: header.name,
        incident: header.incident,
        scattered: header.scattered,
        channels: header.channels,
        floor: header.floor,
        grazing: header.grazing,
        grid,
        nodes,
        migrations,
        mesh,
        repaired,
    })
}

fn header(bytes: &mut Bytes) -> Result<Header> {
    let (mut name, mut symmetry, mut sides, mut channels) = (String::new(), None, None, 1);
    let (mut resolution, mut floor, mut grazing) = (256, 0.0, None);
    loop {
        let at = bytes.offset();
        let line = bytes.line(LONGEST_LINE)?;
        if line.is_empty() {
            break;
        }
        let Some((key, value)) = line.split_once('=') else { continue };
        let fault = |expected: &str| {
            let found: String = value.chars().take(60).collect();
            Error::format(format!("byte {at}: {key}: expected {expected}, found {found:?}"))
        };
        match key {
            "NAME" => name = value.to_owned(),
            "SYMMETRY" => {
                let code: i32 = value.trim().parse().map_err(|_| fault("an integer"))?;
                if !matches!(code, 0..=4 | 6 | 8 | 9 | 12 | 15) {
                    return Err(fault("one of 0, 1, 2, 4, 8, 3, 6, 9, 12, 15"));
                }
                symmetry = Some(code);
            }
            "IO_SIDES" => {
                let expected = "two of 1 and -1";
                let [incident, scattered] =
                    numbers::<i32, 2>(value).ok_or_else(|| fault(expected))?;
                if incident == 0 || scattered == 0 {
                    return Err(fault(expected));
                }
                let side = |sign: i32| if sign > 0 { Side::Front } else { Side::Back };
                sides = Some((side(incident), side(scattered)));
            }
            "COLORIMETRY" => {
                channels = match value.trim() {
                    "CIE-Y" | "Unknown" => 1,
                    "CIE-XYZ" => 3,
                    _ => return Err(fault("CIE-Y, CIE-XYZ or Unknown")),
                };
            }
            "GRIDRES" => {
                resolution = value
                    .trim()
                    .parse()
                    .ok()
                    .filter(|&n| n >= 16)
                    .ok_or_else(|| fault("16 to 65535"))?;
            }
            "BSDFMIN" => {
                let [min] = numbers::<f64, 1>(value).ok_or_else(|| fault("a number"))?;
                floor = Some(min)
                    .filter(|m| (0.0..=1e9).contains(m))
                    .ok_or_else(|| fault("0 to 1e9"))?;
            }
            "BSDFSPEC" => {
                let [value, sigma] =
                    numbers::<f64, 2>(value).ok_or_else(|| fault("two numbers"))?;
                if !(0.0..=1e9).contains(&value) || !(0.0..=std::f64::consts::PI).contains(&sigma) {
                    return Err(fault("a value from 0 to 1e9 and a radius from 0 to pi"));
                }
                grazing = Some(GrazingLobe { value, sigma });
            }
            "FORMAT" if value.trim() != "BSDF_RBFmesh" => return Err(fault("BSDF_RBFmesh")),
            _ => {}
        }
    }
    let missing = |key: &str| {
        Error::format(format!("header: expected {key}=, found none before the empty line"))
    };
    let symmetry = symmetry.ok_or_else(|| missing("SYMMETRY"))?;
    let (incident, scattered) = sides.ok_or_else(|| missing("IO_SIDES"))?;
    let grazing = grazing.filter(|g| g.value > floor && g.sigma > 0.0);
    Ok(Header { name, symmetry, incident, scattered, channels, resolution, floor, grazing })
}

/// Exactly `N` numbers parted by white space.
fn numbers<T: std::str::FromStr, const N: usize>(text: &str) -> Option<[T; N]> {
    let all: Vec<T> =
        text.split_whitespace().map(|word| word.parse().ok()).collect::<Option<_>>()?;
    all.try_into().ok()
}

fn nodes(bytes: &mut Bytes, header: &Header, grid: Grid) -> Result<Vec<SirNode>> {
    let mut nodes = Vec::new();
    loop {
        let at = bytes.offset();
        let ordinal = bytes.i32("ordinal of a node")?;
        if ordinal == -1 {
            break;
        }
        let place = |what: &str| format!("byte {at}: node {}: {what}", nodes.len());
        if usize::try_from(ordinal) != Ok(nodes.len()) {
            return Err(Error::format(place(&format!(
                "expected ordinal {}, found {ordinal}",
                nodes.len()
            ))));
        }
        let what = "incident vector";
        let incident = DVec3::new(bytes.float(what)?, bytes.float(what)?, bytes.float(what)?);
        if (incident.length() - 1.0).abs() > 1e-3 || Side::of(incident) != header.incident {
            let side = header.incident;
            return Err(Error::format(place(&format!(
                "expected a unit incident vector on side {side:?}, found {incident}"
            ))));
        }
        let total = bytes.float("total of a node")?;
        if !PLAUSIBLE.contains(&total) {
            return Err(Error::format(place(&format!(
                "expected a total from 1e-9 to 1e9, found {total}"
            ))));
        }
        let count = bytes.i32("number of lobes")?;
        let count = usize::try_from(count)
            .ok()
            .filter(|n| n.saturating_mul(LOBE_BYTES) <= bytes.left())
            .ok_or_else(|| {
                let most = bytes.left() / LOBE_BYTES;
                Error::format(place(&format!(
                    "expected 0 to {most} lobes in the rest of the file, found {count}"
                )))
            })?;
        let lobes = (0..count)
            .map(|k| {
                lobe(bytes, header.channels, grid)
                    .map_err(|e| e.context(place(&format!("lobe {k}"))))
            })
            .collect::<Result<_>>()?;
        nodes.push(SirNode { incident: incident.normalize(), total, lobes });
    }
    if nodes.is_empty() {
        return Err(Error::format(format!(
            "byte {}: expected at least one node, found none",
            bytes.offset()
        )));
    }
    Ok(nodes)
}

fn lobe(bytes: &mut Bytes, channels: usize, grid: Grid) -> Result<SirLobe> {
    let peak = bytes.float("peak")?;
    if !(0.0..=*PLAUSIBLE.end()).contains(&peak) {
        return Err(Error::format(format!("expected a peak from 0 to 1e9, found {peak}")));
    }
    let colour = bytes.u16("colour")?;
    let radius = bytes.u16("radius")?;
    let cell = [bytes.u16("cell")?, bytes.u16("cell")?];
    if cell.iter().any(|&c| c >= grid.resolution) {
        return Err(Error::format(format!(
            "expected a cell below {}, found {cell:?}",
            grid.resolution
        )));
    }
    let colour = if channels == 1 { [1.0; 2] } else { decode_colour(colour) };
    Ok(SirLobe { peak, radius, cell, colour, centre: grid.centre(cell) })
}

/// X/Y and Z/Y of a packed chromaticity: low byte 410 u′, high byte 410 v′.
fn decode_colour(code: u16) -> [f32; 2] {
    if code == NEUTRAL {
        return [1.0; 2];
    }
    let [high, low] = code.to_be_bytes();
    let u = f32::from(low) / 410.0;
    let v = f32::from(high.max(1)) / 410.0;
    [9.0 * u / (4.0 * v), ((12.0 - 3.0 * u - 20.0 * v) / (4.0 * v)).max(0.0)]
}

fn migrations(
    bytes: &mut Bytes,
    nodes: &[SirNode],
    plans: Plans,
) -> Result<(Vec<Migration>, usize)> {
    // Shares of mass per node, for the repair; a lobe's mass is counted as the writer counts it.
    let shares: Vec<Vec<f64>> = match plans {
        Plans::AsStored => Vec::new(),
        Plans::Repaired => nodes
            .iter()
            .map(|n| n.lobes.iter().map(|l| slice::mass(l) / n.total).collect())
            .collect(),
    };
    let (mut migrations, mut repaired) = (Vec::new(), 0);
    loop {
        let at = bytes.offset();
        let from = bytes.i32("source node of a migration")?;
        if from == -1 {
            return Ok((migrations, repaired));
        }
        let to = bytes.i32("target node of a migration")?;
        let node = |n: i32| usize::try_from(n).ok().filter(|&n| n < nodes.len());
        let (Some(from), Some(to)) = (node(from), node(to)) else {
            let last = nodes.len() - 1;
            return Err(Error::format(format!(
                "byte {at}: migration: expected nodes from 0 to {last}, found {from} and {to}"
            )));
        };
        if from >= to {
            return Err(Error::format(format!(
                "byte {at}: migration: expected a lower and a higher node, found {from} and {to}"
            )));
        }
        let entries = Plan::parse(bytes, &nodes[from], &nodes[to])
            .map_err(|e| e.context(format!("migration {from} to {to}")))?;
        let masses =
            (plans == Plans::Repaired).then(|| (shares[from].as_slice(), shares[to].as_slice()));
        let (plan, mended) = Plan::build(entries, masses);
        repaired += usize::from(mended);
        migrations.push(Migration { from, to, plan });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colour_codes_come_back_to_the_quantum() {
        // (x, y) → u′ = 4x / (−2x + 12y + 3), v′ = 9y / (the same), 410 steps to the unit.
        for (x, y) in
            [(1.0 / 3.0, 1.0 / 3.0), (0.64, 0.33), (0.3, 0.6), (0.15, 0.06), (0.44757, 0.40745)]
        {
            let d = -2.0 * x + 12.0 * y + 3.0;
            let code = [9.0 * y / d, 4.0 * x / d].map(|c: f32| (c * 410.0).round() as u8);
            let found = decode_colour(u16::from_be_bytes(code));
            let expected = [x / y, (1.0 - x - y) / y];
            for k in 0..2 {
                assert!(
                    (found[k] - expected[k]).abs() < 0.02 + 0.02 * expected[k],
                    "{found:?}, expected {expected:?}"
                );
            }
        }
        assert_eq!(decode_colour(NEUTRAL), [1.0, 1.0]);
    }
}
