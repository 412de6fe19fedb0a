//! Named arrays on their way into a safetensors file, and out of it with every fault named.

use std::borrow::Cow;

use bsdfkit::limits::{MAGNITUDE, is_plausible};
use bsdfkit::{Error, Result};
use safetensors::{Dtype, SafeTensors, View};

/// An array on its way into the file.
pub(crate) struct Array {
    pub(crate) dtype: Dtype,
    pub(crate) shape: Vec<usize>,
    pub(crate) bytes: Vec<u8>,
}

impl Array {
    pub(crate) fn f64(shape: &[usize], values: impl Iterator<Item = f64>) -> Self {
        let bytes = values.flat_map(f64::to_le_bytes).collect();
        Self { dtype: Dtype::F64, shape: shape.to_vec(), bytes }
    }
}

impl View for &Array {
    fn dtype(&self) -> Dtype {
        self.dtype
    }

    fn shape(&self) -> &[usize] {
        &self.shape
    }

    fn data(&self) -> Cow<'_, [u8]> {
        Cow::Borrowed(&self.bytes)
    }

    fn data_len(&self) -> usize {
        self.bytes.len()
    }
}

/// The arrays of one component, checked as they are taken.
pub(crate) struct Arrays<'a> {
    pub(crate) tensors: &'a SafeTensors<'a>,
    pub(crate) prefix: String,
}

impl Arrays<'_> {
    /// Whether there is an array of this name.
    pub(crate) fn holds(&self, name: &str) -> bool {
        self.tensors.tensor(&format!("{}.{name}", self.prefix)).is_ok()
    }

    /// Shape and bytes of an array of known type and number of dimensions.
    pub(crate) fn bytes(
        &self,
        name: &str,
        dtype: Dtype,
        dimensions: usize,
    ) -> Result<(Vec<usize>, &[u8])> {
        let place = format!("{}.{name}", self.prefix);
        let t = self.tensors.tensor(&place).map_err(|e| Error::format(format!("{place}: {e}")))?;
        if t.dtype() != dtype || t.shape().len() != dimensions {
            return Err(Error::format(format!(
                "{place}: expected {dtype:?} in {dimensions} dimensions, found {:?} {:?}",
                t.dtype(),
                t.shape()
            )));
        }
        Ok((t.shape().to_vec(), t.data()))
    }

    /// Rows of `WIDTH` plausible numbers.
    pub(crate) fn rows<const WIDTH: usize>(&self, name: &str) -> Result<Vec<[f64; WIDTH]>> {
        let (shape, bytes) = self.bytes(name, Dtype::F64, 2)?;
        if shape[1] != WIDTH {
            return Err(self.wrong(name, &format!("{WIDTH} columns"), &format!("{}", shape[1])));
        }
        let values: Vec<f64> = bytes
            .chunks_exact(8)
            .map(|c| f64::from_le_bytes(c.try_into().unwrap_or_default()))
            .collect();
        if let Some(bad) = values.iter().position(|v| !is_plausible(*v)) {
            return Err(self.wrong(
                name,
                &format!("finite numbers of at most {MAGNITUDE:e}"),
                &format!("{} at {bad}", values[bad]),
            ));
        }
        Ok(values.chunks_exact(WIDTH).map(|c| c.try_into().unwrap_or([0.0; WIDTH])).collect())
    }

    pub(crate) fn wrong(&self, name: &str, expected: &str, found: &str) -> Error {
        Error::format(format!("{}.{name}: expected {expected}, found {found}", self.prefix))
    }
}
