//! Arrays → BSDF: everything is checked before it is used.

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use safetensors::tensor::{Metadata, TensorInfo};
use safetensors::{Dtype, SafeTensors};

use super::{
    Compiled, Header, KEY, KIND, LAMBERTIAN_ROWS, Representation, VERSION, VERSION_OF_PEAKS, hue,
    render, specular,
};
use crate::limits::{CONTAINER_BYTES, open_file, read_file};
use crate::matrix::{KlemsBasis, KlemsMatrix, Ring};
use crate::tree::{Rank, Slices, Tables, TensorTree, TreeDistribution, TreeHues};
use crate::words::{Bytes, Words};
use crate::{Bsdf, Component, Distribution, Error, Lambertian, Result, Sense, Side, Xyz};

/// Reads a BSDF from a file.
///
/// Errors: io; format, with the file and the array, for whatever [`save`](super::save) would not
/// have written; limit above 4 GiB.
pub fn load(path: impl AsRef<Path>) -> Result<Bsdf> {
    let path = path.as_ref();
    let bytes = read_file(path, CONTAINER_BYTES)?;
    from_bytes(&bytes).map_err(|e| e.context(path.display()))
}

/// Opens a BSDF in place: maps the file into memory (a small one it reads) and looks at no more than its
/// header, its matrices and its trees of rank 3.
///
/// Of trees of rank 4 a page is read when a query first needs it, and every index is checked as
/// it is used: in a damaged file wrong values come out, and nothing worse; [`load`] finds the damage.
/// The file must stay as it is while it is open: replace it by renaming, as
/// [`save`](super::save) does. Cut short in place, it ends the process by a signal.
///
/// Errors: as [`load`], as far as is read.
/// Cost: 30 µs for a tree of any size; 13 µs for a matrix of 145 × 145 values, of which 6 are the system's to
/// read the file and 5 go into the header.
pub fn open(path: impl AsRef<Path>) -> Result<Bsdf> {
    let path = path.as_ref();
    let io = |e: std::io::Error| Error::io(path.display(), &e);
    let file = open_file(path)?;
    let size = file.metadata().map_err(io)?.len();
    if size > CONTAINER_BYTES {
        let text = format!("expected at most {CONTAINER_BYTES} bytes, found {size}");
        return Err(Error::limit(text).context(path.display()));
    }
    let file = Bytes::of(file).map_err(io)?;
    read(&file, Some(&file)).map_err(|e| e.context(path.display()))
}

/// Reads a BSDF from the content of a file.
///
/// Errors: format, as [`load`].
pub fn from_bytes(bytes: &[u8]) -> Result<Bsdf> {
    read(bytes, None)
}

/// `file` is what `bytes` are of, where arrays may stay in it.
fn read(bytes: &[u8], file: Option<&Arc<Bytes>>) -> Result<Bsdf> {
    let (header_length, declared) = SafeTensors::read_metadata(bytes)
        .map_err(|e| Error::format(format!("safetensors: {e}")))?;
    let arrays = Arrays { declared, bytes, start: 8 + header_length, file };
    let Some(json) = arrays.declared.metadata().as_ref().and_then(|m| m.get(KEY)) else {
        return Err(Error::format(format!("__metadata__: expected the key {KEY:?}")));
    };
    let header: Header = serde_json::from_str(json)
        .map_err(|e| Error::format(format!("__metadata__/{KEY}: {e}")))?;
    if header.kind != KIND || !(VERSION..=VERSION_OF_PEAKS).contains(&header.version) {
        return Err(Error::format(format!(
            "__metadata__/{KEY}: expected kind {KIND:?} of version {VERSION} or {VERSION_OF_PEAKS}, found {:?} of version {}",
            header.kind, header.version
        )));
    }
    let mut components = Vec::new();
    for (n, c) in header.components.iter().enumerate() {
        let name = format!("component.{n}");
        let (incident, scattered) = (c.incident.into(), c.scattered.into());
        components.push(match (&c.representation, &c.compiled) {
            (Representation::Tree, Some(compiled)) if file.is_some() => {
                let trees = arrays.compiled_trees(&name, compiled)?;
                let trees = arrays.with_hues(&name, trees, c.spectra.as_ref())?;
                compiled.component((incident, scattered), trees)
            }
            (Representation::Tree, _) => {
                let trees = arrays.tree_distribution(&name)?;
                let trees = arrays.with_hues(&name, trees, c.spectra.as_ref())?;
                Component::new(incident, scattered, trees)
            }
            (Representation::Matrix { incident_basis, scattered_basis }, compiled) => {
                let matrix = arrays.matrix(&name, incident_basis, scattered_basis)?;
                match compiled.as_ref().filter(|_| file.is_some()) {
                    Some(compiled) => compiled.component((incident, scattered), matrix),
                    None => Component::new(incident, scattered, matrix),
                }
            }
            (Representation::Render(described), _) => {
                let table = render::load(&arrays, &format!("{name}.render"), described)?;
                Component::new(incident, scattered, table)
            }
        });
    }
    let peaks = header.specular.iter().enumerate();
    let peaks = peaks.map(|(k, described)| specular::load(&arrays, k, described));
    let peaks = peaks.collect::<Result<Vec<_>>>()?;
    Ok(Bsdf::new(header.material, components, arrays.lambertian()?).with_specular(peaks))
}

impl Compiled {
    fn component(&self, sides: (Side, Side), distribution: impl Distribution) -> Component {
        let [x, y, z] = self.floor;
        Component::compiled(sides, distribution, Xyz::new(x, y, z), self.negligible)
    }
}

pub(super) struct Arrays<'a> {
    declared: Metadata,
    pub(super) bytes: &'a [u8],
    /// Offset of the first array.
    start: usize,
    pub(super) file: Option<&'a Arc<Bytes>>,
}

