//! Incidences of a SIR file and their lobes.

use bsdfkit_sphere::DVec3;

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
