//! One moving lobe of a cell: which lobes it is at the corners, how heavy it is between, and where.

use bsdfkit::DVec2;

use crate::interpolant::motion::moved::Moved;
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
    pub(crate) fn mass(&self, lambda: [f64; 3]) -> f64 {
        let of = |row: &[f64; 3]| row.iter().zip(lambda).map(|(m, l)| l * m).sum::<f64>();
        self.rows.iter().zip(lambda).map(|(row, l)| l * of(row)).sum()
    }

    /// `lambda` of the corners that have the lobe, made to sum to 1.
    fn shares(&self, lambda: [f64; 3]) -> [f64; 3] {
        let present = |v: usize| if self.partners[v].is_some() { lambda[v] } else { 0.0 };
        let shares = [0, 1, 2].map(present);
        let all: f64 = shares.iter().sum();
        shares.map(|share| if all > 0.0 { share / all } else { 0.0 })
    }

    /// The lobe at `lambda`, of this mass: between those of the corners that have it, along their tracks. `bend` as in
    /// [`Movers::at`].
    ///
    /// [`Movers::at`]: crate::interpolant::motion::cell_movers::Movers::at
    pub(crate) fn moved(
        &self,
        mass: f64,
        corners: [&LobeSet; 3],
        lambda: [f64; 3],
        bend: &dyn Fn(usize, usize) -> DVec2,
    ) -> Moved {
        let shares = self.shares(lambda);
        let at = [0, 1, 2].map(|v| self.partners[v].map(|i| corners[v].lobes[i as usize]));
        let (mut mean, mut curve) = (DVec2::ZERO, DVec2::ZERO);
        let mut parts = [(0.0, Covariance::isotropic(1.0)); 3];
        for v in (0..3).filter(|&v| shares[v] > 0.0) {
            if let (Some(index), Some(lobe)) = (self.partners[v], at[v]) {
                mean += shares[v] * lobe.mean;
                curve += 0.5 * lambda[v] * bend(v, index as usize);
                parts[v] = (shares[v], lobe.covariance);
            }
        }
        let covariance = Covariance::barycentre(&parts);
        // What the incidence of a corner without it says is taken from where it fades.
        let still = (mean, Covariance::isotropic(1.0));
        let back = |lobe: Lobe| (lobe.mean, covariance.transport_to(lobe.covariance));
        let mean = mean + curve;
        let maps = at.map(|lobe| lobe.map_or(still, back));
        // One corner's lobe is its own matter; of partners all corners have a say.
        let alone = self.partners.iter().flatten().count() == 1;
        Moved::new(Lobe { mass, mean, covariance }, maps, if alone { shares } else { lambda })
    }
}
