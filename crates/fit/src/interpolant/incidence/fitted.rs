//! One fitted incidence: floor, lobes and detail.

use bsdfkit::{DVec2, DVec3};

use crate::lobe::LobeSet;
use crate::lobe::detail::Detail;
use bsdfkit_measure::frame::Frame;
use bsdfkit_measure::{Image, Seen};

/// Scattering of one measured incident direction:
/// f(u) = (floor + Σ lobes(q)/|du/dq| + ε) · exp detail(u) − ε, never below 0.
#[derive(Clone, Debug)]
pub struct FittedIncidence {
    /// Incident direction, on the front hemisphere of the fit (|z|).
    pub wi: DVec3,
    /// Floor and lobes, in coordinates of the component's [`Frame`].
    pub lobes: LobeSet,
    /// log ratio of data to lobes: of luminance (of spectra the guide), or of Y, X and Z.
    pub details: Vec<Detail>,
    /// Coefficients of the [`Basis`](bsdfkit::spectrum::Basis), where there are bands.
    pub coefficients: Vec<Detail>,
    /// Number of measured points.
    pub points: usize,
    /// Directional-hemispherical luminance, unmeasured directions included; dimensionless.
    pub hemispherical: f64,
    /// Relative L1 distance of this model from the measured points, area-weighted.
    pub fit_error: f64,
    /// Largest measured sin θₒ.
    pub limit: f64,
    /// Where, out to there, directions lie between measured points or their images; in the frame of `wi`.
    pub seen: Seen,
}

impl FittedIncidence {
    /// Whether enough was seen for its total; see [`Seen::tells`].
    pub fn tells(&self) -> bool {
        self.seen.tells(self.limit, DVec3::new(-self.wi.x, -self.wi.y, self.wi.z))
    }

    /// Share of the projected hemisphere that was seen.
    pub fn seen_share(&self) -> f64 {
        self.seen.share(self.limit)
    }

    /// floor + Σ lobes at disk coordinates `u`: f before the detail.
    pub fn smooth(&self, frame: Frame, u: DVec2) -> f64 {
        let at = frame.at(self.wi);
        self.lobes.floor + self.lobes.density(at.forward(u)) / at.density(u)
    }

    /// Luminance f at disk coordinates `u`.
    pub(crate) fn eval(&self, frame: Frame, epsilon: f64, u: DVec2) -> f64 {
        let detail = self.details[0].log_at(u).exp();
        ((self.smooth(frame, u) + epsilon) * detail - epsilon).max(0.0)
    }

    /// The lobes as seen through `image`.
    pub(crate) fn image_lobes(&self, image: Image) -> LobeSet {
        self.lobes.transformed(image.x, image.y)
    }
}
