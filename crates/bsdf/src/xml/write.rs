//! Writes a BSDF as Radiance and WINDOW read it.

use std::io::Write;
use std::path::Path;

use quick_xml::escape::escape;

use super::content::{Content, Entry, EntryData};
use super::material::{DEFINITION, GEOMETRY, LAYER, MATERIAL, OPTICAL, ROOT};
use super::orientation;
use super::text::{Numbers, TreeText};
use crate::tree::{Rank, TensorTree};
use crate::{Bsdf, Error, Metadata, Result, Xyz, replace_file};

/// How to write.
#[derive(Clone, Debug, PartialEq)]
pub struct WriteOptions {
    /// Significant digits of values; 5 keep them to 5·10⁻⁵ relative, 9 keep every bit of an f32.
    pub digits: usize,
    /// Whether fields that WINDOW asks for and the metadata lack (conductivity, emissivities, …)
    /// are filled with the defaults of Radiance's template.
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
/// component.
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
    let file = Content::of(bsdf)?;
    Writer { out, options, metadata: bsdf.metadata() }.file(&file)
}

struct Writer<'w, W> {
    out: &'w mut W,
    options: &'w WriteOptions,
    metadata: &'w Metadata,
}

const HEAD: &str = "\
<WindowElement xmlns=\"http://windows.lbl.gov\" \
xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" \
xsi:schemaLocation=\"http://windows.lbl.gov/BSDF-v1.4.xsd\">";

/// Material fields of Radiance's template for WINDOW.
const WINDOW_FIELDS: [(&str, &str); 6] = [
    ("DeviceType", "Other"),
    ("ThermalConductivity", "1"),
    ("EmissivityFront", "0.9"),
    ("EmissivityBack", "0.9"),
    ("TIR", "0.1"),
    ("EffectiveOpennessFraction", "0.05"),
];

