//! The interpolant's container: round trips, and files broken in every way.

mod support;

use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

use bsdfkit::{DVec3, ErrorClass, Side};
use bsdfkit_fit::interpolant::{Component, Encoding, FitSettings, Frame, Interpolant, Part};
use bsdfkit_measure::{Colorimetry, Measurement, Mirror, Symmetry};
use bsdfkit_represent::Source;
use bsdfkit_simulate::Material;
use bsdfkit_simulate::material::{BrushedMetal, Fabric, FrittedGlass, RotatedMetal};
use bsdfkit_sphere::direction::from_degrees;
use proptest::prelude::*;
use support::{coarse, direction, fit, given, grid, measured};

/// A lattice of details small enough that hundreds of files can be opened.
fn small(frame: Frame) -> FitSettings {
    FitSettings { detail_cells: 16, ..given(frame) }
}

fn part(m: &Measurement, frame: Frame) -> Part {
    Part::Transported(Arc::new(fit(m, &small(frame))))
}

fn interpolant(components: Vec<Part>) -> Interpolant {
    Interpolant { name: Some("specimen \"é\"".to_owned()), components, ..Interpolant::default() }
}

/// Values at many pairs of directions, the part's own sides.
fn values(part: &Part) -> Vec<f32> {
    values_to(85.0, part)
}

/// The same, of incident directions up to a polar angle.
fn values_to(theta_degrees: f64, part: &Part) -> Vec<f32> {
    let mut all = Vec::new();
    for k in 0..60 {
        let side = |w: DVec3, s: Side| DVec3::new(w.x, w.y, w.z * s.sign());
        let wi = side(direction(k, theta_degrees), part.incident());
        let wo: Vec<DVec3> =
            (0..20).map(|j| side(direction(100 + 20 * k + j, 88.0), part.scattered())).collect();
        let mut out = vec![0.0; wo.len() * part.channels()];
        part.slice(wi).eval(&wo, &mut out);
        all.extend(out);
    }
    all
}

fn component(part: &Part) -> &Component {
    match part {
        Part::Transported(c) => c,
        Part::Sir(_) | Part::Dense(_) => panic!("expected a fitted component"),
    }
}

#[test]
fn saved_and_opened_values_agree() {
    let (metal, fabric) = (BrushedMetal::default(), Fabric::default());
    let (rotated, glass) = (RotatedMetal::default(), FrittedGlass::default());
    let sets: [(&dyn Material, Symmetry, &[f64]); 5] = [
        (&metal, Symmetry::Quadrilateral, &[0.0, 45.0, 90.0]),
        (&fabric, Symmetry::Bilateral(Mirror::Y), &[0.0, 60.0, 120.0, 180.0]),
        (&rotated, Symmetry::Rotational180, &[0.0, 60.0, 120.0]),
        (&rotated, Symmetry::None, &[0.0, 90.0, 180.0, 270.0]),
        (&glass, Symmetry::Isotropic, &[0.0]),
    ];
    let folder = tempfile::tempdir().unwrap();
    for (material, symmetry, phis) in sets {
        let m = measured(&coarse(), material, symmetry, &grid(&[0.0, 30.0, 55.0], phis));
        let before = interpolant(vec![part(&m, Frame::Half)]);
        let path = folder.path().join(format!("{symmetry}.safetensors"));
        before.save(&path, Encoding::Plain).unwrap();
        let after = Interpolant::open(&path).unwrap();
        assert_eq!(after.name, before.name);
        let (a, b) = (component(&before.components[0]), component(&after.components[0]));
        assert_eq!(
            (a.incident(), a.scattered(), a.symmetry()),
            (b.incident(), b.scattered(), b.symmetry())
        );
        assert_eq!(a.motion(), b.motion());
        assert!((a.fitted().epsilon / b.fitted().epsilon - 1.0).abs() < 1e-14);
        for (x, y) in a.incidences().iter().zip(b.incidences()) {
            assert_eq!((x.wi, &x.lobes, x.points), (y.wi, &y.lobes, y.points));
            assert_eq!((x.fit_error, x.limit), (y.fit_error, y.limit));
        }
        let (old, new) = (values(&before.components[0]), values(&after.components[0]));
        for (x, y) in old.iter().zip(&new) {
            assert!((x - y).abs() <= 1e-3 * x + 1e-5, "{symmetry}: {x} {y}");
        }
    }
}

