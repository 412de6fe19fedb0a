//! Components: the parts of a BSDF and the flags that select them.

use std::ops::{BitAnd, BitOr};
use std::sync::Arc;

use crate::Result;
use crate::Side;
use crate::colour::Xyz;
use crate::distribution::Distribution;
use crate::lanes::Lookup;
use crate::tree::read_as;

/// A selection of components: {reflection, transmission} × {Lambertian, other}, by the
/// front or back side of the incident direction.
///
/// A part counts only when its side, its sense and its kind are all selected.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Components(u8);

impl Components {
    /// Light that stays on the incident side.
    pub const REFLECTION: Self = Self(0b00_11_01 | Self::SIDES);
    /// Light that crosses the surface.
    pub const TRANSMISSION: Self = Self(0b00_11_10 | Self::SIDES);
    /// Everything that is not Lambertian.
    pub const NON_LAMBERTIAN: Self = Self(0b00_01_11 | Self::SIDES);
    /// The Lambertian parts.
    pub const LAMBERTIAN: Self = Self(0b00_10_11 | Self::SIDES);
    /// Incidence on the front (z > 0).
    pub const FRONT: Self = Self(0b01_11_11);
    /// Incidence on the back.
    pub const BACK: Self = Self(0b10_11_11);
    /// Everything.
    pub const ALL: Self = Self(0b11_11_11);
    /// Nothing.
    pub const NONE: Self = Self(0);

    const SIDES: u8 = 0b11_00_00;

    /// The bits, for other languages: 1 reflection, 2 transmission, 4 other, 8 Lambertian,
    /// 16 front, 32 back.
    pub const fn bits(self) -> u8 {
        self.0
    }

    /// From [`Components::bits`]; unknown bits are dropped. With neither side bit, both sides
    /// are meant, so that the reference library's flags (`SDsampR` …) mean here what they do there.
    pub const fn from_bits(bits: u8) -> Self {
        let bits = bits & Self::ALL.0;
        Self(if bits & Self::SIDES == 0 { bits | Self::SIDES } else { bits })
    }

    /// Whether a part selected by `other` is selected here too.
    pub const fn intersects(self, other: Self) -> bool {
        let both = self.0 & other.0;
        both & 0b11 != 0 && both & 0b1100 != 0 && both & Self::SIDES != 0
    }

    /// Whether a part is selected: incident on `incident`, crossing the surface or not,
    /// Lambertian or not.
    #[inline]
    pub const fn selects(self, incident: Side, transmitted: bool, lambertian: bool) -> bool {
        let side = match incident {
            Side::Front => 16,
            Side::Back => 32,
        };
        let need = side | if transmitted { 2 } else { 1 } | if lambertian { 8 } else { 4 };
        self.0 & need == need
    }
}

impl BitAnd for Components {
    type Output = Self;
    /// Parts that both select: `REFLECTION & LAMBERTIAN`.
    fn bitand(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

impl BitOr for Components {
    type Output = Self;
    /// Union bit by bit: `REFLECTION | TRANSMISSION` is both; a sum over kinds and senses at
    /// once selects every combination of them.
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl Default for Components {
    fn default() -> Self {
        Self::ALL
    }
}

/// Where scattered light of one part came from: what [`sample`](crate::Bsdf::sample) drew.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Part {
    /// The Lambertian reflection of the incident side.
    LambertianReflection,
    /// The Lambertian transmission from the incident side.
    LambertianTransmission,
    /// The non-Lambertian part of the component with this index in
    /// [`Bsdf::components`](crate::Bsdf::components).
    Component(usize),
}

/// What a component is called by its sides: "front reflection", "back transmission", …
pub fn name_of_sides(incident: Side, scattered: Side) -> &'static str {
    match (incident, scattered) {
        (Side::Front, Side::Front) => "front reflection",
        (Side::Back, Side::Back) => "back reflection",
        (Side::Front, Side::Back) => "front transmission",
        (Side::Back, Side::Front) => "back transmission",
    }
}

/// One stored distribution and the pair of sides it belongs to.
#[derive(Clone, Debug)]
pub struct Component {
    /// Side of the stored incident direction.
    pub incident: Side,
    /// Side of the stored scattered direction.
    pub scattered: Side,
    distribution: Arc<dyn Distribution>,
    floor: Xyz,
    negligible: bool,
}

impl Component {
    /// A component as a file stores it; its constant part counts as Lambertian.
    pub fn new(incident: Side, scattered: Side, distribution: impl Distribution) -> Self {
        Self::shared(incident, scattered, Arc::new(distribution))
    }

    /// The same, of a distribution that others hold too.
    pub fn shared(incident: Side, scattered: Side, distribution: Arc<dyn Distribution>) -> Self {
        let floor = distribution.constant_part();
        let negligible = distribution.is_negligible(floor.y);
        Self { incident, scattered, distribution, floor, negligible }
    }

    /// One whose constant part and weight are known from a file.
    pub(crate) fn compiled(
        (incident, scattered): (Side, Side),
        distribution: impl Distribution,
        floor: Xyz,
        negligible: bool,
    ) -> Self {
        Self { incident, scattered, distribution: Arc::new(distribution), floor, negligible }
    }

    /// The same values read in the given way.
    ///
    /// Errors: format, for values from a damaged file.
    pub fn with_lookup(mut self, lookup: Lookup) -> Result<Self> {
        if let Some(distribution) = read_as(&self.distribution, lookup)? {
            self.distribution = distribution;
        }
        Ok(self)
    }

    /// Whether light crosses the surface.
    pub fn is_transmission(&self) -> bool {
        self.incident != self.scattered
    }

    /// The distribution, with nothing taken out.
    pub fn distribution(&self) -> &dyn Distribution {
        self.distribution.as_ref()
    }

    /// The constant (1/sr) that counts as Lambertian; the rest is the non-Lambertian part.
    pub fn floor(&self) -> Xyz {
        self.floor
    }

    /// Whether the non-Lambertian part is too small to count (at most 0.1 % in total).
    pub fn is_negligible(&self) -> bool {
        self.negligible
    }
}
