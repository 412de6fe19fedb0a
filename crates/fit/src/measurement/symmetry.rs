//! What the incidences say about the symmetry of a specimen.

use bsdfkit::DVec3;
use bsdfkit_sphere::DVec2;

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

    /// The map that undoes this one.
    #[must_use]
    pub fn inverse(self) -> Image {
        Image { x: DVec2::new(self.x.x, self.y.x), y: DVec2::new(self.x.y, self.y.y) }
    }
}

impl Symmetry {
    /// Every image under which the BSDF repeats, the identity first.
    ///
    /// [`Symmetry::Isotropic`] has infinitely many: it lists the identity, and [`Symmetry::fold`] gives the rotation.
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

    /// `wi` moved into the fundamental domain, and the image that took it there.
    ///
    /// f(wi, wo) = f(folded, image.apply(wo)). The domain: azimuth 0 when isotropic, x ≥ 0 and y ≥ 0 when
    /// quadrilateral, the mirror's positive side when bilateral, y ≥ 0 for the half turn.
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
