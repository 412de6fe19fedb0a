//! Writes a BSDF as Radiance and WINDOW read it.

use std::io::Write;
use std::path::Path;

use quick_xml::escape::escape;

use super::content::{Content, Entry, EntryData};
use super::kept::{BLOCKS, DEFINITION, LAYER, OPTICAL, ROOT};
use super::orientation;
use super::text::{Numbers, TreeText};
use crate::matrix::KlemsMatrix;
use crate::specular::cells::InCells;
use crate::tree::{Rank, TensorTree};
use crate::{Band, Bsdf, Error, Metadata, Result, Xyz, replace_file};

/// How to write.
#[derive(Clone, Debug, PartialEq)]
pub struct WriteOptions {
    /// Significant digits of values; 5 keep them to 5·10⁻⁵ relative, 9 keep every bit of an f32.
    pub digits: usize,
    /// Whether fields that WINDOW's engine or Radiance's pkgBSDF cannot do without and the metadata lack (name, sizes,
    /// emissivities, …) get the values of [`placeholders`](super::placeholders()), called so in a comment.
    pub window_fields: bool,
}

impl Default for WriteOptions {
    fn default() -> Self {
        Self { digits: 5, window_fields: true }
    }
}

/// Writes `bsdf` to `path`: into a temporary file beside it, then renamed.
///
/// Lambertian parts that no component holds are added to the values, or become a constant
/// component. Peaks of no width stand twice: in the narrowest cells, where Radiance and WINDOW find them, and in a block
/// of their own, from which reading gives back the peaks and the values without them.
///
/// Errors: io; argument: what the format cannot hold: trees of different rank or trees beside
/// matrices, coloured Lambertian parts over trees, digits outside 1 to 17.
pub fn write(bsdf: &Bsdf, path: impl AsRef<Path>, options: &WriteOptions) -> Result<()> {
    replace_file(path.as_ref(), |out| write_to(bsdf, out, options))
}

/// Writes `bsdf` to a stream; errors as [`write`].
pub fn write_to(bsdf: &Bsdf, out: &mut impl Write, options: &WriteOptions) -> Result<()> {
    if !(1..=17).contains(&options.digits) {
        let text = format!("digits: expected 1 to 17, found {}", options.digits);
        return Err(Error::argument(text));
    }
    if bsdf.specular().is_empty() {
        let file = Content::of(bsdf)?;
        return Writer { out, options, metadata: bsdf.metadata() }.file(&file, |_| Ok(()));
    }
    let in_cells = InCells::of(bsdf)?;
    let file = Content::of(&in_cells.bsdf)?;
    let constant = |sides| {
        let entry = file.entries.iter().find(|e| e.sides == sides);
        entry.map_or(0.0, |e| e.constant.y)
    };
    Writer { out, options, metadata: bsdf.metadata() }
        .file(&file, |writer| writer.specular(bsdf.specular(), &in_cells, constant))
}

pub(super) struct Writer<'w, W> {
    out: &'w mut W,
    pub(super) options: &'w WriteOptions,
    pub(super) metadata: &'w Metadata,
}

const HEAD: &str = "\
<WindowElement xmlns=\"http://windows.lbl.gov\" \
xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" \
xsi:schemaLocation=\"http://windows.lbl.gov/BSDF-v1.4.xsd\">";

