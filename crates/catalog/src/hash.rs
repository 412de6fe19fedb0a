//! What a file must be, bit by bit.

use std::fmt;
use std::io::Read;
use std::str::FromStr;

use bsdfkit::{Error, Result};
use serde::{Deserialize, Serialize};
use sha2::Digest;

/// A SHA-256 hash, in hexadecimal as `sha256sum` prints it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Sha256([u8; 32]);

impl Sha256 {
    /// Of these bytes.
    pub fn of(bytes: &[u8]) -> Self {
        Self(sha2::Sha256::digest(bytes).into())
    }

    /// Of all that `source` reads, and how many bytes those are.
    ///
    /// Errors: those of reading.
    pub fn of_reader(source: &mut impl Read) -> std::io::Result<(Self, u64)> {
        let mut hashing = Hashing::default();
        let mut block = vec![0; 1 << 16];
        loop {
            match source.read(&mut block)? {
                0 => return Ok(hashing.end()),
                n => hashing.add(&block[..n]),
            }
        }
    }
}

/// A hash of what comes bit by bit.
#[derive(Default)]
pub(crate) struct Hashing {
    hash: sha2::Sha256,
    bytes: u64,
}

impl Hashing {
    pub(crate) fn add(&mut self, bytes: &[u8]) {
        self.hash.update(bytes);
        self.bytes += bytes.len() as u64;
    }

    pub(crate) fn bytes(&self) -> u64 {
        self.bytes
    }

    pub(crate) fn end(self) -> (Sha256, u64) {
        (Sha256(self.hash.finalize().into()), self.bytes)
    }
}

impl fmt::Display for Sha256 {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

impl FromStr for Sha256 {
    type Err = Error;

    /// Errors: format, for anything but 64 hexadecimal digits.
    fn from_str(text: &str) -> Result<Self> {
        let wrong =
            || Error::format(format!("SHA-256: expected 64 hexadecimal digits, found {text:?}"));
        if text.len() != 64 || !text.bytes().all(|b| b.is_ascii_hexdigit()) {
            return Err(wrong());
        }
        let mut bytes = [0; 32];
        for (k, byte) in bytes.iter_mut().enumerate() {
            *byte = u8::from_str_radix(&text[2 * k..2 * k + 2], 16).map_err(|_| wrong())?;
        }
        Ok(Self(bytes))
    }
}

impl TryFrom<String> for Sha256 {
    type Error = Error;

    fn try_from(text: String) -> Result<Self> {
        text.parse()
    }
}

impl From<Sha256> for String {
    fn from(hash: Sha256) -> Self {
        hash.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_answers() {
        // FIPS 180-4, example of one block.
        let abc = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(Sha256::of(b"abc").to_string(), abc);
        assert_eq!(Sha256::of_reader(&mut &b"abc"[..]).unwrap(), (abc.parse().unwrap(), 3));
        assert!("xyz".parse::<Sha256>().is_err());
        assert!(abc.replace('b', "é").parse::<Sha256>().is_err());
    }
}
