//! What an XML output holds: the visible band, further ones, and of the description what stays true.

use bsdfkit::{Band, Bsdf, Lambertian, Metadata, Result};

use crate::consumer::forget_made_up;
use crate::output::{Tabulation, Target, Written, assembled};
use crate::surface::Surface;

/// Everything of `surface` in the form of `target`, fitted to whom it is for; what that leaves out is
/// said in `written`.
///
/// Errors: as of the tabulation.
pub(crate) fn contents(
    target: &Target,
    surface: &Surface,
    metadata: &Metadata,
    tabulation: &Tabulation,
    written: &mut Written,
) -> Result<Bsdf> {
    let (kind, consumer) = (target.kind, target.consumer);
    let bsdf = assembled(kind, surface, metadata, tabulation, written)?;
    let same_structure = written.copied() == bsdf.components().len();

    let further = match surface {
        Surface::Stored(bsdf) => bsdf.bands(),
        Surface::Continuous(_) => &[],
    };
    let (wanted, left_out): (Vec<&Band>, Vec<&Band>) =
        further.iter().partition(|band| consumer.is_none_or(|c| c.wants(band)));
    let mut bands = Vec::new();
    for band in wanted {
        let alone = Bsdf::new(Metadata::default(), band.components.clone(), Lambertian::default());
        let alone = Surface::Stored(alone.into());
        let alone = assembled(kind, &alone, &Metadata::default(), tabulation, written)?;
        bands.push(Band { components: alone.components().to_vec(), ..band.clone() });
    }
    let mut lost: Vec<String> = left_out.iter().map(|b| format!("band {}", b.name)).collect();

    let mut metadata = metadata.clone();
    if !same_structure || consumer.is_some() {
        lost.extend(metadata.bound());
        metadata = metadata.unbound();
    }
    forget_made_up(&mut metadata, &bands);
    if !lost.is_empty() {
        written.said.push(format!("left out: {}", lost.join(", ")));
    }
    let (components, explicit) = (bsdf.components().to_vec(), *bsdf.explicit_lambertian());
    let bsdf = Bsdf::new(metadata, components, explicit).with_bands(bands);
    match consumer {
        Some(consumer) => consumer.fitted(bsdf, kind, &mut written.said),
        None => Ok(bsdf),
    }
}
