//! `bsdf compile`: a BSDF that opens without parsing.

use std::io::{self, Write};
use std::path::PathBuf;

use bsdfkit::{Error, container};
use bsdfkit_fit::deliver::{Delivered, Kind, Order};
use bsdfkit_represent::tabulate::Report;
use bsdfkit_represent::{Progress, Watch};
use clap::Args;

use crate::files::load::load;
use crate::files::surface::Surface;
use crate::files::target::expect_writable;
use crate::terminal::progress::Bar;
use crate::terminal::stop::{Outcome, Verdict, remark};

const EXAMPLES: &str = "\
Examples:
  bsdf compile fabric.xml -o fabric_compiled.safetensors
  bsdf compile fabric.safetensors -o fabric_render.safetensors";

/// Compile a BSDF into a file that opens in milliseconds
///
/// Named arrays in a safetensors file. Of a tree or matrix the same values, colour included; of an interpolant the
/// render form: tables that move along with its peaks, for renderers (`bsdf convert --to render` makes it of trees, too).
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// XML, compiled BSDF or interpolant
    file: PathBuf,
    /// File to write, *.safetensors
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
}

pub(crate) fn run(arguments: &Arguments) -> Outcome {
    let (file, path) = (&arguments.file, &arguments.output);
    if path.extension().is_none_or(|s| s != "safetensors") {
        let text = "expected a name ending in .safetensors";
        return Err(Error::argument(text).context(path.display()).into());
    }
    let input = load(file)?;
    input.warn(&arguments.file);
    let Surface::Stored(bsdf) = &input.surface else {
        expect_writable(path)?;
        let bar = Bar::new(Kind::Render.name());
        let report = |progress: Progress| bar.report(progress);
        let watch = Watch { progress: Some(&report), cancel: None };
        let order = Order::new(Kind::Render);
        let made = order.deliver(input.surface.subject(), input.metadata(), &watch);
        let Delivered { bsdf, reports, .. } = made.map_err(|e| e.context(file.display()))?;
        container::save(&bsdf, path)?;
        drop(bar);
        let mut line = format!("{}: {} components", path.display(), bsdf.components().len());
        for report in &reports {
            if let Report::Render(table) = report {
                line += &format!(", added L1 {:.4}", table.error);
            }
        }
        writeln!(io::stdout(), "{line}")?;
        return Ok(Verdict::Good);
    };
    let bands: Vec<&str> = bsdf.bands().iter().map(|b| b.name.as_str()).collect();
    if !bands.is_empty() {
        let bands = bands.join(", ");
        let text = format!("left out: band {bands}; `bsdf convert --band` makes a file of one");
        remark("note", &[format!("{}: {text}", path.display())]);
    }
    expect_writable(path)?;
    container::save(bsdf, path)?;
    writeln!(io::stdout(), "{}: {} components", path.display(), bsdf.components().len())?;
    Ok(Verdict::Good)
}
