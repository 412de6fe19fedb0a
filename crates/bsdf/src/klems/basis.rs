//! Klems bases: the hemisphere cut into rings, each ring into equal azimuth patches. [K94]

use std::f64::consts::PI;
use std::sync::{Arc, OnceLock};

use bsdfkit_sphere::octant::{at_turns, turns};
use bsdfkit_sphere::{DVec2, DVec3};

use super::numbering::Numbering;
use crate::{Error, Lanes, Result};

/// One ring of a Klems basis: all polar angles up to `upper_degrees` that the ring before does
/// not have, cut into `patches` equal azimuths.
///
/// Convention: patch k is centred on φ = 360° k / patches and spans ±180° / patches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ring {
    /// Outer polar angle.
    pub upper_degrees: f64,
    /// Number of azimuth patches, at least 1.
    pub patches: usize,
}

/// A basis: rings outward from the normal, patches numbered ring by ring, azimuth fastest.
///
/// Convention: numbers *directions of the upper hemisphere in basis form*; which side and sense
/// they stand for is [`KlemsMatrix`](crate::matrix::KlemsMatrix)'s affair.
/// Differs from: Radiance, where the last ring excludes θ = 90° and a file's rings are ignored
/// when their name is known.
#[derive(Clone, Debug)]
pub struct KlemsBasis(Arc<Inner>);

#[derive(Debug)]
struct Inner {
    name: String,
    rings: Vec<Ring>,
    /// First index of each ring, then the number of directions.
    first: Vec<usize>,
    /// cos θ of ring bounds, from 1 at the normal outward; one more than rings.
    cosines: Vec<f64>,
    /// Made when first asked for.
    numbering: OnceLock<Numbering>,
}

impl PartialEq for KlemsBasis {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
            || (self.name(), self.rings()) == (other.name(), other.rings())
    }
}

const FULL: &[(f64, usize)] = &[
    (5.0, 1),
    (15.0, 8),
    (25.0, 16),
    (35.0, 20),
    (45.0, 24),
    (55.0, 24),
    (65.0, 24),
    (75.0, 16),
    (90.0, 12),
];
const HALF: &[(f64, usize)] =
    &[(6.5, 1), (19.5, 8), (32.5, 12), (45.5, 16), (58.5, 20), (71.5, 12), (90.0, 8)];
const HALF_73: &[(f64, usize)] =
    &[(6.5, 1), (19.5, 8), (32.5, 12), (46.5, 16), (61.5, 20), (76.5, 12), (90.0, 4)];
const QUARTER: &[(f64, usize)] = &[(9.0, 1), (27.0, 8), (45.0, 12), (63.0, 12), (90.0, 8)];

impl Inner {
    /// The patch of ring `r` that an azimuth in turns is nearest to.
    #[inline(always)]
    fn patch(&self, r: usize, turns: f64) -> usize {
        let patches = self.rings[r].patches;
        let k = (turns * patches as f64 + 0.5) as usize;
        self.first[r] + if k >= patches { 0 } else { k }
    }
}

impl KlemsBasis {
    /// `LBNL/Klems Full`, 145 directions.
    pub fn full() -> Self {
        Self::from_table("LBNL/Klems Full", FULL)
    }

    /// `LBNL/Klems Half`, 77 directions: what LBNL's WINDOW engine and Radiance since 2022 mean.
    pub fn half() -> Self {
        Self::from_table("LBNL/Klems Half", HALF)
    }

    /// The 73 directions that Radiance before 2022 called `LBNL/Klems Half`.
    pub fn half_73() -> Self {
        Self::from_table("LBNL/Klems Half", HALF_73)
    }

    /// `LBNL/Klems Quarter`, 41 directions.
    pub fn quarter() -> Self {
        Self::from_table("LBNL/Klems Quarter", QUARTER)
    }

    /// The built-in basis of that name, in any case; `None` for others.
    pub fn named(name: &str) -> Option<Self> {
        [Self::full(), Self::half(), Self::quarter()]
            .into_iter()
            .find(|basis| basis.name().eq_ignore_ascii_case(name))
    }

