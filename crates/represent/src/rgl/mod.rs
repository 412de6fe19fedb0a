//! Files `.bsdf` in the form of RGL's measured materials, which Mitsuba's `measured`, pbrt-v4 and others read: written here,
//! and read as a measurement or a function.
//!
//! Such a file holds reflection of the front over half vectors, warped so that cells are small where light is. What is
//! written here is a form that all readers take alike: `ndf` ≡ 4 and `sigma` ≡ 1, so that f cos θo is the table alone; one
//! warp for all incidences, so that between them f is linear at a fixed half vector, where peaks of rough surfaces stay;
//! azimuths from -π to π. Source: [DJ18].

mod half_vector;
pub mod material;
pub mod reflection;
mod resolution;
mod spectrum;
mod tables;
mod tensor;
mod warp;

use std::path::Path;

use bsdfkit::{Bsdf, Error, Metadata, Result, replace_file};

use crate::watch::Watch;

pub use spectrum::Channels;

use resolution::Resolution;
use tables::Tables;
use tensor::{Tensor, write_tensors};

/// What a name says of the channels: `…_rgb.bsdf`, `…_spec.bsdf`.
pub fn channels_of(path: &Path) -> Option<Channels> {
    let stem = path.file_stem()?.to_str()?;
    let by_end = [("_rgb", Channels::Rgb), ("_spec", Channels::Spectral)];
    by_end.into_iter().find(|(end, _)| stem.ends_with(end)).map(|(_, channels)| channels)
}

/// Writes the reflection of the front to `path`; `isotropic` tells whether azimuths count there by their difference
/// alone. Returns what is left out, a sentence each.
///
/// Accuracy: f of smooth materials within 2 % (L1) at incidences up to 75 degrees and roughness from 0.05 up.
/// Errors: argument, where the front reflects nothing; io; limit when cancelled.
/// Cost: 6 million values of anisotropic materials, 0.6 million of isotropic ones; 21 and 3 MB in RGB.
pub fn write(
    bsdf: &Bsdf,
    isotropic: bool,
    metadata: &Metadata,
    channels: Channels,
    path: &Path,
    watch: &Watch<'_>,
) -> Result<Vec<String>> {
    let place = |e: Error| e.context(path.display());
    let mut said = tables::left_out(bsdf).map_err(place)?;
    let resolution = if isotropic { Resolution::isotropic() } else { Resolution::anisotropic() };
    let tables = Tables::new(bsdf, channels, &resolution, watch).map_err(place)?;
    if channels == Channels::Spectral && tables.coloured {
        said.push("spectra are not known: the smoothest of the same colour".into());
    }
    let description = format!("{}\nbsdfkit {}", metadata.name, env!("CARGO_PKG_VERSION"));
    let radians = |degrees: &[f64]| degrees.iter().map(|d| d.to_radians() as f32).collect();
    let (thetas, phis) = (resolution.thetas.len(), resolution.phis.len());
    let (warped, cells) = (resolution.warp, resolution.cells);
    let mut tensors = vec![
        Tensor::bytes("description", description.into_bytes()),
        Tensor::bytes("jacobian", vec![1]),
        Tensor::floats("theta_i", &[thetas], radians(&resolution.thetas)),
        Tensor::floats("phi_i", &[phis], radians(&resolution.phis)),
        Tensor::floats("ndf", &[2, 2], vec![4.0; 4]),
        Tensor::floats("sigma", &[2, 2], vec![1.0; 4]),
        Tensor::repeated("vndf", &[phis, thetas, warped, warped], tables.warp),
        Tensor::floats("luminance", &[phis, thetas, cells, cells], tables.luminance),
    ];
    let name = match channels {
        Channels::Rgb => "rgb",
        Channels::Spectral => {
            let wavelengths = tables.wavelengths;
            tensors.push(Tensor::floats("wavelengths", &[wavelengths.len()], wavelengths));
            "spectra"
        }
    };
    tensors.push(Tensor::floats(
        name,
        &[phis, thetas, tables.channels, cells, cells],
        tables.values,
    ));
    replace_file(path, |out| write_tensors(out, &tensors))?;
    Ok(said)
}
