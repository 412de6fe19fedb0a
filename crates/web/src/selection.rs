//! Which part of f is looked at, and in which channel.

use bsdfkit::{Bsdf, Components, DVec3, Scatter, Side, Xyz};
use wasm_bindgen::prelude::wasm_bindgen;

/// What the page has switched on.
#[wasm_bindgen]
#[derive(Clone, Copy, Debug)]
pub struct Selection {
    pub(crate) components: Components,
    channel: Channel,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Channel {
    X,
    Y,
    Z,
}

#[wasm_bindgen]
impl Selection {
    /// `components` as [`Components::bits`]; `channel` is "x", "z", or anything else for Y.
    #[wasm_bindgen(constructor)]
    pub fn new(components: u8, channel: &str) -> Self {
        let channel = match channel {
            "x" => Channel::X,
            "z" => Channel::Z,
            _ => Channel::Y,
        };
        Self { components: Components::from_bits(components), channel }
    }
}

impl Selection {
    fn is_whole(&self, wi: DVec3, wo: DVec3) -> bool {
        let (side, transmitted) = (Side::of(wi), Side::of(wi) != Side::of(wo));
        [Scatter::DirectionalDiffuse, Scatter::Lambertian]
            .into_iter()
            .all(|kind| self.components.selects(side, transmitted, kind))
    }

    /// f(wi, wo) of the selection for many `wo`, 1/sr. Colour is known of the whole alone: X and Z of a part of f are
    /// as large a share of those of the whole as its Y.
    pub(crate) fn values(&self, bsdf: &Bsdf, wi: DVec3, wo: &[DVec3]) -> Vec<f64> {
        let mut y = vec![0.0; wo.len()];
        let whole = wo.iter().all(|&wo| self.is_whole(wi, wo));
        match whole {
            true => bsdf.eval_many(&[wi], wo, &mut y),
            false => bsdf.eval_components_many(&[wi], wo, self.components, &mut y),
        }
        .expect("one value for each direction");
        if self.channel == Channel::Y {
            return y;
        }
        let mut xyz = vec![Xyz::ZERO; wo.len()];
        bsdf.eval_xyz_many(&[wi], wo, &mut xyz).expect("one value for each direction");
        let scaled = xyz.iter().zip(&y).map(|(xyz, y)| {
            let of_channel = if self.channel == Channel::X { xyz.x } else { xyz.z };
            if xyz.y > 0.0 { of_channel * (y / xyz.y) } else { 0.0 }
        });
        scaled.collect()
    }

    /// The same of one direction.
    pub(crate) fn value(&self, bsdf: &Bsdf, wi: DVec3, wo: DVec3) -> f64 {
        self.values(bsdf, wi, &[wo])[0]
    }

    /// The same components, those alone that scatter to `side`.
    pub(crate) fn to_side(self, wi: DVec3, side: Side) -> Components {
        let crossing =
            if Side::of(wi) == side { Components::REFLECTION } else { Components::TRANSMISSION };
        self.components & crossing
    }
}
