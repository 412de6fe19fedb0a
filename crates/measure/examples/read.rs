//! How long reading measurement files takes, and nothing else: read PATH...

use std::path::PathBuf;
use std::time::Instant;

use bsdfkit_measure::{ReadOptions, components};

fn main() -> bsdfkit::Result<()> {
    let paths: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    let start = Instant::now();
    let options = ReadOptions { incomplete: true, ..ReadOptions::default() };
    for component in components(&paths, &options, &|_, _| Ok(()))? {
        let m = component?;
        println!("{}: {} points", m.sample_name.as_deref().unwrap_or("?"), m.points());
    }
    println!("{:.2} s", start.elapsed().as_secs_f64());
    Ok(())
}