impl Arrays<'_> {
    pub(super) fn has(&self, name: &str) -> bool {
        self.declared.info(name).is_some()
    }

    /// What is said of an array, and where its bytes are.
    fn find(&self, name: &str) -> Result<(&TensorInfo, Range<usize>)> {
        let info =
            self.declared.info(name).ok_or_else(|| Error::format(format!("{name}: missing")))?;
        let (first, end) = info.data_offsets;
        Ok((info, self.start + first..self.start + end))
    }

    /// The shape of an array of that type and of `rank` dimensions, and where its bytes are.
    pub(super) fn place(
        &self,
        name: &str,
        dtype: Dtype,
        rank: usize,
    ) -> Result<(&[usize], Range<usize>)> {
        let (info, place) = self.find(name)?;
        let found = (info.dtype, info.shape.len());
        if found != (dtype, rank) {
            return Err(Error::format(format!(
                "{name}: expected {dtype:?} in {rank} dimensions, found {:?} in {}",
                found.0, found.1
            )));
        }
        Ok((&info.shape, place))
    }

    /// Elements of `N` bytes each, and the shape, of an array of `rank` dimensions.
    pub(super) fn array<const N: usize, T>(
        &self,
        name: &str,
        dtype: Dtype,
        rank: usize,
        element: impl Fn([u8; N]) -> T,
    ) -> Result<(&[usize], Vec<T>)> {
        let (shape, place) = self.place(name, dtype, rank)?;
        let values = self.bytes[place].as_chunks::<N>().0.iter().map(|bytes| element(*bytes));
        Ok((shape, values.collect()))
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

    /// A tree with its spectra, if it has some.
    fn with_hues(
        &self,
        name: &str,
        trees: TreeDistribution,
        described: Option<&hue::Described>,
    ) -> Result<TreeDistribution> {
        let Some(described) = described else { return Ok(trees) };
        let name = format!("{name}.tree");
        let hue = hue::load(self, &name, described)?;
        let name = format!("{name}.hue");
        let (_, place) = self.place(&name, Dtype::U8, 2)?;
        let coefficients = match self.file {
            Some(file) => Words::in_place(file, place),
            None => Words::copied(&self.bytes[place]),
        };
        trees.with_hues(TreeHues { hue, coefficients }).map_err(|e| format_of(&name, &e))
    }

    /// An array of u32 in `columns` (0: one dimension), left in the file.
    fn words(&self, name: &str, columns: usize) -> Result<Words> {
        let (info, place) = self.find(name)?;
        let shape_fits = match info.shape.as_slice() {
            [_] => columns == 0,
            [_, n] => *n == columns,
            _ => false,
        };
        let Some(file) = self.file.filter(|_| info.dtype == Dtype::U32 && shape_fits) else {
            let (dtype, shape) = (info.dtype, &info.shape);
            return Err(Error::format(format!(
                "{name}: expected U32 in rows of {columns}, found {dtype:?} of shape {shape:?}"
            )));
        };
        Ok(Words::in_place(file, place))
    }

    /// Trees with what queries need of them, nothing looked through.
    fn compiled_trees(&self, name: &str, compiled: &Compiled) -> Result<TreeDistribution> {
        let trees = ["y", "u", "v"].iter().zip(&compiled.depths).map(|(channel, depth)| {
            let name = format!("{name}.tree.{channel}");
            let slots = format!("{name}.slots");
            let columns = self.declared.info(&slots).and_then(|info| info.shape.get(1));
            if columns != Some(&16) {
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
        let incident = self.basis(&format!("{name}.matrix.incident_rings"), incident, None)?;
        let rings = format!("{name}.matrix.scattered_rings");
        let scattered = self.basis(&rings, scattered, Some(&incident))?;
        let expected = [incident.directions(), scattered.directions()];
        let values = |channel: &str| {
            let name = format!("{name}.matrix.{channel}");
            let (shape, place) = self.place(&name, Dtype::F32, 2)?;
            if shape != expected {
                let text = format!("{name}: expected shape {expected:?}, found {shape:?}");
                return Err(Error::format(text));
            }
            Ok(match self.file {
                Some(file) => Words::in_place(file, place),
                None => Words::copied(&self.bytes[place]),
            })
        };
        let y = values("y")?;
        let coloured = self.has(&format!("{name}.matrix.x"));
        let chromatic = if coloured { Some([values("x")?, values("z")?]) } else { None };
        KlemsMatrix::of_words(incident, scattered, y, chromatic).map_err(|e| format_of(name, &e))
    }

    /// A basis of a name and of the rings in an array; a copy of `known` if it is that one.
    fn basis(&self, array: &str, name: &str, known: Option<&KlemsBasis>) -> Result<KlemsBasis> {
        let (shape, values) = self.array(array, Dtype::F64, 2, f64::from_le_bytes)?;
        if shape[1] != 2 {
            return Err(Error::format(format!("{array}: expected rows of 2, found {}", shape[1])));
        }
        // The cast saturates, and a basis refuses what is not a possible number.
        let ring = |row: &[f64]| Ring { upper_degrees: row[0], patches: row[1] as usize };
        let rings: Vec<Ring> = values.chunks(2).map(ring).collect();
        match known.filter(|known| known.name() == name && known.rings() == rings) {
            Some(known) => Ok(known.clone()),
            None => KlemsBasis::new(name, rings).map_err(|e| format_of(array, &e)),
        }
    }
}

/// What is an argument's fault in memory is the file's fault here.
pub(super) fn format_of(name: &str, error: &Error) -> Error {
    Error::format(format!("{name}: {error}"))
}
