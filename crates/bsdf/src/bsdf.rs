//! The BSDF: Lambertian parts, components, metadata.

use std::f64::consts::PI;

use crate::band::Band;
use crate::colour::Xyz;
use crate::component::Component;
use crate::metadata::Metadata;
use crate::specular::Specular;
use crate::{Lookup, Result, Side};

/// The four Lambertian fields, dimensionless (reflectance or transmittance), by incident side.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lambertian {
    /// Reflectance of the front.
    pub reflection_front: Xyz,
    /// Reflectance of the back.
    pub reflection_back: Xyz,
    /// Transmittance from the front to the back.
    pub transmission_front: Xyz,
    /// Transmittance from the back to the front.
    pub transmission_back: Xyz,
}

impl Lambertian {
    /// The field for light incident on `incident` and scattered to `scattered`.
    pub fn get(&self, incident: Side, scattered: Side) -> Xyz {
        match (incident, scattered) {
            (Side::Front, Side::Front) => self.reflection_front,
            (Side::Back, Side::Back) => self.reflection_back,
            (Side::Front, Side::Back) => self.transmission_front,
            (Side::Back, Side::Front) => self.transmission_back,
        }
    }

    /// The same field, to write.
    pub fn get_mut(&mut self, incident: Side, scattered: Side) -> &mut Xyz {
        match (incident, scattered) {
            (Side::Front, Side::Front) => &mut self.reflection_front,
            (Side::Back, Side::Back) => &mut self.reflection_back,
            (Side::Front, Side::Back) => &mut self.transmission_front,
            (Side::Back, Side::Front) => &mut self.transmission_back,
        }
    }
}

/// A BSDF: immutable after construction, shared by any number of threads.
///
/// Its queries are the five verbs of [`query`](crate::query).
#[derive(Clone, Debug)]
pub struct Bsdf {
    metadata: Metadata,
    components: Vec<Component>,
    explicit: Lambertian,
    lambertian: Lambertian,
    /// Whether transmission from the front, from the back is answered in reverse.
    reversed: [bool; 2],
    /// Whether any component prepares for an incident direction.
    prepares: bool,
    /// Whether any component draws samples with another density than f.
    varies: bool,
    bands: Vec<Band>,
    specular: Vec<Specular>,
    /// Whether peaks that cross the surface from the front, from the back are answered in reverse.
    specular_reversed: [bool; 2],
}

impl Bsdf {
    /// A BSDF of stored components, plus Lambertian parts that no component contains.
    ///
    /// The constant part of each component counts as Lambertian; a lone transmission
    /// component answers, with its constant part, the opposite travel direction too.
    pub fn new(metadata: Metadata, components: Vec<Component>, explicit: Lambertian) -> Self {
        let lone = |side: Side| {
            let from = |s| components.iter().any(|c| c.is_transmission() && c.incident == s);
            !from(side) && from(side.opposite())
        };
        let reversed = [lone(Side::Front), lone(Side::Back)];
        let mut lambertian = explicit;
        for c in &components {
            let part = c.floor() * PI;
            *lambertian.get_mut(c.incident, c.scattered) += part;
            if c.is_transmission() && lone(c.scattered) {
                *lambertian.get_mut(c.scattered, c.incident) += part;
            }
        }
        let prepares = components.iter().any(|c| c.distribution().prepares());
        let varies = components.iter().any(|c| c.distribution().draws_apart());
        Self {
            metadata,
            components,
            explicit,
            lambertian,
            reversed,
            prepares,
            varies,
            bands: Vec::new(),
            specular: Vec::new(),
            specular_reversed: [false; 2],
        }
    }

    /// The same BSDF with these peaks of no width instead of those that it had.
    #[must_use]
    pub fn with_specular(self, specular: Vec<Specular>) -> Self {
        let lone = |side: Side| {
            let component = |c: &Component| c.is_transmission() && c.incident == side;
            let peak = |s: &Specular, side| s.is_transmission() && s.incident == side;
            !self.components.iter().any(component)
                && !specular.iter().any(|s| peak(s, side))
                && specular.iter().any(|s| peak(s, side.opposite()))
        };
        let specular_reversed = [lone(Side::Front), lone(Side::Back)];
        Self { specular, specular_reversed, ..self }
    }

    /// The same BSDF with these further bands instead of those that it had.
    #[must_use]
    pub fn with_bands(self, bands: Vec<Band>) -> Self {
        Self { bands, ..self }
    }

    /// The same BSDF, its trees read in the given way: [`Lookup::Stored`] after opening.
    ///
    /// Errors: format, for a damaged compiled file.
    pub fn with_lookup(mut self, lookup: Lookup) -> Result<Self> {
        let components = self.components.into_iter().map(|c| c.with_lookup(lookup));
        self.components = components.collect::<Result<_>>()?;
        for band in &mut self.bands {
            let components = std::mem::take(&mut band.components).into_iter();
            band.components = components.map(|c| c.with_lookup(lookup)).collect::<Result<_>>()?;
        }
        Ok(self)
    }

    /// Whether light from `incident` to `scattered` is answered by the opposite travel direction.
    pub(crate) fn is_reversed(&self, incident: Side, scattered: Side) -> bool {
        incident != scattered && self.reversed[usize::from(incident == Side::Back)]
    }

    /// Whether peaks that cross the surface answer light from `incident` by the opposite travel direction.
    pub(crate) fn is_specular_reversed(&self, incident: Side) -> bool {
        self.specular_reversed[usize::from(incident == Side::Back)]
    }

    /// Whether queries of one incident direction share work: [`Distribution::prepare`](crate::Distribution::prepare).
    pub(crate) fn prepares(&self) -> bool {
        self.prepares
    }

    /// Whether weights of samples vary: [`Distribution::draws_apart`](crate::Distribution::draws_apart).
    pub(crate) fn varies(&self) -> bool {
        self.varies || self.prepares
    }

    /// What the file says about the specimen.
    pub fn metadata(&self) -> &Metadata {
        &self.metadata
    }

    /// The stored components, in the order given.
    pub fn components(&self) -> &[Component] {
        &self.components
    }

    /// Peaks of no width, which [`Bsdf::eval`] leaves out.
    pub fn specular(&self) -> &[Specular] {
        &self.specular
    }

    /// Further bands of the file, which no query of this BSDF sees.
    pub fn bands(&self) -> &[Band] {
        &self.bands
    }

    /// The BSDF of a further band, by its name in any case.
    pub fn band(&self, name: &str) -> Option<Self> {
        let band = self.bands.iter().find(|b| b.is(name))?;
        let components = band.components.clone();
        let metadata = self.metadata.clone().unbound();
        Some(Self::new(metadata, components, Lambertian::default()))
    }

    /// The Lambertian fields as queried: explicit ones plus constant parts of components.
    pub fn lambertian(&self) -> &Lambertian {
        &self.lambertian
    }

    /// The Lambertian fields that no component contains.
    pub fn explicit_lambertian(&self) -> &Lambertian {
        &self.explicit
    }
}
