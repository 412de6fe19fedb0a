//! `bsdf view`: files in a browser.

use std::io::{self, Write};
use std::path::PathBuf;

use bsdfkit::Error;
use bsdfkit_viewer::{Offer, Server};
use clap::Args;

use crate::terminal::stop::{Outcome, Verdict};

const EXAMPLES: &str = "\
Examples:
  bsdf view fabric.xml
  bsdf view fabric.safetensors fabric_klems.xml       # compared
  bsdf view fabric.safetensors measurements/          # with the points that it was made of
  bsdf view --page viewer.html                        # the page itself: open it, drop files on it";

/// Look at files in a browser: lobe, hemisphere, slice, lit object
///
/// Prints a link and answers it, on this machine alone, until it is stopped by Ctrl-C. Nothing is uploaded: the page
/// reads the files itself.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// XML, compiled BSDFs, interpolants, Radiance interpolants: one, or two to compare; and measurements
    #[arg(value_name = "FILE", required_unless_present = "page")]
    files: Vec<PathBuf>,
    /// Port on 127.0.0.1; 0 takes a free one
    #[arg(long, value_name = "PORT", default_value_t = 0)]
    port: u16,
    /// Do not open a browser
    #[arg(long)]
    no_browser: bool,
    /// Write the page to a file instead: it needs no server
    #[arg(long, value_name = "OUT.html", conflicts_with = "files")]
    page: Option<PathBuf>,
}

pub(crate) fn run(arguments: &Arguments) -> Outcome {
    if let Some(path) = &arguments.page {
        let page = bsdfkit_viewer::page()?;
        bsdfkit::replace_file(path, |out| {
            out.write_all(page.as_bytes()).map_err(|e| Error::io(path.display(), &e))
        })?;
        return Ok(Verdict::Good);
    }
    let server = Server::new(Offer::of(&arguments.files)?, arguments.port)?;
    let link = server.link();
    let mut out = io::stdout().lock();
    writeln!(out, "{link}")?;
    out.flush()?;
    drop(out);
    if !arguments.no_browser {
        // Where there is none, the link is there to be copied.
        let _ = open::that_detached(&link);
    }
    server.run();
    Ok(Verdict::Good)
}
