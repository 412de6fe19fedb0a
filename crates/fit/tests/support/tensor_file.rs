//! Tensor files made by hand.

/// A tensor file: name, type, shape, bytes.
pub(crate) fn tensors(all: &[(&str, u8, Vec<u64>, Vec<u8>)]) -> Vec<u8> {
    let mut file = b"tensor_file\0\x01\x00".to_vec();
    file.extend((all.len() as u32).to_le_bytes());
    let head: usize = all.iter().map(|(n, _, s, _)| 2 + n.len() + 2 + 1 + 8 + 8 * s.len()).sum();
    let mut at = (file.len() + head) as u64;
    for (name, kind, shape, bytes) in all {
        file.extend((name.len() as u16).to_le_bytes());
        file.extend(name.as_bytes());
        file.extend((shape.len() as u16).to_le_bytes());
        file.push(*kind);
        file.extend(at.to_le_bytes());
        shape.iter().for_each(|n| file.extend(n.to_le_bytes()));
        at += bytes.len() as u64;
    }
    all.iter().for_each(|(_, _, _, bytes)| file.extend(bytes));
    file
}

/// Name, type, shape, bytes.
pub(crate) type Tensor = (&'static str, u8, Vec<u64>, Vec<u8>);

/// One of f32.
pub(crate) fn floats(name: &'static str, shape: &[u64], value: impl Fn(usize) -> f32) -> Tensor {
    let count = shape.iter().product::<u64>() as usize;
    (name, 10, shape.to_vec(), (0..count).flat_map(|k| value(k).to_le_bytes()).collect())
}