    fn from_table(name: &str, table: &[(f64, usize)]) -> Self {
        let rings =
            table.iter().map(|&(upper_degrees, patches)| Ring { upper_degrees, patches }).collect();
        Self::new(name, rings).expect("the built-in tables are valid")
    }

    /// A basis of the given rings, inner to outer; the first starts at the normal.
    ///
    /// Errors: argument: no ring, no patch in a ring, bounds that do not increase or pass 90°,
    /// a single patch in any ring but the first, more than 2³¹ directions.
    pub fn new(name: impl Into<String>, rings: Vec<Ring>) -> Result<Self> {
        let name = name.into();
        let fault = |text: String| Err(Error::argument(format!("angle basis {name:?}: {text}")));
        if rings.is_empty() {
            return fault("expected at least one ring, found none".into());
        }
        let mut first = vec![0usize];
        let mut cosines = vec![1.0];
        let mut lower = 0.0;
        for (r, ring) in rings.iter().enumerate() {
            let upper = ring.upper_degrees;
            if !(upper > lower && upper <= 90.0) {
                return fault(format!(
                    "ring {}: expected an upper bound in ({lower}, 90] degrees, found {upper}",
                    r + 1
                ));
            }
            if ring.patches == 0 || (ring.patches == 1 && r > 0) {
                let least = if r > 0 { 2 } else { 1 };
                return fault(format!(
                    "ring {}: expected at least {least} azimuths, found {}",
                    r + 1,
                    ring.patches
                ));
            }
            match first[r].checked_add(ring.patches).filter(|&n| n <= 1 << 31) {
                Some(n) => first.push(n),
                None => return fault("more than 2^31 directions".into()),
            }
            cosines.push(if upper == 90.0 { 0.0 } else { upper.to_radians().cos() });
            lower = upper;
        }
        Ok(Self(Arc::new(Inner { name, rings, first, cosines, numbering: OnceLock::new() })))
    }

    /// The name as written in files.
    pub fn name(&self) -> &str {
        &self.0.name
    }

    /// The rings, inner to outer.
    pub fn rings(&self) -> &[Ring] {
        &self.0.rings
    }

    /// Number of directions (patches).
    pub fn directions(&self) -> usize {
        *self.0.first.last().expect("`first` starts with 0")
    }

    /// First patch of each ring, then the number of directions.
    pub(crate) fn ring_starts(&self) -> &[usize] {
        &self.0.first
    }

    /// Inner and outer polar angle of ring `r`.
    pub fn ring_bounds_degrees(&self, r: usize) -> (f64, f64) {
        let lower = if r == 0 { 0.0 } else { self.0.rings[r - 1].upper_degrees };
        (lower, self.0.rings[r].upper_degrees)
    }

    /// Cosine of the outer polar angle of ring `r`; exactly 0 at grazing, so that the last ring is
    /// closed.
    pub fn ring_cosine(&self, r: usize) -> f64 {
        self.0.cosines[r + 1]
    }

    /// Polar angle by which files name ring `r`: 0 for a first ring of one patch, else the mean of
    /// its bounds.
    pub fn ring_centre_degrees(&self, r: usize) -> f64 {
        let (lower, upper) = self.ring_bounds_degrees(r);
        if r == 0 && self.0.rings[0].patches == 1 { 0.0 } else { 0.5 * (lower + upper) }
    }

    /// Ring of patch `k`.
    fn ring_of(&self, k: usize) -> usize {
        debug_assert!(k < self.directions());
        self.0.first.partition_point(|&first| first <= k) - 1
    }

    /// Direction in basis form (z ≥ 0) → patch: lower bound ≤ θ < upper bound, nearest azimuth.
    ///
    /// The last ring of a basis that reaches 90° is closed: exactly grazing directions have a
    /// patch. `None` beyond the last ring, below the horizon and for NaN.
    ///
    /// Differs from: Radiance, where exactly grazing directions have none.
    /// Cost: some 5 ns by a table of 2 KB a ring, made at the first call; hard by borders four
    /// times that.
    #[inline]
    pub fn index(&self, w: DVec3) -> Option<usize> {
        self.numbering().index(w).or_else(|| self.index_by_angles(w))
    }

