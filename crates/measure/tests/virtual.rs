//! The reader against the virtual goniophotometer, whose truth is known.

use std::path::Path;

use bsdfkit::{ErrorClass, Result};
use bsdfkit_measure::{
    Image, Incidence, Measurement, Mirror, ReadOptions, Symmetry, SymmetryKind, read,
};
use bsdfkit_simulate::material::{BrushedMetal, Fabric, FrittedGlass, RotatedMetal, registry};
use bsdfkit_simulate::{Goniophotometer, Material, SymmetryHint, write_measurements};
use bsdfkit_sphere::direction::from_degrees;

/// A tenth of the usual points.
fn sparse() -> Goniophotometer {
    Goniophotometer { sweeps: 36, points_per_sweep: 80, spiral_points: 2000, ..Default::default() }
}

fn one(folder: &Path, options: &ReadOptions) -> Result<Measurement> {
    read(&[folder.to_owned()], options).map(|mut components| {
        assert_eq!(components.len(), 1);
        components.remove(0)
    })
}

/// Writes only the incidences (θ, φ) given.
fn measured(
    material: &dyn Material,
    incidences: &[(f64, f64)],
    symmetry: Option<SymmetryKind>,
) -> Result<Measurement> {
    let folder = tempfile::tempdir().unwrap();
    for (k, &(theta, phi)) in incidences.iter().enumerate() {
        let scan = sparse().scan(material, theta, phi);
        let mut text =
            format!("#format: theta phi BSDF\n#incident_angle {theta} {phi}\n#upphi 90\n");
        for (&w, value) in scan.wo.iter().zip(&scan.values) {
            let (theta, phi) = bsdfkit_sphere::direction::to_degrees(w);
            text += &format!("{theta} {phi} {value}\n");
        }
        std::fs::write(folder.path().join(k.to_string()), text).unwrap();
    }
    one(folder.path(), &ReadOptions { symmetry, ..Default::default() })
}

fn grid(thetas: &[f64], phis: &[f64]) -> Vec<(f64, f64)> {
    thetas.iter().flat_map(|&t| phis.iter().map(move |&p| (t, p))).collect()
}

#[test]
fn written_files_come_back_with_points_values_and_symmetry() {
    for material in registry() {
        let folder = tempfile::tempdir().unwrap();
        let summary =
            write_measurements(folder.path(), material.as_ref(), &sparse(), |_, _| Ok(())).unwrap();
        let m = one(folder.path(), &ReadOptions::default()).unwrap();
        let name = material.name();
        let expected = match material.symmetry() {
            SymmetryHint::Isotropic => Symmetry::Isotropic,
            SymmetryHint::Quadrilateral => Symmetry::Quadrilateral,
            SymmetryHint::Bilateral => Symmetry::Bilateral(Mirror::Y),
            SymmetryHint::None => Symmetry::None,
        };
        assert_eq!(m.symmetry, expected, "{name}: {:?}", m.notes);
        assert_eq!(m.scattered, material.scattered());
        assert_eq!((m.incidences.len(), m.points()), (summary.files.len(), summary.points));
        assert_eq!(m.sample_name.as_deref(), Some(name));
        for incidence in &m.incidences {
            for index in (0..incidence.wo.len()).step_by(97) {
                let truth = material.eval(incidence.wi, incidence.wo.at(index));
                let read = incidence.value(index, 0);
                // angles have three decimals: a lobe of 2° changes by 0.1 % within one
                assert!((read - truth).abs() < 2e-3 * truth.abs() + 1e-6, "{name}: {read} {truth}");
            }
        }
    }
}

#[test]
fn the_simulator_does_not_mix_its_files_with_others() {
    let folder = tempfile::tempdir().unwrap();
    let write = |material: &dyn Material| {
        write_measurements(folder.path(), material, &sparse(), |_, _| Ok(())).map(|s| s.files.len())
    };
    assert_eq!(write(&FrittedGlass::default()).unwrap(), 6);
    assert_eq!(write(&FrittedGlass::default()).unwrap(), 6);
    let pane = &registry()[5];
    let error = write(pane.as_ref()).unwrap_err();
    assert_eq!(error.class(), ErrorClass::Argument);
    assert!(error.to_string().contains("expected a new or empty folder, found \"i_"), "{error}");
}

#[test]
fn isotropic_in_ways_the_reference_fails_at() {
    let glass = FrittedGlass::default();
    let thetas = [20.0, 40.0, 60.0];
    for (phis, count) in
        [(vec![45.0], 3), (vec![0.0, 180.0], 3), (vec![0.0, 90.0], 3), (vec![33.0, 213.0], 3)]
    {
        let m = measured(&glass, &grid(&thetas, &phis), None).unwrap();
        assert_eq!((m.symmetry, m.incidences.len()), (Symmetry::Isotropic, count), "{phis:?}");
        for incidence in &m.incidences {
            assert!(incidence.wi.y.abs() < 1e-12 && incidence.wi.x > 0.0);
            let (w, value) = (incidence.wo.at(50), incidence.value(50, 0));
            assert!((glass.eval(incidence.wi, w) / value - 1.0).abs() < 1e-5, "{phis:?}");
        }
    }
    let given = measured(&glass, &grid(&thetas, &[45.0]), Some(SymmetryKind::Isotropic)).unwrap();
    assert_eq!(given.symmetry, Symmetry::Isotropic);
    // a normal incidence has any azimuth
    let m = measured(&glass, &[(0.0, 77.0), (30.0, 0.0), (60.0, 0.0)], None).unwrap();
    assert_eq!(m.symmetry, Symmetry::Isotropic);
}

