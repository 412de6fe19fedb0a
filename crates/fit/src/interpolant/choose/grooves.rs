//! Along which line a specimen is drawn out, if along any.
//!
//! Slats, prisms, threads and brushed metal are the same all along a line. How much they scatter then depends on the profile
//! angle, the angle of incidence in the plane across that line, more than on anything else. The line along which it does so
//! most is looked for; whether it tells where light goes is for left-out incidences to say.

use bsdfkit::{DVec2, DVec3};

use bsdfkit_measure::{Measurement, Symmetry};

/// Directions tried in half a turn, where no mirror tells.
const TRIED: usize = 36;

/// Azimuth of the line along which energies differ least, radians in 0 to π; `None` of an isotropic specimen, or where there
/// are fewer than six incidences.
pub(crate) fn grooves(m: &Measurement, energies: &[f64]) -> Option<f64> {
    if m.symmetry == Symmetry::Isotropic || energies.len() < 6 {
        return None;
    }
    let known: Vec<(DVec3, f64)> = m
        .incidences
        .iter()
        .zip(energies)
        .flat_map(|(i, &e)| m.symmetry.images().iter().map(move |image| (image.apply(i.wi), e)))
        .collect();
    let tried: Vec<f64> = match m.symmetry {
        Symmetry::Bilateral(_) | Symmetry::Quadrilateral => {
            vec![0.0, std::f64::consts::FRAC_PI_2]
        }
        _ => (0..TRIED).map(|k| std::f64::consts::PI * k as f64 / TRIED as f64).collect(),
    };
    tried
        .into_iter()
        .map(|a| (roughness(&known, a), a))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map(|b| b.1)
}

/// How much energies change from one profile angle to the next.
fn roughness(known: &[(DVec3, f64)], azimuth: f64) -> f64 {
    let across = -DVec2::from_angle(azimuth).perp();
    let mut curve: Vec<(f64, f64)> =
        known.iter().map(|(w, e)| (w.truncate().dot(across).atan2(w.z.abs()), *e)).collect();
    curve.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    curve.windows(2).map(|w| (w[1].1 - w[0].1).abs()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use bsdfkit::Side;
    use bsdfkit_measure::{Colorimetry, Incidence, Mirror};
    use bsdfkit_sphere::direction::from_degrees;

    fn found(symmetry: Symmetry, azimuth: f64, phis: std::ops::Range<i32>) -> Option<f64> {
        let across = -DVec2::from_angle(azimuth).perp();
        let directions: Vec<DVec3> = [0.0, 20.0, 40.0, 60.0, 75.0]
            .into_iter()
            .flat_map(|theta| phis.clone().map(move |k| from_degrees(theta, f64::from(30 * k))))
            .collect();
        // Slats that shut out what comes from one side.
        let view = |w: &DVec3| (0.5 - w.truncate().dot(across).atan2(w.z)).clamp(0.05, 0.9);
        let energies: Vec<f64> = directions.iter().map(view).collect();
        let of = |&wi: &DVec3| Incidence::new(wi, [], []);
        let incidences = directions.iter().map(of).collect();
        let m = Measurement {
            incident: Side::Front,
            scattered: Side::Back,
            colorimetry: Colorimetry::Luminance,
            symmetry,
            incidences,
            sample_name: None,
            notes: Vec::new(),
        };
        grooves(&m, &energies)
    }

    #[test]
    fn slats_are_found_along_or_across_a_mirror_and_at_any_angle_without() {
        let half = std::f64::consts::FRAC_PI_2;
        assert_eq!(found(Symmetry::Bilateral(Mirror::Y), half, 0..7), Some(half));
        assert_eq!(found(Symmetry::Bilateral(Mirror::X), 0.0, -3..4), Some(0.0));
        let turned = found(Symmetry::None, 35f64.to_radians(), 0..12).expect("a line");
        assert!((turned.to_degrees() - 35.0).abs() < 5.1, "{turned}");
        assert_eq!(found(Symmetry::Isotropic, 0.0, 0..1), None);
    }
}
