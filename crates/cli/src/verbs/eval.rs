//! `bsdf eval`: values at rows of directions.

use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use bsdfkit::{Components, DVec3, Error, Result, Xyz};
use clap::Args;
use rayon::prelude::*;

use crate::files::load::{Reading, bsdf};
use crate::files::seen::Seen;
use crate::terminal::queries::{Notation, Queries};
use crate::terminal::stop::{Outcome, Verdict};
use crate::verbs::simulate::material;

const EXAMPLES: &str = "\
Examples:
  echo 30 0 30 180 | bsdf eval fabric.xml
  bsdf eval fabric.safetensors < rows.txt > values.txt
  bsdf eval --channels glass.xml < rows.txt
  bsdf eval --bands paint.safetensors < rows.txt
  bsdf eval --view solar glazing.safetensors < rows.txt
  bsdf eval --pdf fabric_render.safetensors < rows.txt
  bsdf eval --smooth fabric.xml < rows.txt
  bsdf eval --material fabric < rows.txt";

/// Values of a BSDF, or of an analytic material, at rows of directions
///
/// Reads rows `theta_i phi_i theta_o phi_o` in degrees: both directions point away from the
/// surface, theta 0-180 from the front normal (+Z), phi from +X toward +Y. Prints f in 1/sr,
/// without cosine, one row for each. Lines that begin with # are passed over.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// XML, interpolant, compiled BSDF, Radiance interpolant, or tables of RGL, MERL or Zemax
    #[arg(required_unless_present = "material")]
    file: Option<PathBuf>,
    /// The truth of an analytic material instead; see `bsdf simulate --list`
    #[arg(long, value_name = "NAME", conflicts_with_all = ["file", "smooth", "channels"])]
    material: Option<String>,
    #[command(flatten)]
    reading: Reading,
    #[command(flatten)]
    notation: Notation,
    /// Print X, Y and Z instead of the luminance
    #[arg(long)]
    channels: bool,
    /// Print f of every band of what was made of a spectral measurement, shortest wavelength first; `bsdf info` tells the wavelengths
    #[arg(long, conflicts_with_all = ["channels", "material", "view", "smooth"])]
    bands: bool,
    /// Print after the value the density with which `bsdf sample` draws the scattered direction, 1/sr
    #[arg(long, conflicts_with_all = ["channels", "bands", "material"])]
    pdf: bool,
}

pub(crate) fn run(arguments: &Arguments) -> Outcome {
    match (&arguments.file, &arguments.material) {
        (Some(file), _) if arguments.bands => bands(arguments, file),
        (Some(file), _) => {
            if arguments.pdf {
                let bsdf = bsdf(file, arguments.reading)?;
                return rows(
                    arguments,
                    |wi, wo, found| bsdf.eval_pdf_many(wi, wo, Components::ALL, found),
                    |[value, pdf]: [f64; 2]| vec![value, pdf],
                );
            }
            let seen = Seen::open(file, arguments.reading)?;
            let numbers = |v: Xyz| if arguments.channels { vec![v.x, v.y, v.z] } else { vec![v.y] };
            rows(arguments, |wi, wo, values| seen.eval_xyz(wi, wo, values), numbers)
        }
        (None, Some(name)) => {
            let material = material(name)?;
            rows(
                arguments,
                |wi, wo, values| {
                    let f = |k: usize| material.eval(wi[k], wo[k]);
                    values.par_iter_mut().enumerate().for_each(|(k, value)| *value = f(k));
                    Ok(())
                },
                |value: f64| vec![value],
            )
        }
        (None, None) => Err(Error::argument("expected a file or --material, found neither").into()),
    }
}

/// Every band at rows of directions.
fn bands(arguments: &Arguments, file: &Path) -> Outcome {
    let bsdf = bsdf(file, arguments.reading)?;
    let place = |e: Error| e.context(format!("{}: --bands", file.display()));
    let count = bsdf.expect_wavelengths().map_err(place)?.count();
    rows(
        arguments,
        |wi, wo, spectra| {
            let mut all = vec![0.0; count * spectra.len()];
            bsdf.eval_bands_many(wi, wo, &mut all)?;
            spectra.iter_mut().zip(all.chunks_exact(count)).for_each(|(s, f)| *s = f.to_vec());
            Ok(())
        },
        |spectrum: Vec<f64>| spectrum,
    )
}

/// Answers rows block by block: `f` of incident and scattered directions into answers, each of which has these `numbers`.
fn rows<T: Clone + Default>(
    arguments: &Arguments,
    f: impl Fn(&[DVec3], &[DVec3], &mut [T]) -> Result<()>,
    numbers: impl Fn(T) -> Vec<f64>,
) -> Outcome {
    let mut queries = Queries::<2>::new(arguments.notation);
    let mut out = BufWriter::new(io::stdout().lock());
    loop {
        let block = queries.block()?;
        if block.is_empty() {
            return Ok(Verdict::Good);
        }
        let [wi, wo] = [0, 1].map(|k| block.iter().map(|q| q.0[k]).collect::<Vec<DVec3>>());
        let mut answers = vec![T::default(); block.len()];
        f(&wi, &wo, &mut answers)?;
        for answer in answers {
            let numbers = numbers(answer).into_iter().map(|x| arguments.notation.number(x));
            writeln!(out, "{}", numbers.collect::<Vec<_>>().join(" "))?;
        }
        out.flush()?;
    }
}
