//! What a container holds, from its header alone.

use std::io::Read;
use std::path::Path;

use serde_json::Value;

use super::KEY;
use crate::limits::{HEADER_BYTES, open_file};
use crate::{Error, Result};

/// The `kind` that a safetensors file of ours states: "bsdf", "interpolant"; `None` where the file is
/// no container or none of ours.
///
/// Errors: io; argument: no regular file.
pub fn kind(path: impl AsRef<Path>) -> Result<Option<String>> {
    let path = path.as_ref();
    let header = header(open_file(path)?).map_err(|e| Error::io(path.display(), &e))?;
    Ok(stated(&header))
}

/// [`kind`] of a file's content.
pub fn kind_of_bytes(bytes: &[u8]) -> Option<String> {
    stated(&header(bytes).ok()?)
}

fn stated(header: &[u8]) -> Option<String> {
    let header: Value = serde_json::from_slice(header).ok()?;
    let ours: Value = serde_json::from_str(header["__metadata__"][KEY].as_str()?).ok()?;
    Some(ours["kind"].as_str()?.to_owned())
}

/// The bytes that the first eight count, as many as there are.
fn header(mut file: impl Read) -> std::io::Result<Vec<u8>> {
    let mut length = Vec::new();
    Read::by_ref(&mut file).take(8).read_to_end(&mut length)?;
    let length = length.first_chunk().map_or(0, |bytes| u64::from_le_bytes(*bytes));
    let mut header = Vec::new();
    file.take(length.min(HEADER_BYTES)).read_to_end(&mut header)?;
    Ok(header)
}
