//! Numbers as Radiance's portable binary files hold them: big-endian integers, five-byte floats.

use bsdfkit::{Error, Result};

/// A place in a file's bytes; every fault names the offset.
pub(super) struct Bytes<'a> {
    all: &'a [u8],
    at: usize,
}

impl<'a> Bytes<'a> {
    pub(super) fn new(all: &'a [u8]) -> Self {
        Self { all, at: 0 }
    }

    pub(super) fn offset(&self) -> usize {
        self.at
    }

    pub(super) fn left(&self) -> usize {
        self.all.len() - self.at
    }

    fn take<const N: usize>(&mut self, what: &str) -> Result<[u8; N]> {
        let bytes = self.all.get(self.at..self.at + N).ok_or_else(|| {
            let (at, left) = (self.at, self.left());
            Error::format(format!(
                "byte {at}: {what}: expected {N} bytes, found {left} before the end of the file"
            ))
        })?;
        self.at += N;
        Ok(bytes.try_into().expect("the slice has N bytes"))
    }

    pub(super) fn u8(&mut self, what: &str) -> Result<u8> {
        self.take::<1>(what).map(|b| b[0])
    }

    pub(super) fn u16(&mut self, what: &str) -> Result<u16> {
        self.take(what).map(u16::from_be_bytes)
    }

    pub(super) fn i32(&mut self, what: &str) -> Result<i32> {
        self.take(what).map(i32::from_be_bytes)
    }

    /// (m ± ½) / (2³¹ − 1) · 2ᵉ, from a four-byte mantissa m and a one-byte exponent e; m = 0 is zero. Always finite.
    pub(super) fn float(&mut self, what: &str) -> Result<f64> {
        let [a, b, c, d, e] = self.take(what)?;
        let mantissa = i32::from_be_bytes([a, b, c, d]);
        if mantissa == 0 {
            return Ok(0.0);
        }
        let half = if mantissa > 0 { 0.5 } else { -0.5 };
        let exponent = i32::from(i8::from_be_bytes([e]));
        Ok((f64::from(mantissa) + half) / f64::from(i32::MAX) * f64::from(exponent).exp2())
    }

    /// The text up to the next line feed, which is swallowed.
    pub(super) fn line(&mut self, longest: usize) -> Result<&'a str> {
        let at = self.at;
        let rest = &self.all[at..];
        let end = rest.iter().take(longest + 1).position(|&b| b == b'\n').ok_or_else(|| {
            let found = rest.len().min(longest);
            Error::format(format!(
                "byte {at}: header: expected a line feed, found none in the next {found} bytes"
            ))
        })?;
        self.at += end + 1;
        std::str::from_utf8(&rest[..end]).map_err(|_| {
            Error::format(format!("byte {at}: header: expected text, found binary data"))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn five_byte_floats_are_exact_to_31_bits() {
        // 0.75 = mantissa 0.75 · (2³¹ − 1), exponent 0; then 3 = 0.75 · 2².
        let m = (0.75 * f64::from(i32::MAX)) as i32;
        for (exponent, value) in
            [(0_i8, 0.75), (2, 3.0), (-3, 0.09375), (127, 0.75 * 2f64.powi(127))]
        {
            for sign in [1, -1] {
                let mut bytes = (m * sign).to_be_bytes().to_vec();
                bytes.push(exponent.to_be_bytes()[0]);
                let read = Bytes::new(&bytes).float("x").unwrap();
                assert!((read / (value * f64::from(sign)) - 1.0).abs() < 1e-9, "{read} {value}");
            }
        }
        assert_eq!(Bytes::new(&[0, 0, 0, 0, 9]).float("x").unwrap(), 0.0);
    }

    #[test]
    fn the_end_of_the_file_is_named() {
        let mut bytes = Bytes::new(&[1, 2, 3]);
        bytes.u8("a").unwrap();
        let message = bytes.i32("number of lobes").unwrap_err().to_string();
        assert_eq!(
            message,
            "byte 1: number of lobes: expected 4 bytes, found 2 before the end of the file"
        );
    }
}
