//! Real measurements, found through the environment variable BSDFKIT_DATA.

use std::path::PathBuf;

use bsdfkit_measure::{Measurement, Quality, ReadOptions, Side, Symmetry, SymmetryKind, read};

/// The files of `folder` whose names begin with `prefix`; `None`, said plainly, without the data.
fn files(folder: &str, prefix: &str) -> Option<Vec<PathBuf>> {
    let Some(root) = std::env::var_os("BSDFKIT_DATA") else {
        println!("BSDFKIT_DATA is not set: {folder} not tested");
        return None;
    };
    let folder = PathBuf::from(root).join(folder);
    let mut files: Vec<PathBuf> = folder
        .read_dir()
        .unwrap_or_else(|e| panic!("{}: {e}", folder.display()))
        .map(|e| e.unwrap().path())
        .filter(|p| p.file_name().unwrap().to_string_lossy().starts_with(prefix))
        .collect();
    files.sort();
    Some(files)
}

fn one(files: &[PathBuf]) -> (Measurement, Quality) {
    let mut components = read(files, &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(components.len(), 1);
    let measurement = components.remove(0);
    let quality = measurement.quality();
    (measurement, quality)
}

#[test]
fn engineered_diffuser() {
    let Some(files) = files("eds10_mountain", "eds10") else { return };
    let (m, quality) = one(&files);
    assert_eq!((m.incident, m.scattered), (Side::Front, Side::Back));
    assert_eq!(m.symmetry, Symmetry::Quadrilateral);
    assert_eq!((m.incidences.len(), m.points()), (7, 214_207));
    assert!(m.sample_name.as_deref().unwrap().starts_with("EDS10"));
    for incidence in &quality.incidences {
        let total = incidence.hemispherical[0];
        assert!((0.8..0.95).contains(&total), "{total}");
        assert_eq!(incidence.grazing_limit_degrees.round(), 85.0);
        // 1 to 2 % at the plateau, more at its rim where a step of the scan shows structure
        assert!((0.005..0.12).contains(&incidence.relative_noise), "{incidence:?}");
    }
}

#[test]
fn car_paint() {
    let Some(files) = files("cornell_mountain", "garnet") else { return };
    let (m, _) = one(&files);
    assert_eq!((m.incident, m.scattered), (Side::Front, Side::Front));
    assert_eq!((m.symmetry, m.incidences.len()), (Symmetry::Isotropic, 8));
    // scanned beside the plane of incidence on one side only
    assert!(m.notes.iter().any(|n| n.starts_with("8 incidences scanned on one side")));
    let first = &m.incidences[0];
    let beside = |sign: f64| first.wo.iter().filter(|w| sign * w.y > 1e-3).count();
    assert!(beside(1.0) == beside(-1.0) && beside(1.0) > 100);
}

#[test]
fn coatings() {
    let Some(files) = files("rt300s_mountain", "") else { return };
    let of = |prefix: &str| -> Vec<PathBuf> {
        let name = |p: &PathBuf| p.file_name().unwrap().to_string_lossy().starts_with(prefix);
        files.iter().filter(|p| name(p)).cloned().collect()
    };
    assert_eq!(one(&of("EC1")).0.symmetry, Symmetry::Isotropic);
    // three rotations of the stage show one distribution, askew to its plane of incidence
    let (coating, quality) = one(&of("NiTE"));
    assert_eq!(
        (coating.symmetry, coating.incidences.len()),
        (Symmetry::Isotropic, 4),
        "{:?}",
        quality.notes
    );
    let (sensor, _) = one(&of("IMX455"));
    assert_eq!((sensor.symmetry, sensor.incidences.len()), (Symmetry::Quadrilateral, 20));
    let given = ReadOptions { symmetry: Some(SymmetryKind::Isotropic), ..Default::default() };
    let message = read(&of("IMX455"), &given).unwrap_err().to_string();
    assert!(message.contains("symmetry isotropic: expected the distributions at"), "{message}");
}
