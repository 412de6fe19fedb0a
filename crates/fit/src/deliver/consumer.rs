//! What a program needs of the XML that it reads, under that program's name.
//!
//! WINDOW's engine reads Klems Full alone, refuses any band but Visible and Solar, and wants both of
//! them in all four directions. EnergyPlus takes the same matrices on any Klems basis. Radiance reads
//! Visible with its CIE colours and ignores the rest.

use std::f64::consts::FRAC_1_PI;
use std::str::FromStr;

use bsdfkit::component::name_of_sides;
use bsdfkit::matrix::{KlemsBasis, KlemsMatrix};
use bsdfkit::{Band, Bsdf, Component, Error, Lambertian, Metadata, Result, Side, Specular};

use super::kind::Kind;
use super::subject::Subject;
use bsdfkit_represent::tabulate::is_isotropic;

/// A program that reads our XML.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Consumer {
    /// WINDOW, and whatever is built on its engine.
    Window,
    /// EnergyPlus, as what its objects are made of.
    EnergyPlus,
    /// Radiance and what is built on it.
    Radiance,
}

impl FromStr for Consumer {
    type Err = Error;

    /// A program's name, or that of one that is built on it.
    ///
    /// Errors: argument, for any other name.
    fn from_str(name: &str) -> Result<Self> {
        let own = |consumer: &Self| consumer.name() == name || consumer.others().contains(&name);
        Self::ALL.into_iter().find(own).ok_or_else(|| {
            let names = Self::ALL.map(Self::name).join(", ");
            Error::argument(format!("consumer: expected one of {names}, found {name:?}"))
        })
    }
}

/// The band that WINDOW and EnergyPlus want beside Visible.
pub(super) const SOLAR: &str = "Solar";

/// What is said of Solar, and noted as a comment in the file, so that reading it again makes no
/// knowledge of it.
const AS_VISIBLE: &str = "not known: written as Visible";

/// Share of transmitted light that EnergyPlus may send elsewhere without being told of. A guess.
const ASYMMETRY: f64 = 0.01;

impl Consumer {
    /// Every one.
    pub const ALL: [Self; 3] = [Self::Window, Self::EnergyPlus, Self::Radiance];

