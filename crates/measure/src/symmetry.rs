//! The symmetries that a specimen can have, and the images of a direction under them.

use std::fmt;
use std::str::FromStr;

use bsdfkit::{DVec2, DVec3, Error, Result};

/// Incidences closer than this to their own image are on the mirror: 0.02 degrees.
pub const ON_MIRROR: f64 = 3.5e-4;

/// A plane through the normal in which a specimen is its own mirror image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Mirror {
    /// x → −x: the YZ plane.
    X,
    /// y → −y: the XZ plane.
    Y,
}

/// Which motions about the normal leave a specimen's BSDF unchanged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Symmetry {
    /// Every rotation about Z.
    Isotropic,
    /// Both mirrors; incidences of one quadrant suffice.
    Quadrilateral,
    /// One mirror; incidences of one half suffice.
    Bilateral(Mirror),
    /// Rotation by 180° about Z; incidences of any half suffice.
    Rotational180,
    /// Nothing but the identity.
    None,
}

/// A [`Symmetry`] as a person names it: which mirror a bilateral one has may be left to the data.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SymmetryKind {
    /// Every rotation about Z.
    Isotropic,
    /// Both mirrors.
    Quadrilateral,
    /// One mirror, the given one or that which the incidences show.
    Bilateral(Option<Mirror>),
    /// Rotation by 180° about Z.
    Rotational180,
    /// Nothing but the identity.
    None,
}

/// An orthogonal map of the surface plane that keeps z: a mirror or a rotation about the normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Image {
    /// Where +X goes.
    pub x: DVec2,
    /// Where +Y goes.
    pub y: DVec2,
}

impl Image {
    /// Leaves everything where it is.
    pub const IDENTITY: Image = Image { x: DVec2::X, y: DVec2::Y };
    /// x → −x.
    pub const MIRROR_X: Image = Image { x: DVec2::NEG_X, y: DVec2::Y };
    /// y → −y.
    pub const MIRROR_Y: Image = Image { x: DVec2::X, y: DVec2::NEG_Y };
    /// Rotation by 180° about Z.
    pub const HALF_TURN: Image = Image { x: DVec2::NEG_X, y: DVec2::NEG_Y };

    /// The rotation about Z that takes +X to the azimuth of `w`; the identity where it has none.
    pub fn rotation_to(w: DVec3) -> Image {
        let x = w.truncate().normalize_or(DVec2::X);
        Image { x, y: DVec2::new(-x.y, x.x) }
    }

    /// The image of `w`.
    #[inline]
    pub fn apply(self, w: DVec3) -> DVec3 {
        (self.x * w.x + self.y * w.y).extend(w.z)
    }

    /// First `first`, then this one.
    #[must_use]
    pub fn after(self, first: Image) -> Image {
        let turned = |v: DVec2| self.x * v.x + self.y * v.y;
        Image { x: turned(first.x), y: turned(first.y) }
    }

    /// The map that undoes this one.
    #[must_use]
    pub fn inverse(self) -> Image {
        Image { x: DVec2::new(self.x.x, self.y.x), y: DVec2::new(self.x.y, self.y.y) }
    }
}

