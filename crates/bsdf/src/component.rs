//! Components: the parts of a BSDF and the flags that select them.

use std::ops::{BitAnd, BitOr};
use std::sync::Arc;

use crate::Result;
use crate::Side;
use crate::colour::Xyz;
use crate::distribution::Distribution;
use crate::lanes::Lookup;
use crate::tree::read_as;

/// A selection of components: {reflection, transmission} × {Lambertian, directional-diffuse, specular}, by
/// the front or back side of the incident direction.
///
/// A part counts only when its side, its sense and its kind are all selected.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Components(u8);

/// What kind of scattering a part is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Scatter {
    /// Constant over all directions.
    Lambertian,
    /// Of values per solid angle: what a tree or a matrix holds beyond its constant part.
    DirectionalDiffuse,
    /// A peak of no width.
    Specular,
}

impl Components {
    /// Light that stays on the incident side.
    pub const REFLECTION: Self = Self(1 | Self::KINDS | Self::SIDES);
    /// Light that crosses the surface.
    pub const TRANSMISSION: Self = Self(2 | Self::KINDS | Self::SIDES);
    /// Everything that is not Lambertian.
    pub const NON_LAMBERTIAN: Self = Self(Self::EITHER | Self::SENSES | Self::SIDES);
    /// The Lambertian parts.
    pub const LAMBERTIAN: Self = Self(8 | Self::SENSES | Self::SIDES);
    /// Peaks of no width: [`Bsdf::specular`](crate::Bsdf::specular).
    pub const SPECULAR: Self = Self(64 | Self::SENSES | Self::SIDES);
    /// What has values per solid angle and is not constant.
    pub const DIRECTIONAL_DIFFUSE: Self = Self(128 | Self::SENSES | Self::SIDES);
    /// Incidence on the front (z > 0).
    pub const FRONT: Self = Self(16 | Self::SENSES | Self::KINDS);
    /// Incidence on the back.
    pub const BACK: Self = Self(32 | Self::SENSES | Self::KINDS);
    /// Everything.
    pub const ALL: Self = Self(Self::SENSES | Self::KINDS | Self::SIDES);
    /// Nothing.
    pub const NONE: Self = Self(0);

    const SENSES: u8 = 1 | 2;
    const SIDES: u8 = 16 | 32;
    /// Both kinds that are not Lambertian.
    const EITHER: u8 = 64 | 128;
    const KINDS: u8 = 8 | Self::EITHER;
    /// In [`Components::bits`] alone: not Lambertian.
    const OTHER: u8 = 4;

    /// The bits, for other languages: 1 reflection, 2 transmission, 8 Lambertian, 16 front, 32 back, 64
    /// specular, 128 directional-diffuse; 4 stands beside both of these.
    pub const fn bits(self) -> u8 {
        if self.0 & Self::EITHER == Self::EITHER { self.0 | Self::OTHER } else { self.0 }
    }

    /// From [`Components::bits`]. Bit 4 with neither 64 nor 128 means both, and with neither side bit both sides
    /// are meant, so that the reference library's flags (`SDsampR` …) mean here what they do there.
    pub const fn from_bits(bits: u8) -> Self {
        let undivided = bits & Self::OTHER != 0 && bits & Self::EITHER == 0;
        let bits = (if undivided { bits | Self::EITHER } else { bits }) & Self::ALL.0;
        Self(if bits & Self::SIDES == 0 { bits | Self::SIDES } else { bits })
    }

    /// The same sides and senses of everything but peaks of no width.
    pub(crate) const fn smooth(self) -> Self {
        Self(self.0 & !64 | 8 | 128)
    }

    /// Whether a part selected by `other` is selected here too.
    pub const fn intersects(self, other: Self) -> bool {
        let both = self.0 & other.0;
        both & Self::SENSES != 0 && both & Self::KINDS != 0 && both & Self::SIDES != 0
    }

    /// Whether a part is selected: incident on `incident`, crossing the surface or not, of a kind.
    #[inline]
    pub const fn selects(self, incident: Side, transmitted: bool, kind: Scatter) -> bool {
        let side = match incident {
            Side::Front => 16,
            Side::Back => 32,
        };
        let kind = match kind {
            Scatter::Lambertian => 8,
            Scatter::Specular => 64,
            Scatter::DirectionalDiffuse => 128,
        };
        let need = side | kind | if transmitted { 2 } else { 1 };
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
    /// The peak of no width with this index in [`Bsdf::specular`](crate::Bsdf::specular).
    Specular(usize),
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
