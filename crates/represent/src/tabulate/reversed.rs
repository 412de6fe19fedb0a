//! A transmission as light sees it that comes from the other side.

use bsdfkit::{Component, Result};
use bsdfkit_sphere::{DVec3, Side};

use super::component::{Form, Tabulated, component};
use super::stored::Stored;
use crate::source::{Peak, Slice, Source};
use crate::watch::Watch;

/// f(ωo, ωi) of `source` in a form of its own, for programs that do not exchange directions themselves.
///
/// Convention: no factor of refraction, since both sides are air.
/// Errors: as [`component`].
/// Cost: as [`component`], every value of an incident direction of its own.
pub fn reversed(source: &dyn Source, form: &Form, watch: &Watch<'_>) -> Result<Tabulated> {
    component(&Reversed(source), form, watch)
}

/// [`reversed`] of what is stored.
pub fn stored_reversed(source: &Component, form: &Form, watch: &Watch<'_>) -> Result<Tabulated> {
    reversed(&Stored::coloured(source), form, watch)
}

struct Reversed<'a>(&'a dyn Source);

impl Source for Reversed<'_> {
    fn incident(&self) -> Side {
        self.0.scattered()
    }

    fn scattered(&self) -> Side {
        self.0.incident()
    }

    fn isotropic(&self) -> bool {
        self.0.isotropic()
    }

    fn channels(&self) -> usize {
        self.0.channels()
    }

    fn is_measured(&self, wi: DVec3) -> bool {
        self.0.is_measured(through(wi))
    }

    fn slice<'a>(&'a self, wi: DVec3) -> Box<dyn Slice + 'a> {
        Box::new(Known { source: self.0, wi })
    }
}

/// What scatters into one direction.
struct Known<'a> {
    source: &'a dyn Source,
    wi: DVec3,
}

impl Slice for Known<'_> {
    fn eval(&self, wo: &[DVec3], out: &mut [f32]) {
        for (value, &wo) in out.chunks_mut(self.source.channels()).zip(wo) {
            self.source.value(wo, self.wi, value);
        }
    }

    /// Where light of the same angles has them that comes from the side that is known: what is symmetric has them there.
    fn peaks(&self, out: &mut Vec<Peak>) {
        let first = out.len();
        self.source.slice(through(self.wi)).peaks(out);
        out[first..].iter_mut().for_each(|peak| peak.direction = through(peak.direction));
    }
}

/// Its mirror image in the surface.
fn through(w: DVec3) -> DVec3 {
    DVec3::new(w.x, w.y, -w.z)
}
