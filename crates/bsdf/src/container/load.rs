//! Arrays → BSDF: everything is checked before it is used.

use std::fs::File;
use std::path::Path;
use std::sync::Arc;

use memmap2::Mmap;
use safetensors::{Dtype, SafeTensors};

use super::{Compiled, Header, KEY, KIND, LAMBERTIAN_ROWS, Representation, VERSION};
use crate::matrix::{KlemsBasis, KlemsMatrix, Ring};
use crate::tree::{Rank, Slices, Tables, TensorTree, TreeDistribution};
use crate::words::{self, Words};
use crate::{Bsdf, Component, Error, Lambertian, Result, Sense, Xyz};

/// Reads a BSDF from a file.
///
/// Errors: io; format, with the file and the array, for whatever [`save`](super::save) would not
/// have written.
pub fn load(path: impl AsRef<Path>) -> Result<Bsdf> {
    let path = path.as_ref();
    let bytes = std::fs::read(path).map_err(|e| Error::io(path.display(), &e))?;
    from_bytes(&bytes).map_err(|e| e.context(path.display()))
}

/// Opens a BSDF in place: maps the file into memory and reads no more than its header, its matrices
/// and its trees of rank 3.
///
/// Of trees of rank 4 a page is read when a query first needs it, and every index is checked as
/// it is used: in a damaged file wrong values come out, and nothing worse; [`load`] finds the damage.
/// The file must stay as it is while it is open: replace it by renaming, as
/// [`save`](super::save) does. Cut short in place, it ends the process by a signal.
///
/// Errors: as [`load`], as far as is read.
/// Cost: 0.2 ms for a tree of any size.
pub fn open(path: impl AsRef<Path>) -> Result<Bsdf> {
    let path = path.as_ref();
    let io = |e: std::io::Error| Error::io(path.display(), &e);
    let file = File::open(path).map_err(io)?;
    let mapped = words::map(&file).map_err(io)?;
    read(&mapped, Some(&mapped)).map_err(|e| e.context(path.display()))
}

/// Reads a BSDF from the content of a file.
///
/// Errors: format, as [`load`].
pub fn from_bytes(bytes: &[u8]) -> Result<Bsdf> {
    read(bytes, None)
}

/// `mapped` is the file that `bytes` are of, where arrays may stay in it.
fn read(bytes: &[u8], mapped: Option<&Arc<Mmap>>) -> Result<Bsdf> {
    let unreadable = |e| Error::format(format!("safetensors: {e}"));
    let (_, declared) = SafeTensors::read_metadata(bytes).map_err(unreadable)?;
    let tensors = SafeTensors::deserialize(bytes).map_err(unreadable)?;
    let arrays = Arrays { tensors, start: bytes.as_ptr().addr(), mapped };
    let Some(json) = declared.metadata().as_ref().and_then(|m| m.get(KEY)) else {
        return Err(Error::format(format!("__metadata__: expected the key {KEY:?}")));
    };
    let header: Header = serde_json::from_str(json)
        .map_err(|e| Error::format(format!("__metadata__/{KEY}: {e}")))?;
    if (header.kind.as_str(), header.version) != (KIND, VERSION) {
        return Err(Error::format(format!(
            "__metadata__/{KEY}: expected kind {KIND:?} of version {VERSION}, found {:?} of version {}",
            header.kind, header.version
        )));
    }
    let mut components = Vec::new();
    for (n, c) in header.components.iter().enumerate() {
        let name = format!("component.{n}");
        let (incident, scattered) = (c.incident.into(), c.scattered.into());
        components.push(match (&c.representation, &c.compiled) {
            (Representation::Tree, Some(compiled)) if mapped.is_some() => {
                let trees = arrays.compiled_trees(&name, compiled)?;
                let [x, y, z] = compiled.floor;
                let floor = Xyz::new(x, y, z);
                Component::compiled((incident, scattered), trees, floor, compiled.negligible)
            }
            (Representation::Tree, _) => {
                Component::new(incident, scattered, arrays.tree_distribution(&name)?)
            }
            (Representation::Matrix { incident_basis, scattered_basis }, _) => {
                let matrix = arrays.matrix(&name, incident_basis, scattered_basis)?;
                Component::new(incident, scattered, matrix)
            }
        });
    }
    Ok(Bsdf::new(header.material, components, arrays.lambertian()?))
}

