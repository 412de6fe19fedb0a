//! Arrays → BSDF: everything is checked before it is used.

use std::path::Path;

use safetensors::{Dtype, SafeTensors};

use super::{Header, KEY, KIND, LAMBERTIAN_ROWS, Representation, VERSION};
use crate::matrix::{KlemsBasis, KlemsMatrix, Ring};
use crate::tree::{Rank, TensorTree, TreeDistribution};
use crate::{Bsdf, Component, Error, Lambertian, Result, Xyz};

/// Reads a BSDF from a file.
///
/// Errors: io; format, with the file and the array, for whatever [`save`](super::save) would not
/// have written.
pub fn load(path: impl AsRef<Path>) -> Result<Bsdf> {
    let path = path.as_ref();
    let bytes = std::fs::read(path).map_err(|e| Error::io(path.display(), &e))?;
    from_bytes(&bytes).map_err(|e| e.context(path.display()))
}

/// Reads a BSDF from the content of a file.
///
/// Errors: format, as [`load`].
pub fn from_bytes(bytes: &[u8]) -> Result<Bsdf> {
    let unreadable = |e| Error::format(format!("safetensors: {e}"));
    let (_, declared) = SafeTensors::read_metadata(bytes).map_err(unreadable)?;
    let arrays = Arrays(SafeTensors::deserialize(bytes).map_err(unreadable)?);
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
        components.push(match &c.representation {
            Representation::Tree => {
                Component::new(incident, scattered, arrays.tree_distribution(&name)?)
            }
            Representation::Matrix { incident_basis, scattered_basis } => {
                let matrix = arrays.matrix(&name, incident_basis, scattered_basis)?;
                Component::new(incident, scattered, matrix)
            }
        });
    }
    Ok(Bsdf::new(header.material, components, arrays.lambertian()?))
}

struct Arrays<'a>(SafeTensors<'a>);

impl Arrays<'_> {
    fn has(&self, name: &str) -> bool {
        self.0.tensor(name).is_ok()
    }

    /// Elements of `N` bytes each, and the shape, of an array of `rank` dimensions.
    fn array<const N: usize, T>(
        &self,
        name: &str,
        dtype: Dtype,
        rank: usize,
        element: impl Fn([u8; N]) -> T,
    ) -> Result<(Vec<usize>, Vec<T>)> {
        let array = self.0.tensor(name).map_err(|_| Error::format(format!("{name}: missing")))?;
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
