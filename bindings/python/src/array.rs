//! numpy arrays: arguments that broadcast over their leading axes, and results of their shape.

use std::borrow::Cow;

use numpy::ndarray::IxDyn;
use numpy::{
    PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyReadwriteArrayDyn, PyUntypedArrayMethods,
};
use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{IntoPyDict, PyTuple};

use crate::error::argument;

/// An argument as float64 in C order, whose elements are `width` numbers.
pub(crate) struct Argument<'py> {
    array: PyReadonlyArrayDyn<'py, f64>,
    width: usize,
    /// Axes before that of the element.
    leading: Vec<usize>,
}

impl<'py> Argument<'py> {
    /// Elements of three numbers.
    pub(crate) fn directions(name: &str, given: &Bound<'py, PyAny>) -> PyResult<Self> {
        Self::rows(name, given, 3)
    }

    /// Elements of `width` numbers, along the last axis.
    ///
    /// Errors: argument, where the last axis has another length.
    pub(crate) fn rows(name: &str, given: &Bound<'py, PyAny>, width: usize) -> PyResult<Self> {
        let array = as_float64(given)?;
        match array.shape() {
            [leading @ .., last] if *last == width => {
                let leading = leading.to_vec();
                Ok(Self { array, width, leading })
            }
            shape => Err(argument(format!(
                "{name}: expected a last axis of {width}, found the shape {}",
                written(shape)
            ))),
        }
    }

    /// Elements of one number: no axis of their own.
    pub(crate) fn numbers(given: &Bound<'py, PyAny>) -> PyResult<Self> {
        let array = as_float64(given)?;
        let leading = array.shape().to_vec();
        Ok(Self { array, width: 1, leading })
    }

    /// As many elements as a result of shape `shape` has, or a single one that counts for all.
    pub(crate) fn expanded(&self, shape: &[usize]) -> PyResult<Cow<'_, [f64]>> {
        let own = self.array.as_slice().map_err(|e| argument(e.to_string()))?;
        let results: usize = shape.iter().product();
        if own.len() == self.width || own.len() == results * self.width {
            return Ok(Cow::Borrowed(own));
        }
        let mut full = shape.to_vec();
        if self.array.ndim() > self.leading.len() {
            full.push(self.width);
        }
        let view = self.array.as_array();
        let view = view.broadcast(IxDyn(&full)).ok_or_else(|| argument("cannot be broadcast"))?;
        let mut copy = Vec::new();
        copy.try_reserve_exact(results * self.width)
            .map_err(|e| PyMemoryError::new_err(e.to_string()))?;
        copy.extend(view.iter());
        Ok(Cow::Owned(copy))
    }
}

/// The array itself where it can be, else a copy.
fn as_float64<'py>(given: &Bound<'py, PyAny>) -> PyResult<PyReadonlyArrayDyn<'py, f64>> {
    static ARRAY: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    if let Ok(array) = given.cast::<PyArrayDyn<f64>>()
        && array.is_c_contiguous()
        && let Ok(array) = array.try_readonly()
        && array.as_slice().is_ok()
    {
        return Ok(array);
    }
    let py = given.py();
    let options = [("dtype", "float64"), ("order", "C")].into_py_dict(py)?;
    let copy = ARRAY.import(py, "numpy", "array")?.call((given,), Some(&options))?;
    Ok(copy.cast::<PyArrayDyn<f64>>()?.try_readonly()?)
}

/// The shape that all arguments broadcast to, without the axis of the element.
///
/// Errors: argument, where two of them do not fit.
pub(crate) fn broadcast(arguments: &[(&str, &Argument<'_>)]) -> PyResult<Vec<usize>> {
    let axes = arguments.iter().map(|(_, a)| a.leading.len()).max().unwrap_or(0);
    let mut shape = vec![1; axes];
    for (_, a) in arguments {
        let first = axes - a.leading.len();
        for (common, &own) in shape[first..].iter_mut().zip(&a.leading) {
            match (*common, own) {
                (1, _) => *common = own,
                (_, 1) => {}
                (a, b) if a == b => {}
                _ => {
                    let shapes =
                        arguments.iter().map(|(n, a)| format!("{n} {}", written(&a.leading)));
                    let shapes: Vec<String> = shapes.collect();
                    return Err(argument(format!(
                        "expected leading axes that broadcast, found {}",
                        shapes.join(" and ")
                    )));
                }
            }
        }
    }
    Ok(shape)
}

fn written(shape: &[usize]) -> String {
    let lengths: Vec<String> = shape.iter().map(usize::to_string).collect();
    format!("({})", lengths.join(", "))
}

/// A new array to be filled.
///
/// Errors: numpy's `MemoryError`.
pub(crate) struct Output<'py> {
    array: Bound<'py, PyAny>,
    borrowed: PyReadwriteArrayDyn<'py, f64>,
}

impl<'py> Output<'py> {
    /// Of `shape`, and of elements with `width` numbers along one more axis unless there is one.
    pub(crate) fn new(py: Python<'py>, shape: &[usize], width: Option<usize>) -> PyResult<Self> {
        let shape: Vec<usize> = shape.iter().copied().chain(width).collect();
        let array = empty(py, &shape, "float64")?;
        let borrowed = array.cast::<PyArrayDyn<f64>>()?.try_readwrite()?;
        Ok(Self { array, borrowed })
    }

    /// Its numbers in C order.
    pub(crate) fn numbers(&mut self) -> PyResult<&mut [f64]> {
        self.borrowed.as_slice_mut().map_err(|e| argument(e.to_string()))
    }

    /// What Python gets: a number where there is no axis.
    pub(crate) fn finish(self) -> PyResult<Bound<'py, PyAny>> {
        drop(self.borrowed);
        finished(self.array)
    }
}

/// `numpy.empty`.
pub(crate) fn empty<'py>(
    py: Python<'py>,
    shape: &[usize],
    dtype: &str,
) -> PyResult<Bound<'py, PyAny>> {
    static EMPTY: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    EMPTY.import(py, "numpy", "empty")?.call1((PyTuple::new(py, shape)?, dtype))
}

/// An array as Python gets it: a number where it has no axis.
pub(crate) fn finished(array: Bound<'_, PyAny>) -> PyResult<Bound<'_, PyAny>> {
    let axes: usize = array.getattr("ndim")?.extract()?;
    if axes == 0 { array.get_item(PyTuple::empty(array.py())) } else { Ok(array) }
}