struct Arrays<'a> {
    tensors: SafeTensors<'a>,
    /// Address of the first byte.
    start: usize,
    mapped: Option<&'a Arc<Mmap>>,
}

impl Arrays<'_> {
    fn has(&self, name: &str) -> bool {
        self.tensors.tensor(name).is_ok()
    }

    /// Elements of `N` bytes each, and the shape, of an array of `rank` dimensions.
    fn array<const N: usize, T>(
        &self,
        name: &str,
        dtype: Dtype,
        rank: usize,
        element: impl Fn([u8; N]) -> T,
    ) -> Result<(Vec<usize>, Vec<T>)> {
        let array =
            self.tensors.tensor(name).map_err(|_| Error::format(format!("{name}: missing")))?;
        let found = (array.dtype(), array.shape().len());
        if found != (dtype, rank) {
            return Err(Error::format(format!(
                "{name}: expected {dtype:?} in {rank} dimensions, found {:?} in {}",
                found.0, found.1
            )));
        }
        let values = array.data().as_chunks::<N>().0.iter().map(|bytes| element(*bytes));
        Ok((array.shape().to_vec(), values.collect()))
    }

    fn lambertian(&self) -> Result<Lambertian> {
        let name = "lambertian";
        let (shape, values) = self.array(name, Dtype::F64, 2, f64::from_le_bytes)?;
        if shape != [4, 3] {
            return Err(Error::format(format!("{name}: expected shape [4, 3], found {shape:?}")));
        }
        if let Some(bad) = values.iter().find(|v| !(v.is_finite() && **v >= 0.0)) {
            return Err(Error::format(format!(
                "{name}: expected finite values of at least 0, found {bad}"
            )));
        }
        let mut fields = Lambertian::default();
        for ((incident, scattered), c) in LAMBERTIAN_ROWS.into_iter().zip(values.chunks(3)) {
            *fields.get_mut(incident, scattered) = Xyz::new(c[0], c[1], c[2]);
        }
        Ok(fields)
    }

    fn tree_distribution(&self, name: &str) -> Result<TreeDistribution> {
        let y = self.tree(&format!("{name}.tree.y"))?;
        if !self.has(&format!("{name}.tree.u.slots")) {
            return Ok(TreeDistribution::new(y));
        }
        let u = self.tree(&format!("{name}.tree.u"))?;
        let v = self.tree(&format!("{name}.tree.v"))?;
        TreeDistribution::with_chromaticity(y, u, v).map_err(|e| format_of(name, &e))
    }

    /// An array of u32 in `columns` (0: one dimension), left in the file.
    fn words(&self, name: &str, columns: usize) -> Result<Words> {
        let array =
            self.tensors.tensor(name).map_err(|_| Error::format(format!("{name}: missing")))?;
        let shape_fits = match array.shape() {
            [_] => columns == 0,
            [_, n] => *n == columns,
            _ => false,
        };
        let Some(mapped) = self.mapped.filter(|_| array.dtype() == Dtype::U32 && shape_fits) else {
            let (dtype, shape) = (array.dtype(), array.shape());
            return Err(Error::format(format!(
                "{name}: expected U32 in rows of {columns}, found {dtype:?} of shape {shape:?}"
            )));
        };
        let first = array.data().as_ptr().addr() - self.start;
        Ok(Words::mapped(mapped, first..first + array.data().len()))
    }

    /// Trees with what queries need of them, nothing looked through.
    fn compiled_trees(&self, name: &str, compiled: &Compiled) -> Result<TreeDistribution> {
        let trees = ["y", "u", "v"].iter().zip(&compiled.depths).map(|(channel, depth)| {
            let name = format!("{name}.tree.{channel}");
            let slots = format!("{name}.slots");
            let shape = self.tensors.tensor(&slots).map(|t| t.shape().to_vec()).unwrap_or_default();
            if shape.get(1) != Some(&16) {
                // The walks of the reverse sense of rank 3 need a sound tree; it is small.
                return self.tree(&name);
            }
            let root = self.words(&format!("{name}.root"), 0)?;
            let root = root.first().copied().unwrap_or(0);
            Ok(TensorTree::unchecked(Rank::Four, root, self.words(&slots, 16)?, *depth))
        });
        let mut trees = trees.collect::<Result<Vec<_>>>()?.into_iter();
        let trees = match (trees.next(), trees.next(), trees.next()) {
            (Some(y), None, _) => TreeDistribution::new(y),
            (Some(y), Some(u), Some(v)) => {
                TreeDistribution::with_chromaticity(y, u, v).map_err(|e| format_of(name, &e))?
            }
            _ => return Err(Error::format(format!("{name}: expected the depths of 1 or 3 trees"))),
        };
        let senses = [(Sense::Forward, "forward"), (Sense::Reverse, "reverse")];
        senses.into_iter().try_fold(trees, |trees, (sense, word)| {
            let name = format!("{name}.tree.y.{word}");
            if !self.has(&format!("{name}.index")) {
                return Ok(trees);
            }
            let tables = Tables {
                index: self.words(&format!("{name}.index"), 0)?,
                slices: self.words(&format!("{name}.slices"), 3)?,
                records: self.words(&format!("{name}.records"), 8)?,
            };
            let slices = Slices::unchecked(trees.luminance(), sense, tables);
            Ok(trees.with_slices(sense, slices))
        })
    }

    fn tree(&self, name: &str) -> Result<TensorTree> {
        let slots_name = format!("{name}.slots");
        let (shape, slots) = self.array(&slots_name, Dtype::U32, 2, u32::from_le_bytes)?;
        let rank = match shape[1] {
            8 => Rank::Three,
            16 => Rank::Four,
            n => {
                return Err(Error::format(format!(
                    "{slots_name}: expected 8 or 16 slots a branch, found {n}"
                )));
            }
        };
        let root_name = format!("{name}.root");
        let (_, root) = self.array(&root_name, Dtype::U32, 1, u32::from_le_bytes)?;
        let &[root] = root.as_slice() else {
            let found = root.len();
            return Err(Error::format(format!("{root_name}: expected 1 value, found {found}")));
        };
        TensorTree::from_slots(rank, root, slots).map_err(|e| format_of(name, &e))
    }

    fn matrix(&self, name: &str, incident: &str, scattered: &str) -> Result<KlemsMatrix> {
        let incident = self.rings(&format!("{name}.matrix.incident_rings"), incident)?;
        let scattered = self.rings(&format!("{name}.matrix.scattered_rings"), scattered)?;
        let expected = [incident.directions(), scattered.directions()];
        let values = |channel: &str| {
            let name = format!("{name}.matrix.{channel}");
            let (shape, values) = self.array(&name, Dtype::F32, 2, f32::from_le_bytes)?;
            if shape == expected {
                Ok(values)
            } else {
                Err(Error::format(format!("{name}: expected shape {expected:?}, found {shape:?}")))
            }
        };
        let y = values("y")?;
        let coloured = self.has(&format!("{name}.matrix.x"));
        let chromatic = if coloured { Some((values("x")?, values("z")?)) } else { None };
        let matrix = KlemsMatrix::new(incident, scattered, y).map_err(|e| format_of(name, &e))?;
        match chromatic {
            None => Ok(matrix),
            Some((x, z)) => matrix.with_colour(x, z).map_err(|e| format_of(name, &e)),
        }
    }

    fn rings(&self, name: &str, basis: &str) -> Result<KlemsBasis> {
        let (shape, values) = self.array(name, Dtype::F64, 2, f64::from_le_bytes)?;
        if shape[1] != 2 {
            return Err(Error::format(format!("{name}: expected rows of 2, found {}", shape[1])));
        }
        // The cast saturates, and a basis refuses what is not a possible number.
        let ring = |row: &[f64]| Ring { upper_degrees: row[0], patches: row[1] as usize };
        let rings = values.chunks(2).map(ring).collect();
        KlemsBasis::new(basis, rings).map_err(|e| format_of(name, &e))
    }
}

/// What is an argument's fault in memory is the file's fault here.
fn format_of(name: &str, error: &Error) -> Error {
    Error::format(format!("{name}: {error}"))
}
