//! The container: named tensors of one type each, little-endian.

use std::io::Write;

use bsdfkit::limits::{MAGNITUDE, is_plausible};
use bsdfkit::{Error, Result};

const MAGIC: &[u8] = b"tensor_file\0\x01\x00";
const U8: u8 = 1;
const F32: u8 = 10;

/// Types of numbers by their codes: name and bytes of one.
const KINDS: [(u8, &str, usize); 11] = [
    (1, "u8", 1),
    (2, "i8", 1),
    (3, "u16", 2),
    (4, "i16", 2),
    (5, "u32", 4),
    (6, "i32", 4),
    (7, "u64", 8),
    (8, "i64", 8),
    (9, "f16", 2),
    (10, "f32", 4),
    (11, "f64", 8),
];
const F64: u8 = 11;

/// Tensors of a file, and dimensions of one: six times what any program writes.
const MOST: usize = 64;

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

/// A tensor in a file that was read.
#[derive(Debug)]
pub(super) struct Stored<'b> {
    pub(super) name: &'b str,
    kind: u8,
    pub(super) shape: Vec<usize>,
    bytes: &'b [u8],
}

impl Stored<'_> {
    /// Its numbers.
    ///
    /// Errors: the message where they are none of floating point, or not plausible.
    pub(super) fn numbers(&self) -> std::result::Result<Vec<f32>, String> {
        let name = self.name;
        let all: Vec<f32> = match self.kind {
            F32 => {
                let of = |b: &[u8]| f32::from_le_bytes(b.try_into().unwrap_or_default());
                self.bytes.chunks_exact(4).map(of).collect()
            }
            F64 => {
                let of = |b: &[u8]| f64::from_le_bytes(b.try_into().unwrap_or_default()) as f32;
                self.bytes.chunks_exact(8).map(of).collect()
            }
            kind => {
                let found = KINDS.iter().find(|k| k.0 == kind).map_or("?", |k| k.1);
                return Err(format!("{name}: expected f32 or f64, found {found}"));
            }
        };
        match all.iter().position(|v| !is_plausible(f64::from(*v))) {
            Some(at) => Err(format!(
                "{name}[{at}]: expected a finite number of at most {MAGNITUDE:e}, found {}",
                all[at]
            )),
            None => Ok(all),
        }
    }

    /// Its bytes as they are.
    ///
    /// Errors: the message where they are no bytes.
    pub(super) fn octets(&self) -> std::result::Result<&[u8], String> {
        match self.kind {
            U8 => Ok(self.bytes),
            _ => Err(format!("{}: expected u8, found another type", self.name)),
        }
    }
}

/// The tensors of a file; nothing is copied, and what it declares lies within it.
///
/// Errors: the message, naming tensor, expected and found.
pub(super) fn read_tensors(bytes: &[u8]) -> std::result::Result<Vec<Stored<'_>>, String> {
    let mut at = MAGIC.len();
    if bytes.get(..at) != Some(MAGIC) {
        return Err("expected a tensor file of version 1.0, found another start".into());
    }
    let mut take = |count: usize, what: &str| {
        let end = at.saturating_add(count);
        let found = bytes.get(at..end).ok_or_else(|| {
            format!(
                "{what}: expected {count} bytes, found the end of the file after {}",
                bytes.len()
            )
        })?;
        at = end;
        Ok::<_, String>(found)
    };
    let number = |bytes: &[u8]| bytes.iter().rev().fold(0_u64, |sum, b| sum << 8 | u64::from(*b));
    let count = number(take(4, "number of tensors")?) as usize;
    if count > MOST {
        return Err(format!("expected at most {MOST} tensors, found {count}"));
    }
    let mut tensors: Vec<Stored<'_>> = Vec::new();
    for _ in 0..count {
        let length = number(take(2, "length of a name")?) as usize;
        let name = std::str::from_utf8(take(length, "name of a tensor")?)
            .map_err(|_| "name of a tensor: expected UTF-8, found other bytes".to_owned())?;
        if tensors.iter().any(|t| t.name == name) {
            return Err(format!("{name}: expected each tensor once, found it twice"));
        }
        let dimensions = number(take(2, name)?) as usize;
        if dimensions > MOST {
            return Err(format!("{name}: expected at most {MOST} dimensions, found {dimensions}"));
        }
        let kind = take(1, name)?[0];
        let Some((_, _, size)) = KINDS.iter().find(|k| k.0 == kind) else {
            return Err(format!("{name}: expected a type from 1 to 11, found {kind}"));
        };
        let offset = number(take(8, name)?);
        let mut shape = Vec::new();
        for _ in 0..dimensions {
            shape.push(usize::try_from(number(take(8, name)?)).unwrap_or(usize::MAX));
        }
        let declared = shape.iter().try_fold(*size, |sum, n| sum.checked_mul(*n));
        let within = declared
            .zip(usize::try_from(offset).ok())
            .and_then(|(length, start)| bytes.get(start..start.checked_add(length)?));
        let within = within.ok_or_else(|| {
            format!(
                "{name}: expected numbers of shape {shape:?} at byte {offset}, found a file of {} bytes",
                bytes.len()
            )
        })?;
        tensors.push(Stored { name, kind, shape, bytes: within });
    }
    Ok(tensors)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read() {
        let mut file = Vec::new();
        let tensors =
            [Tensor::bytes("a", vec![7, 8, 9]), Tensor::floats("bc", &[2, 1], vec![1.5, -2.0])];
        write_tensors(&mut file, &tensors).unwrap();
        let read = read_tensors(&file).unwrap();
        assert_eq!(read[0].octets().unwrap(), [7, 8, 9]);
        assert_eq!((read[1].name, &read[1].shape[..]), ("bc", &[2, 1][..]));
        assert_eq!(read[1].numbers().unwrap(), [1.5, -2.0]);
        assert!(read[0].numbers().unwrap_err().contains("found u8"));
        for end in 0..file.len() {
            let message = read_tensors(&file[..end]).unwrap_err();
            assert!(message.contains("found"), "{end}: {message}");
        }
    }

    #[test]
    fn declared_sizes_are_held_against_the_file() {
        let mut file = Vec::new();
        write_tensors(&mut file, &[Tensor::floats("bc", &[2, 1], vec![1.5, -2.0])]).unwrap();
        let shape = 18 + 2 + 2 + 2 + 1 + 8;
        file[shape..shape + 16].fill(0xff);
        assert!(read_tensors(&file).unwrap_err().contains("found a file of"));
    }

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
