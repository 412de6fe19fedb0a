//! One layer: its matrices, and what heat needs.

use bsdfkit::matrix::{KlemsBasis, KlemsMatrix};
use bsdfkit::xml::{placeholder, placeholders};
use bsdfkit::{Bsdf, Component, Error, Metadata, Result, Side};

/// The four matrices of a band, n × n, rows scattered, columns incident, by direction of travel, 1/sr.
///
/// Front is outside, as EnergyPlus has it.
#[derive(Clone, Debug)]
pub(super) struct Matrices {
    pub(super) transmission_front: Vec<f64>,
    pub(super) transmission_back: Vec<f64>,
    pub(super) reflection_front: Vec<f64>,
    pub(super) reflection_back: Vec<f64>,
}

/// A layer of a window, its back (z < 0) outside.
#[derive(Clone, Debug)]
pub struct Layer {
    pub(super) solar: Matrices,
    pub(super) visible: Matrices,
    basis: KlemsBasis,
    /// Metres.
    pub(super) thickness: f64,
    /// W / (m K).
    pub(super) conductivity: f64,
    /// Of the outside and of the inside.
    pub(super) emissivities: [f64; 2],
    pub(super) infrared_transmittance: f64,
    /// Fields that are not known of the material.
    pub(super) assumed: Vec<&'static str>,
}

/// What heat needs, as WINDOW's files name it.
const THERMAL: [&str; 5] =
    ["Thickness", "ThermalConductivity", "EmissivityFront", "EmissivityBack", "TIR"];

impl Layer {
    /// Of what [`Order::deliver`](crate::deliver::Order::deliver) makes for EnergyPlus: matrices of Visible and Solar in all
    /// four directions.
    ///
    /// Errors: argument, where one is missing.
    pub fn new(bsdf: &Bsdf, metadata: &Metadata) -> Result<Self> {
        let bsdf = &bsdf.with_peaks_in_cells()?;
        let solar = bsdf.bands().iter().find(|band| band.is("Solar"));
        let solar = solar.ok_or_else(|| Error::argument("expected the band Solar, found none"))?;
        let unknown = placeholders(metadata);
        let known = |field: &str| {
            let own = metadata.property(field).filter(|_| !unknown.contains(&field));
            own.and_then(|text| text.trim().parse().ok())
        };
        let number = |field: &'static str, own: &str| {
            let text =
                if unknown.contains(&field) { placeholder(field, known) } else { own.into() };
            text.trim().parse::<f64>().unwrap_or(0.0)
        };
        let property = |field| number(field, metadata.property(field).unwrap_or_default());
        let thickness = metadata.thickness.to_string();
        let basis = matrix(bsdf.components(), Side::Back, Side::Front)?.incident().clone();
        Ok(Self {
            solar: Matrices::new(&solar.components, &basis)?,
            visible: Matrices::new(bsdf.components(), &basis)?,
            basis,
            thickness: number("Thickness", &thickness),
            conductivity: property("ThermalConductivity"),
            emissivities: [property("EmissivityFront"), property("EmissivityBack")],
            infrared_transmittance: property("TIR"),
            assumed: THERMAL.into_iter().filter(|field| unknown.contains(field)).collect(),
        })
    }

    /// The basis of all matrices.
    pub fn basis(&self) -> &KlemsBasis {
        &self.basis
    }

    /// Fields for which a value was assumed.
    pub fn assumed(&self) -> &[&'static str] {
        &self.assumed
    }
}

impl Matrices {
    fn new(components: &[Component], basis: &KlemsBasis) -> Result<Self> {
        let table = |from, to| {
            let found = matrix(components, from, to)?;
            if found.incident() != basis || found.scattered() != basis {
                return Err(Error::argument("expected one basis of all matrices, found others"));
            }
            let n = basis.directions();
            let values = found.values();
            Ok((0..n * n).map(|k| f64::from(values[k % n * n + k / n])).collect::<Vec<f64>>())
        };
        Ok(Self {
            transmission_front: table(Side::Back, Side::Front)?,
            transmission_back: table(Side::Front, Side::Back)?,
            reflection_front: table(Side::Back, Side::Back)?,
            reflection_back: table(Side::Front, Side::Front)?,
        })
    }
}

fn matrix(components: &[Component], from: Side, to: Side) -> Result<&KlemsMatrix> {
    let component = components.iter().find(|c| (c.incident, c.scattered) == (from, to));
    component.and_then(|c| c.distribution().downcast_ref::<KlemsMatrix>()).ok_or_else(|| {
        Error::argument("expected Klems matrices of all four directions, found fewer")
    })
}
