//! A SIR file in memory.

use bsdfkit_sphere::Side;

use super::grid::Grid;
use super::mesh::Mesh;
use super::node::SirNode;
use super::plan::Migration;

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
    pub(super) name: String,
    pub(super) incident: Side,
    pub(super) scattered: Side,
    pub(super) channels: usize,
    pub(super) floor: f64,
    pub(super) grazing: Option<GrazingLobe>,
    pub(super) grid: Grid,
    pub(super) nodes: Vec<SirNode>,
    pub(super) migrations: Vec<Migration>,
    pub(super) mesh: Mesh,
    pub(super) repaired: usize,
}

impl Sir {
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
