//! A transmission as light sees it that comes from the other side.

use bsdfkit::{Component, Result};
use bsdfkit_sphere::{DVec3, Side};

use super::component::{Form, Tabulated, component};
use super::stored::Stored;
use crate::source::{Peak, Slice, Source};
use crate::watch::Watch;

/// f(ωo, ωi) of what `source` was made into, in a form of its own, for programs that do not exchange directions themselves.
///
/// Meaning: values are those of `made`; where peaks are tells `source`, so that few of them are missed.
/// Convention: no factor of refraction, since both sides are air.
/// Errors: as [`component`].
/// Cost: 1 to 2 s a tree of rank 3: every value is one look-up in `made`. Asking an interpolant, of which each would be a slice of
/// its own, takes forty times as long.
pub fn reversed(
    source: &dyn Source,
    made: &Component,
    form: &Form,
    watch: &Watch<'_>,
) -> Result<Tabulated> {
    component(&Reversed { values: &Stored::coloured(made), peaks: source }, form, watch)
}

/// [`reversed`] of what is stored.
pub fn stored_reversed(source: &Component, form: &Form, watch: &Watch<'_>) -> Result<Tabulated> {
    reversed(&Stored::coloured(source), source, form, watch)
}

struct Reversed<'a> {
    values: &'a dyn Source,
    peaks: &'a dyn Source,
}

impl Source for Reversed<'_> {
    fn incident(&self) -> Side {
        self.values.scattered()
    }

    fn scattered(&self) -> Side {
        self.values.incident()
    }

    fn isotropic(&self) -> bool {
        self.values.isotropic()
    }

    fn channels(&self) -> usize {
        self.values.channels()
    }

    fn is_measured(&self, wi: DVec3) -> bool {
        self.peaks.is_measured(through(wi))
    }

    fn slice<'a>(&'a self, wi: DVec3) -> Box<dyn Slice + 'a> {
        Box::new(Known { of: self, wi })
    }
}

/// What scatters into one direction.
struct Known<'a> {
    of: &'a Reversed<'a>,
    wi: DVec3,
}

impl Slice for Known<'_> {
    fn eval(&self, wo: &[DVec3], out: &mut [f32]) {
        for (value, &wo) in out.chunks_mut(self.of.values.channels()).zip(wo) {
            self.of.values.value(wo, self.wi, value);
        }
    }

    /// Where light of the same angles has them that comes from the side that is known: what is symmetric has them there.
    fn peaks(&self, out: &mut Vec<Peak>) {
        let first = out.len();
        self.of.peaks.slice(through(self.wi)).peaks(out);
        out[first..].iter_mut().for_each(|peak| peak.direction = through(peak.direction));
    }
}

/// Its mirror image in the surface.
fn through(w: DVec3) -> DVec3 {
    DVec3::new(w.x, w.y, -w.z)
}
