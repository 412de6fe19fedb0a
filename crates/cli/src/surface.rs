//! What answers queries: a stored BSDF or an interpolant, alike to the verbs.

use std::f64::consts::PI;

use bsdfkit::{Bsdf, Components, DVec2, DVec3, Side, Xyz};
use bsdfkit_fit::interpolant::{Interpolant, Part};
use bsdfkit_fit::tabulate::Source;
use bsdfkit_sphere::concentric::square_to_hemisphere;
use rayon::prelude::*;

/// A BSDF in either form.
#[derive(Clone, Debug)]
pub(crate) enum Surface {
    /// Trees or matrices.
    Stored(Box<Bsdf>),
    /// A function to be evaluated.
    Continuous(Interpolant),
}

/// Both sides.
pub(crate) const SIDES: [Side; 2] = [Side::Front, Side::Back];

/// Cells along the square by which a continuous distribution is integrated: equal projected solid
/// angles of 0.4 degrees. Doubled, a total takes 0.3 s instead of 0.1 s.
const CELLS: usize = 256;

impl Surface {
    /// Pairs of sides (incident, scattered) that hold data.
    pub(crate) fn pairs(&self) -> Vec<(Side, Side)> {
        match self {
            Self::Stored(b) => b.components().iter().map(|c| (c.incident, c.scattered)).collect(),
            Self::Continuous(i) => {
                i.components.iter().map(|p| (p.incident(), p.scattered())).collect()
            }
        }
    }

    /// Sides from which light is known to be scattered.
    pub(crate) fn incident_sides(&self) -> Vec<Side> {
        let pairs = self.pairs();
        SIDES.into_iter().filter(|&s| pairs.iter().any(|&(incident, _)| incident == s)).collect()
    }

    /// f(wi, wo) in 1/sr for each of `wo`, appended to `out`.
    pub(crate) fn eval(&self, wi: DVec3, wo: &[DVec3], out: &mut Vec<Xyz>) {
        match self {
            Self::Stored(bsdf) => out.extend(wo.iter().map(|&w| bsdf.eval_xyz(wi, w))),
            Self::Continuous(interpolant) => {
                for run in wo.chunk_by(|a, b| Side::of(*a) == Side::of(*b)) {
                    eval_continuous(interpolant, wi, run, out);
                }
            }
        }
    }

    /// ∫ f |cos θo| dωo to side `to`, photopic.
    pub(crate) fn hemispherical(&self, wi: DVec3, to: Side) -> f64 {
        match self {
            Self::Stored(bsdf) => {
                let reflects = Side::of(wi) == to;
                let way = if reflects { Components::REFLECTION } else { Components::TRANSMISSION };
                bsdf.directional_hemispherical(wi, way)
            }
            Self::Continuous(_) => {
                self.grid(wi, to).iter().sum::<f64>() * PI / (CELLS * CELLS) as f64
            }
        }
    }

    /// f at equal projected solid angles of side `to`: rows of [`grid_direction`].
    fn grid(&self, wi: DVec3, to: Side) -> Vec<f64> {
        let rows = (0..CELLS).into_par_iter().flat_map_iter(|i| {
            let wo: Vec<DVec3> = (0..CELLS).map(|j| cell_centre(i, j, to)).collect();
            let mut row = Vec::with_capacity(CELLS);
            self.eval(wi, &wo, &mut row);
            row.into_iter().map(|c| c.y)
        });
        rows.collect()
    }

    /// The distribution of one incident direction, to be drawn from; continuous ones are cut into cells.
    pub(crate) fn drawn(&self, wi: DVec3) -> Drawn {
        let mut drawn = Drawn { sums: Vec::with_capacity(2 * CELLS * CELLS), values: Vec::new() };
        let mut sum = 0.0;
        for to in SIDES {
            for f in self.grid(wi, to) {
                sum += f.max(0.0) * PI / (CELLS * CELLS) as f64;
                drawn.sums.push(sum);
                drawn.values.push(f.max(0.0));
            }
        }
        drawn
    }
}

/// The middle of cell (i, j) of the square.
fn cell_centre(i: usize, j: usize, side: Side) -> DVec3 {
    square_to_hemisphere(DVec2::new(i as f64 + 0.5, j as f64 + 0.5) / CELLS as f64, side)
}

/// A table of f over both hemispheres for one incident direction.
pub(crate) struct Drawn {
    /// Running sums of the cells' totals.
    sums: Vec<f64>,
    values: Vec<f64>,
}

impl Drawn {
    /// Scattered direction, weight and pdf (1/sr) for u in [0, 1); `None` where nothing scatters.
    pub(crate) fn sample(&self, u: f64, within: DVec2) -> Option<(DVec3, f64, f64)> {
        let total = *self.sums.last()?;
        if total.is_nan() || total <= 0.0 {
            return None;
        }
        let aim = u * total;
        let cell = self.sums.partition_point(|&s| s <= aim).min(self.sums.len() - 1);
        let (side, cell_on_side) = (SIDES[cell / (CELLS * CELLS)], cell % (CELLS * CELLS));
        let corner = DVec2::new((cell_on_side / CELLS) as f64, (cell_on_side % CELLS) as f64);
        let wo = square_to_hemisphere((corner + within) / CELLS as f64, side);
        Some((wo, total, self.values[cell] * wo.z.abs() / total))
    }
}

/// Of values all on one side.
fn eval_continuous(interpolant: &Interpolant, wi: DVec3, wo: &[DVec3], out: &mut Vec<Xyz>) {
    let Some(&first) = wo.first() else { return };
    let (from, to) = (Side::of(wi), Side::of(first));
    let value = |part: &Part, values: &[f32]| match (part.channels(), values) {
        (3, &[y, x, z]) => Xyz::new(x.into(), y.into(), z.into()),
        (_, &[y, ..]) => Xyz::grey(y.into()),
        (_, []) => Xyz::ZERO,
    };
    if let Some(part) = interpolant.part(from, to) {
        let channels = part.channels();
        let mut values = vec![0.0f32; wo.len() * channels];
        part.slice(wi).eval(wo, &mut values);
        out.extend(values.chunks(channels).map(|v| value(part, v)));
        return;
    }
    // A lone transmission answers the opposite travel direction too, as in a stored BSDF.
    let crosses = |p: &&Part| p.incident() == to && p.scattered() == from && from != to;
    let from_here = |p: &Part| p.incident() == from && p.scattered() != from;
    match interpolant.components.iter().find(crosses) {
        Some(part) if !interpolant.components.iter().any(from_here) => {
            let mut values = vec![0.0f32; part.channels()];
            for &w in wo {
                part.slice(w).eval(&[wi], &mut values);
                out.push(value(part, &values));
            }
        }
        _ => out.extend(wo.iter().map(|_| Xyz::ZERO)),
    }
}
