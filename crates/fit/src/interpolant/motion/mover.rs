//! One moving lobe of a cell: which lobes it is at the corners, how heavy it is between, and where.

use bsdfkit::DVec2;
use bsdfkit_sphere::widest::{Loop, widest};

use crate::interpolant::motion::moved::{CUT, Moved};
use crate::lobe::barycentre::{Barycentres, Each};
use crate::lobe::{Covariance, Lobe, LobeSet};

/// The lobes of the corners that are one moving lobe. `None`: it is missing at that corner; it fades
/// toward it, where the other corners take it.
pub(crate) type Partners = [Option<u16>; 3];

/// One moving lobe of a cell.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mover {
    pub(crate) partners: Partners,
    /// mass(λ) = Σ_v Σ_w λ_v λ_w rows[v][w].
    pub(crate) rows: Rows,
}

/// The masses at the corners, by the gluing at each of them.
pub(crate) type Rows = [[f64; 3]; 3];

impl Mover {
    /// The mass at `lambda`. A lobe that is missing at some of the corners fades toward them.
    #[inline(always)]
    pub(crate) fn mass(&self, [a, b, c]: [f64; 3]) -> f64 {
        let of = |[x, y, z]: [f64; 3]| a * x + b * y + c * z;
        let [x, y, z] = self.rows;
        a * of(x) + b * of(y) + c * of(z)
    }

    /// `lambda` of the corners that have the lobe, made to sum to 1.
    #[inline(always)]
    fn shares(&self, lambda: [f64; 3]) -> [f64; 3] {
        let present = |v: usize| if self.partners[v].is_some() { lambda[v] } else { 0.0 };
        let [a, b, c] = [present(0), present(1), present(2)];
        let all = a + b + c;
        if all > 0.0 { [a / all, b / all, c / all] } else { [0.0; 3] }
    }

    /// The way of the lobe at `lambda`: along the tracks of those of the corners that have it. `None` where it has no mass, or
    /// is surely not seen at `near`. `bend` as in [`Movers::at`].
    ///
    /// [`Movers::at`]: crate::interpolant::motion::cell_movers::Movers::at
    #[inline(always)]
    pub(crate) fn way(
        &self,
        corners: [&LobeSet; 3],
        lambda: [f64; 3],
        bend: &impl Fn(usize, usize) -> DVec2,
        near: Option<DVec2>,
    ) -> Option<Way> {
        let shares = self.shares(lambda);
        let (mut still, mut curve) = (DVec2::ZERO, DVec2::ZERO);
        let mut wide = Covariance { xx: 0.0, xy: 0.0, yy: 0.0 };
        for v in 0..3 {
            if let (Some(index), true) = (self.partners[v], shares[v] > 0.0) {
                let lobe = &corners[v].lobes[index as usize];
                still += shares[v] * lobe.mean;
                curve += 0.5 * lambda[v] * bend(v, index as usize);
                wide = Covariance::combine(1.0, wide, shares[v], lobe.covariance);
            }
        }
        let mean = still + curve;
        if near.is_some_and(|q| !wide.reaches(q - mean)) {
            return None;
        }
        let mass = self.mass(lambda);
        if mass <= 0.0 || shares == [0.0; 3] {
            return None;
        }
        // One corner's lobe is its own matter; of partners all corners have a say.
        let alone = self.partners.iter().flatten().count() == 1;
        let say = if alone { shares } else { lambda };
        let end = |v: usize| {
            let lobe = &corners[v].lobes[self.partners[v]? as usize];
            Some((lobe.mean, lobe.covariance))
        };
        Some(Way { mass, mean, still, shares, ends: [end(0), end(1), end(2)], say })
    }
}

impl Covariance {
    /// Whether a lobe of this shape, or of one that is nowhere wider, may be seen `d` from its centre.
    ///
    /// A barycentre is nowhere wider than the mean of its matrices: lobes that do not reach as that are not looked at, and what
    /// is, is to the last bit as it would be among all.
    #[inline(always)]
    pub(crate) fn reaches(self, d: DVec2) -> bool {
        let off = self.yy * d.x * d.x - 2.0 * self.xy * d.x * d.y + self.xx * d.y * d.y;
        off < SURELY * CUT * self.determinant()
    }
}

/// Room for rounding.
const SURELY: f64 = 1.0 + 1e-6;

/// A moving lobe at a place of its cell, but for its shape, which costs most.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Way {
    mass: f64,
    mean: DVec2,
    /// The mean without what tracks bend.
    still: DVec2,
    shares: [f64; 3],
    /// Centre and shape at the corners that have it.
    ends: [Option<(DVec2, Covariance)>; 3],
    /// [`Moved::shares`].
    say: [f64; 3],
}

impl Way {
    /// The lobes with their shapes.
    pub(crate) fn moved(ways: &[Self]) -> Vec<Moved> {
        let mut moved = Vec::with_capacity(ways.len());
        widest(Shapes { ways, moved: &mut moved });
        moved
    }
}

/// Lobes whose shapes are found side by side.
const LANES: usize = 8;

/// Finds the shapes of many.
struct Shapes<'a> {
    ways: &'a [Way],
    moved: &'a mut Vec<Moved>,
}

impl Loop for Shapes<'_> {
    #[inline(always)]
    fn run(self) {
        let absent = Covariance::isotropic(1.0);
        for ways in self.ways.chunks(LANES) {
            let (mut weights, mut parts) = ([[0.0; LANES]; 3], [[[1.0; LANES]; 3]; 3]);
            for (k, way) in ways.iter().enumerate() {
                for v in 0..3 {
                    let c = way.ends[v].map_or(absent, |end| end.1);
                    weights[v][k] = way.shares[v];
                    (parts[v][0][k], parts[v][1][k], parts[v][2][k]) = (c.xx, c.xy, c.yy);
                }
            }
            let all = Barycentres::of(&weights, &parts);
            for (k, way) in ways.iter().enumerate() {
                let of = |each: &Each<LANES>| Covariance {
                    xx: each[0][k],
                    xy: each[1][k],
                    yy: each[2][k],
                };
                let lobe = Lobe { mass: way.mass, mean: way.mean, covariance: of(&all.covariance) };
                // What the incidence of a corner without it says is taken from where it fades.
                let back = |v: usize| match way.ends[v] {
                    Some((mean, _)) => (mean, of(&all.maps[v])),
                    None => (way.still, absent),
                };
                self.moved.push(Moved::new(lobe, [0, 1, 2].map(back), way.say));
            }
        }
    }
}