/// f and, in colour, every channel, within 2 %, three times that past the rim; all else as it was.
#[test]
fn compact_files_keep_values_to_two_percent() {
    let angles = grid(&[0.0, 30.0, 55.0], &[0.0, 60.0, 120.0, 180.0]);
    let fabric = measured(&coarse(), &Fabric::default(), Symmetry::Bilateral(Mirror::Y), &angles);
    let mut glass = measured(
        &coarse(),
        &FrittedGlass::default(),
        Symmetry::Isotropic,
        &grid(&[0.0, 40.0], &[0.0]),
    );
    glass.colorimetry = Colorimetry::Xyz;
    for i in &mut glass.incidences {
        i.values = i.values.iter().flat_map(|v| [0.9 * v, *v, 1.2 * v]).collect();
    }
    let settings = given(Frame::Half);
    let both = [&fabric, &glass].map(|m| Part::Transported(Arc::new(fit(m, &settings))));
    let before = interpolant(both.into());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("compact.safetensors");
    before.save(&path, Encoding::Compact).unwrap();
    let bytes = std::fs::metadata(&path).unwrap().len() as usize;
    assert!(3 * bytes < before.to_bytes(Encoding::Plain).unwrap().len(), "{bytes}");
    let after = Interpolant::open(&path).unwrap();
    for (a, b) in before.components.iter().zip(&after.components) {
        assert_eq!(
            (a.incident(), a.scattered(), a.channels()),
            (b.incident(), b.scattered(), b.channels())
        );
        for (x, y) in component(a).incidences().iter().zip(component(b).incidences()) {
            assert_eq!((x.wi, &x.lobes, x.points), (y.wi, &y.lobes, y.points));
        }
        // Past the rim, f is the square of one value over another. (Straight edges dip to 35 degrees.)
        for (theta, within) in [(35.0, 0.0205), (85.0, 0.0615)] {
            let (old, new) = (values_to(theta, a), values_to(theta, b));
            let mut wrong = 0.0;
            for (x, y) in old.iter().zip(&new) {
                // f + ε is scaled, then ε taken away.
                let epsilon = component(a).fitted().epsilon as f32;
                assert!((x - y).abs() <= within * (x + 2.0 * epsilon), "{theta} {x} {y}");
                wrong += (x - y).abs();
            }
            let share = wrong / old.iter().sum::<f32>();
            assert!(share > 0.0 && share < 0.6 * within, "{share}");
        }
    }
}

/// Transmission beside reflection, every frame, three channels.
#[test]
fn parts_frames_and_channels_come_back() {
    let angles = grid(&[0.0, 40.0], &[0.0, 90.0]);
    let metal = measured(&coarse(), &BrushedMetal::default(), Symmetry::Quadrilateral, &angles);
    let mut glass = measured(&coarse(), &FrittedGlass::default(), Symmetry::Quadrilateral, &angles);
    glass.colorimetry = Colorimetry::Xyz;
    for i in &mut glass.incidences {
        i.values = i.values.iter().flat_map(|v| [0.9 * v, *v, 1.2 * v]).collect();
    }
    for frame in [Frame::Fixed, Frame::Shift, Frame::Turned, Frame::Refracted { index: 1.37 }] {
        let before = interpolant(vec![part(&metal, Frame::Half), part(&glass, frame)]);
        let after = Interpolant::from_bytes(&before.to_bytes(Encoding::Plain).unwrap()).unwrap();
        let second = component(&after.components[1]);
        assert_eq!((second.motion().frame, second.scattered()), (frame, Side::Back));
        assert_eq!((after.components[0].channels(), after.components[1].channels()), (1, 3));
        for (a, b) in before.components.iter().zip(&after.components) {
            for (x, y) in values(a).iter().zip(&values(b)) {
                assert!((x - y).abs() <= 1e-3 * x + 1e-5, "{frame:?}: {x} {y}");
            }
        }
        // Luminance first, then X and Z, in the measured proportions.
        let (wi, wo) = (from_degrees(20.0, 30.0), from_degrees(150.0, 200.0));
        let mut xyz = [0.0; 3];
        after.components[1].slice(wi).eval(&[wo], &mut xyz);
        assert!((xyz[1] / xyz[0] - 0.9).abs() < 0.02 && (xyz[2] / xyz[0] - 1.2).abs() < 0.02);
    }
}

