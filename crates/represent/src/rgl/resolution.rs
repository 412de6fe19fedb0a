//! How fine the tables are.

/// Incidences and cells.
pub(super) struct Resolution {
    /// Incident polar angles, degrees.
    pub(super) thetas: Vec<f64>,
    /// Incident azimuths, degrees: one of isotropic materials.
    pub(super) phis: Vec<f64>,
    /// Nodes of the warp along each side.
    pub(super) warp: usize,
    /// Nodes of the tables along each side.
    pub(super) cells: usize,
}

/// The last incident polar angle: readers hold values past it.
const LAST: f64 = 89.0;

/// Incident polar angles crowd a little toward grazing, where f changes fastest.
const CROWDING: f64 = 0.9;

impl Resolution {
    /// Readers take one azimuth for an isotropic material.
    pub(super) fn isotropic() -> Self {
        Self { thetas: thetas(24), phis: vec![0.0], warp: 64, cells: 64 }
    }

    /// From -180 to 180: files that begin elsewhere lose their anisotropy in Mitsuba 3.9.
    ///
    /// With 16 azimuths L1 of a rough metal (0.1 by 0.4) rises by a tenth, with tables of 32 nodes from 0.01 to 0.02.
    pub(super) fn anisotropic() -> Self {
        let phis = (0..=24).map(|k| 15.0 * f64::from(k) - 180.0).collect();
        Self { thetas: thetas(20), phis, warp: 64, cells: 48 }
    }
}

fn thetas(count: usize) -> Vec<f64> {
    let last = (count - 1) as f64;
    (0..count).map(|k| LAST * (k as f64 / last).powf(CROWDING)).collect()
}
