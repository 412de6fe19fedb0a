//! A hypothesis beside the paper: peaks that obey Snell and Fresnel at a tilted facet.

#[expect(clippy::module_inception, reason = "the type gives the room its name")]
pub(crate) mod facet;
pub(crate) mod facets;
pub(crate) mod refracted_lobe;
mod search;
