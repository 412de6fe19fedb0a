//! Fitted incidences and whole components in plain numbers, exact to the bit.

use bsdfkit::spectrum::{Bands, Basis};
use bsdfkit::{DVec2, DVec3, Error, Result, Side};
use serde::{Deserialize, Serialize};

use crate::interpolant::component::component::{Component, EnergyParts};
use crate::interpolant::{Fitted, FittedIncidence, Motion};
use crate::lobe::detail::Detail;
use crate::lobe::{Covariance, Lobe, LobeSet};
use bsdfkit_measure::{Mirror, Seen, Symmetry};

/// Floor, and mass, centre and covariance of each lobe.
type KeptLobes = (f64, Vec<[f64; 6]>);

fn lobes(of: &LobeSet) -> KeptLobes {
    let six = |l: &Lobe| {
        let c = l.covariance;
        [l.mass, l.mean.x, l.mean.y, c.xx, c.xy, c.yy]
    };
    (of.floor, of.lobes.iter().map(six).collect())
}

fn lobes_back((floor, lobes): KeptLobes) -> LobeSet {
    let lobe = |[mass, x, y, xx, xy, yy]: [f64; 6]| Lobe {
        mass,
        mean: DVec2::new(x, y),
        covariance: Covariance { xx, xy, yy },
    };
    LobeSet { floor, lobes: lobes.into_iter().map(lobe).collect() }
}

fn details(of: &[Detail]) -> Vec<Vec<f32>> {
    of.iter().map(|d| d.control().to_vec()).collect()
}

fn details_back(of: Vec<Vec<f32>>) -> Vec<Detail> {
    of.into_iter().map(|c| Detail::from_control(c).unwrap_or_else(Detail::none)).collect()
}

/// A fitted incidence, and its lobes before they were made symmetric.
#[derive(Serialize, Deserialize)]
pub(crate) struct KeptIncidence {
    wi: [f64; 3],
    lobes: KeptLobes,
    before: KeptLobes,
    details: Vec<Vec<f32>>,
    coefficients: Vec<Vec<f32>>,
    points: u64,
    /// Directional-hemispherical value, fit error, limit.
    figures: [f64; 3],
    seen: Vec<u8>,
}

impl KeptIncidence {
    pub(crate) fn of(i: &FittedIncidence, before: &LobeSet) -> Self {
        Self {
            wi: i.wi.to_array(),
            lobes: lobes(&i.lobes),
            before: lobes(before),
            details: details(&i.details),
            coefficients: details(&i.coefficients),
            points: i.points as u64,
            figures: [i.hemispherical, i.fit_error, i.limit],
            seen: i.seen.bytes().to_vec(),
        }
    }

    pub(crate) fn back(self) -> (FittedIncidence, LobeSet) {
        let [hemispherical, fit_error, limit] = self.figures;
        let incidence = FittedIncidence {
            wi: DVec3::from_array(self.wi),
            lobes: lobes_back(self.lobes),
            details: details_back(self.details),
            coefficients: details_back(self.coefficients),
            points: self.points as usize,
            hemispherical,
            fit_error,
            limit,
            seen: Seen::from_bytes(&self.seen).unwrap_or_else(Seen::whole),
        };
        (incidence, lobes_back(self.before))
    }
}

/// Wavelengths, offset, basis and its error.
type KeptSpectra = (Vec<f64>, Vec<f64>, Vec<Vec<f64>>, f64);

/// A component: all of which its mesh and plans follow.
#[derive(Serialize, Deserialize)]
pub(crate) struct KeptComponent {
    front: [bool; 2],
    symmetry: u8,
    motion: Motion,
    epsilon: f64,
    energy: EnergyParts,
    expected_error: Option<f64>,
    spectra: Option<KeptSpectra>,
    incidences: Vec<KeptIncidence>,
}

/// Numbered by their place.
const SYMMETRIES: [Symmetry; 6] = [
    Symmetry::Isotropic,
    Symmetry::Quadrilateral,
    Symmetry::Bilateral(Mirror::X),
    Symmetry::Bilateral(Mirror::Y),
    Symmetry::Rotational180,
    Symmetry::None,
];

impl KeptComponent {
    pub(crate) fn of(c: &Component) -> Self {
        let spectra = |s: &Basis| {
            let basis = s.rows().to_vec();
            (s.bands().nanometres().to_vec(), s.offset().to_vec(), basis, s.error())
        };
        let none = LobeSet { floor: 0.0, lobes: Vec::new() };
        Self {
            front: [c.incident(), c.scattered()].map(|side| side == Side::Front),
            symmetry: SYMMETRIES.iter().position(|s| *s == c.symmetry()).unwrap_or(5) as u8,
            motion: c.motion(),
            epsilon: c.fitted().epsilon,
            energy: c.energy().parts(),
            expected_error: c.expected_error,
            spectra: c.spectra().map(spectra),
            incidences: c.incidences().iter().map(|i| KeptIncidence::of(i, &none)).collect(),
        }
    }

    /// Errors: format, where it cannot have been kept by this library.
    pub(crate) fn back(self) -> Result<Component> {
        let damaged = || Error::format("cache: expected a component, found other numbers");
        let [incident, scattered] =
            self.front.map(|front| if front { Side::Front } else { Side::Back });
        let symmetry = *SYMMETRIES.get(usize::from(self.symmetry)).ok_or_else(damaged)?;
        let spectra = match self.spectra {
            None => None,
            Some((bands, offset, basis, error)) => {
                let spectra = Basis::new(Bands::new(bands)?, offset, basis, error);
                Some(spectra.ok_or_else(damaged)?.into())
            }
        };
        let incidences = self.incidences.into_iter().map(|i| i.back().0).collect();
        let epsilon = self.epsilon;
        let fitted = Fitted { incident, scattered, symmetry, epsilon, spectra, incidences };
        let mut component = Component::restored(fitted, self.motion, &self.energy)?;
        component.expected_error = self.expected_error;
        Ok(component)
    }
}
