//! One moving lobe of a cell: which lobes it is at the corners, how heavy it is between, and where.

use bsdfkit::DVec2;

use super::carried::Carried;
use super::moved::Moved;
use super::row::Row;
use crate::lobe::{Covariance, Lobe, LobeSet};

/// The lobes of the corners that are one moving lobe. `None`: it is missing at that corner; it fades
/// or is cut off toward it, where the other corners take it.
pub(super) type Partners = [Option<u16>; 3];

/// One moving lobe of a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mover {
    pub(super) partners: Partners,
    /// mass(λ) = Σ_v Σ_w λ_v λ_w rows[v].masses[w], but for cuts.
    pub(super) rows: Rows,
}

/// What the gluings at the three corners say of one moving lobe.
pub(super) type Rows = [Row; 3];

/// How lobes of the corners come here that follow a facet.
type Ways = [Option<Carried>; 3];

impl Mover {
    /// The mass at `lambda`, and what it were without cuts. A lobe that is missing at some of the
    /// corners fades toward them, or is cut off on the way there. `way` as in [`Movers::at`].
    ///
    /// [`Movers::at`]: super::displace::Movers::at
    pub(super) fn mass(&self, lambda: [f64; 3], way: &dyn Fn(usize, usize) -> f64) -> (f64, f64) {
        // Past the rim: the mean of the corners that have the lobe.
        let shares = self.shares(lambda);
        let past = |v: usize| {
            let lobe = self.partners[v].filter(|_| shares[v] > 0.0);
            lobe.map_or(0.0, |lobe| shares[v] * way(v, lobe as usize))
        };
        let past = (0..3).map(past).sum();
        let (mut mass, mut uncut) = (0.0, 0.0);
        for (row, l) in self.rows.iter().zip(lambda) {
            let sum: f64 = row.masses.iter().zip(lambda).map(|(m, l)| l * m).sum();
            uncut += l * sum;
            mass += l * sum * row.kept(lambda, past);
        }
        (mass, uncut)
    }

    /// The mass at `lambda` of a lobe that follows a facet at each corner that has it, and what it does
    /// on the way from there; `None` for other lobes. `carried` as in [`Movers::at`].
    ///
    /// [`Movers::at`]: super::displace::Movers::at
    pub(super) fn carried(
        &self,
        lambda: [f64; 3],
        carried: &dyn Fn(usize, usize) -> Option<Carried>,
    ) -> Option<(f64, Ways)> {
        let mut ways = [None; 3];
        let (mut here, mut there) = (0.0, 0.0);
        for v in (0..3).filter(|&v| lambda[v] > 0.0) {
            if let Some(lobe) = self.partners[v] {
                let way = carried(v, lobe as usize)?;
                // Of corners where little is left, which says little, little is made.
                here += lambda[v] * way.energies[0];
                there = way.energies[1];
                ways[v] = Some(way);
            }
        }
        let of_row = |row: &Row| -> f64 {
            let present = (0..3).filter(|&v| ways[v].is_some());
            present.map(|v| lambda[v] * row.masses[v]).sum()
        };
        let mass: f64 = self.rows.iter().zip(lambda).map(|(row, l)| l * of_row(row)).sum();
        (here > 0.0).then(|| (mass * there / here, ways))
    }

    /// `lambda` of the corners that have the lobe, made to sum to 1.
    fn shares(&self, lambda: [f64; 3]) -> [f64; 3] {
        let present = |v: usize| if self.partners[v].is_some() { lambda[v] } else { 0.0 };
        let shares = [0, 1, 2].map(present);
        let all: f64 = shares.iter().sum();
        shares.map(|share| if all > 0.0 { share / all } else { 0.0 })
    }

    /// The lobe at `lambda`: between those of the corners that have it, as facets carry them (`ways`)
    /// or along their tracks. `bend` as in [`Movers::at`].
    ///
    /// [`Movers::at`]: super::displace::Movers::at
    pub(super) fn moved(
        &self,
        (mass, ways): (f64, Ways),
        corners: [&LobeSet; 3],
        lambda: [f64; 3],
        bend: &dyn Fn(usize, usize) -> DVec2,
    ) -> Moved {
        // Corners where a facet lets little through say little of its peak.
        let weight = |v: usize| lambda[v] * ways[v].map_or(1.0, |way: Carried| way.energies[0]);
        let shares = self.shares([0, 1, 2].map(weight));
        let at = [0, 1, 2].map(|v| self.partners[v].map(|i| corners[v].lobes[i as usize]));
        let (mut mean, mut curve) = (DVec2::ZERO, DVec2::ZERO);
        let mut parts = [(0.0, Covariance::isotropic(1.0)); 3];
        for v in (0..3).filter(|&v| shares[v] > 0.0) {
            if let (Some(index), Some(lobe)) = (self.partners[v], at[v]) {
                let here = ways[v].map_or(lobe, |way| way.lobe(lobe));
                mean += shares[v] * here.mean;
                if ways[v].is_none() {
                    curve += 0.5 * lambda[v] * bend(v, index as usize);
                }
                parts[v] = (shares[v], here.covariance);
            }
        }
        let covariance = Covariance::barycentre(&parts);
        // What the incidence of a corner without it says is taken from where it fades.
        let still = (mean, Covariance::isotropic(1.0));
        let back = |lobe: Lobe| (lobe.mean, covariance.transport_to(lobe.covariance));
        let mean = mean + curve;
        Moved {
            lobe: Lobe { mass, mean, covariance },
            precision: covariance.inverse(),
            peak: mass / (std::f64::consts::TAU * covariance.determinant().sqrt()),
            maps: at.map(|lobe| lobe.map_or(still, back)),
            shares: if ways.iter().any(Option::is_some) { shares } else { lambda },
        }
    }
}
