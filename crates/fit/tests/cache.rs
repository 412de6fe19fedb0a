//! Fits that are stopped and go on: to the bit what they would have been.

mod support;

use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use bsdfkit_fit::Cache;
use bsdfkit_fit::interpolant::{Encoding, FitSettings, Interpolant};
use bsdfkit_measure::{Measurement, Symmetry};
use bsdfkit_represent::{Progress, Watch};
use bsdfkit_simulate::material::{FrittedGlass, RotatedMetal};
use support::{grid, instrument, measured};

fn settings(folder: &Path) -> FitSettings {
    let cache = Cache::open(folder, 1 << 28).unwrap();
    FitSettings { detail_cells: 24, cache: Some(Arc::new(cache)), ..FitSettings::default() }
}

fn bytes(m: &Measurement, settings: &FitSettings) -> Vec<u8> {
    let fitted = Interpolant::fit(std::slice::from_ref(m), settings, &Watch::default()).unwrap();
    fitted.to_bytes(Encoding::Plain).unwrap()
}

/// Cancelled after so many jobs, the last of which may still be finished.
fn stopped(m: &Measurement, settings: &FitSettings, after: usize) -> bool {
    let (cancel, jobs) = (AtomicBool::new(false), AtomicUsize::new(0));
    let count = |_: Progress| {
        if jobs.fetch_add(1, Ordering::Relaxed) + 1 >= after {
            cancel.store(true, Ordering::Relaxed);
        }
    };
    let watch = Watch { progress: Some(&count), cancel: Some(&cancel) };
    Interpolant::fit(std::slice::from_ref(m), settings, &watch).is_err()
}

#[test]
fn what_was_stopped_anywhere_goes_on_to_the_same_bits() {
    let angles = grid(&[0.0, 20.0, 40.0, 60.0], &[0.0, 90.0, 180.0, 270.0]);
    let metal = measured(&instrument(), &RotatedMetal::default(), Symmetry::None, &angles);
    let plain = FitSettings { detail_cells: 24, ..FitSettings::default() };
    let expected = bytes(&metal, &plain);
    for after in [1, 5, 12] {
        let folder = tempfile::tempdir().unwrap();
        assert!(stopped(&metal, &settings(folder.path()), after), "{after}");
        let stages = fs::read_dir(folder.path()).unwrap().count();
        assert!(stages > 0, "{after}: nothing was kept");
        assert!(bytes(&metal, &settings(folder.path())) == expected, "{after}");
        // And once more from what is whole: nothing new is kept.
        let all = fs::read_dir(folder.path()).unwrap().count();
        assert!(bytes(&metal, &settings(folder.path())) == expected, "{after}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), all);
        assert!(all > stages);
    }
}

#[test]
fn other_points_and_other_settings_are_other_stages() {
    let folder = tempfile::tempdir().unwrap();
    let angles = grid(&[0.0, 30.0, 60.0], &[0.0]);
    let glass = measured(&instrument(), &FrittedGlass::default(), Symmetry::Isotropic, &angles);
    let mut other = glass.clone();
    other.incidences[1].values[77] *= 1.5;
    let kept = settings(folder.path());
    let finer = FitSettings { detail_cells: 48, ..kept.clone() };
    for (m, settings) in [(&glass, &kept), (&other, &kept), (&glass, &finer)] {
        let alone = FitSettings { cache: None, ..settings.clone() };
        assert!(bytes(m, settings) == bytes(m, &alone));
    }
}

#[test]
fn damaged_stages_are_computed_again() {
    let folder = tempfile::tempdir().unwrap();
    let angles = grid(&[0.0, 30.0, 60.0], &[0.0]);
    let glass = measured(&instrument(), &FrittedGlass::default(), Symmetry::Isotropic, &angles);
    let kept = settings(folder.path());
    let expected = bytes(&glass, &kept);
    for (n, file) in fs::read_dir(folder.path()).unwrap().enumerate() {
        let path = file.unwrap().path();
        let mut content = fs::read(&path).unwrap();
        match n % 3 {
            0 => content.truncate(content.len() / 2),
            1 => {
                let last = content.len() - 1;
                content[last] ^= 1;
            }
            _ => content.clear(),
        }
        fs::write(&path, content).unwrap();
    }
    assert!(bytes(&glass, &kept) == expected);
}

/// Whatever cannot be written, the fit is what it would have been.
#[test]
fn a_cache_without_room_changes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let angles = grid(&[0.0, 30.0, 60.0], &[0.0]);
    let glass = measured(&instrument(), &FrittedGlass::default(), Symmetry::Isotropic, &angles);
    let plain = FitSettings { detail_cells: 24, ..FitSettings::default() };
    let expected = bytes(&glass, &plain);
    for most in [0, 3000] {
        let cache = Arc::new(Cache::open(folder.path(), most).unwrap());
        let tight = FitSettings { cache: Some(cache), ..plain.clone() };
        assert!(bytes(&glass, &tight) == expected);
        let held: u64 = fs::read_dir(folder.path())
            .unwrap()
            .map(|f| f.unwrap().metadata().unwrap().len())
            .sum();
        assert!(held <= most, "{held}");
    }
}
