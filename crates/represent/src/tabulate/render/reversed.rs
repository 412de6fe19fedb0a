//! A table seen from its other end.

use bsdfkit::render::RenderTable;
use bsdfkit::{DVec3, Distribution, Result, Side};

use super::settings::RenderSettings;
use super::subject::Subject;
use super::{build, choose};
use crate::source::{Slice, Source};
use crate::watch::Watch;

/// Totals and samples of light that travels the other way through `table`, which was made of `source`.
pub(super) fn table(
    table: &RenderTable,
    source: &dyn Source,
    settings: &RenderSettings,
    watch: &Watch<'_>,
) -> Result<RenderTable> {
    let reversed = Reversed { table, incident: source.scattered(), scattered: source.incident() };
    let mut subject = Subject::new(&reversed);
    let few = RenderSettings { max_bytes: settings.max_bytes / 3, ..*settings };
    let plan = choose::plan(&mut subject, &few, watch)?.without_values();
    build::table(&subject, &plan, watch)
}

/// f(ωo, ωi) of a table: what light does that travels the other way.
struct Reversed<'a> {
    table: &'a RenderTable,
    incident: Side,
    scattered: Side,
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
