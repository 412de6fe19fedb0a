//! Which peaks light from one direction has.

use bsdfkit_sphere::{DVec3, Side};

use super::Specular;
use crate::component::{Components, Scatter};
use crate::{Bsdf, Xyz};

/// A peak of no width for one incident direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpecularPeak {
    /// Where the light goes.
    pub wo: DVec3,
    /// The share of the incident light that goes there, dimensionless.
    pub coefficient: Xyz,
    /// Which of [`Bsdf::specular`].
    pub index: usize,
}

impl Specular {
    /// Where light from `wi` goes, and how much of it, along the stored way or against it.
    fn peak(&self, wi: DVec3, reverse: bool) -> Option<(DVec3, Xyz)> {
        if !reverse {
            let wo = self.law.scattered(wi, self.scattered)?;
            return Some((wo, self.coefficient.at(wi)));
        }
        let from = self.law.reversed().scattered(wi, self.incident)?;
        Some((from, self.coefficient.at(from)))
    }
}

impl Bsdf {
    /// The selected peaks of no width for light from `wi`: what [`Bsdf::eval`] leaves out.
    ///
    /// A ray that goes on as `wo` carries `coefficient` of what came; of radiance that is seen through a refracting
    /// surface the index of refraction is left out. Empty for NaN and where a peak would lie beyond the horizon.
    ///
    /// Convention: a transmission stored one way alone, in components and peaks, answers the other way too: as much of
    /// the light goes back along the same path.
    pub fn specular_peaks(
        &self,
        wi: DVec3,
        components: Components,
    ) -> impl Iterator<Item = SpecularPeak> {
        let side = Side::of(wi);
        let valid = !wi.is_nan();
        let stored = self.specular().iter().enumerate().filter(move |_| valid);
        stored.filter_map(move |(index, s)| {
            let forward = s.incident == side;
            let reverse = !forward && s.scattered == side && self.is_specular_reversed(side);
            let on = components.selects(side, s.is_transmission(), Scatter::Specular);
            if !(on && (forward || reverse)) {
                return None;
            }
            let (wo, coefficient) = s.peak(wi, reverse)?;
            Some(SpecularPeak { wo, coefficient, index })
        })
    }
}
