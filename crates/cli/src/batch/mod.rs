//! Many materials: what a manifest asks for, what of it is done, and the rest as processes of their own.
//!
//! `manifest` reads rows, `material` makes a job of each, `folder` keeps what jobs make, `state` tells which are finished; `local` runs
//! the others here, `dask` on many machines; `summary` tells of all.

pub(crate) mod dask;
pub(crate) mod folder;
pub(crate) mod job;
pub(crate) mod local;
pub(crate) mod manifest;
pub(crate) mod material;
mod name;
pub(crate) mod options;
pub(crate) mod output;
mod pattern;
pub(crate) mod state;
pub(crate) mod stopping;
pub(crate) mod summary;
