//! Files of others beside a second reader of them, short, slow and obvious.

#![allow(dead_code)] // each test program uses its part

use std::path::{Path, PathBuf};

use bsdfkit::DVec3;
use bsdfkit_measure::{Measurement, ReadOptions, SymmetryKind, read};

/// A real file, found through the environment variable BSDFKIT_DATA.
pub(crate) fn data(file: &str) -> Option<PathBuf> {
    let Some(root) = std::env::var_os("BSDFKIT_DATA") else {
        println!("BSDFKIT_DATA is not set: {file} not tested");
        return None;
    };
    Some(PathBuf::from(root).join(file))
}

/// All components as they are written: nothing is folded.
pub(crate) fn plain(paths: &[PathBuf]) -> Vec<Measurement> {
    let symmetry = Some(SymmetryKind::None);
    let options = ReadOptions { symmetry, incomplete: true, ..ReadOptions::default() };
    read(paths, &options).unwrap_or_else(|e| panic!("{e}"))
}

/// The only component of one file.
pub(crate) fn only(path: &Path) -> Measurement {
    let mut components = plain(&[path.to_owned()]);
    assert_eq!(components.len(), 1);
    components.remove(0)
}

/// What a second reader found: incident and scattered direction, values.
pub(crate) type Row = (DVec3, DVec3, Vec<f64>);

/// Every point of `m` is a row and every row a point: as many at each incidence, with the same sums, and 1000 values alike.
pub(crate) fn expect_rows(m: &Measurement, rows: &[Row]) {
    assert_eq!(m.points(), rows.len(), "points");
    for incidence in &m.incidences {
        let own: Vec<&Row> = rows.iter().filter(|r| r.0.dot(incidence.wi) > 1.0 - 1e-9).collect();
        assert_eq!(own.len(), incidence.wo.len(), "points at {}", incidence.wi);
        // Spectra are led by a guide that the file does not hold.
        let bands = rows[0].2.len();
        let guide = incidence.channels() - bands;
        for channel in 0..bands {
            let ours: f64 = incidence.channel(guide + channel).sum();
            let theirs: f64 = own.iter().map(|r| r.2[channel]).sum();
            assert!((ours - theirs).abs() <= 1e-6 * theirs.abs(), "{ours} {theirs}");
        }
    }
    let step = rows.len().div_ceil(1000);
    for (wi, wo, values) in rows.iter().step_by(step) {
        let same = |i: &&bsdfkit_measure::Incidence| i.wi.dot(*wi) > 1.0 - 1e-9;
        let incidence = m.incidences.iter().find(same).unwrap_or_else(|| panic!("no {wi}"));
        let found = (0..incidence.wo.len()).filter(|&k| (incidence.wo.at(k) - *wo).length() < 2e-6);
        let agrees = |k: usize| {
            let point = incidence.point(k);
            let own = point[point.len() - values.len()..].iter().zip(values);
            own.into_iter().all(|(a, b)| (f64::from(*a) - b).abs() <= 1e-6 * b.abs())
        };
        assert!(found.into_iter().any(agrees), "{wi} {wo}: {values:?}");
    }
}

pub(crate) fn numbers(line: &str) -> Vec<f64> {
    line.split([' ', '\t', ',']).filter(|w| !w.is_empty()).map(|w| w.parse().unwrap()).collect()
}

pub(crate) fn radians(theta: f64, phi: f64) -> DVec3 {
    DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
}

/// Light that goes on to `z`, tilted by θ in the plane at azimuth φ + 180; azimuth 0 is back toward the normal.
pub(crate) fn about_specular(theta: f64, phi: f64, radial: f64, azimuth: f64) -> DVec3 {
    let (r, a) = (radial.to_radians(), azimuth.to_radians());
    let local = DVec3::new(-r.sin() * a.cos(), -r.sin() * a.sin(), r.cos());
    let (s, c) = theta.to_radians().sin_cos();
    let tilted = DVec3::new(c * local.x + s * local.z, local.y, c * local.z - s * local.x);
    let (s, c) = (phi + 180.0).to_radians().sin_cos();
    DVec3::new(c * tilted.x - s * tilted.y, s * tilted.x + c * tilted.y, tilted.z)
}