    /// As the command and Python name it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Window => "window",
            Self::EnergyPlus => "energyplus",
            Self::Radiance => "radiance",
        }
    }

    /// Names of programs that read their files through it, or as it does.
    pub fn others(self) -> &'static [&'static str] {
        match self {
            Self::Window => &["frads", "pywincalc"],
            Self::EnergyPlus => &[],
            Self::Radiance => &["honeybee", "mitsuba"],
        }
    }

    /// Who wants more than `bsdf` has where it was made for nobody, in one sentence: matrices are what WINDOW's
    /// engine reads, but not these; of trees Radiance misses a direction.
    pub fn hint(bsdf: &Bsdf, kind: Kind) -> Option<String> {
        let whole = |components: &[Component]| components.len() == 4;
        let bands = bsdf.bands();
        let solar = bands.len() == 1 && bands[0].is(SOLAR) && whole(&bands[0].components);
        let read = kind == Kind::KlemsFull && whole(bsdf.components()) && solar;
        if kind == Kind::TensorTree {
            return dark_from_behind(bsdf).map(|said| format!("in Radiance, {said}"));
        }
        (kind.basis().is_some() && !read).then(|| {
            "WINDOW and frads refuse it: --for window writes Klems Full with Visible and Solar in all directions"
                .to_owned()
        })
    }

    /// The kinds of file that it reads, the usual one first.
    fn kinds(self) -> &'static [Kind] {
        match self {
            Self::Window => &[Kind::KlemsFull],
            Self::EnergyPlus => &[Kind::KlemsFull, Kind::KlemsHalf, Kind::KlemsQuarter],
            Self::Radiance => {
                &[Kind::TensorTree, Kind::KlemsFull, Kind::KlemsHalf, Kind::KlemsQuarter]
            }
        }
    }

    /// The kind to write, where `--to` asks for `to`.
    ///
    /// Errors: where the program does not read that kind.
    pub fn kind(self, to: Option<Kind>) -> Result<Kind> {
        let kinds = self.kinds();
        match to {
            None => Ok(kinds[0]),
            Some(kind) if kinds.contains(&kind) => Ok(kind),
            Some(kind) => {
                let names: Vec<&str> = kinds.iter().map(|k| k.name()).collect();
                Err(Error::argument(format!(
                    "{} reads {}: expected one of these, found {}",
                    self.name(),
                    names.join(", "),
                    kind.name()
                )))
            }
        }
    }

    /// The usual kind for this input: Radiance reads a matrix as well as a tree, so it stays one.
    pub fn kind_of(self, subject: Subject<'_>) -> Kind {
        let Subject::Stored(bsdf) = subject else { return self.kinds()[0] };
        let of = |kind: &&Kind| {
            let components = bsdf.components();
            let basis = kind.basis();
            let alike = |c: &Component| {
                let m = c.distribution().downcast_ref::<KlemsMatrix>();
                let bases = m.map(|m| [m.incident().clone(), m.scattered().clone()]);
                bases.is_some_and(|b| b.iter().all(|b| Some(b) == basis.as_ref()))
            };
            !components.is_empty() && components.iter().all(alike)
        };
        self.kinds().iter().find(of).copied().unwrap_or(self.kinds()[0])
    }

    /// Whether it reads a further band.
    pub(super) fn wants(self, band: &Band) -> bool {
        self != Self::Radiance && band.is(SOLAR)
    }

    /// `bsdf`, of a kind that it reads, with all that it needs; what was made up is said.
    ///
    /// Errors: argument, for matrices of bases that cannot be turned about the normal.
    pub(super) fn fitted(self, bsdf: Bsdf, kind: Kind, said: &mut Vec<String>) -> Result<Bsdf> {
        let transmits = bsdf.components().iter().any(Component::is_transmission);
        let Some(basis) = kind.basis().filter(|_| self != Self::Radiance) else {
            if transmits {
                said.push(
                    "in a scene, give the BSDF primitive a thickness of 0 or use aBSDF: any other thickness lets sun and view rays through as if nothing were there".to_owned(),
                );
            }
            return Ok(bsdf);
        };
        if bsdf.components().iter().any(|c| c.distribution().is_coloured()) {
            said.push(format!("colour left out: {} reads none", self.name()));
        }
        let mut needs = Complete { basis: &basis, lambertian: *bsdf.explicit_lambertian(), said };
        let (visible, _) = needs.directions("Visible", bsdf.components(), &[])?;
        needs.lambertian = Lambertian::default();
        let peaks = both_ways(bsdf.specular());
        // Of Solar nobody reads the peaks but in its cells.
        let in_cells = |components: &[Component]| -> Result<Vec<Component>> {
            let alone = Bsdf::new(Metadata::default(), components.to_vec(), Lambertian::default());
            Ok(alone.with_specular(peaks.clone()).with_peaks_in_cells()?.components().to_vec())
        };
        let stored = bsdf.bands().iter().find(|b| b.is(SOLAR));
        let (solar, made_up) = match stored {
            Some(band) => {
                let (components, made_up) =
                    needs.directions(SOLAR, &band.components, &in_cells(bsdf.components())?)?;
                let text = format!("{SOLAR}: {} {AS_VISIBLE}", made_up.join(", "));
                let name = SOLAR.to_owned();
                (Band { name, components, ..band.clone() }, (!made_up.is_empty()).then_some(text))
            }
            None => {
                let components = in_cells(&visible)?;
                (Band::new(SOLAR, components), Some(format!("{SOLAR} is {AS_VISIBLE}")))
            }
        };
        let mut metadata = bsdf.metadata().clone();
        if let Some(text) = made_up {
            metadata.comments.push(text);
        }
        said.extend(metadata.comments.iter().filter(|c| is_made_up(c)).cloned());
        if self == Self::EnergyPlus {
            said.extend(asymmetry(&visible));
        }
        let visible = Bsdf::new(metadata, visible, Lambertian::default());
        Ok(visible.with_bands(vec![solar]).with_specular(peaks))
    }
}

/// Peaks, and where they cross the surface one way alone, those of the other way.
pub(super) fn both_ways(peaks: &[Specular]) -> Vec<Specular> {
    let crossing = |from| peaks.iter().any(|p| p.is_transmission() && p.incident == from);
    let lone = |p: &&Specular| p.is_transmission() && !crossing(p.scattered);
    peaks.iter().cloned().chain(peaks.iter().filter(lone).map(Specular::reversed)).collect()
}

/// Whether a comment says that Solar is not known.
fn is_made_up(comment: &str) -> bool {
    comment.starts_with(SOLAR) && comment.ends_with(AS_VISIBLE)
}

