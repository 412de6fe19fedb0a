//! One file a target.

pub(crate) mod c_abi;
pub(crate) mod container;
pub(crate) mod container_parts;
pub(crate) mod measurement;
pub(crate) mod record;
pub(crate) mod sir;
pub(crate) mod xml;
pub(crate) mod xml_parts;