impl Symmetry {
    /// Every image under which the BSDF repeats, the identity first.
    ///
    /// [`Symmetry::Isotropic`] has infinitely many: it lists the identity, and [`Symmetry::fold`]
    /// gives the rotation.
    pub fn images(self) -> &'static [Image] {
        match self {
            Symmetry::Isotropic | Symmetry::None => &[Image::IDENTITY],
            Symmetry::Quadrilateral => {
                &[Image::IDENTITY, Image::MIRROR_X, Image::MIRROR_Y, Image::HALF_TURN]
            }
            Symmetry::Bilateral(Mirror::X) => &[Image::IDENTITY, Image::MIRROR_X],
            Symmetry::Bilateral(Mirror::Y) => &[Image::IDENTITY, Image::MIRROR_Y],
            Symmetry::Rotational180 => &[Image::IDENTITY, Image::HALF_TURN],
        }
    }

    /// The image that brings `from` nearest to `to`, the first of those that do, and how near (the
    /// chord).
    pub fn nearest_image(self, from: DVec3, to: DVec3) -> (f64, Image) {
        let apart = |image: Image| (image.apply(from).distance(to), image);
        if self == Symmetry::Isotropic {
            return apart(Image::rotation_to(to).after(Image::rotation_to(from).inverse()));
        }
        let images = self.images().iter().map(|&image| apart(image));
        images.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or(apart(Image::IDENTITY))
    }

    /// The images, other than the identity, that leave `wi` where it is.
    pub fn keeping(self, wi: DVec3) -> impl Iterator<Item = Image> {
        let kept = move |image: &&Image| image.apply(wi).distance(wi) < ON_MIRROR;
        self.images().iter().skip(1).filter(kept).copied()
    }

    /// `wi` moved into the fundamental domain, and the image that took it there.
    ///
    /// f(wi, wo) = f(folded, image.apply(wo)). The domain: azimuth 0 when isotropic, x ≥ 0 and y ≥
    /// 0 when quadrilateral, the mirror's positive side when bilateral, y ≥ 0 for the half turn.
    pub fn fold(self, wi: DVec3) -> (DVec3, Image) {
        let image = match self {
            Symmetry::None => Image::IDENTITY,
            Symmetry::Isotropic => Image::rotation_to(wi).inverse(),
            Symmetry::Bilateral(Mirror::X) if wi.x < 0.0 => Image::MIRROR_X,
            Symmetry::Bilateral(Mirror::Y) if wi.y < 0.0 => Image::MIRROR_Y,
            Symmetry::Bilateral(_) => Image::IDENTITY,
            Symmetry::Rotational180 if wi.y < 0.0 || (wi.y == 0.0 && wi.x < 0.0) => {
                Image::HALF_TURN
            }
            Symmetry::Rotational180 => Image::IDENTITY,
            Symmetry::Quadrilateral => match (wi.x < 0.0, wi.y < 0.0) {
                (false, false) => Image::IDENTITY,
                (true, false) => Image::MIRROR_X,
                (false, true) => Image::MIRROR_Y,
                (true, true) => Image::HALF_TURN,
            },
        };
        (image.apply(wi), image)
    }
}

impl SymmetryKind {
    /// Every kind with the name that stands for it in files and on the command line.
    pub const NAMES: [(&'static str, SymmetryKind); 7] = [
        ("isotropic", SymmetryKind::Isotropic),
        ("quadrilateral", SymmetryKind::Quadrilateral),
        ("bilateral", SymmetryKind::Bilateral(None)),
        ("bilateral-x", SymmetryKind::Bilateral(Some(Mirror::X))),
        ("bilateral-y", SymmetryKind::Bilateral(Some(Mirror::Y))),
        ("rotational180", SymmetryKind::Rotational180),
        ("none", SymmetryKind::None),
    ];
}

impl FromStr for SymmetryKind {
    type Err = Error;

    /// By name in any case, see [`SymmetryKind::NAMES`]; `up` is the reference's word for the half
    /// turn.
    fn from_str(text: &str) -> Result<Self> {
        let name = text.to_ascii_lowercase();
        let name = if name == "up" { "rotational180" } else { &name };
        Self::NAMES.iter().find(|(n, _)| *n == name).map(|&(_, kind)| kind).ok_or_else(|| {
            let names: Vec<&str> = Self::NAMES.iter().map(|&(n, _)| n).collect();
            Error::argument(format!(
                "symmetry: expected one of {}, found \"{text}\"",
                names.join(", ")
            ))
        })
    }
}

impl From<Symmetry> for SymmetryKind {
    fn from(symmetry: Symmetry) -> Self {
        match symmetry {
            Symmetry::Isotropic => SymmetryKind::Isotropic,
            Symmetry::Quadrilateral => SymmetryKind::Quadrilateral,
            Symmetry::Bilateral(mirror) => SymmetryKind::Bilateral(Some(mirror)),
            Symmetry::Rotational180 => SymmetryKind::Rotational180,
            Symmetry::None => SymmetryKind::None,
        }
    }
}

impl fmt::Display for Symmetry {
    /// The name in [`SymmetryKind::NAMES`].
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kind = SymmetryKind::from(*self);
        let (name, _) =
            SymmetryKind::NAMES.iter().find(|(_, k)| *k == kind).expect("every kind is named");
        f.write_str(name)
    }
}

