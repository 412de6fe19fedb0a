//! Sound containers of which single things are changed: lengths and offsets hold, what they mean does not.

use std::collections::HashMap;

use arbitrary::{Arbitrary, Result, Unstructured};
use safetensors::tensor::TensorView;
use safetensors::{Dtype, SafeTensors};
use serde_json::Value;

use super::container::container;
use crate::corpus;

/// The key under which a container of ours describes itself.
const KEY: &str = "bsdfkit";

/// An array, apart from its file.
struct Array {
    name: String,
    dtype: Dtype,
    shape: Vec<usize>,
    bytes: Vec<u8>,
}

/// Bytes as a container of the corpus and what is changed in it.
pub fn container_parts(bytes: &[u8]) {
    let mut choices = Unstructured::new(bytes);
    if let Ok(changed) = changed(&mut choices) {
        container(&changed);
    }
}

fn changed(choices: &mut Unstructured<'_>) -> Result<Vec<u8>> {
    let sound = choices.choose(corpus::containers())?;
    let (mut header, mut arrays) = apart(sound);
    for _ in 0..choices.int_in_range(1..=4)? {
        if choices.ratio(2, 5)? {
            describe(&mut header, choices)?;
        } else {
            alter(&mut arrays, choices)?;
        }
    }
    Ok(together(&header, &arrays))
}

fn apart(bytes: &[u8]) -> (Value, Vec<Array>) {
    let (_, declared) = SafeTensors::read_metadata(bytes).expect("the corpus is sound");
    let json = declared.metadata().as_ref().map(|m| &m[KEY]).expect("it is ours");
    let arrays = SafeTensors::deserialize(bytes).expect("the corpus is sound");
    let mut arrays: Vec<Array> = arrays
        .iter()
        .map(|(name, view)| Array {
            name: name.to_owned(),
            dtype: view.dtype(),
            shape: view.shape().to_vec(),
            bytes: view.data().to_vec(),
        })
        .collect();
    arrays.sort_by(|a, b| a.name.cmp(&b.name));
    (serde_json::from_str(json).expect("JSON"), arrays)
}

fn together(header: &Value, arrays: &[Array]) -> Vec<u8> {
    let views = arrays.iter().map(|a| {
        let view = TensorView::new(a.dtype, a.shape.clone(), &a.bytes);
        (a.name.as_str(), view.expect("bytes fit the shape"))
    });
    let told = HashMap::from([(KEY.to_owned(), header.to_string())]);
    safetensors::serialize(views, Some(told)).expect("names are unique")
}

/// Changes one value of the description: what is at the end of a walk by chance.
fn describe(value: &mut Value, choices: &mut Unstructured<'_>) -> Result<()> {
    match value {
        Value::Object(map) if !map.is_empty() => {
            let at = choices.choose_index(map.len())?;
            let key = map.keys().nth(at).expect("so many keys").clone();
            if choices.ratio(1, 16)? {
                map.remove(&key);
                return Ok(());
            }
            describe(&mut map[&key], choices)
        }
        Value::Array(all) if !all.is_empty() => {
            let at = choices.choose_index(all.len())?;
            match choices.int_in_range(0..=15)? {
                0 => drop(all.remove(at)),
                1 => all.push(all[at].clone()),
                _ => describe(&mut all[at], choices)?,
            }
            Ok(())
        }
        _ => {
            *value = match choices.int_in_range(0..=5)? {
                0 => Value::Null,
                1 => bool::arbitrary(choices)?.into(),
                2 => {
                    choices.choose(&["", "none", "front", "bilateral-x", "Klems Full"])?[..].into()
                }
                3 => Value::Array(vec![value.clone(); choices.int_in_range(0..=3)?]),
                4 => u64::from(*choices.choose(&INTEGERS)?).into(),
                _ => number(choices)?.into(),
            };
            Ok(())
        }
    }
}

/// Integers at the edges of what is expected.
const INTEGERS: [u32; 10] = [0, 1, 2, 3, 7, 64, 65_535, 1 << 20, i32::MAX as u32, u32::MAX];

/// A number of any size, often one that breaks things.
fn number(choices: &mut Unstructured<'_>) -> Result<f64> {
    let hard = [0.0, -0.0, 1.0, -1.0, 1e-300, 1e300, 1e38, 5e-324, f64::NAN, f64::INFINITY, 90.0];
    match choices.int_in_range(0..=2)? {
        0 => f64::arbitrary(choices),
        1 => Ok(f64::from(choices.int_in_range(-100..=100)?) / 16.0),
        _ => choices.choose(&hard).copied(),
    }
}

/// Changes one array: a value, its length, its type, its name, whether it is there.
fn alter(arrays: &mut Vec<Array>, choices: &mut Unstructured<'_>) -> Result<()> {
    if arrays.is_empty() {
        return Ok(());
    }
    let at = choices.choose_index(arrays.len())?;
    let others: Vec<String> = arrays.iter().map(|a| a.name.clone()).collect();
    let array = &mut arrays[at];
    let row = array.bytes.len() / array.shape.first().copied().unwrap_or(1).max(1);
    match choices.int_in_range(0..=15)? {
        0 => drop(arrays.remove(at)),
        1 => array.name.push('x'),
        2 => {
            let name = choices.choose(&others)?;
            if arrays.iter().all(|a| &a.name != name) {
                arrays[at].name.clone_from(name);
            }
        }
        // Fewer or more of the first dimension.
        3 | 4 if !array.shape.is_empty() => {
            let rows = choices.int_in_range(0..=2 * array.shape[0].min(1 << 12))?;
            array.bytes.resize(rows * row, 0);
            array.shape[0] = rows;
        }
        // Dimensions that trade places.
        5 => array.shape.reverse(),
        6 => {
            array.shape = vec![array.bytes.len()];
            array.dtype = Dtype::U8;
        }
        _ => value(array, choices)?,
    }
    Ok(())
}

/// Some values of an array, by its type.
fn value(array: &mut Array, choices: &mut Unstructured<'_>) -> Result<()> {
    let size = match array.dtype {
        Dtype::F64 => 8,
        Dtype::F32 | Dtype::U32 => 4,
        Dtype::F16 => 2,
        _ => 1,
    };
    let count = array.bytes.len() / size;
    if count == 0 {
        return Ok(());
    }
    let first = choices.choose_index(count)?;
    let many = choices.int_in_range(1..=4)?.min(count - first);
    let x = number(choices)?;
    let n = *choices.choose(&INTEGERS)?;
    let n = if choices.ratio(1, 2)? { n } else { u32::arbitrary(choices)? };
    for place in array.bytes[size * first..].chunks_exact_mut(size).take(many) {
        match array.dtype {
            Dtype::F64 => place.copy_from_slice(&x.to_le_bytes()),
            Dtype::F32 => place.copy_from_slice(&(x as f32).to_le_bytes()),
            Dtype::U32 => place.copy_from_slice(&n.to_le_bytes()),
            Dtype::F16 => place.copy_from_slice(&(n as u16).to_le_bytes()),
            _ => place.fill(n as u8),
        }
    }
    Ok(())
}
