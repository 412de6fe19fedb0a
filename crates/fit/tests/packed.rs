//! Measured points packed and read again are the same points.

use bsdfkit_fit::packed;
use bsdfkit_measure::{Colorimetry, DVec3, Incidence, Measurement, Mirror, Side, Symmetry};

fn measured() -> Vec<Measurement> {
    let of = |incident: Side, scattered: Side, symmetry, colorimetry: Colorimetry| {
        let channels = colorimetry.channels();
        let incidence = |k: usize| {
            let wi = DVec3::new(0.1 * k as f64, 0.2, incident.sign()).normalize();
            let wo = (0..=k).map(|n| DVec3::new(0.3, 0.1 * n as f64, scattered.sign()).normalize());
            Incidence::new(
                wi,
                wo.collect::<Vec<_>>(),
                (0..(k + 1) * channels).map(|v| v as f64 - 1.0),
            )
        };
        Measurement {
            incident,
            scattered,
            colorimetry,
            symmetry,
            incidences: (0..4).map(incidence).collect(),
            sample_name: Some("cloth <12>".to_owned()),
            notes: Vec::new(),
        }
    };
    let (front, back) = (Side::Front, Side::Back);
    vec![
        of(front, front, Symmetry::Bilateral(Mirror::Y), Colorimetry::Luminance),
        of(front, back, Symmetry::Isotropic, Colorimetry::Xyz),
    ]
}

#[test]
fn points_come_back() {
    let before = measured();
    let bytes = packed::to_bytes(&before).unwrap();
    assert!(packed::holds(&bytes));
    let after = packed::from_bytes(&bytes).unwrap();
    assert_eq!(after.len(), 2);
    for (a, b) in before.iter().zip(&after) {
        assert_eq!((a.incident, a.scattered, a.symmetry), (b.incident, b.scattered, b.symmetry));
        assert_eq!(b.sample_name.as_deref(), Some("cloth <12>"));
        assert_eq!(a.incidences.len(), b.incidences.len());
        let channel = a.colorimetry.luminance_channel();
        for (a, b) in a.incidences.iter().zip(&b.incidences) {
            assert_eq!(a.wi, b.wi);
            assert_eq!(a.points(channel).collect::<Vec<_>>(), b.points(0).collect::<Vec<_>>());
        }
    }
}

#[test]
fn damage_is_an_error_that_names_the_array() {
    let good = packed::to_bytes(&measured()).unwrap();
    let message = |bytes: &[u8]| packed::from_bytes(bytes).unwrap_err().to_string();
    for length in 0..good.len() {
        message(&good[..length]);
    }
    assert!(message(b"rubbish").contains("safetensors"));
    let text = |from: &str, to: &str| {
        assert_eq!(from.len(), to.len());
        let mut bytes = good.clone();
        let at = bytes.windows(from.len()).position(|w| w == from.as_bytes()).unwrap();
        bytes[at..at + to.len()].copy_from_slice(to.as_bytes());
        message(&bytes)
    };
    assert!(text("measurement", "measuremend").contains("expected kind"));
    assert!(text("isotropic", "isotropes").contains("component.1.symmetry"));
    assert!(text("component.1.values", "component.1.walues").contains("component.1.values"));
    // Another number of points than there are.
    let (_, declared) = safetensors::SafeTensors::read_metadata(&good).unwrap();
    let header = u64::from_le_bytes(good[..8].try_into().unwrap()) as usize + 8;
    let place = header + declared.info("component.0.points").unwrap().data_offsets.0;
    let mut bytes = good.clone();
    bytes[place] += 1;
    assert!(message(&bytes).contains("component.0.scattered: expected 11 points"));
}
