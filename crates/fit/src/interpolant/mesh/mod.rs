//! Where the measured incidences lie and who is whose neighbour.

pub(crate) mod chart;
pub(crate) mod incidence_mesh;

pub use incidence_mesh::{IncidenceMesh, Vertex};
