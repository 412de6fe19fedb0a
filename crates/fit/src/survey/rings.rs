//! Rings of incident directions about the normal, laid out before anything is known of a specimen.

use bsdfkit::DVec3;
use bsdfkit_sphere::direction::from_degrees;

use super::limits::Limits;
use bsdfkit_measure::Symmetry;

/// How rings are laid out under a symmetry.
struct Proportions {
    /// Polar angles grow with the number of the ring to this power: below 1 rings are denser toward
    /// grazing.
    power: f64,
    /// Azimuths around the circle for each ring.
    aspect: f64,
    /// From this polar angle on, rings have as many azimuths as the outermost; those within, fewer
    /// in proportion to their circle.
    full_degrees: f64,
    /// Fewer directions do better where holes are widest, on no rings.
    fewest: usize,
}

/// Found on virtual materials with two sets of parameters each: powers of 0.7 to 1.1, 2.2 to 3.3
/// azimuths (with two mirrors, where steps are halved, not rounded, 0.6 to 2.5: many rings of few
/// azimuths), 30 to 75 degrees.
const fn proportions(symmetry: Symmetry) -> Proportions {
    match symmetry {
        Symmetry::Quadrilateral => {
            Proportions { power: 0.95, aspect: 0.9, full_degrees: 60.0, fewest: 4 }
        }
        _ => Proportions { power: 0.8, aspect: 2.7, full_degrees: 45.0, fewest: 9 },
    }
}

/// Steps are sought so closely.
const SETTLED: f64 = 1e-3;
/// How much a direction left over counts beside azimuths too many or too few.
const LEFT_OVER: f64 = 2.0;

/// The last ring, or the end of a chain, is so many steps within the limit: past it scattering goes
/// on changing, and all others lie closer together. Of 0, 0.25 and 0.4 (notebook: fewer
/// measurements).
const LAST_STEP: f64 = 0.25;

/// On a chain, polar angles grow with the number of the incidence to this power, the first of them
/// [`FIRST_STEP`] from the normal, which lies midway between it and its image.
const CHAIN_POWER: f64 = 0.55;
/// That way, in steps. Of 0.5 to 0.8, with powers of 0.5 to 0.6.
const FIRST_STEP: f64 = 0.7;
/// The first is no farther from the normal than this, where few leave a hole across it wider than
/// all others. Four of a rough dielectric err 5 to 7 % less so than with the first at 30 degrees;
/// of 22 to 30.
const FIRST_DEGREES: f64 = 26.0;

/// Rings about the normal, the outermost [`LAST_STEP`] within the limit.
#[derive(Clone, Copy, Debug)]
struct Rings {
    symmetry: Symmetry,
    max_theta_degrees: f64,
    rings: usize,
    /// Steps of azimuth of the outermost in the part of the circle that the symmetry leaves, before
    /// every ring rounds its own: so nearly every budget is used up.
    steps: f64,
}

/// A ring: its azimuths are `first` + k / `count` turns, k = 0 … `count` − 1.
struct Ring {
    theta_degrees: f64,
    first: f64,
    count: usize,
    /// Of these, how many no symmetry makes images of others.
    distinct: usize,
}

impl Rings {
    fn ring(&self, number: usize) -> Ring {
        let Proportions { power, full_degrees: full, .. } = proportions(self.symmetry);
        let theta_degrees =
            self.max_theta_degrees * (number as f64 / (self.rings as f64 + LAST_STEP)).powf(power);
        let circle = theta_degrees.min(full).to_radians().sin()
            / self.max_theta_degrees.min(full).to_radians().sin();
        let (images, least) = match self.symmetry {
            Symmetry::None => (1, 3),
            Symmetry::Rotational180 => (2, 2),
            other => (other.images().len(), 1),
        };
        let steps = match self.symmetry {
            // Turned by half a step a ring must have its neighbours' steps, twice or half of them.
            Symmetry::Quadrilateral => {
                let outermost = self.steps.max(1.0).log2().floor().exp2();
                ((outermost * circle).ceil() as usize).next_power_of_two()
            }
            _ => ((self.steps * circle).round() as usize).max(least),
        };
        let turned = (self.rings - number) % 2 == 1;
        let count = images * steps;
        let first = if turned { 0.5 / count as f64 } else { 0.0 };
        let on_both_mirrors = self.symmetry == Symmetry::Quadrilateral && !turned;
        let distinct = steps + usize::from(on_both_mirrors);
        Ring { theta_degrees, first, count, distinct }
    }

