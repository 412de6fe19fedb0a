//! What families of lobes add to the scattering of one incident direction.

use bsdfkit::DVec2;

use crate::interpolant::answer::distribution::{Corner, Distribution, details, with_room};
use crate::interpolant::answer::lobe_on_disk::Bow;
use crate::interpolant::facet::refracted_lobe::visible;
use crate::interpolant::family::assign::turned;
use crate::interpolant::family::carried::{Law, Standing, value};
use crate::interpolant::incidence::spectra::MOST_DETAILS;

/// What is darker than this, in 1/sr, is not looked up.
const DARK: f64 = 1e-9;

impl Distribution<'_> {
    /// Each corner, law and lobes that follow it there, with the number of the corner and its weight.
    fn carried(&self) -> impl Iterator<Item = (usize, &Corner<'_>, &Law<'_>, &Vec<Standing>)> {
        let present = self.corners.iter().enumerate().filter(|(_, c)| c.weight > 0.0);
        present.flat_map(|(c, corner)| {
            let of = self.laws.iter().zip(corner.families);
            of.map(move |(law, lobes)| (c, corner, law, lobes))
        })
    }

    /// The lobes of families on the disk, but for those of less than `least` mass.
    pub(super) fn carried_bows(&self, least: f64) -> Vec<Bow> {
        let mut bows = Vec::new();
        for (c, corner, law, lobes) in self.carried() {
            let place = |q: DVec2| {
                let (v, z) = corner.frame.inverse(q);
                if z > 0.0 { law.to(c, v) } else { None }
            };
            let lobes = lobes.iter().map(|standing| &standing.lobe);
            let bright = lobes.filter(|lobe| corner.weight * lobe.mass > least);
            bows.extend(bright.filter_map(|lobe| Bow::of(lobe, &place)));
        }
        bows
    }

    /// The share of the lobes and the floor that is above the horizon.
    pub(crate) fn visible_share(&self) -> f64 {
        let (above, all) = self.visible_mass();
        if all > 0.0 { (above / all).clamp(1e-3, 1.0) } else { 1.0 }
    }

    /// About the energy of the lobes and the floor above the horizon, and on both sides of it.
    pub(crate) fn visible_mass(&self) -> (f64, f64) {
        let floor = std::f64::consts::PI * self.floor;
        let (mut above, mut all) = (floor, floor);
        for m in &self.moved {
            above += m.lobe.mass * visible(&m.lobe, &self.frame);
            all += m.lobe.mass;
        }
        for (c, corner, law, lobes) in self.carried() {
            let weight = law.per_seen * corner.weight;
            for Standing { lobe, .. } in lobes {
                all += weight * lobe.mass;
                let there = turned(lobe, corner.frame, law.there[c]);
                above += there.map_or(0.0, |l| weight * lobe.mass * visible(&l, &law.here));
            }
        }
        (above, all)
    }

    /// Adds what families scatter at disk coordinates `u`, all channels.
    #[inline(always)]
    pub(super) fn add_families<const N: usize>(&self, u: &[DVec2; N], out: &mut [f64]) {
        let channels = out.len() / N;
        for (number, law) in self.laws.iter().enumerate() {
            for (u, out) in u.iter().zip(out.chunks_exact_mut(channels)) {
                let mut parts = [(0.0, DVec2::ZERO); 3];
                for (c, corner) in self.corners.iter().enumerate() {
                    if corner.weight <= 0.0 {
                        continue;
                    }
                    let lobes = &corner.families[number];
                    if lobes.is_empty() {
                        continue;
                    }
                    if let Some((v, brighter)) = law.from(c, *u) {
                        parts[c] = (
                            law.per_seen * corner.weight * brighter * value(lobes, corner.frame, v),
                            v,
                        );
                    }
                }
                for ((part, v), corner) in parts.into_iter().zip(&self.corners) {
                    if part > DARK {
                        let v = corner.back.apply(v.extend(0.0)).truncate();
                        let mut told = [0.0; MOST_DETAILS];
                        let details = details(corner.incidence, channels);
                        told.iter_mut().zip(details).for_each(|(told, d)| *told = d.log_at(v));
                        with_room(channels, |logs| {
                            self.logarithms(|detail| told[detail], logs);
                            out.iter_mut()
                                .zip(logs)
                                .for_each(|(out, log)| *out += part * log.exp());
                        });
                    }
                }
            }
        }
    }
}
