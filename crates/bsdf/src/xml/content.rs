//! What a file is to hold, found to fit one structure before a byte is written.

use super::orientation;
use crate::matrix::{KlemsBasis, KlemsMatrix};
use crate::tree::{Rank, TreeDistribution};
use crate::{Band, Bsdf, Component, Error, Result, Side, Xyz};

/// One block: a component with the constant that its Lambertian part adds.
pub(crate) struct Entry<'b> {
    pub(crate) sides: (Side, Side),
    pub(crate) data: EntryData<'b>,
    pub(crate) constant: Xyz,
}

pub(crate) enum EntryData<'b> {
    Matrix(&'b KlemsMatrix),
    Tree(&'b TreeDistribution),
    /// Nothing but the constant.
    Constant,
}

/// What a file holds, checked to be of one structure.
pub(crate) struct Content<'b> {
    pub(crate) entries: Vec<Entry<'b>>,
    /// Further bands with their entries.
    pub(crate) bands: Vec<(&'b Band, Vec<Entry<'b>>)>,
    pub(crate) structure: &'static str,
    /// Bases with the names that they get.
    pub(crate) bases: Vec<(KlemsBasis, String)>,
}

impl<'b> Content<'b> {
    /// Errors: argument: what the format cannot hold.
    pub(crate) fn of(bsdf: &'b Bsdf) -> Result<Self> {
        let mut form = Form::default();
        let mut entries = form.entries(bsdf.components())?;
        let mut bands = Vec::new();
        for band in bsdf.bands() {
            if band.components.iter().any(|c| c.distribution().is_coloured()) {
                let text = format!("band {}: expected values without colour", band.name);
                return Err(Error::argument(text));
            }
            let entries = form.entries(&band.components);
            bands.push((band, entries.map_err(|e| e.context(format!("band {}", band.name)))?));
        }
        add_lambertian(bsdf, &mut entries)?;
        let structure = form.structure.unwrap_or("TensorTree4");
        let place = |e: &Entry<'_>| orientation::ALL.iter().position(|s| *s == e.sides);
        entries.sort_by_key(place);
        bands.iter_mut().for_each(|(_, entries)| entries.sort_by_key(place));
        Ok(Self { entries, bands, structure, bases: form.bases })
    }

    /// The name that a basis gets in the file.
    pub(crate) fn name_of<'a>(&'a self, basis: &'a KlemsBasis) -> &'a str {
        self.bases.iter().find(|(b, _)| b == basis).map_or(basis.name(), |(_, name)| name)
    }
}

/// Which structure and which bases the components seen so far ask for.
#[derive(Default)]
struct Form {
    structure: Option<&'static str>,
    bases: Vec<(KlemsBasis, String)>,
}

impl Form {
    /// The components of one band.
    fn entries<'b>(&mut self, components: &'b [Component]) -> Result<Vec<Entry<'b>>> {
        let mut entries: Vec<Entry<'b>> = Vec::new();
        for component in components {
            let sides = (component.incident, component.scattered);
            let distribution = component.distribution();
            let (data, found) = if let Some(matrix) = distribution.downcast_ref::<KlemsMatrix>() {
                for basis in [matrix.incident(), matrix.scattered()] {
                    add_basis(basis, &mut self.bases);
                }
                (EntryData::Matrix(matrix), "Columns")
            } else if let Some(tree) = distribution.downcast_ref::<TreeDistribution>() {
                let name = match tree.luminance().rank() {
                    Rank::Three => "TensorTree3",
                    Rank::Four => "TensorTree4",
                };
                (EntryData::Tree(tree), name)
            } else {
                return Err(Error::argument("expected components stored as matrix or tree"));
            };
            if *self.structure.get_or_insert(found) != found {
                return Err(Error::argument(
                    "expected components of one kind (matrices, or trees of one rank)",
                ));
            }
            if entries.iter().any(|e| e.sides == sides) {
                let text = format!(
                    "expected one component for {}, found more",
                    orientation::direction(sides.0, sides.1)
                );
                return Err(Error::argument(text));
            }
            entries.push(Entry { sides, data, constant: Xyz::ZERO });
        }
        Ok(entries)
    }
}

/// Gives the Lambertian parts that no component contains a place.
fn add_lambertian(bsdf: &Bsdf, entries: &mut Vec<Entry<'_>>) -> Result<()> {
    let stored: Vec<_> = entries.iter().map(|e| e.sides).collect();
    for sides in orientation::ALL {
        let lambertian = |(i, s)| bsdf.explicit_lambertian().get(i, s);
        let constant = lambertian(sides);
        if constant == Xyz::ZERO {
            continue;
        }
        // A lone transmission answers the opposite way too, its constant part included.
        let opposite = (sides.1, sides.0);
        let has = |sides| stored.contains(&sides);
        if sides.0 != sides.1 && !has(sides) && has(opposite) {
            if lambertian(opposite) == constant {
                continue;
            }
            return Err(Error::argument(
                "a lone transmission component needs equal Lambertian transmission both ways",
            ));
        }
        let constant = constant * std::f64::consts::FRAC_1_PI;
        match entries.iter_mut().find(|e| e.sides == sides) {
            Some(entry) => entry.constant = constant,
            None => entries.push(Entry { sides, data: EntryData::Constant, constant }),
        }
    }
    Ok(())
}

/// Gives a basis a name that means it alone: Radiance ignores the rings under a name it knows.
fn add_basis(basis: &KlemsBasis, bases: &mut Vec<(KlemsBasis, String)>) {
    if bases.iter().any(|(b, _)| b == basis) {
        return;
    }
    let mut name = basis.name().to_owned();
    let taken = |name: &str| {
        bases.iter().any(|(_, other)| other.eq_ignore_ascii_case(name))
            || KlemsBasis::named(name).is_some_and(|known| known != *basis)
    };
    let mut number = basis.directions();
    while taken(&name) {
        name = format!("{} {number}", basis.name());
        number += 1;
    }
    bases.push((basis.clone(), name));
}
