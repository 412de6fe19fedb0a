//! What symmetry says of an incidence beside its own points: their images, and the turns about the normal.

use std::borrow::Cow;

use bsdfkit::DVec3;

use super::seen::{Seen, limit};
use super::{Image, Incidence, MERGE_DEGREES, Symmetry};

/// Turning must show so much more of the hemisphere: who measured all round needs no images.
const WORTH: f64 = 0.05;

/// Least and most arc between the images of a turned point, degrees: what is turned is the same all round, so
/// that narrow peaks need no finer one.
const ARC_DEGREES: (f64, f64) = (1.0, 5.0);

/// Least images of a point.
const FEWEST_IMAGES: usize = 24;

/// Images in all, about: ten times the points of a usual scan.
const MOST_IMAGES: usize = 500_000;

impl Incidence {
    /// Its points, and their images under what `symmetry` leaves its direction where it is.
    ///
    /// An isotropic specimen lit along the normal scatters alike all round: where few azimuths were
    /// measured, every point is turned about the normal. Its own points come first.
    pub fn with_images(&self, symmetry: Symmetry) -> Cow<'_, Incidence> {
        let mut all = Cow::Borrowed(self);
        for image in symmetry.keeping(self.wi) {
            let all = all.to_mut();
            all.wo.extend(self.wo.iter().map(|w| image.apply(w)));
            all.values.extend_from_slice(&self.values);
        }
        let axial = self.wi.truncate().length() < MERGE_DEGREES.to_radians();
        if symmetry == Symmetry::Isotropic && axial && !self.wo.is_empty() {
            let limit = limit(&self.wo);
            let turned = limit * limit;
            if Seen::of(self).share(limit) < turned - WORTH {
                turn(all.to_mut());
            }
        }
        all
    }
}

/// Adds the images of every point around the normal.
fn turn(incidence: &mut Incidence) {
    let (own, channels) = (incidence.wo.len(), incidence.channels());
    let mut polar: Vec<f64> = incidence.wo.iter().map(|w| w.z.abs().min(1.0).acos()).collect();
    polar.sort_by(f64::total_cmp);
    let mut steps: Vec<f64> =
        polar.windows(2).map(|p| p[1] - p[0]).filter(|s| *s > MERGE_DEGREES.to_radians()).collect();
    steps.sort_by(f64::total_cmp);
    let usual = steps.get(steps.len() / 2).copied().unwrap_or(0.0);
    let arc = usual.clamp(ARC_DEGREES.0.to_radians(), ARC_DEGREES.1.to_radians());
    let most = (MOST_IMAGES / own).max(1);
    // Of very many points every so many are turned.
    let every = (own * FEWEST_IMAGES / MOST_IMAGES).max(1);
    for k in (0..own).step_by(every) {
        let w = incidence.wo.at(k);
        let round = std::f64::consts::TAU * w.truncate().length();
        let images = ((round / arc) as usize).max(FEWEST_IMAGES).min(most.max(FEWEST_IMAGES));
        for n in 1..images {
            let turn = std::f64::consts::TAU * n as f64 / images as f64;
            let image = Image::rotation_to(DVec3::new(turn.cos(), turn.sin(), 0.0));
            incidence.wo.push(image.apply(w));
            incidence.values.extend_from_within(k * channels..(k + 1) * channels);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bsdfkit_sphere::direction::from_degrees;

    fn plane(wi: DVec3) -> Incidence {
        let angles = (-16..=16).map(|k| 5.0 * f64::from(k));
        let wo: Vec<DVec3> = angles.map(|theta| from_degrees(theta, 30.0)).collect();
        Incidence::new(wi, wo.clone(), wo.iter().map(|w| w.z))
    }

    #[test]
    fn an_isotropic_specimen_lit_along_the_normal_is_turned_and_no_other() {
        let axial = plane(DVec3::Z);
        let all = axial.with_images(Symmetry::Isotropic);
        assert!(all.wo.iter().take(33).eq(axial.wo.iter()));
        assert!(Seen::of(&all).share(limit(&all.wo)) > 0.96);
        for (w, value) in all.points(0) {
            assert!((w.z - value).abs() < 1e-7, "{w} {value}");
        }
        assert_eq!(axial.with_images(Symmetry::None).wo.len(), 33);
        assert_eq!(plane(from_degrees(20.0, 0.0)).with_images(Symmetry::Isotropic).wo.len(), 33);
        // Mirrors and the half turn alone show no more than a second plane.
        assert_eq!(axial.with_images(Symmetry::Quadrilateral).wo.len(), 4 * 33);
    }

    #[test]
    fn who_measured_all_round_gets_no_images_and_many_points_no_flood() {
        let mut all = plane(DVec3::Z).with_images(Symmetry::Isotropic).into_owned();
        let points = all.wo.len();
        assert_eq!(all.with_images(Symmetry::Isotropic).wo.len(), points);
        all = plane(DVec3::Z);
        let many = (0..100_000).map(|k| from_degrees(f64::from(k) * 8e-4, 30.0));
        all.wo = many.collect();
        all.values = vec![1.0; all.wo.len()];
        assert!(all.with_images(Symmetry::Isotropic).wo.len() < 800_000);
    }
}
