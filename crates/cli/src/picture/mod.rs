//! Pixels: colours, disks, text.

pub(crate) mod canvas;
pub(crate) mod error_map;
pub(crate) mod font;
pub(crate) mod raster;