    /// The normal, and of every ring the directions that no symmetry makes images of others.
    fn directions(&self) -> Vec<DVec3> {
        let mut all = vec![DVec3::Z];
        for number in 1..=self.rings {
            let ring = self.ring(number);
            let mut folded: Vec<DVec3> = Vec::new();
            for k in 0..ring.count {
                let turns = ring.first + k as f64 / ring.count as f64;
                let wi = self.symmetry.fold(from_degrees(ring.theta_degrees, 360.0 * turns)).0;
                let images = self.symmetry.images();
                let alike = |v: &DVec3| images.iter().any(|i| i.apply(*v).distance(wi) < 1e-9);
                if !folded.iter().any(alike) {
                    folded.push(wi);
                }
            }
            all.extend(folded);
        }
        all
    }

    /// How many these are.
    fn count(&self) -> usize {
        1 + (1..=self.rings).map(|number| self.ring(number).distinct).sum::<usize>()
    }

    /// Whether no two directions are nearer than the limits allow.
    fn apart(&self, limits: &Limits) -> bool {
        (1..=self.rings).all(|number| {
            let ring = self.ring(number);
            let inner = if number == 1 { 0.0 } else { self.ring(number - 1).theta_degrees };
            let half = std::f64::consts::PI / ring.count as f64;
            let chord = 2.0 * ring.theta_degrees.to_radians().sin() * half.sin();
            ring.theta_degrees - inner >= limits.spacing_degrees && chord >= limits.spacing()
        })
    }
}

/// Up to `budget` directions on rings, the normal first; none where that is too few.
pub(super) fn rings(symmetry: Symmetry, limits: &Limits, budget: usize) -> Vec<DVec3> {
    let Proportions { fewest, aspect, .. } = proportions(symmetry);
    if budget < fewest {
        return Vec::new();
    }
    let max_theta_degrees = limits.max_theta_degrees;
    let of = |rings, steps| Rings { symmetry, max_theta_degrees, rings, steps };
    let fits = |r: &Rings| r.count() <= budget && r.apart(limits);
    let most = (1..).take_while(|&rings| fits(&of(rings, 0.0))).last().unwrap_or(0);
    let fullest = (1..=most).map(|rings| {
        let (mut fit, mut over) = (0.0, budget as f64 + 1.0);
        while over - fit > SETTLED {
            let steps = 0.5 * (fit + over);
            *if fits(&of(rings, steps)) { &mut fit } else { &mut over } = steps;
        }
        of(rings, fit)
    });
    let badness = |r: &Rings| {
        let azimuths = r.ring(r.rings).count as f64;
        let off = (azimuths / (aspect * r.rings as f64)).ln().abs();
        off + LEFT_OVER * (budget as f64 / r.count() as f64).ln()
    };
    let best = fullest.min_by(|a, b| badness(a).total_cmp(&badness(b)));
    best.map_or_else(Vec::new, |r| r.directions())
}