/// Takes out of the comments what was true of a band that is no longer there.
pub(super) fn forget_made_up(metadata: &mut Metadata, bands: &[Band]) {
    if !bands.iter().any(|b| b.is(SOLAR)) {
        metadata.comments.retain(|c| !is_made_up(c));
    }
}

/// Makes bands complete.
struct Complete<'a> {
    basis: &'a KlemsBasis,
    /// What no component contains.
    lambertian: Lambertian,
    said: &'a mut Vec<String>,
}

impl Complete<'_> {
    /// All four directions of a band without colour: what is stored, transmission reversed, else as
    /// in `other` components, else 0. Also those taken from `other`.
    fn directions(
        &mut self,
        band: &str,
        components: &[Component],
        other: &[Component],
    ) -> Result<(Vec<Component>, Vec<String>)> {
        let (mut all, mut reversed, mut zero, mut made_up) =
            (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for from in [Side::Back, Side::Front] {
            for to in [from.opposite(), from] {
                let name = name_of_sides(from, to).to_owned();
                let constant = self.lambertian.get(from, to).y * FRAC_1_PI;
                let opposite = matrix(components, to, from).filter(|_| from != to);
                let mut values = if let Some(matrix) = matrix(components, from, to) {
                    matrix.values().to_vec()
                } else if let Some(matrix) = opposite {
                    reversed.push(name);
                    matrix.reversed()?.values().to_vec()
                } else if let Some(matrix) = matrix(other, from, to) {
                    made_up.push(name);
                    matrix.values().to_vec()
                } else {
                    if constant == 0.0 {
                        zero.push(name);
                    }
                    vec![0.0; self.basis.directions() * self.basis.directions()]
                };
                if constant != 0.0 {
                    values.iter_mut().for_each(|v| *v = (f64::from(*v) + constant) as f32);
                }
                let matrix = KlemsMatrix::new(self.basis.clone(), self.basis.clone(), values)?;
                all.push(Component::new(from, to, matrix));
            }
        }
        for (names, what) in [(reversed, "the other direction reversed"), (zero, "written as 0")] {
            if !names.is_empty() {
                self.said.push(format!("{band}: {} not known: {what}", names.join(", ")));
            }
        }
        Ok((all, made_up))
    }
}

/// The matrix stored for a pair of sides.
fn matrix(components: &[Component], from: Side, to: Side) -> Option<&KlemsMatrix> {
    let component = components.iter().find(|c| (c.incident, c.scattered) == (from, to))?;
    component.distribution().downcast_ref::<KlemsMatrix>()
}

/// Radiance traces no light through a lone isotropic tree against the way that it is stored.
fn dark_from_behind(bsdf: &Bsdf) -> Option<String> {
    let lone = |c: &&Component| {
        let back = (c.scattered, c.incident);
        let other = bsdf.components().iter().any(|o| (o.incident, o.scattered) == back);
        c.is_transmission() && is_isotropic(c) && !other
    };
    let c = bsdf.components().iter().find(lone)?;
    let side = if c.scattered == Side::Front { "front" } else { "back" };
    Some(format!(
        "seen from the {side}, an isotropic tree of one transmission is lit by sources alone, not by the sky: --for radiance writes the other direction, too"
    ))
}

/// EnergyPlus takes the transposed matrix for light of sky and ground: how much differs.
fn asymmetry(components: &[Component]) -> Option<String> {
    let outside = components.iter().find(|c| c.is_transmission() && c.incident == Side::Back)?;
    let matrix = outside.distribution().downcast_ref::<KlemsMatrix>()?;
    let share = matrix.asymmetry().unwrap_or(0.0);
    (share > ASYMMETRY).then(|| {
        format!(
            "EnergyPlus transposes transmission for diffuse light of sky and ground: {:.0} % of it differs",
            100.0 * share
        )
    })
}

/// A further band of a stored BSDF alone, in the place of the visible one.
///
/// Errors: argument, where there is none of that name.
pub fn alone(subject: Subject<'_>, band: &str) -> Result<Bsdf> {
    let Subject::Stored(bsdf) = subject else {
        return Err(Error::argument(format!("band {band}: an interpolant has no further bands")));
    };
    bsdf.band(band).ok_or_else(|| {
        let names: Vec<&str> = bsdf.bands().iter().map(|b| b.name.as_str()).collect();
        let names = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
        Error::argument(format!("expected one of the further bands ({names}), found {band}"))
    })
}
