//! f of one incident direction at many places, and how far a table is from it.

use bsdfkit::render::{Place, RenderTable, View};
use bsdfkit::{DVec2, DVec3, Distribution};

use super::plan::{Plan, Planned, parts};
use super::subject::Subject;

/// Direction `n` of `count` spread over the hemisphere.
pub(super) fn golden(n: usize, count: usize) -> DVec3 {
    let r = ((n as f64 + 0.5) / count as f64).sqrt();
    let xy = DVec2::from_angle(n as f64 * 2.399_963_229_728_653) * r;
    xy.extend((1.0 - r * r).sqrt())
}

/// Widths of a peak from which on quadratures widen.
const CORE: f64 = 0.5;

/// Limits of the factors that give layers their energy: a blend far from the source is not blown up.
const FACTORS: [f64; 2] = [0.1, 10.0];

/// Cells of a quadrature about each peak.
pub(super) const CELLS: (usize, usize) = (32, 40);

/// Directions with projected solid angles, close together about the peaks of several views, whose integral is that
/// over the hemisphere.
pub(super) fn quadrature(views: &[View], (angles, radii): (usize, usize)) -> Vec<Place> {
    let mut all = Vec::new();
    let mut part = vec![0.0; views.len()];
    for (n, view) in views.iter().enumerate() {
        for place in view.cells(angles, radii, CORE) {
            parts(views, place.wo, &mut part);
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
    pub(super) fn new(subject: &Subject<'_>, wi: DVec3, views: &[View]) -> Self {
        let places = quadrature(views, CELLS);
        let wo: Vec<DVec3> = places.iter().map(|p| p.wo).collect();
        let values = subject.values(wi, &wo);
        let total = places.iter().zip(&values).map(|(p, f)| p.size * f).sum();
        Self { wi, places, values, total }
    }

    /// What each layer of the table has to be multiplied by to have as much light as its part of f.
    pub(super) fn factors(
        &self,
        subject: &Subject<'_>,
        plan: &Plan,
        table: &RenderTable,
    ) -> Vec<f64> {
        let wo: Vec<DVec3> = self.places.iter().map(|p| p.wo).collect();
        let shares = match plan.layers.iter().any(|l| !l.peaks.is_empty()) {
            true => subject.shares(self.wi, &wo),
            false => Vec::new(),
        };
        let mut found = vec![0.0; plan.layers.len()];
        for place in &self.places {
            table
                .layer_values(self.wi, place.wo, |layer, value| found[layer] += place.size * value);
        }
        let factor = |(planned, found): (&Planned, f64)| {
            let mut values = self.values.clone();
            planned.take(&mut values, &shares);
            let wanted: f64 = self.places.iter().zip(&values).map(|(p, f)| p.size * f).sum();
            if found > 1e-12 { (wanted / found).clamp(FACTORS[0], FACTORS[1]) } else { 1.0 }
        };
        plan.layers.iter().zip(found).map(factor).collect()
    }

    /// Share of the light that the table has in a wrong place.
    pub(super) fn error(&self, table: &RenderTable) -> f64 {
        self.errors(table)[0]
    }

    /// The same, and share of the light that it has too much or too little of.
    pub(super) fn errors(&self, table: &RenderTable) -> [f64; 2] {
        let found: Vec<f64> = self.places.iter().map(|p| table.value(self.wi, p.wo)).collect();
        let total: f64 = self.places.iter().zip(&found).map(|(p, f)| p.size * f).sum();
        if self.total <= 0.0 || total <= 0.0 {
            return [0.0; 2];
        }
        let gain = self.total / total;
        let wrong = |((p, f), g): ((&Place, &f64), &f64)| p.size * (f - gain * g).abs();
        let wrong: f64 = self.places.iter().zip(&self.values).zip(&found).map(wrong).sum();
        [wrong / self.total, (total / self.total - 1.0).abs().min(1.0)]
    }
}
