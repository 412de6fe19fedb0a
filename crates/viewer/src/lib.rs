//! The viewer's page, and a server on this machine alone that hands it files.
//!
//! The page (`viewer/`, with `crates/web` inside) is built by `make viewer`; a crate compiled before that has none,
//! and says so when asked.

mod offer;
mod reply;
mod server;

pub use offer::Offer;
pub use server::Server;

use bsdfkit::{Error, Result};

#[cfg(page)]
const PAGE: Option<&str> = Some(include_str!(env!("BSDFKIT_VIEWER_PAGE")));
#[cfg(not(page))]
const PAGE: Option<&str> = None;

/// The page: one HTML document that needs nothing else, opens from a disk as well, and sends nothing anywhere.
///
/// Errors: argument where it was not built before this crate was.
pub fn page() -> Result<&'static str> {
    PAGE.ok_or_else(|| {
        Error::argument(
            "this build has no viewer: `make viewer` builds its page (with node and Rust's target \
             wasm32-unknown-unknown), then build again",
        )
    })
}
