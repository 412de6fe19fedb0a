//! Numbers in two bytes.

use crate::words::Word;

/// A number in \[0, 65504\] in two bytes: the bits of a half float.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(transparent)]
pub struct Half(pub(crate) u16);

impl Half {
    /// The nearest half; not finite or negative counts as 0, too large as the largest.
    pub(crate) fn of(value: f64) -> Self {
        let value = if value > 0.0 { value.min(65504.0) } else { 0.0 };
        Self(half::f16::from_f64(value).to_bits())
    }

    /// Its value, whatever the bits: finite and not negative.
    #[inline(always)]
    pub(crate) fn value(self) -> f64 {
        // Exponents differ by 112. Those of 0 have no leading 1, so it is lent and taken back: arithmetic
        // with numbers that small takes the processor a hundred cycles.
        let bits = u32::from(self.0 & 0x7fff);
        let small = bits < 0x400;
        let exponent = if small { 113 } else { 112 } << 23;
        let lent = if small { f32::from_bits(113 << 23) } else { 0.0 };
        f64::from(f32::from_bits((bits << 13) + exponent) - lent)
    }
}

impl Word for Half {
    const BYTES: usize = 2;

    fn from_bytes(bytes: &[u8]) -> Self {
        bytes.first_chunk().map_or(Self(0), |b| Self(u16::from_le_bytes(*b)))
    }

    fn put(self, bytes: &mut Vec<u8>) {
        bytes.extend(self.0.to_le_bytes());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_are_halves() {
        for bits in 0..=u16::MAX {
            let ours = Half(bits).value();
            assert!(ours.is_finite() && ours >= 0.0);
            let theirs = half::f16::from_bits(bits);
            if bits < 0x7c00 {
                assert_eq!(ours, theirs.to_f64(), "{bits}");
                assert_eq!(Half::of(ours).0, bits);
            }
        }
    }
}
