//! The specimen's axes in the world.

use glam::DVec3;

/// Unit axes of a surface in world coordinates: right-handed, z the front normal, y "up".
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Right as seen from the front.
    pub x: DVec3,
    /// Up.
    pub y: DVec3,
    /// Front normal.
    pub z: DVec3,
}

/// Squared sine of normal and up below which they count as parallel: what rounding of two f64
/// vectors leaves. A larger one would refuse surfaces that lie nearly flat.
const PARALLEL: f64 = 1e-24;

impl Frame {
    /// z along `normal`, x along `up` × z, y = z × x; lengths do not matter.
    ///
    /// `None` for a vector without direction (zero, NaN, infinite) and where both are parallel.
    pub fn new(normal: DVec3, up: DVec3) -> Option<Self> {
        let (z, up) = (normal.try_normalize()?, up.try_normalize()?);
        let x = up.cross(z);
        if x.length_squared() < PARALLEL {
            return None;
        }
        let x = x.normalize();
        Some(Self { x, y: z.cross(x), z })
    }

    /// World → surface coordinates.
    pub fn to_local(&self, world: DVec3) -> DVec3 {
        DVec3::new(self.x.dot(world), self.y.dot(world), self.z.dot(world))
    }

    /// Surface → world coordinates, inverse of [`Frame::to_local`].
    pub fn to_world(&self, local: DVec3) -> DVec3 {
        self.x * local.x + self.y * local.y + self.z * local.z
    }
}
