//! The container: named tensors of one type each, little-endian.

use std::io::Write;

use bsdfkit::{Error, Result};

const MAGIC: &[u8] = b"tensor_file\0\x01\x00";
const U8: u8 = 1;
const F32: u8 = 10;

/// Tensors begin at multiples of this.
const ALIGNMENT: usize = 8;

/// One tensor.
pub(super) struct Tensor {
    name: &'static str,
    kind: u8,
    shape: Vec<usize>,
    bytes: Vec<u8>,
    /// How many times `bytes` follow each other.
    times: usize,
}

impl Tensor {
    pub(super) fn bytes(name: &'static str, bytes: Vec<u8>) -> Self {
        Self { name, kind: U8, shape: vec![bytes.len()], bytes, times: 1 }
    }

    pub(super) fn floats(name: &'static str, shape: &[usize], values: Vec<f32>) -> Self {
        let bytes: Vec<u8> = values.into_iter().flat_map(f32::to_le_bytes).collect();
        Self { name, kind: F32, shape: shape.to_vec(), bytes, times: 1 }
    }

    /// `values` once for each of the first two dimensions.
    pub(super) fn repeated(name: &'static str, shape: &[usize; 4], values: Vec<f32>) -> Self {
        Self { times: shape[0] * shape[1], ..Self::floats(name, shape, values) }
    }
}

/// Writes all, in this order.
///
/// Errors: io.
pub(super) fn write_tensors(out: &mut impl Write, tensors: &[Tensor]) -> Result<()> {
    let io = |e: std::io::Error| Error::io("writing", &e);
    let mut header = MAGIC.to_vec();
    header.extend((tensors.len() as u32).to_le_bytes());
    let described = |t: &Tensor| 2 + t.name.len() + 2 + 1 + 8 + 8 * t.shape.len();
    let mut at = header.len() + tensors.iter().map(described).sum::<usize>();
    for t in tensors {
        at = at.next_multiple_of(ALIGNMENT);
        header.extend((t.name.len() as u16).to_le_bytes());
        header.extend(t.name.as_bytes());
        header.extend((t.shape.len() as u16).to_le_bytes());
        header.push(t.kind);
        header.extend((at as u64).to_le_bytes());
        header.extend(t.shape.iter().flat_map(|n| (*n as u64).to_le_bytes()));
        at += t.bytes.len() * t.times;
    }
    out.write_all(&header).map_err(io)?;
    let mut at = header.len();
    for t in tensors {
        let start = at.next_multiple_of(ALIGNMENT);
        out.write_all(&[0; ALIGNMENT][..start - at]).map_err(io)?;
        for _ in 0..t.times {
            out.write_all(&t.bytes).map_err(io)?;
        }
        at = start + t.bytes.len() * t.times;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offsets_lead_to_the_data() {
        let mut file = Vec::new();
        let tensors =
            [Tensor::bytes("a", vec![7, 8, 9]), Tensor::floats("bc", &[2, 1], vec![1.5, -2.0])];
        write_tensors(&mut file, &tensors).unwrap();
        assert_eq!(&file[..14], MAGIC);
        assert_eq!(file[14..18], 2_u32.to_le_bytes());
        let offset = |at: usize| u64::from_le_bytes(file[at..at + 8].try_into().unwrap()) as usize;
        // name length, name, dimensions, type: then the offset.
        let first = offset(18 + 2 + 1 + 2 + 1);
        assert_eq!(file[first..first + 3], [7, 8, 9]);
        let second = offset(18 + 14 + 8 + 2 + 2 + 2 + 1);
        assert_eq!(second % ALIGNMENT, 0);
        assert_eq!(file[second..second + 4], 1.5_f32.to_le_bytes());
        assert_eq!(file.len(), second + 8);
    }
}
