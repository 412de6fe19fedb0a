//! Further spectral bands of a file: Solar, NIR, one wavelength.

use crate::component::Component;

/// One band beside the visible: what a file holds under a `Wavelength` of its own.
///
/// Not queried by the five verbs; [`Bsdf::band`](crate::Bsdf::band) makes a BSDF of it.
#[derive(Clone, Debug)]
pub struct Band {
    /// `Wavelength`: "Solar", "NIR", or a number of nanometres.
    pub name: String,
    /// Its unit: "Integral" or "Nanometer".
    pub unit: String,
    /// `SourceSpectrum`; empty when not given.
    pub source: String,
    /// `DetectorSpectrum`; empty when not given.
    pub detector: String,
    /// The stored components, without colour.
    pub components: Vec<Component>,
}

impl Band {
    /// An integral band with the spectra that Radiance's files name.
    pub fn new(name: impl Into<String>, components: Vec<Component>) -> Self {
        let (unit, source, detector) = ("Integral", "CIE Illuminant D65 1nm.ssp", "None");
        Self {
            name: name.into(),
            unit: unit.to_owned(),
            source: source.to_owned(),
            detector: detector.to_owned(),
            components,
        }
    }

    /// Whether `name` means this band, in any case.
    pub fn is(&self, name: &str) -> bool {
        self.name.eq_ignore_ascii_case(name)
    }
}