#[test]
fn symmetry_from_the_azimuths_and_the_data() {
    let metal = BrushedMetal::default();
    let detect = |m: &dyn Material, phis: &[f64]| {
        let found = measured(m, &grid(&[30.0, 60.0], phis), None).unwrap();
        (found.symmetry, found.incidences.len())
    };
    assert_eq!(detect(&metal, &[0.0, 90.0]), (Symmetry::Quadrilateral, 4));
    assert_eq!(detect(&metal, &[90.0, 135.0, 180.0]), (Symmetry::Quadrilateral, 6));
    assert_eq!(detect(&metal, &[7.5, 45.0, 82.5]), (Symmetry::Quadrilateral, 6));
    assert_eq!(detect(&metal, &[-90.0, -45.0, 0.0, 45.0, 90.0]).0, Symmetry::Bilateral(Mirror::X));
    // the half turn is all that a rotated grain has, and the data show it
    let rotated = RotatedMetal::default();
    let half = [0.0, 45.0, 90.0, 135.0];
    assert_eq!(detect(&rotated, &half), (Symmetry::Rotational180, 8));
    assert_eq!(detect(&rotated, &[20.0, 65.0, 110.0, 155.0, 200.0]).0, Symmetry::Rotational180);
}

#[test]
fn a_given_symmetry_folds_or_is_refused_with_the_reason() {
    let metal = BrushedMetal::default();
    let around = grid(&[30.0, 60.0], &[0.0, 60.0, 120.0, 180.0, 240.0, 300.0]);
    let m = measured(&metal, &around, Some(SymmetryKind::Quadrilateral)).unwrap();
    assert_eq!((m.symmetry, m.incidences.len()), (Symmetry::Quadrilateral, 4));
    for incidence in &m.incidences {
        assert!(incidence.wi.x >= 0.0 && incidence.wi.y >= 0.0);
        let last = incidence.wo.len() - 1;
        let truth = metal.eval(incidence.wi, incidence.wo.at(last));
        assert!((truth - incidence.value(last, 0)).abs() < 1e-5 * truth);
    }
    let refused = |material: &dyn Material, kind| {
        let error = measured(material, &around, Some(kind)).unwrap_err();
        assert_eq!(error.class(), ErrorClass::Argument);
        error.to_string()
    };
    let message = refused(&metal, SymmetryKind::Isotropic);
    assert!(
        message.starts_with(
            "front reflection: symmetry isotropic: expected the distributions at incidence theta"
        ) && message.contains("of their light, of which noise explains"),
        "{message}"
    );
    let message = refused(&RotatedMetal::default(), SymmetryKind::Quadrilateral);
    assert!(message.contains("symmetry quadrilateral"), "{message}");
    measured(&RotatedMetal::default(), &around, Some(SymmetryKind::Rotational180)).unwrap();
}

#[test]
fn incidences_that_cover_less_than_the_symmetry_needs() {
    let metal = BrushedMetal::default();
    let refused = |incidences: &[(f64, f64)], kind, class| {
        let error = measured(&metal, incidences, kind).unwrap_err();
        assert_eq!(error.class(), class, "{error}");
        error.to_string()
    };
    let message = refused(&[(30.0, 0.0)], None, ErrorClass::Format);
    assert!(
        message.contains("expected at least 2 incident directions, found only theta 30.0 phi 0.0")
    );
    let quadrant = grid(&[30.0, 60.0], &[0.0, 45.0, 90.0]);
    let message = refused(&quadrant, Some(SymmetryKind::None), ErrorClass::Argument);
    assert!(message.contains("found a gap of 270 (measured: 0, 45, 90)"), "{message}");
    // one plane through the normal of a specimen that is not isotropic fills nothing
    let plane = measured(&Fabric::default(), &grid(&[30.0, 60.0], &[30.0, 210.0]), None);
    let message = plane.unwrap_err().to_string();
    assert!(message.contains("found a gap of 180"), "{message}");
}

#[test]
fn quality_finds_noise_hole_limit_and_energy() {
    let metal = BrushedMetal { roughness_x: 0.2, ..Default::default() };
    for (relative, absolute) in [(0.0, 0.0), (0.02, 0.0), (0.05, 0.003)] {
        let gonio = Goniophotometer {
            relative_noise: relative,
            absolute_noise: absolute,
            ..Default::default()
        };
        let scan = gonio.scan(&metal, 40.0, 30.0);
        let incidence = Incidence::new(scan.wi, scan.wo, scan.values);
        let q = incidence.quality(0, Symmetry::None);
        assert!((q.relative_noise - relative).abs() < 0.15 * relative + 1e-3, "{q:?}");
        assert!((q.absolute_noise - absolute).abs() < 0.2 * absolute + 1e-3, "{q:?}");
        assert!((q.grazing_limit_degrees - 82.0).abs() < 0.01);
        assert_eq!(q.holes.len(), 1, "{:?}", q.holes);
        let hole = q.holes[0];
        let off = from_degrees(hole.theta_degrees, hole.phi_degrees).angle_between(incidence.wi);
        assert!(hole.retro_reflection && off.to_degrees() < 1.0, "{hole:?}");
        assert!((3.7..5.0).contains(&hole.radius_degrees), "{hole:?}");
        let truth = metal.albedo(incidence.wi);
        assert!((q.hemispherical[0] / truth - 1.0).abs() < 0.02, "{:?} {truth}", q.hemispherical);
        // the same distribution in a mirror has the same quality
        let mirrored = incidence.transformed(Image::MIRROR_Y).quality(0, Symmetry::None);
        assert!((mirrored.relative_noise - q.relative_noise).abs() < 1e-2 * relative + 1e-9);
        assert!((mirrored.hemispherical[0] / q.hemispherical[0] - 1.0).abs() < 2e-3);
    }
}