#[cfg(test)]
mod tests {
    use bsdfkit_sphere::direction;

    use super::*;

    const ALL: [Symmetry; 6] = [
        Symmetry::Isotropic,
        Symmetry::Quadrilateral,
        Symmetry::Bilateral(Mirror::X),
        Symmetry::Bilateral(Mirror::Y),
        Symmetry::Rotational180,
        Symmetry::None,
    ];

    /// A BSDF-like function with exactly the symmetry asked for, and no more.
    fn symmetric(symmetry: Symmetry, wi: DVec3, wo: DVec3) -> f64 {
        let odd = |a: DVec3, b: DVec3| (3.0 * a.x + 1.7 * a.y + b.x * a.y - 2.3 * b.y).sin();
        let turns = match symmetry {
            Symmetry::Isotropic => {
                return (wi.truncate().perp_dot(wo.truncate())).sin() + wi.dot(wo);
            }
            other => other.images(),
        };
        turns.iter().map(|i| odd(i.apply(wi), i.apply(wo))).sum()
    }

    #[test]
    fn folding_keeps_the_function() {
        for symmetry in ALL {
            for (theta, phi) in [
                (30.0, 12.0),
                (50.0, 100.0),
                (70.0, 200.0),
                (20.0, 300.0),
                (0.0, 0.0),
                (140.0, 250.0),
            ] {
                let wi = direction::from_degrees(theta, phi);
                let wo = direction::from_degrees(55.0, 77.0);
                let (folded, image) = symmetry.fold(wi);
                let (before, after) =
                    (symmetric(symmetry, wi, wo), symmetric(symmetry, folded, image.apply(wo)));
                assert!(
                    (before - after).abs() < 1e-12,
                    "{symmetry} at {theta} {phi}: {before} became {after}"
                );
                assert!((image.inverse().apply(folded) - wi).length() < 1e-12);
                let (again, _) = symmetry.fold(folded);
                assert!((again - folded).length() < 1e-12, "{symmetry}: folding twice moves");
            }
        }
    }

    #[test]
    fn every_image_folds_to_the_same_place() {
        let wi = direction::from_degrees(40.0, 33.0);
        for symmetry in ALL {
            for &image in symmetry.images() {
                let (folded, _) = symmetry.fold(image.apply(wi));
                assert!((folded - symmetry.fold(wi).0).length() < 1e-12, "{symmetry}");
            }
        }
    }

    #[test]
    fn the_nearest_image_is_that_of_the_folded_direction() {
        let wi = direction::from_degrees(40.0, 33.0);
        for symmetry in ALL {
            for phi in (3..360).step_by(10) {
                let other = direction::from_degrees(50.0, f64::from(phi));
                let (near, image) = symmetry.nearest_image(other, wi);
                assert!((image.apply(other).distance(wi) - near).abs() < 1e-15, "{symmetry}");
                for turned in symmetry.images() {
                    assert!(turned.apply(other).distance(wi) >= near, "{symmetry} {phi}");
                }
            }
        }
        // Only the polar angle is left between them.
        let (near, _) = Symmetry::Isotropic.nearest_image(direction::from_degrees(50.0, 211.0), wi);
        assert!((near - 2.0 * 5f64.to_radians().sin()).abs() < 1e-12, "{near}");
    }

    #[test]
    fn names_round_trip_and_others_are_refused() {
        for symmetry in ALL {
            assert_eq!(symmetry.to_string().parse::<SymmetryKind>().unwrap(), symmetry.into());
        }
        assert_eq!("Up".parse::<SymmetryKind>().unwrap(), SymmetryKind::Rotational180);
        let message = "round".parse::<SymmetryKind>().unwrap_err().to_string();
        assert!(
            message.contains("expected one of isotropic, quadrilateral")
                && message.contains("\"round\"")
        );
    }
}