impl<W: Write> Writer<'_, W> {
    pub(super) fn line(&mut self, text: impl std::fmt::Display) -> Result<()> {
        writeln!(self.out, "{text}").map_err(|e| Error::io("cannot write", &e))
    }

    pub(super) fn element(&mut self, name: &str, text: &str) -> Result<()> {
        self.line(format_args!("<{name}>{}</{name}>", escape(text)))
    }

    /// The elements below `parent` that were kept as they stood in the file read.
    pub(super) fn unread(&mut self, parent: &str) -> Result<()> {
        match self.metadata.unread.iter().find(|(place, _)| place == parent) {
            Some((_, text)) => self.line(text),
            None => Ok(()),
        }
    }

    /// The stream, for blocks of numbers.
    pub(super) fn stream(&mut self) -> &mut W {
        self.out
    }

    fn file(
        &mut self,
        content: &Content<'_>,
        specular: impl FnOnce(&mut Self) -> Result<()>,
    ) -> Result<()> {
        self.line("<?xml version=\"1.0\" encoding=\"UTF-8\"?>")?;
        for comment in &self.metadata.comments {
            // Two hyphens would end the comment.
            let text = comment.replace("--", "- -");
            self.line(format_args!("<!-- {} -->", text.trim()))?;
        }
        self.line(HEAD)?;
        let kind = self.metadata.property("WindowElementType").unwrap_or("System");
        self.element("WindowElementType", kind)?;
        self.element("FileType", "BSDF")?;
        self.unread(ROOT)?;
        self.line("<Optical>\n<Layer>")?;
        self.material()?;
        self.geometry()?;
        self.definition(content)?;
        for entry in &content.entries {
            self.entry(entry, content)?;
        }
        for (band, entries) in &content.bands {
            for entry in entries {
                self.band_entry(band, entry, content)?;
            }
        }
        self.unread(BLOCKS)?;
        specular(self)?;
        self.unread(LAYER)?;
        self.line("</Layer>")?;
        self.unread(OPTICAL)?;
        self.line("</Optical>\n</WindowElement>")
    }

    fn definition(&mut self, content: &Content<'_>) -> Result<()> {
        self.line("<DataDefinition>")?;
        self.element("IncidentDataStructure", content.structure)?;
        for (basis, name) in &content.bases {
            self.line("<AngleBasis>")?;
            self.element("AngleBasisName", name)?;
            for (r, ring) in basis.rings().iter().enumerate() {
                let (lower, upper) = basis.ring_bounds_degrees(r);
                let centre = basis.ring_centre_degrees(r);
                self.line(format_args!(
                    "<AngleBasisBlock><Theta>{centre}</Theta><nPhis>{}</nPhis><ThetaBounds>\
                     <LowerTheta>{lower}</LowerTheta><UpperTheta>{upper}</UpperTheta>\
                     </ThetaBounds></AngleBasisBlock>",
                    ring.patches
                ))?;
            }
            self.line("</AngleBasis>")?;
        }
        self.unread(DEFINITION)?;
        self.line("</DataDefinition>")
    }

    fn entry(&mut self, entry: &Entry<'_>, content: &Content<'_>) -> Result<()> {
        let constant = entry.constant;
        match &entry.data {
            EntryData::Matrix(matrix) => {
                let basis = basis_of(matrix, content);
                let shape = (matrix.incident().directions(), matrix.scattered().directions());
                let y = matrix.values();
                self.matrix(&VISIBLE, entry, &basis, shape, y, constant.y)?;
                match matrix.chromatic() {
                    Some([x, z]) => {
                        self.matrix(&CIE_X, entry, &basis, shape, x, constant.x)?;
                        self.matrix(&CIE_Z, entry, &basis, shape, z, constant.z)
                    }
                    None if is_grey(constant) => Ok(()),
                    None => {
                        self.matrix(&CIE_X, entry, &basis, shape, y, constant.x)?;
                        self.matrix(&CIE_Z, entry, &basis, shape, y, constant.z)
                    }
                }
            }
            EntryData::Tree(tree) => {
                if !is_grey(constant) {
                    return Err(Error::argument(
                        "a coloured Lambertian part cannot be added to trees",
                    ));
                }
                self.tree(&VISIBLE, entry, tree.luminance(), constant.y)?;
                if let Some([u, v]) = tree.chromaticity() {
                    if constant != Xyz::ZERO {
                        return Err(Error::argument(
                            "a Lambertian part cannot be added to coloured trees",
                        ));
                    }
                    self.tree(&CIE_U, entry, u, 0.0)?;
                    self.tree(&CIE_V, entry, v, 0.0)?;
                }
                Ok(())
            }
            EntryData::Constant => self.constant(entry, content),
        }
    }

    /// A component of a further band.
    fn band_entry(&mut self, band: &Band, entry: &Entry<'_>, content: &Content<'_>) -> Result<()> {
        let wavelength = Wavelength::of(band);
        match &entry.data {
            EntryData::Matrix(matrix) => {
                let shape = (matrix.incident().directions(), matrix.scattered().directions());
                let basis = basis_of(matrix, content);
                self.matrix(&wavelength, entry, &basis, shape, matrix.values(), 0.0)
            }
            EntryData::Tree(tree) => self.tree(&wavelength, entry, tree.luminance(), 0.0),
            EntryData::Constant => Ok(()),
        }
    }

    /// A component that is the same in all directions.
    fn constant(&mut self, entry: &Entry<'_>, content: &Content<'_>) -> Result<()> {
        let constant = entry.constant;
        if let Some((basis, name)) = content.bases.first() {
            let n = basis.directions();
            let zeros = vec![0.0; n * n];
            let name = escape(name.as_str());
            let basis = format!(
                "<ColumnAngleBasis>{name}</ColumnAngleBasis>\n<RowAngleBasis>{name}</RowAngleBasis>"
            );
            self.matrix(&VISIBLE, entry, &basis, (n, n), &zeros, constant.y)?;
            if !is_grey(constant) {
                self.matrix(&CIE_X, entry, &basis, (n, n), &zeros, constant.x)?;
                self.matrix(&CIE_Z, entry, &basis, (n, n), &zeros, constant.z)?;
            }
            return Ok(());
        }
        let mut one = |wavelength, value: f64| {
            self.tree(wavelength, entry, &TensorTree::constant(Rank::Four, 0.0)?, value)
        };
        one(&VISIBLE, constant.y)?;
        if !is_grey(constant) {
            let (u, v) = constant.uv();
            one(&CIE_U, u)?;
            one(&CIE_V, v)?;
        }
        Ok(())
    }

    /// A block of a matrix; a text row is a scattered direction (`Columns`).
    ///
    /// A comma follows each value: WINDOW's engine knows no other end of a number, not even that of a line.
    fn matrix(
        &mut self,
        wavelength: &Wavelength<'_>,
        entry: &Entry<'_>,
        basis: &str,
        (incident, scattered): (usize, usize),
        values: &[f32],
        constant: f64,
    ) -> Result<()> {
        self.open_block(wavelength, entry, basis)?;
        let mut numbers = Numbers::new(&mut *self.out, self.options.digits);
        for o in 0..scattered {
            for i in 0..incident {
                numbers.number(f64::from(values[i * scattered + o]) + constant)?;
                numbers.raw(b",")?;
            }
            numbers.raw(b"\n")?;
        }
        self.close_block()
    }

    fn tree(
        &mut self,
        wavelength: &Wavelength<'_>,
        entry: &Entry<'_>,
        tree: &TensorTree,
        constant: f64,
    ) -> Result<()> {
        self.open_block(wavelength, entry, "<AngleBasis>LBNL/Shirley-Chiu</AngleBasis>")?;
        let numbers = Numbers::new(&mut *self.out, self.options.digits);
        tree.visit(&mut TreeText::new(numbers, constant))?;
        self.line("")?;
        self.close_block()
    }

    fn open_block(
        &mut self,
        wavelength: &Wavelength<'_>,
        entry: &Entry<'_>,
        basis: &str,
    ) -> Result<()> {
        let Wavelength { name, unit, source, detector } = wavelength;
        self.line("<WavelengthData>\n<LayerNumber>System</LayerNumber>")?;
        let (name, unit) = (escape(*name), escape(*unit));
        self.line(format_args!("<Wavelength unit=\"{unit}\">{name}</Wavelength>"))?;
        for (element, text) in [("SourceSpectrum", source), ("DetectorSpectrum", detector)] {
            if !text.is_empty() {
                self.element(element, text)?;
            }
        }
        self.line("<WavelengthDataBlock>")?;
        let (incident, scattered) = entry.sides;
        self.element("WavelengthDataDirection", orientation::direction(incident, scattered))?;
        self.line(basis)?;
        self.line("<ScatteringDataType>BTDF</ScatteringDataType>\n<ScatteringData>")
    }

    fn close_block(&mut self) -> Result<()> {
        self.line("</ScatteringData>\n</WavelengthDataBlock>\n</WavelengthData>")
    }
}

