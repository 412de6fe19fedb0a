//! Radiance's interpolant (SIR): lobes per incidence, transport plans per mesh edge; read and evaluated by its rules.
//!
//! Differs from: our own interpolant, which needs none of these rules. Radiance rounds lobe centres to a grid after every
//! interpolation, softens the cosine at the horizon, cuts lobes in grid distance and depends on the order of vertices;
//! all of this is imitated here, so that a laboratory's old files answer the same values as in Radiance.

mod boxes;
mod bytes;
mod file;
mod grid;
mod mesh;
mod plan;
mod slice;

use std::fs::File;
use std::io::Read;
use std::path::Path;

use bsdfkit::{Error, Result};
use bsdfkit_sphere::{DVec3, Side};

pub use plan::{Plan, PlanEntry};
pub use slice::SirSlice;

use grid::Grid;
use mesh::Mesh;

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

/// One Gaussian lobe of an incidence: DSF = peak · exp((ω·centre − 1) / σ²), in 1/sr.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SirLobe {
    /// DSF at the centre, 1/sr.
    pub peak: f64,
    /// σ = (radius + ½) π / 65536 radians.
    pub radius: u16,
    /// Grid cell whose middle is the centre.
    pub cell: [u16; 2],
    /// X/Y and Z/Y of the lobe's colour; (1, 1) is neutral.
    pub colour: [f32; 2],
    /// Unit vector to the middle of `cell`.
    pub centre: DVec3,
}

/// One measured (or completed) incidence.
#[derive(Clone, Debug)]
pub struct SirNode {
    /// Unit vector to the light.
    pub incident: DVec3,
    /// Directional-hemispherical value as the writer counted it.
    pub total: f64,
    /// Its lobes.
    pub lobes: Vec<SirLobe>,
}

/// A transport plan along a mesh edge; row i of `plan` says where lobe i of node `from` goes.
#[derive(Clone, Debug)]
pub struct Migration {
    /// Index of the source node, below `to`.
    pub from: usize,
    /// Index of the target node.
    pub to: usize,
    /// Fractions of each source lobe; rows sum to one.
    pub plan: Plan,
}

/// The lobe that stands for everything beyond the outermost measured incidence.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GrazingLobe {
    pub(crate) value: f64,
    pub(crate) sigma: f64,
}

/// A SIR file in memory: one pair of incident and scattered side.
///
/// Convention: Radiance's own frame, which is ours; no swap of front and back here.
#[derive(Debug)]
pub struct Sir {
    name: String,
    incident: Side,
    scattered: Side,
    channels: usize,
    floor: f64,
    grazing: Option<GrazingLobe>,
    grid: Grid,
    nodes: Vec<SirNode>,
    migrations: Vec<Migration>,
    mesh: Mesh,
    repaired: usize,
}

impl Sir {
    /// Reads a file with [`SirLimits::default`], plans repaired.
    ///
    /// Errors: io; format with byte offset, expected, found; limit when the file is too large.
    pub fn read(path: &Path) -> Result<Sir> {
        let limits = SirLimits::default();
        let name = path.display().to_string();
        let file = File::open(path).map_err(|e| Error::io(&name, &e))?;
        let mut bytes = Vec::new();
        file.take(limits.bytes + 1).read_to_end(&mut bytes).map_err(|e| Error::io(&name, &e))?;
        Sir::from_bytes(&bytes, Plans::Repaired, limits).map_err(|e| e.context(&name))
    }

    /// Reads a file's content.
    ///
    /// Errors: format with byte offset, expected, found; limit when `bytes` is too large.
    pub fn from_bytes(bytes: &[u8], plans: Plans, limits: SirLimits) -> Result<Sir> {
        file::parse(bytes, plans, limits)
    }

    /// The specimen's name, empty when the file has none.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The side that light comes from.
    pub fn incident(&self) -> Side {
        self.incident
    }

    /// The side that light goes to.
    pub fn scattered(&self) -> Side {
        self.scattered
    }

    /// Whether the specimen looks the same after any rotation about Z.
    pub fn isotropic(&self) -> bool {
        self.mesh.isotropic()
    }

    /// One (luminance) or three (Y, X, Z: luminance first).
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// BSDF below which no answer falls, 1/sr.
    pub fn floor(&self) -> f64 {
        self.floor
    }

    /// The incidences in the file's order.
    pub fn nodes(&self) -> &[SirNode] {
        &self.nodes
    }

    /// The transport plans in the file's order.
    pub fn migrations(&self) -> &[Migration] {
        &self.migrations
    }

    /// How many plans got their lost entry back.
    pub fn repaired(&self) -> usize {
        self.repaired
    }
}
