//! `DataDefinition/AngleBasis`: the bases that a file defines, and what a name in it means.

use super::document::{Node, clip};
use super::limits::Limits;
use super::material::short_text;
use super::report::{Fault, Report};
use crate::matrix::{KlemsBasis, Ring};

/// The bases defined in a file, by name.
///
/// Differs from: Radiance, which ignores the rings of a definition whose name it knows.
pub(crate) struct AngleBases<'d, 'a> {
    defined: Vec<(KlemsBasis, Node<'d, 'a>)>,
}

impl<'d, 'a> AngleBases<'d, 'a> {
    /// Reads all definitions that carry rings.
    pub(crate) fn read(definition: Node<'d, 'a>, limits: &Limits, report: &mut Report) -> Self {
        let mut defined: Vec<(KlemsBasis, Node<'d, 'a>)> = Vec::new();
        for node in definition.children_named("AngleBasis") {
            if defined.len() == limits.bases {
                let text = format!("more than {} angle bases", limits.bases);
                report.fault(Fault::limit(node.place(), text));
                break;
            }
            if node.child("AngleBasisBlock").is_none() {
                continue;
            }
            match read_basis(node, limits, report) {
                Ok(basis) => {
                    let built_in = KlemsBasis::named(basis.name());
                    if built_in.is_some_and(|known| !same_rings(&known, &basis)) {
                        let text = format!(
                            "the file's rings ({} directions) differ from the built-in {:?}; using the file's",
                            basis.directions(),
                            basis.name()
                        );
                        let is_73 = same_rings(&KlemsBasis::half_73(), &basis);
                        let code = if is_73 { "half-73" } else { "other-rings" };
                        report.warn(code, node.place(), text);
                    }
                    if defined.iter().any(|(d, _)| d.name().eq_ignore_ascii_case(basis.name())) {
                        let text = format!("angle basis {:?} is defined twice", clip(basis.name()));
                        report.fault(Fault::format(node.place(), text));
                    }
                    defined.push((basis, node));
                }
                Err(fault) => report.fault(fault),
            }
        }
        Self { defined }
    }

    /// What `name` means: the file's own definition, else a built-in basis.
    pub(crate) fn find(&self, name: &str) -> Option<KlemsBasis> {
        let own = self.defined.iter().map(|(b, _)| b).find(|b| b.name().eq_ignore_ascii_case(name));
        own.cloned().or_else(|| KlemsBasis::named(name))
    }

    /// Whether `basis` came from the file.
    pub(crate) fn is_own(&self, basis: &KlemsBasis) -> bool {
        self.defined.iter().any(|(b, _)| b == basis)
    }

    /// The definitions that are none of `used`.
    pub(crate) fn unused(&self, used: &[KlemsBasis]) -> impl Iterator<Item = Node<'d, 'a>> {
        self.defined.iter().filter(|(b, _)| !used.contains(b)).map(|(_, node)| *node)
    }
}

fn same_rings(a: &KlemsBasis, b: &KlemsBasis) -> bool {
    a.rings().len() == b.rings().len()
        && a.rings().iter().zip(b.rings()).all(|(a, b)| {
            a.patches == b.patches && (a.upper_degrees - b.upper_degrees).abs() <= 1e-4
        })
}

fn read_basis(
    node: Node<'_, '_>,
    limits: &Limits,
    report: &mut Report,
) -> Result<KlemsBasis, Fault> {
    let name = node.child("AngleBasisName").map(|n| short_text(n, limits, report));
    let name = name.filter(|n| !n.is_empty());
    let Some(name) = name else {
        return Err(Fault::format(node.place(), "an angle basis needs an AngleBasisName"));
    };
    let mut rings: Vec<Ring> = Vec::new();
    for block in node.children_named("AngleBasisBlock") {
        if rings.len() == limits.rings {
            let text = format!("more than {} rings", limits.rings);
            return Err(Fault::limit(block.place(), text));
        }
        let bounds = block.child("ThetaBounds").unwrap_or(block);
        let lower = number(bounds, "LowerTheta")?;
        let upper_degrees = number(bounds, "UpperTheta")?;
        let patches = number(block, "nPhis")?;
        if patches.fract() != 0.0 || patches < 1.0 {
            let text = format!("expected a whole number of azimuths nPhis, found {patches}");
            return Err(Fault::format(block.place(), text));
        }
        if patches > limits.azimuths as f64 {
            let text = format!("expected at most {} azimuths, found {patches}", limits.azimuths);
            return Err(Fault::limit(block.place(), text));
        }
        let inner = rings.last().map_or(0.0, |r| r.upper_degrees);
        if (lower - inner).abs() > 1e-6 * inner.max(1.0) {
            let text =
                format!("expected LowerTheta {inner}, where the ring inside ends, found {lower}");
            return Err(Fault::format(block.place(), text));
        }
        rings.push(Ring { upper_degrees, patches: patches as usize });
    }
    let basis =
        KlemsBasis::new(name, rings).map_err(|e| Fault::format(node.place(), e.to_string()))?;
    if !basis.is_complete() {
        let text = "the last ring ends before 90 degrees: no data beyond it";
        report.warn("incomplete-basis", node.place(), text);
    }
    Ok(basis)
}

fn number(parent: Node<'_, '_>, name: &str) -> Result<f64, Fault> {
    let Some(node) = parent.child(name) else {
        return Err(Fault::format(parent.place(), format!("expected {name}, found none")));
    };
    let text = node.text();
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => {
            let text = format!("expected a number, found {:?}", clip(text.trim()));
            Err(Fault::format(node.place(), text))
        }
    }
}