#[test]
fn radiance_files_are_kept_as_they_were() {
    let golden = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../tests/golden/sir");
    for name in ["diel", "frit", "fabric"] {
        let path = golden.join(format!("{name}.sir"));
        let before = Interpolant::read_sir(&[&path]).unwrap();
        let after = Interpolant::from_bytes(&before.to_bytes(Encoding::Plain).unwrap()).unwrap();
        let Part::Sir(kept) = &after.components[0] else { panic!("expected a SIR part") };
        assert!(kept.bytes[..] == std::fs::read(&path).unwrap());
        assert_eq!(after.name, before.name);
        assert_eq!(values(&before.components[0]), values(&after.components[0]), "{name}");
        let twice = Interpolant::read_sir(&[&path, &path]).unwrap_err();
        assert_eq!(twice.class(), ErrorClass::Argument);
        assert!(twice.to_string().contains("expected one file for each pair of sides"), "{twice}");
    }
}

/// A container with a fitted and a Radiance part, plain and compact.
fn containers() -> &'static [Vec<u8>; 2] {
    static BYTES: OnceLock<[Vec<u8>; 2]> = OnceLock::new();
    BYTES.get_or_init(|| {
        let golden = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../tests/golden/sir");
        let mut all = Interpolant::read_sir(&[golden.join("frit.sir")]).unwrap();
        let angles = grid(&[0.0, 40.0], &[0.0, 90.0]);
        let m = measured(&coarse(), &BrushedMetal::default(), Symmetry::Quadrilateral, &angles);
        let settings = FitSettings { detail_cells: 8, ..given(Frame::Half) };
        all.components.insert(0, Part::Transported(Arc::new(fit(&m, &settings))));
        [Encoding::Plain, Encoding::Compact].map(|encoding| all.to_bytes(encoding).unwrap())
    })
}

/// Opens what may be broken: an error of class format, or something that answers sensibly.
fn survives(bytes: &[u8]) -> Result<(), TestCaseError> {
    match Interpolant::from_bytes(bytes) {
        Err(e) => prop_assert!(matches!(e.class(), ErrorClass::Format | ErrorClass::Limit), "{e}"),
        Ok(opened) => {
            for part in &opened.components {
                for (wi, wo) in [(20.0, 40.0), (0.0, 0.0), (89.0, 70.0)] {
                    let wi = from_degrees(wi, 10.0);
                    let wo = from_degrees(wo, 200.0);
                    let mut out = vec![0.0; part.channels()];
                    part.slice(wi).eval(&[wo], &mut out);
                    prop_assert!(out.iter().all(|f| *f >= 0.0), "{out:?}");
                }
            }
        }
    }
    Ok(())
}

/// Length of the JSON header and the 8 bytes that tell it.
fn header(container: &[u8]) -> usize {
    8 + u64::from_le_bytes(container[..8].try_into().unwrap()) as usize
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(100) })]

    #[test]
    fn truncated_files_are_refused(share in 0.0..1.0f64) {
        for container in containers() {
            let length = (share * container.len() as f64) as usize;
            let error = Interpolant::from_bytes(&container[..length]).unwrap_err();
            prop_assert_eq!(error.class(), ErrorClass::Format);
        }
    }

    #[test]
    fn changed_headers_do_no_harm(changes in prop::collection::vec((0.0..1.0f64, any::<u8>()), 1..4)) {
        for container in containers() {
            let mut bytes = container.clone();
            for &(share, byte) in &changes {
                bytes[(share * header(container) as f64) as usize] = byte;
            }
            survives(&bytes)?;
        }
    }

    #[test]
    fn changed_digits_do_no_harm(share in 0.0..1.0f64, digit in b'0'..=b'9') {
        for container in containers() {
            let mut bytes = container.clone();
            let digits: Vec<usize> = (8..header(container)).filter(|&k| bytes[k].is_ascii_digit()).collect();
            bytes[digits[(share * digits.len() as f64) as usize]] = digit;
            survives(&bytes)?;
        }
    }

    #[test]
    fn changed_numbers_do_no_harm(changes in prop::collection::vec((0.0..1.0f64, any::<u8>()), 1..12)) {
        for container in containers() {
            let mut bytes = container.clone();
            let (start, length) = (header(container), container.len() - header(container));
            for &(share, byte) in &changes {
                bytes[start + (share * length as f64) as usize] = byte;
            }
            survives(&bytes)?;
        }
    }
}

