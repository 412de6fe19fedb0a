//! Measurements that show little of what a specimen scatters: said wherever they are used, refused where nothing can be made of them.

use bsdfkit::{Error, Result};
use bsdfkit_sphere::direction::to_degrees;
use rayon::prelude::*;

use super::pattern::{FEWEST, Pattern, distinct};
use super::seen::{Seen, limit, specular};
use super::{Incidence, Measurement, Symmetry};

/// What one incidence shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sight {
    /// Where its points lie.
    pub pattern: Pattern,
    /// Share of the projected hemisphere that lies between them, and their images under the specimen's symmetry.
    pub share: f64,
    /// Whether the specular direction does.
    pub specular: bool,
}

impl Sight {
    /// Whether what it does not show is too much for a total; see [`Seen::tells`].
    pub fn is_scant(&self) -> bool {
        !self.specular || self.share < Seen::ENOUGH
    }

    /// That of `incidence`, whose points and images show `seen`.
    pub(super) fn of(incidence: &Incidence, symmetry: Symmetry) -> (Self, Seen) {
        let all = incidence.with_images(symmetry);
        let seen = Seen::of(&all);
        let alone = all.wo.len() == incidence.wo.len();
        let own = if alone { seen.clone() } else { Seen::of(incidence) };
        let (pattern, share) = (Pattern::of(incidence, &own), seen.share(limit(&all.wo)));
        let specular = seen.holds(specular(incidence));
        (Self { pattern, share, specular }, seen)
    }
}

impl Measurement {
    /// What each incidence shows, in their order. Cost: some milliseconds each, on all threads.
    pub fn sights(&self) -> Vec<Sight> {
        self.incidences.par_iter().map(|i| Sight::of(i, self.symmetry).0).collect()
    }

    /// Errors: format, where the points of an incidence are too few for any lobe.
    pub fn expect_enough(&self) -> Result<()> {
        let few = |k: &usize| distinct(&self.incidences[*k].wo) < FEWEST;
        let few: Vec<usize> = (0..self.incidences.len()).filter(few).collect();
        let Some(&first) = few.first() else { return Ok(()) };
        let (theta, phi) = to_degrees(self.incidences[first].wi);
        let message = format!(
            "incidence theta {theta:.1} phi {phi:.1}: expected points in at least {FEWEST} scattered directions, found \
             {}, and too few at {} of {} incidences, which do not tell what is scattered elsewhere: measure a plane or \
             the hemisphere at each incidence, or leave these incidences out",
            Pattern::of(&self.incidences[first], &Seen::whole()),
            few.len(),
            self.incidences.len()
        );
        let error = Error::format(message);
        Err(match self.incidences[first].files.first() {
            Some(file) => error.context(file.display()),
            None => error,
        })
    }
}

/// What `sights` show too little of, a sentence for each arrangement of points; empty where nothing is scant.
pub fn scant(sights: &[Sight]) -> Vec<String> {
    let mut kinds: Vec<Vec<&Sight>> = Vec::new();
    for sight in sights {
        match kinds.iter_mut().find(|k| k[0].pattern.kind() == sight.pattern.kind()) {
            Some(kind) => kind.push(sight),
            None => kinds.push(vec![sight]),
        }
    }
    kinds.iter().filter_map(|kind| sentence(kind, sights.len())).collect()
}

/// Of sights of one kind; `None` where all show enough.
fn sentence(kind: &[&Sight], all: usize) -> Option<String> {
    let short: Vec<&&Sight> = kind.iter().filter(|s| s.is_scant()).collect();
    let first = short.first()?;
    let shares = || short.iter().map(|s| 100.0 * s.share);
    let (least, most) = (shares().fold(100.0, f64::min), shares().fold(0.0, f64::max));
    let percent = if most - least < 1.0 {
        format!("{least:.0} %")
    } else {
        format!("{least:.0} to {most:.0} %")
    };
    let alike = if kind.iter().all(|s| s.pattern == kind[0].pattern) { "" } else { " and alike" };
    let at = match kind.len() - short.len() {
        0 => String::new(),
        n => format!(" at {}, all of it through the specimen's symmetry at {n}", short.len()),
    };
    let hidden = match short.iter().filter(|s| !s.specular).count() {
        0 => String::new(),
        n => format!(", not the specular direction at {n}"),
    };
    Some(format!(
        "only {}{alike} measured at {} of {all} incidences: {percent} of the projected hemisphere seen{at}{hidden}; values \
         elsewhere and totals are extrapolated",
        first.pattern,
        kind.len()
    ))
}
