//! Formats of others for what people say of a material, and for what of its light these formats can hold.

pub mod bed;
pub mod bird;