/// A container with other numbers in an array of the first component, from the number `at` on.
fn with_numbers(container: &[u8], array: &str, at: usize, numbers: &[f64]) -> Vec<u8> {
    let tensors = safetensors::SafeTensors::deserialize(container).unwrap();
    let data = tensors.tensor(&format!("component.0.{array}")).unwrap().data();
    let start = data.as_ptr() as usize - container.as_ptr() as usize + 8 * at;
    let mut changed = container.to_vec();
    for (place, x) in changed[start..].chunks_exact_mut(8).zip(numbers) {
        place.copy_from_slice(&x.to_le_bytes());
    }
    changed
}

/// Variances whose determinant is no number any more: once read, written again as NaN.
#[test]
fn numbers_that_no_function_has_are_refused() {
    for container in containers() {
        for (array, at) in [("lobes", 3), ("figures", 0), ("energy", 0), ("incident", 0)] {
            let broken = with_numbers(container, array, at, &[1e200, 0.0, 1e200]);
            let error = Interpolant::from_bytes(&broken).unwrap_err();
            let expected = format!("component.0.{array}: expected finite numbers of at most 1e30");
            assert!(error.to_string().contains(&expected), "{error}");
        }
        let key = b"epsilon\\\":";
        let at = container.windows(key.len()).position(|w| w == key).unwrap() + key.len();
        let mut negative = container.clone();
        negative[at..at + 2].copy_from_slice(b"-9");
        let error = Interpolant::from_bytes(&negative).unwrap_err();
        assert!(
            error.to_string().contains("component.0.epsilon: expected 1e-30 to 1e30"),
            "{error}"
        );
    }
}

/// Of values that sums make infinite a density would be no number.
#[test]
fn largest_numbers_still_have_a_density() {
    for container in containers() {
        let bright = with_numbers(container, "lobes", 0, &[1e30, 0.1, 0.1, 1e-4, 0.0, 1e-4]);
        let opened = Interpolant::from_bytes(&bright).unwrap().bsdf();
        let (wi, wo) = (from_degrees(20.0, 10.0), from_degrees(20.0, 190.0));
        let (f, pdf) = opened.eval_pdf(wi, wo, bsdfkit::Components::ALL);
        let total = opened.directional_hemispherical(wi, bsdfkit::Components::ALL);
        assert!(f <= 1.001e30 && pdf >= 0.0 && total.is_finite(), "{f} {pdf} {total}");
    }
}

#[test]
fn wrong_files_say_what_they_are() {
    let message = |bytes: &[u8]| Interpolant::from_bytes(bytes).unwrap_err().to_string();
    assert!(message(b"").contains("not a safetensors file"));
    assert!(message(b"<html><body>404</body></html>").contains("not a safetensors file"));
    let changed = |file: usize, from: &str, to: &str| {
        assert_eq!(from.len(), to.len());
        let mut text = containers()[file].clone();
        let at = (0..text.len()).find(|&k| text[k..].starts_with(from.as_bytes())).unwrap();
        text[at..at + to.len()].copy_from_slice(to.as_bytes());
        message(&text)
    };
    let other = |from: &str, to: &str| changed(0, from, to);
    let version = other("version\\\":7", "version\\\":9");
    assert!(version.contains("expected kind \"interpolant\" version 7"), "{version}");
    let onward = other("onward\\\":0.0", "onward\\\":1e9");
    assert!(onward.contains("motion.onward: expected 0 to 1"), "{onward}");
    let array = other("component.0.lobes", "component.0.globe");
    assert!(array.contains("component.0.lobes"), "{array}");
    for array in ["component.0.detail_step", "component.0.detail_kept", "component.0.detail_tile"] {
        let gone = changed(1, array, &array.to_uppercase());
        assert!(gone.contains(array), "{gone}");
    }
    // A lattice that a small file only claims to have.
    let wide = changed(1, "lattice\\\":[1,15]", "lattice\\\":[1,99]");
    assert!(wide.contains("component.0.detail_step: expected"), "{wide}");
    let missing = Interpolant::open(&PathBuf::from("no such folder/x.safetensors")).unwrap_err();
    assert_eq!(missing.class(), ErrorClass::Io);
}