/// Up to `budget` directions of an isotropic specimen, from the normal outward.
pub(super) fn chain(limits: &Limits, budget: usize) -> Vec<DVec3> {
    let at = |k: usize, count: usize| {
        let steps = FIRST_STEP + count as f64 - 1.0 + LAST_STEP;
        let share = |k: usize| (k as f64 + FIRST_STEP) / steps;
        let power = (FIRST_DEGREES / limits.max_theta_degrees).ln() / share(0).ln();
        limits.max_theta_degrees * share(k).powf(CHAIN_POWER.max(power))
    };
    let apart = |count: usize| {
        let nearest = (1..count).map(|k| at(k, count) - at(k - 1, count)).fold(f64::MAX, f64::min);
        nearest.min(2.0 * at(0, count)) >= limits.spacing_degrees
    };
    let count = (1..=budget).take_while(|&count| apart(count)).last().unwrap_or(0);
    (0..count).map(|k| from_degrees(at(k, count), 0.0)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use bsdfkit_sphere::direction::to_degrees;

    const LIMITS: Limits = Limits { max_theta_degrees: 75.0, spacing_degrees: 4.0 };
    const ALL: [Symmetry; 3] = [Symmetry::Quadrilateral, Symmetry::None, Symmetry::Rotational180];

    #[test]
    fn directions_are_as_many_as_counted_and_apart() {
        for symmetry in ALL {
            for (rings, steps) in [(1, 1.0), (2, 3.4), (4, 4.0), (5, 9.5)] {
                let r = Rings { symmetry, max_theta_degrees: 75.0, rings, steps };
                assert_eq!(r.directions().len(), r.count(), "{r:?}");
            }
            for budget in 0..80 {
                let all = rings(symmetry, &LIMITS, budget);
                assert!(all.len() <= budget, "{symmetry} {budget}: {}", all.len());
                for (n, w) in all.iter().enumerate() {
                    assert!(symmetry.fold(*w).0.distance(*w) < 1e-9, "{symmetry} {w}");
                    for image in symmetry.images() {
                        let apart = |v: &DVec3| image.apply(*w).angle_between(*v).to_degrees();
                        let own = apart(w);
                        assert!(!(1e-5..=3.99).contains(&own), "{symmetry} {budget} {w}: {own}");
                        assert!(
                            all[..n].iter().all(|v| apart(v) > 3.99),
                            "{symmetry} {budget} {w}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn few_of_a_budget_are_left_over() {
        for symmetry in ALL {
            // Where steps are doubled a few directions do not make a ring.
            let (budgets, part) = match symmetry {
                Symmetry::Quadrilateral => (4..60, 6),
                _ => (20..200, 24),
            };
            for budget in budgets {
                let left = budget - rings(symmetry, &LIMITS, budget).len();
                assert!(left <= 3.max(budget / part), "{symmetry} {budget}: {left} left");
            }
        }
    }

    #[test]
    fn with_two_mirrors_every_other_ring_is_off_them() {
        let all = rings(Symmetry::Quadrilateral, &LIMITS, 13);
        let angles: Vec<(i32, i32)> = all
            .into_iter()
            .map(to_degrees)
            .map(|(t, p)| (t.round() as i32, (10.0 * p).round() as i32))
            .collect();
        let [few, off, on] = [vec![0, 900], vec![225, 675], vec![0, 450, 900]];
        for (ring, azimuths) in [(16, &few), (30, &off), (44, &on), (58, &off), (72, &on)] {
            let mut found: Vec<i32> = angles.iter().filter(|a| a.0 == ring).map(|a| a.1).collect();
            found.sort_unstable();
            assert_eq!(&found, azimuths, "{ring}: {angles:?}");
        }
    }

    #[test]
    fn a_chain_ends_near_the_limit_and_crosses_the_normal() {
        let thetas: Vec<f64> = chain(&LIMITS, 6).into_iter().map(|w| to_degrees(w).0).collect();
        assert_eq!(thetas.len(), 6);
        let past = (75.0 - thetas[5]) / (thetas[5] - thetas[4]);
        assert!((past - LAST_STEP).abs() < 0.03 && thetas[0] > 10.0, "{past} {thetas:?}");
        let first = |count: usize| to_degrees(chain(&LIMITS, count)[0]).0;
        assert!([1, 2, 3].into_iter().all(|n| (first(n) - 26.0).abs() < 1e-9), "{}", first(3));
        assert!(first(8) < 22.0, "{}", first(8));
        let near = Limits { max_theta_degrees: 20.0, ..LIMITS };
        assert!(chain(&near, 3).into_iter().all(|w| to_degrees(w).0 < 20.0 + 1e-9));
        assert!(chain(&LIMITS, 1000).len() < 20);
        assert!(chain(&LIMITS, 0).is_empty());
    }
}
