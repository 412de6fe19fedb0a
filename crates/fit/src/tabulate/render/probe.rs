//! A source looked at from the outside.

use bsdfkit::Side;
use bsdfkit::render::{Place, RenderTable, View};
use bsdfkit::{DVec2, DVec3, Distribution};

use super::plan::shares;
use crate::source::{Slice, Source};

/// The sides of a source; tables have both directions on the front.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sides {
    incident: Side,
    scattered: Side,
}

fn on_side(w: DVec3, side: Side) -> DVec3 {
    DVec3::new(w.x, w.y, side.sign() * w.z.max(1e-9))
}

impl Sides {
    pub(super) fn of(source: &dyn Source) -> Self {
        Self { incident: source.incident(), scattered: source.scattered() }
    }

    /// All channels of f at each of `wo`, 1/sr: (directions, channels).
    pub(super) fn channels(self, source: &dyn Source, wi: DVec3, wo: &[DVec3]) -> Vec<f32> {
        self.channels_of(source, &*self.slice(source, wi), wo)
    }

    /// The slice of an incident direction on the front.
    pub(super) fn slice<'a>(self, source: &'a dyn Source, wi: DVec3) -> Box<dyn Slice + 'a> {
        source.slice(on_side(wi, self.incident))
    }

    /// Luminance of a slice.
    pub(super) fn of_slice(self, source: &dyn Source, slice: &dyn Slice, wo: &[DVec3]) -> Vec<f64> {
        let values = self.channels_of(source, slice, wo);
        values.iter().step_by(source.channels()).map(|&v| f64::from(v)).collect()
    }

    fn channels_of(self, source: &dyn Source, slice: &dyn Slice, wo: &[DVec3]) -> Vec<f32> {
        let other: Vec<DVec3> = wo.iter().map(|&w| on_side(w, self.scattered)).collect();
        let mut values = vec![0.0; wo.len() * source.channels()];
        slice.eval(&other, &mut values);
        for value in &mut values {
            *value = if value.is_finite() { value.max(0.0) } else { 0.0 };
        }
        values
    }

    /// Luminance alone.
    pub(super) fn values(self, source: &dyn Source, wi: DVec3, wo: &[DVec3]) -> Vec<f64> {
        self.of_slice(source, &*self.slice(source, wi), wo)
    }
}

/// Direction `n` of `count` spread over the hemisphere.
pub(super) fn golden(n: usize, count: usize) -> DVec3 {
    let r = ((n as f64 + 0.5) / count as f64).sqrt();
    let xy = DVec2::from_angle(n as f64 * 2.399_963_229_728_653) * r;
    xy.extend((1.0 - r * r).sqrt())
}

/// Distance from peaks from which on quadratures widen.
const CORE: f64 = 0.01;

/// Cells of a quadrature about each peak.
pub(super) const CELLS: (usize, usize) = (32, 40);

/// Directions with projected solid angles, close together about the peaks of several views, whose integral is that
/// over the hemisphere.
pub(super) fn quadrature(views: &[View], (angles, radii): (usize, usize)) -> Vec<Place> {
    let mut all = Vec::new();
    let mut part = vec![0.0; views.len()];
    for (n, view) in views.iter().enumerate() {
        for place in view.cells(angles, radii, CORE) {
            shares(views, place.wo, &mut part);
            all.push(Place { size: place.size * part[n], ..place });
        }
    }
    all
}

/// f of one incident direction at many places.
pub(super) struct Probe {
    pub(super) wi: DVec3,
    places: Vec<Place>,
    values: Vec<f64>,
    /// ∫ f |cos θo| dω.
    pub(super) total: f64,
}

impl Probe {
    /// `views`: about peaks.
    pub(super) fn new(source: &dyn Source, wi: DVec3, views: &[View]) -> Self {
        let places = quadrature(views, CELLS);
        let wo: Vec<DVec3> = places.iter().map(|p| p.wo).collect();
        let values = Sides::of(source).values(source, wi, &wo);
        let total = places.iter().zip(&values).map(|(p, f)| p.size * f).sum();
        Self { wi, places, values, total }
    }

    /// Share of the light that the table has in a wrong place, and its total over the source's.
    pub(super) fn error(&self, table: &RenderTable) -> (f64, f64) {
        let found: Vec<f64> = self.places.iter().map(|p| table.value(self.wi, p.wo)).collect();
        let total: f64 = self.places.iter().zip(&found).map(|(p, f)| p.size * f).sum();
        if self.total <= 0.0 || total <= 0.0 {
            return (0.0, 1.0);
        }
        let gain = self.total / total;
        let wrong = |((p, f), g): ((&Place, &f64), &f64)| p.size * (f - gain * g).abs();
        let wrong: f64 = self.places.iter().zip(&self.values).zip(&found).map(wrong).sum();
        (wrong / self.total, total / self.total)
    }
}
