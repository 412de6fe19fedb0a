//! Reads a file: bytes → outline → metadata, bases, components; all faults in one error.

use std::path::Path;

use super::angle_bases::AngleBases;
use super::assemble::{Blocks, assemble};
use super::blocks::{Structure, read_blocks};
use super::decode::decode;
use super::document::{Document, Node, clip};
use super::kept::{DEFINITION, LAYER, OPTICAL, ROOT, keep};
use super::limits::Limits;
use super::material::{comments, marked, read_geometry, read_material, short_text};
use super::report::{Fault, Report, Warning};
use super::specular;
use crate::limits::{name_of, read_file};
use crate::matrix::{KlemsBasis, KlemsMatrix};
use crate::{Bsdf, Error, Lambertian, Metadata, Result};

/// Reads an XML file of WINDOW or Radiance with default [`Limits`]; looks for no warnings.
///
/// Errors: as [`read_with`].
/// Cost: about 2 ns a byte on one core; blocks are read in parallel.
pub fn read(path: impl AsRef<Path>) -> Result<Bsdf> {
    let limits = Limits::default();
    let report = Report::without_warnings(limits.faults);
    read_path(path.as_ref(), &limits, report).map(|(bsdf, _)| bsdf)
}

/// Reads an XML file; also returns what was questionable but readable.
///
/// Errors: io: missing, a directory, unreadable. format: not such a file, with all faults found
/// (line, path, expected, found). limit: larger than `limits`.
/// Cost: that of [`read`], and the energy of each component, for which a tree prepares its sums.
pub fn read_with(path: impl AsRef<Path>, limits: &Limits) -> Result<(Bsdf, Vec<Warning>)> {
    read_path(path.as_ref(), limits, Report::new(limits.faults))
}

/// Reads the content of such a file.
///
/// Errors: as [`read_with`], without io and without the file's name.
pub fn from_bytes(bytes: &[u8], limits: &Limits) -> Result<(Bsdf, Vec<Warning>)> {
    read_bytes(bytes, limits, Report::new(limits.faults))
}

fn read_path(path: &Path, limits: &Limits, report: Report) -> Result<(Bsdf, Vec<Warning>)> {
    let bytes = bytes_of(path, limits)?;
    read_bytes(&bytes, limits, report).map_err(|e| e.context(name_of(path)))
}

fn read_bytes(bytes: &[u8], limits: &Limits, mut report: Report) -> Result<(Bsdf, Vec<Warning>)> {
    let text = decode(bytes, &mut report)?;
    let bsdf = Document::parse(&text, limits, &mut report)
        .and_then(|document| read_document(&document, limits, &mut report));
    let warnings = report.finish()?;
    match bsdf {
        Some(bsdf) => Ok((bsdf, warnings)),
        None => Err(Error::format("no BSDF in the file")),
    }
}

/// The bytes of a file, if they are no more than `limits` allow.
///
/// Errors: io; argument: no regular file; limit. With the file's name.
pub fn bytes_of(path: impl AsRef<Path>, limits: &Limits) -> Result<Vec<u8>> {
    read_file(path, limits.file_bytes)
}

/// The BSDF of an outline; `None` where `report` has faults.
pub(super) fn read_document(
    document: &Document<'_>,
    limits: &Limits,
    report: &mut Report,
) -> Option<Bsdf> {
    let root = document.root();
    if root.name() != "WindowElement" {
        let text = format!("expected root element WindowElement, found {}", clip(root.name()));
        report.fault(Fault::format(root.place(), text));
        return None;
    }
    let mut metadata = Metadata::default();
    let mut layer = None;
    for child in root.children() {
        match child.name() {
            "FileType" => {
                let text = child.text();
                if !text.trim().eq_ignore_ascii_case("BSDF") {
                    let text = format!("expected FileType BSDF, found {:?}", clip(text.trim()));
                    report.fault(Fault::format(child.place(), text));
                }
            }
            "WindowElementType" => {
                let kind = short_text(child, limits, report);
                if !kind.eq_ignore_ascii_case("System") {
                    metadata.properties.push((child.name().to_owned(), kind));
                }
            }
            "Optical" if layer.is_none() => {
                layer = child.child("Layer").map(|layer| (child, layer));
                read_optical(child, &mut metadata, report);
            }
            // Of the text as it was: wrong for any other.
            "Checksum" => {}
            _ => keep(&mut metadata, ROOT, child.verbatim()),
        }
    }
    let Some((optical, layer)) = layer else {
        report.fault(Fault::format(root.place(), "expected Optical/Layer, found none"));
        return None;
    };
    metadata.comments = comments(document, optical, layer);
    let mut blocks = read_layer(document, layer, limits, &mut metadata, report);
    let peaks = match layer.child(specular::BLOCK) {
        Some(block) if !report.has_faults() => specular::read(block, &mut blocks, limits, report),
        _ => Vec::new(),
    };
    let Blocks { components, bands } = blocks;
    (!report.has_faults()).then(|| {
        Bsdf::new(metadata, components, Lambertian::default())
            .with_bands(bands)
            .with_specular(peaks)
    })
}

fn read_optical(optical: Node<'_, '_>, metadata: &mut Metadata, report: &mut Report) {
    let mut layers = 0;
    for child in optical.children() {
        layers += usize::from(child.name() == "Layer");
        if child.name() != "Layer" || layers > 1 {
            keep(metadata, OPTICAL, child.verbatim());
        }
    }
    if layers > 1 {
        let text = format!("{layers} layers; only the first one is read");
        report.warn("further-layers", optical.place(), text);
    }
}

fn read_layer(
    document: &Document<'_>,
    layer: Node<'_, '_>,
    limits: &Limits,
    metadata: &mut Metadata,
    report: &mut Report,
) -> Blocks {
    let marked = marked(document, layer);
    for child in layer.children() {
        match child.name() {
            "Material" => read_material(child, &marked, limits, metadata, report),
            "Geometry" => read_geometry(child, metadata, report),
            "DataDefinition" | "WavelengthData" | specular::BLOCK => {}
            _ => keep(metadata, LAYER, child.verbatim()),
        }
    }
    let Some(definition) = layer.child("DataDefinition") else {
        report.fault(Fault::format(layer.place(), "expected DataDefinition, found none"));
        return Blocks::default();
    };
    let bases = AngleBases::read(definition, limits, report);
    let structure = definition.child("IncidentDataStructure").map(Node::text);
    let structure = structure.as_deref().map_or("", str::trim);
    let Some(structure) = Structure::parse(structure) else {
        let text = format!(
            "expected IncidentDataStructure Columns, Rows, TensorTree3 or TensorTree4, found {:?}",
            clip(structure)
        );
        report.fault(Fault::format(definition.place(), text));
        return Blocks::default();
    };
    let (data, bands) = read_blocks(layer, structure, &bases, limits, metadata, report);
    if report.has_faults() {
        return Blocks::default();
    }
    let blocks = assemble(data, bands, layer, report);
    let further = blocks.bands.iter().flat_map(|b| &b.components);
    let used: Vec<KlemsBasis> = blocks
        .components
        .iter()
        .chain(further)
        .filter_map(|c| c.distribution().downcast_ref::<KlemsMatrix>())
        .flat_map(|m| [m.incident().clone(), m.scattered().clone()])
        .collect();
    for basis in bases.unused(&used) {
        keep(metadata, DEFINITION, basis.verbatim());
    }
    let read = ["IncidentDataStructure", "AngleBasis"];
    for child in definition.children().filter(|c| !read.contains(&c.name())) {
        keep(metadata, DEFINITION, child.verbatim());
    }
    blocks
}