impl<W: Write> Writer<'_, W> {
    fn line(&mut self, text: impl std::fmt::Display) -> Result<()> {
        writeln!(self.out, "{text}").map_err(|e| Error::io("cannot write", &e))
    }

    fn element(&mut self, name: &str, text: &str) -> Result<()> {
        self.line(format_args!("<{name}>{}</{name}>", escape(text)))
    }

    /// The elements below `parent` that were kept as they stood in the file read.
    fn unread(&mut self, parent: &str) -> Result<()> {
        match self.metadata.unread.iter().find(|(place, _)| place == parent) {
            Some((_, text)) => self.line(text),
            None => Ok(()),
        }
    }

    fn file(&mut self, content: &Content<'_>) -> Result<()> {
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
        self.unread(LAYER)?;
        self.line("</Layer>")?;
        self.unread(OPTICAL)?;
        self.line("</Optical>\n</WindowElement>")
    }

    fn material(&mut self) -> Result<()> {
        let metadata = self.metadata;
        self.line("<Material>")?;
        self.element("Name", &metadata.name)?;
        self.element("Manufacturer", &metadata.manufacturer)?;
        let sizes = [
            ("Thickness", metadata.thickness),
            ("Width", metadata.width),
            ("Height", metadata.height),
        ];
        for (name, metres) in sizes {
            if metres > 0.0 {
                self.line(format_args!("<{name} unit=\"Meter\">{metres}</{name}>"))?;
            }
        }
        for (key, value) in &metadata.properties {
            if key == "WindowElementType" {
                continue;
            }
            if !is_name(key) {
                let text = format!("property {key:?}: expected a name of letters and digits");
                return Err(Error::argument(text));
            }
            self.element(key, value)?;
        }
        if self.options.window_fields {
            let missing = WINDOW_FIELDS.iter().filter(|(key, _)| metadata.property(key).is_none());
            for (key, value) in missing {
                self.element(key, value)?;
            }
        }
        self.unread(MATERIAL)?;
        self.line("</Material>")
    }

    fn geometry(&mut self) -> Result<()> {
        let Some(mgf) = &self.metadata.geometry else {
            self.line("<Geometry>")?;
            self.unread(GEOMETRY)?;
            return self.line("</Geometry>");
        };
        let mgf = escape(mgf.as_str());
        self.line("<Geometry format=\"MGF\">")?;
        self.line(format_args!("<MGFblock unit=\"Meter\">{mgf}</MGFblock>"))?;
        self.unread(GEOMETRY)?;
        self.line("</Geometry>")
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
        let tree_basis = "<AngleBasis>LBNL/Shirley-Chiu</AngleBasis>";
        match &entry.data {
            EntryData::Matrix(matrix) => {
                let basis = format!(
                    "<ColumnAngleBasis>{}</ColumnAngleBasis>\n<RowAngleBasis>{}</RowAngleBasis>",
                    escape(content.name_of(matrix.incident())),
                    escape(content.name_of(matrix.scattered()))
                );
                let shape = (matrix.incident().directions(), matrix.scattered().directions());
                let y = matrix.values();
                self.matrix("Visible", entry, &basis, shape, y, constant.y)?;
                match matrix.chromatic() {
                    Some([x, z]) => {
                        self.matrix("CIE-X", entry, &basis, shape, x, constant.x)?;
                        self.matrix("CIE-Z", entry, &basis, shape, z, constant.z)
                    }
                    None if is_grey(constant) => Ok(()),
                    None => {
                        self.matrix("CIE-X", entry, &basis, shape, y, constant.x)?;
                        self.matrix("CIE-Z", entry, &basis, shape, y, constant.z)
                    }
                }
            }
            EntryData::Tree(tree) => {
                if !is_grey(constant) {
                    return Err(Error::argument(
                        "a coloured Lambertian part cannot be added to trees",
                    ));
                }
                self.tree("Visible", entry, tree_basis, tree.luminance(), constant.y)?;
                if let Some([u, v]) = tree.chromaticity() {
                    if constant != Xyz::ZERO {
                        return Err(Error::argument(
                            "a Lambertian part cannot be added to coloured trees",
                        ));
                    }
                    self.tree("CIE-u", entry, tree_basis, u, 0.0)?;
                    self.tree("CIE-v", entry, tree_basis, v, 0.0)?;
                }
                Ok(())
            }
            EntryData::Constant => self.constant(entry, content, tree_basis),
        }
    }

    /// A component that is the same in all directions.
    fn constant(
        &mut self,
        entry: &Entry<'_>,
        content: &Content<'_>,
        tree_basis: &str,
    ) -> Result<()> {
        let constant = entry.constant;
        if let Some((basis, name)) = content.bases.first() {
            let n = basis.directions();
            let zeros = vec![0.0; n * n];
            let name = escape(name.as_str());
            let basis = format!(
                "<ColumnAngleBasis>{name}</ColumnAngleBasis>\n<RowAngleBasis>{name}</RowAngleBasis>"
            );
            self.matrix("Visible", entry, &basis, (n, n), &zeros, constant.y)?;
            if !is_grey(constant) {
                self.matrix("CIE-X", entry, &basis, (n, n), &zeros, constant.x)?;
                self.matrix("CIE-Z", entry, &basis, (n, n), &zeros, constant.z)?;
            }
            return Ok(());
        }
        let mut one = |channel, value: f64| {
            self.tree(channel, entry, tree_basis, &TensorTree::constant(Rank::Four, 0.0)?, value)
        };
        one("Visible", constant.y)?;
        if !is_grey(constant) {
            let (u, v) = constant.uv();
            one("CIE-u", u)?;
            one("CIE-v", v)?;
        }
        Ok(())
    }

    /// A block of a matrix; a text row is a scattered direction (`Columns`).
    fn matrix(
        &mut self,
        channel: &str,
        entry: &Entry<'_>,
        basis: &str,
        (incident, scattered): (usize, usize),
        values: &[f32],
        constant: f64,
    ) -> Result<()> {
        self.open_block(channel, entry, basis)?;
        let mut numbers = Numbers::new(&mut *self.out, self.options.digits);
        for o in 0..scattered {
            for i in 0..incident {
                numbers.number(f64::from(values[i * scattered + o]) + constant)?;
            }
            numbers.raw(b"\n")?;
        }
        self.close_block()
    }

    fn tree(
        &mut self,
        channel: &str,
        entry: &Entry<'_>,
        basis: &str,
        tree: &TensorTree,
        constant: f64,
    ) -> Result<()> {
        self.open_block(channel, entry, basis)?;
        let numbers = Numbers::new(&mut *self.out, self.options.digits);
        tree.visit(&mut TreeText::new(numbers, constant))?;
        self.line("")?;
        self.close_block()
    }

    fn open_block(&mut self, channel: &str, entry: &Entry<'_>, basis: &str) -> Result<()> {
        self.line("<WavelengthData>\n<LayerNumber>System</LayerNumber>")?;
        self.line(format_args!("<Wavelength unit=\"Integral\">{channel}</Wavelength>"))?;
        self.element("SourceSpectrum", "CIE Illuminant D65 1nm.ssp")?;
        let detector = match channel {
            "Visible" => Some("ASTM E308 1931 Y.dsp"),
            "CIE-X" => Some("ASTM E308 1931 X.dsp"),
            "CIE-Z" => Some("ASTM E308 1931 Z.dsp"),
            _ => None,
        };
        if let Some(detector) = detector {
            self.element("DetectorSpectrum", detector)?;
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

/// Whether a colour is that of a colourless distribution, X = Y = Z.
fn is_grey(c: Xyz) -> bool {
    c == Xyz::grey(c.y)
}

/// Whether `key` can be the name of an element.
fn is_name(key: &str) -> bool {
    let letter = |c: char| c.is_alphabetic() || c == '_';
    key.starts_with(letter) && key.chars().all(|c| letter(c) || c.is_numeric() || "-.".contains(c))
}
