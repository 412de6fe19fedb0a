//! Measured directions, compact.

use bsdfkit::DVec3;

/// A list of unit vectors, each kept as three numbers of single precision: 12 bytes.
///
/// A direction comes back to 1e-7 rad (6e-6 degrees). Files carry a thousandth of a degree, and
/// instruments repeat to about a fiftieth. Millions of points take most of the memory of a fit:
/// with double precision they would take twice as much, and tell no more.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Directions {
    all: Vec<[f32; 3]>,
}

impl Directions {
    /// None.
    pub fn new() -> Self {
        Self::default()
    }

    /// How many.
    pub fn len(&self) -> usize {
        self.all.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// Direction `index`; panics where there are fewer.
    #[inline]
    pub fn at(&self, index: usize) -> DVec3 {
        double(&self.all[index])
    }

    /// The first, if there is one.
    pub fn first(&self) -> Option<DVec3> {
        self.all.first().map(double)
    }

    /// All, in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = DVec3> + DoubleEndedIterator + Clone {
        self.all.iter().map(double)
    }

    /// The numbers that are kept: x, y, z of each in order.
    pub fn numbers(&self) -> impl Iterator<Item = f32> {
        self.all.iter().flatten().copied()
    }

    /// Adds one at the end.
    pub fn push(&mut self, w: DVec3) {
        self.all.push(single(w));
    }

    /// Puts `f` of each in its place.
    pub fn change(&mut self, f: impl Fn(DVec3) -> DVec3) {
        self.all.iter_mut().for_each(|w| *w = single(f(double(w))));
    }

    /// Keeps those for which `keeps` holds, asked in order.
    pub fn retain(&mut self, mut keeps: impl FnMut(DVec3) -> bool) {
        self.all.retain(|w| keeps(double(w)));
    }

    /// Drops all but the first `count`.
    pub fn truncate(&mut self, count: usize) {
        self.all.truncate(count);
    }

    /// Moves those of `other` to the end.
    pub fn append(&mut self, other: &mut Self) {
        self.all.append(&mut other.all);
    }

    /// Gives back the memory that growing took too much.
    pub fn shrink_to_fit(&mut self) {
        self.all.shrink_to_fit();
    }
}

impl Extend<DVec3> for Directions {
    fn extend<T: IntoIterator<Item = DVec3>>(&mut self, directions: T) {
        self.all.extend(directions.into_iter().map(single));
    }
}

impl FromIterator<DVec3> for Directions {
    fn from_iter<T: IntoIterator<Item = DVec3>>(directions: T) -> Self {
        Self { all: directions.into_iter().map(single).collect() }
    }
}

#[inline]
fn single(w: DVec3) -> [f32; 3] {
    [w.x as f32, w.y as f32, w.z as f32]
}

#[inline]
fn double(&[x, y, z]: &[f32; 3]) -> DVec3 {
    DVec3::new(f64::from(x), f64::from(y), f64::from(z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use bsdfkit_sphere::direction::from_degrees;

    #[test]
    fn directions_come_back_to_what_is_said_of_them() {
        let of = |k: i32| from_degrees(f64::from(k) * 0.0179, f64::from(k) * 7.31);
        let kept: Directions = (0..10_000).map(of).collect();
        for (k, w) in (0..).zip(kept.iter()) {
            assert!(w.distance(of(k)) < 1e-7, "{w}");
            // Near the horizon the cosine, by which values are divided, is as good.
            assert!((w.z / of(k).z - 1.0).abs() < 1e-7, "{w}");
        }
        assert_eq!(kept.len(), 10_000);
    }
}
