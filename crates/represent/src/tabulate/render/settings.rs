//! What is asked of a table in the render form, and what came of it.

/// What is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RenderSettings {
    /// Most bytes of a component's arrays.
    pub max_bytes: usize,
    /// Share of the scattered light that may be in a wrong place between nodes (L1), where `max_bytes` allow.
    pub max_error: f64,
    /// Whether light that travels the other way is drawn from tables, too: of a transmission that stands alone.
    pub reverse: bool,
}

impl Default for RenderSettings {
    /// 6 MB, 0.006, no reverse.
    fn default() -> Self {
        Self { max_bytes: 6_000_000, max_error: 0.006, reverse: false }
    }
}

/// What it cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RenderReport {
    /// Bytes of all arrays.
    pub bytes: usize,
    /// Nodes of incident directions.
    pub nodes: usize,
    /// Layers, each with a frame of its own.
    pub layers: usize,
    /// Share of the scattered light in a wrong place (L1), mean over incidences between nodes.
    pub error: f64,
}