    /// The same without the table.
    pub(crate) fn index_by_angles(&self, w: DVec3) -> Option<usize> {
        let inner = &*self.0;
        let last = inner.cosines.len() - 1;
        let outer = inner.cosines[last];
        let inside = w.z > outer || (w.z == 0.0 && outer == 0.0);
        if !inside || w.x.is_nan() || w.y.is_nan() {
            return None;
        }
        let r = inner.cosines[1..last].iter().take_while(|&&cos| w.z <= cos).count();
        Some(inner.patch(r, turns(w.x, w.y)))
    }

    /// [`KlemsBasis::index`] of up to [`CHUNK`](super::numbering::CHUNK) directions (sign · x, sign
    /// · y, |z|); [`NO_PATCH`](super::numbering::NO_PATCH) for `None`.
    #[inline(always)]
    pub(crate) fn indices(&self, w: Lanes<'_>, sign: f64, out: &mut [u32]) {
        self.numbering().indices(w, sign, out, |w| self.index_by_angles(w));
    }

    pub(crate) fn numbering(&self) -> &Numbering {
        self.0.numbering.get_or_init(|| {
            let cosines = &self.0.cosines;
            let last = cosines.len() - 1;
            Numbering::new(&self.0.first, &cosines[1..last], cosines[last])
        })
    }

    /// cos θ of the inner and of the outer bound of patch `k`, its number in the ring, and the
    /// ring's patches.
    pub(crate) fn extent(&self, k: usize) -> ([f64; 2], usize, usize) {
        let (r, inner) = (self.ring_of(k), &*self.0);
        ([inner.cosines[r], inner.cosines[r + 1]], k - inner.first[r], inner.rings[r].patches)
    }

    /// Patch `k` and a point of the unit square → direction in basis form, uniform in projected
    /// solid angle: cos²θ = (1−u) cos²θ₀ + u cos²θ₁, φ = 2π (k + v − ½) / patches.
    pub fn direction_in(&self, k: usize, point: DVec2) -> DVec3 {
        let ([c0, c1], ..) = self.extent(k);
        let cos2 = (1.0 - point.x) * c0 * c0 + point.x * c1 * c1;
        Patch::new(self, k).at(point).extend(cos2.max(0.0).sqrt())
    }

    /// Patch `k` → (θ, φ) in degrees by which files name it.
    pub fn centre_degrees(&self, k: usize) -> (f64, f64) {
        let r = self.ring_of(k);
        let phi = 360.0 * (k - self.0.first[r]) as f64 / self.0.rings[r].patches as f64;
        (self.ring_centre_degrees(r), phi)
    }

    /// Patch `k` → direction of its centre in basis form.
    pub fn centre(&self, k: usize) -> DVec3 {
        let (theta, phi) = self.centre_degrees(k);
        bsdfkit_sphere::direction::from_degrees(theta, phi)
    }

    /// Projected solid angle of patch `k`, Ω = π (cos²θ₀ − cos²θ₁) / patches, in sr.
    ///
    /// Sums to π over a basis that reaches 90°.
    #[inline]
    pub fn projected_solid_angle(&self, k: usize) -> f64 {
        let r = self.ring_of(k);
        let (c0, c1) = (self.0.cosines[r], self.0.cosines[r + 1]);
        PI * (c0 * c0 - c1 * c1) / self.0.rings[r].patches as f64
    }

    /// The projected solid angle of every patch, in sr.
    pub(crate) fn projected_solid_angles(&self) -> Vec<f64> {
        (0..self.directions()).map(|k| self.projected_solid_angle(k)).collect()
    }