/// What a `WavelengthData` says before its blocks.
struct Wavelength<'a> {
    name: &'a str,
    unit: &'a str,
    source: &'a str,
    detector: &'a str,
}

impl Wavelength<'static> {
    const fn seen(name: &'static str, detector: &'static str) -> Self {
        Self { name, unit: "Integral", source: "CIE Illuminant D65 1nm.ssp", detector }
    }
}

impl<'a> Wavelength<'a> {
    fn of(band: &'a Band) -> Self {
        let Band { name, unit, source, detector, .. } = band;
        Self { name, unit, source, detector }
    }
}

const VISIBLE: Wavelength<'_> = Wavelength::seen("Visible", "ASTM E308 1931 Y.dsp");
const CIE_X: Wavelength<'_> = Wavelength::seen("CIE-X", "ASTM E308 1931 X.dsp");
const CIE_Z: Wavelength<'_> = Wavelength::seen("CIE-Z", "ASTM E308 1931 Z.dsp");
const CIE_U: Wavelength<'_> = Wavelength::seen("CIE-u", "");
const CIE_V: Wavelength<'_> = Wavelength::seen("CIE-v", "");

/// The elements that name a matrix's bases.
fn basis_of(matrix: &KlemsMatrix, content: &Content<'_>) -> String {
    format!(
        "<ColumnAngleBasis>{}</ColumnAngleBasis>\n<RowAngleBasis>{}</RowAngleBasis>",
        escape(content.name_of(matrix.incident())),
        escape(content.name_of(matrix.scattered()))
    )
}

/// Whether a colour is that of a colourless distribution, X = Y = Z.
fn is_grey(c: Xyz) -> bool {
    c == Xyz::grey(c.y)
}
