//! The BSDF: Lambertian parts, components, metadata.

use crate::Side;
use crate::colour::Xyz;
use crate::component::Component;
use crate::metadata::Metadata;

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
#[derive(Clone, Debug)]
pub struct Bsdf {
    metadata: Metadata,
    components: Vec<Component>,
    explicit: Lambertian,
    lambertian: Lambertian,
}

impl Bsdf {
    /// A BSDF of stored components, plus Lambertian parts that no component contains.
    ///
    /// The constant part of each component counts as Lambertian; a lone transmission
    /// component lends its constant part to the opposite travel direction.
    pub fn new(metadata: Metadata, components: Vec<Component>, explicit: Lambertian) -> Self {
        let mut lambertian = explicit;
        for c in &components {
            *lambertian.get_mut(c.incident, c.scattered) += c.floor() * std::f64::consts::PI;
        }
        for side in [Side::Front, Side::Back] {
            let there = |c: &&Component| c.incident == side && c.is_transmission();
            if !components.iter().any(|c| there(&c)) {
                for c in components.iter().filter(|c| c.is_transmission()) {
                    *lambertian.get_mut(side, side.opposite()) += c.floor() * std::f64::consts::PI;
                }
            }
        }
        Self { metadata, components, explicit, lambertian }
    }

    /// What the file says about the specimen.
    pub fn metadata(&self) -> &Metadata {
        &self.metadata
    }

    /// The stored components, in the order given.
    pub fn components(&self) -> &[Component] {
        &self.components
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
