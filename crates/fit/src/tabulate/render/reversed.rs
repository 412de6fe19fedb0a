//! A table seen from its other end.

use bsdfkit::render::RenderTable;
use bsdfkit::{DVec3, Distribution, Side};

use crate::source::{Slice, Source};

/// f(ωo, ωi) of a table: what light does that travels the other way.
pub(super) struct Reversed<'a> {
    table: &'a RenderTable,
    incident: Side,
    scattered: Side,
}

impl<'a> Reversed<'a> {
    /// Of `table`, made of `source`.
    pub(super) fn new(table: &'a RenderTable, source: &dyn Source) -> Self {
        Self { table, incident: source.scattered(), scattered: source.incident() }
    }
}

impl Source for Reversed<'_> {
    fn incident(&self) -> Side {
        self.incident
    }

    fn scattered(&self) -> Side {
        self.scattered
    }

    fn isotropic(&self) -> bool {
        self.table.chart().fold().is_isotropic()
    }

    fn slice<'a>(&'a self, wi: DVec3) -> Box<dyn Slice + 'a> {
        Box::new(Seen { table: self.table, wi })
    }
}

struct Seen<'a> {
    table: &'a RenderTable,
    wi: DVec3,
}

impl Slice for Seen<'_> {
    fn eval(&self, wo: &[DVec3], out: &mut [f32]) {
        for (value, &wo) in out.iter_mut().zip(wo) {
            *value = self.table.value(wo, self.wi) as f32;
        }
    }
}
