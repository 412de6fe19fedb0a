//! From goniophotometer measurement to BSDF: lobes, transport, interpolant, tabulation. [WKB14
//! §2.1–2.2]
//!
//! [`bsdfkit_measure::read`] sorts files into components;
//! [`Interpolant::fit`](interpolant::Interpolant::fit) makes a continuous function of each;
//! [`deliver::Order`] tabulates what a program reads. [`validate`] tells how far off it is where
//! nothing was measured, [`survey`] what to measure next.
//!
//! ```
//! use bsdfkit::{Components, DVec3, Metadata};
//! use bsdfkit_represent::Watch;
//! use bsdfkit_fit::deliver::{Kind, Order, Subject};
//! use bsdfkit_fit::interpolant::{FitSettings, Interpolant};
//! use bsdfkit_measure::ReadOptions;
//! # use bsdfkit_simulate::{Goniophotometer, material::FrittedGlass, write_measurements};
//!
//! # fn main() -> bsdfkit::Result<()> {
//! # let folder = std::env::temp_dir().join(format!("bsdfkit-fit-{}", std::process::id()));
//! # let (sweeps, points_per_sweep) = (8, 40);
//! # let gonio = Goniophotometer { sweeps, points_per_sweep, spiral_points: 100, ..Default::default() };
//! # write_measurements(&folder, &FrittedGlass::default(), &gonio, |_, _| Ok(()))?;
//! let measured = bsdfkit_measure::read(&[folder.clone()], &ReadOptions::default())?;
//! let interpolant = Interpolant::fit(&measured, &FitSettings::default(), &Watch::default())?;
//!
//! // Light from a direction that was not measured.
//! let wi = DVec3::new(6.0, -2.0, 3.0) / 7.0;
//! let transmitted = interpolant.bsdf().directional_hemispherical(wi, Components::ALL);
//! assert!(0.3 < transmitted && transmitted < 1.0);
//!
//! let order = Order::new(Kind::KlemsQuarter);
//! let subject = Subject::Continuous(&interpolant);
//! let table = order.deliver(subject, Metadata::default(), &Watch::default())?;
//! bsdfkit::xml::write(&table.bsdf, folder.join("glass.xml"), &Default::default())?;
//! # std::fs::remove_dir_all(&folder).map_err(|e| bsdfkit::Error::io(folder.display(), &e))?;
//! # Ok(())
//! # }
//! ```

mod cache;
pub mod deliver;
pub mod interpolant;
pub mod lobe;
pub mod open;
pub mod packed;
mod peaks;
pub mod specular;
pub mod survey;
pub mod validate;

pub use cache::Cache;
pub use peaks::{Maximum, peaks};