    /// Smallest and largest projected solid angle of a patch, in sr.
    pub fn projected_solid_angle_range(&self) -> (f64, f64) {
        self.0.first[..self.0.rings.len()]
            .iter()
            .map(|&k| self.projected_solid_angle(k))
            .fold((f64::INFINITY, 0.0), |(lo, hi), omega| (omega.min(lo), omega.max(hi)))
    }

    /// Whether the rings reach grazing; directions beyond the last ring have no data.
    pub fn is_complete(&self) -> bool {
        self.0.cosines.last() == Some(&0.0)
    }
}

/// A patch as the image of the unit square: sin²θ = from + u · step, φ = (first + v) / count turns.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Patch {
    from: f64,
    step: f64,
    first: f64,
    count: f64,
}

impl Patch {
    pub(crate) fn new(basis: &KlemsBasis, k: usize) -> Self {
        let (cosines, number, count) = basis.extent(k);
        let [from, to] = cosines.map(|c| (1.0 - c) * (1.0 + c));
        Self { from, step: to - from, first: number as f64 - 0.5, count: count as f64 }
    }

    /// Point of the unit square → projection of a direction in basis form, uniform in projected
    /// solid angle.
    #[inline(always)]
    pub(crate) fn at(&self, point: DVec2) -> DVec2 {
        let sin = (self.from + point.x * self.step).sqrt();
        at_turns((self.first + point.y) / self.count) * sin
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bases() -> [KlemsBasis; 4] {
        [KlemsBasis::full(), KlemsBasis::half(), KlemsBasis::half_73(), KlemsBasis::quarter()]
    }

    #[test]
    fn sizes_and_total_projected_solid_angle() {
        for (basis, n) in bases().iter().zip([145, 77, 73, 41]) {
            assert_eq!(basis.directions(), n);
            let sum: f64 = (0..n).map(|k| basis.projected_solid_angle(k)).sum();
            assert!((sum - PI).abs() < 1e-12, "{}: {sum}", basis.name());
        }
    }

    #[test]
    fn every_point_of_a_patch_finds_its_patch() {
        for basis in bases() {
            for k in 0..basis.directions() {
                assert_eq!(basis.index(basis.centre(k)), Some(k));
                for (u, v) in
                    [(0.001, 0.001), (0.999, 0.001), (0.001, 0.999), (0.5, 0.5), (0.999, 0.999)]
                {
                    let w = basis.direction_in(k, DVec2::new(u, v));
                    assert!((w.length() - 1.0).abs() < 1e-14);
                    assert_eq!(basis.index(w), Some(k), "{} {k} {u} {v}", basis.name());
                }
            }
        }
    }

    #[test]
    fn grazing_belongs_to_the_last_ring() {
        let basis = KlemsBasis::full();
        assert_eq!(basis.index(DVec3::X), Some(133));
        assert_eq!(basis.index(DVec3::new(1.0, 0.0, -0.0)), Some(133));
        assert_eq!(basis.index(DVec3::new(1.0, 0.0, -1e-9)), None);
        assert_eq!(basis.index(DVec3::NAN), None);
        let short =
            KlemsBasis::new("short", vec![Ring { upper_degrees: 60.0, patches: 2 }]).unwrap();
        assert_eq!(short.index(DVec3::X), None);
        assert!(!short.is_complete());
    }

    #[test]
    fn bad_rings_are_named() {
        let message = |rings: &[(f64, usize)]| {
            let rings =
                rings.iter().map(|&(upper_degrees, patches)| Ring { upper_degrees, patches });
            KlemsBasis::new("mine", rings.collect()).unwrap_err().to_string()
        };
        assert!(message(&[]).contains("at least one ring"));
        assert!(
            message(&[(10.0, 1), (5.0, 4)]).contains("ring 2: expected an upper bound in (10, 90]")
        );
        assert!(message(&[(f64::NAN, 1)]).contains("ring 1"));
        assert!(message(&[(10.0, 1), (90.0, 1)]).contains("at least 2 azimuths"));
        assert!(message(&[(10.0, usize::MAX), (90.0, 4)]).contains("2^31"));
    }
}
