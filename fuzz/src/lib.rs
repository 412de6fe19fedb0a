//! Hostile bytes for every reader: one function a family of formats, which may neither panic nor hang nor take memory.
//!
//! [`TARGETS`] lists them. libFuzzer drives them by `make fuzz` (`fuzz/libfuzzer`); the test of this crate runs each over
//! its corpus and over some thousand [damaged](mutate) copies, without any tool. What a reader opens is
//! [asked](ask()), too.

mod ask;
pub mod corpus;
pub mod mutate;
mod scratch;
mod targets;

pub use ask::{DIRECTIONS, Trust, ask};
pub use targets::c_abi::c_abi;
pub use targets::container::container;
pub use targets::container_parts::container_parts;
pub use targets::measurement::{measurement, tables};
pub use targets::record::record;
pub use targets::sir::sir;
pub use targets::xml::xml;
pub use targets::xml_parts::xml_parts;

/// A function of bytes that no bytes may break.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// Name of the function, of its folder of the corpus and of its program.
    pub name: &'static str,
    /// What is run.
    pub run: fn(&[u8]),
}

/// All targets.
pub const TARGETS: [Target; 9] = [
    Target { name: "measurement", run: measurement },
    Target { name: "tables", run: tables },
    Target { name: "xml", run: xml },
    Target { name: "xml_parts", run: xml_parts },
    Target { name: "container", run: container },
    Target { name: "container_parts", run: container_parts },
    Target { name: "sir", run: sir },
    Target { name: "record", run: record },
    Target { name: "c_abi", run: c_abi },
];
