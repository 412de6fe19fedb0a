//! BSDF → arrays.

use std::collections::HashMap;
use std::io::Write;
use std::path::Path;

use safetensors::{Dtype, View};

use super::{
    Compiled, Described, Header, KEY, KIND, LAMBERTIAN_ROWS, Representation, VERSION,
    VERSION_OF_PEAKS, hue, render, specular,
};
use crate::matrix::{KlemsBasis, KlemsMatrix};
use crate::render::RenderTable;
use crate::tree::{Rank, Slices, TensorTree, TreeDistribution};
use crate::words::Word;
use crate::{Bsdf, Error, Result, Sense, replace_file};

/// Writes `bsdf` to `path`: into a temporary file beside it, then renamed.
///
/// Errors: io; argument for a component that is neither tree, matrix nor render form.
pub fn save(bsdf: &Bsdf, path: impl AsRef<Path>) -> Result<()> {
    let path = path.as_ref();
    let bytes = to_bytes(bsdf).map_err(|e| e.context(path.display()))?;
    replace_file(path, |out| out.write_all(&bytes).map_err(|e| Error::io("writing", &e)))
}

/// The content of the file: the same bytes for the same BSDF.
///
/// Errors: as [`save`], without io.
pub fn to_bytes(bsdf: &Bsdf) -> Result<Vec<u8>> {
    let mut arrays = Arrays(Vec::new());
    let mut components = Vec::new();
    let lambertian = LAMBERTIAN_ROWS.map(|(i, s)| bsdf.explicit_lambertian().get(i, s));
    let values = lambertian.iter().flat_map(|c| [c.x, c.y, c.z]).flat_map(f64::to_le_bytes);
    arrays.push("lambertian".into(), Dtype::F64, vec![4, 3], values.collect());
    for (n, c) in bsdf.components().iter().enumerate() {
        let name = format!("component.{n}");
        let distribution = c.distribution();
        let (mut depths, mut spectra) = (Vec::new(), None);
        let representation = if let Some(tree) = distribution.downcast_ref::<TreeDistribution>() {
            arrays.tree_distribution(&name, tree);
            spectra = tree.hues().map(|hues| {
                let (name, rank) = (format!("{name}.tree"), hues.hue.basis().rank());
                let shape = vec![hues.coefficients.len() / rank, rank];
                arrays.words(format!("{name}.hue"), Dtype::U8, shape, &hues.coefficients);
                hue::save(&mut arrays, &name, &hues.hue)
            });
            arrays.slices(&format!("{name}.tree.y.forward"), tree.slices(Sense::Forward));
            let reversed = bsdf.is_reversed(c.scattered, c.incident);
            if reversed && tree.luminance().rank() == Rank::Four {
                arrays.slices(&format!("{name}.tree.y.reverse"), tree.slices(Sense::Reverse));
            }
            let chromaticity = tree.chromaticity().into_iter().flatten();
            let trees = std::iter::once(tree.luminance()).chain(chromaticity);
            depths.extend(trees.map(TensorTree::depth));
            Representation::Tree
        } else if let Some(matrix) = distribution.downcast_ref::<KlemsMatrix>() {
            arrays.matrix(&name, matrix);
            Representation::Matrix {
                incident_basis: matrix.incident().name().to_owned(),
                scattered_basis: matrix.scattered().name().to_owned(),
            }
        } else if let Some(table) = distribution.downcast_ref::<RenderTable>() {
            Representation::Render(render::save(&mut arrays, &format!("{name}.render"), table))
        } else {
            return Err(Error::argument(format!(
                "{name}: expected a tree, a matrix or the render form, found another representation"
            )));
        };
        let (incident, scattered) = (c.incident.into(), c.scattered.into());
        let compiled = Compiled {
            floor: [c.floor().x, c.floor().y, c.floor().z],
            negligible: c.is_negligible(),
            depths,
        };
        components.push(Described {
            incident,
            scattered,
            representation,
            compiled: Some(compiled),
            spectra,
        });
    }
    let material = bsdf.metadata().clone();
    let peaks = bsdf.specular().iter().enumerate();
    let specular: Vec<_> = peaks.map(|(k, peak)| specular::save(&mut arrays, k, peak)).collect();
    let version = if specular.is_empty() { VERSION } else { VERSION_OF_PEAKS };
    let header = Header { kind: KIND.to_owned(), version, material, components, specular };
    let fault = |e: &dyn std::fmt::Display| Error::argument(format!("container: {e}"));
    let json = serde_json::to_string(&header).map_err(|e| fault(&e))?;
    let metadata = HashMap::from([(KEY.to_owned(), json)]);
    safetensors::serialize(arrays.0, Some(metadata)).map_err(|e| fault(&e))
}

struct Array {
    dtype: Dtype,
    shape: Vec<usize>,
    bytes: Vec<u8>,
}

impl View for Array {
    fn dtype(&self) -> Dtype {
        self.dtype
    }
    fn shape(&self) -> &[usize] {
        &self.shape
    }
    fn data(&self) -> std::borrow::Cow<'_, [u8]> {
        (&self.bytes).into()
    }
    fn data_len(&self) -> usize {
        self.bytes.len()
    }
}

pub(super) struct Arrays(Vec<(String, Array)>);

impl Arrays {
    pub(super) fn push(&mut self, name: String, dtype: Dtype, shape: Vec<usize>, bytes: Vec<u8>) {
        self.0.push((name, Array { dtype, shape, bytes }));
    }

    pub(super) fn words<T: Word>(
        &mut self,
        name: String,
        dtype: Dtype,
        shape: Vec<usize>,
        words: &[T],
    ) {
        let mut bytes = Vec::with_capacity(size_of_val(words));
        words.iter().for_each(|word| word.put(&mut bytes));
        self.push(name, dtype, shape, bytes);
    }

    fn tree_distribution(&mut self, name: &str, trees: &TreeDistribution) {
        self.tree(&format!("{name}.tree.y"), trees.luminance());
        if let Some([u, v]) = trees.chromaticity() {
            self.tree(&format!("{name}.tree.u"), u);
            self.tree(&format!("{name}.tree.v"), v);
        }
    }

    fn tree(&mut self, name: &str, tree: &TensorTree) {
        let slots = tree.slots().iter().flat_map(|s| s.to_le_bytes()).collect();
        let shape = vec![tree.branch_count(), tree.rank().children()];
        self.push(format!("{name}.slots"), Dtype::U32, shape, slots);
        let root = tree.root_slot().to_le_bytes().to_vec();
        self.push(format!("{name}.root"), Dtype::U32, vec![1], root);
    }

    fn slices(&mut self, name: &str, slices: &Slices) {
        let tables = slices.tables();
        let mut push = |array: &str, words: &[u32], shape| {
            let bytes = words.iter().flat_map(|w| w.to_le_bytes()).collect();
            self.push(format!("{name}.{array}"), Dtype::U32, shape, bytes);
        };
        push("index", &tables.index, vec![tables.index.len()]);
        push("slices", &tables.slices, vec![tables.slices.len() / 3, 3]);
        push("records", &tables.records, vec![tables.records.len() / 8, 8]);
    }

    fn matrix(&mut self, name: &str, matrix: &KlemsMatrix) {
        let (incident, scattered) = (matrix.incident(), matrix.scattered());
        let mut values = |channel: &str, values: &[f32]| {
            let bytes = values.iter().flat_map(|v| v.to_le_bytes()).collect();
            let shape = vec![incident.directions(), scattered.directions()];
            self.push(format!("{name}.matrix.{channel}"), Dtype::F32, shape, bytes);
        };
        values("y", matrix.values());
        if let Some([x, z]) = matrix.chromatic() {
            values("x", x);
            values("z", z);
        }
        self.rings(format!("{name}.matrix.incident_rings"), incident);
        self.rings(format!("{name}.matrix.scattered_rings"), scattered);
    }

    fn rings(&mut self, name: String, basis: &KlemsBasis) {
        let rows = basis.rings().iter().flat_map(|r| [r.upper_degrees, r.patches as f64]);
        let bytes = rows.flat_map(f64::to_le_bytes).collect();
        self.push(name, Dtype::F64, vec![basis.rings().len(), 2], bytes);
    }
}
