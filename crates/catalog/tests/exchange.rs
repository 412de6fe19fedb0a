//! What goes to formats of others and comes back.

use bsdfkit::spectrum::Bands;
use bsdfkit::{Bsdf, DVec3, Lambertian, Metadata, Side, Xyz};
use bsdfkit_catalog::Record;
use bsdfkit_catalog::exchange::{bed, bird};
use bsdfkit_measure::{
    Colorimetry, Incidence, Measurement, ReadOptions, Symmetry, SymmetryKind, read,
};
use bsdfkit_sphere::direction::from_degrees;
use serde_json::Value;

/// Reflection of the front, of `channels` values a point.
fn measured(colorimetry: Colorimetry) -> Measurement {
    let channels = colorimetry.channels();
    let directions: Vec<DVec3> =
        (0..40).map(|k| from_degrees(2.0 * f64::from(k), 37.0 * f64::from(k))).collect();
    let incidence = |theta: f64| {
        let values = (0..directions.len() * channels).map(|k| 0.1 + 0.01 * k as f64 + theta);
        Incidence::new(from_degrees(theta, 30.0), directions.iter().copied(), values)
    };
    Measurement {
        incident: Side::Front,
        scattered: Side::Front,
        colorimetry,
        symmetry: Symmetry::None,
        incidences: [0.0, 25.0, 50.0].map(incidence).to_vec(),
        sample_name: Some("Felt".into()),
        notes: Vec::new(),
    }
}

fn record() -> Record {
    Record {
        name: "Felt 3".into(),
        maker: "Acme".into(),
        class: "fabric".into(),
        instrument: "gonioreflectometer".into(),
        date: "2026-11-30".into(),
        licence: "CC-BY-4.0".into(),
        doi: "10.5281/zenodo.1".into(),
        notes: "Along x.".into(),
    }
}

#[test]
fn points_and_record_come_back_from_bird() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("felt.brdf");
    let bands = Bands::new(vec![450.0, 550.0, 650.0]).unwrap();
    for colorimetry in [Colorimetry::Luminance, Colorimetry::Spectral(bands)] {
        let measured = measured(colorimetry);
        let mut bytes = Vec::new();
        bird::write(std::slice::from_ref(&measured), &record(), &mut bytes).unwrap();
        std::fs::write(&path, &bytes).unwrap();
        let symmetry = Some(SymmetryKind::None);
        let options = ReadOptions { incomplete: true, symmetry, ..ReadOptions::default() };
        let back = read(std::slice::from_ref(&path), &options).unwrap();
        assert_eq!((back.len(), &back[0].colorimetry), (1, &measured.colorimetry));
        assert_eq!(back[0].sample_name.as_deref(), Some("Felt 3"));
        assert_eq!(back[0].incidences.len(), 3);
        for (a, b) in measured.incidences.iter().zip(&back[0].incidences) {
            assert!(a.wi.distance(b.wi) < 1e-6);
            // The guide of a spectrum is computed anew.
            let first = usize::from(a.channels() > 1);
            for k in 0..a.wo.len() {
                assert!(a.wo.at(k).distance(b.wo.at(k)) < 1e-6, "{k}");
                assert_eq!(a.point(k)[first..], b.point(k)[first..]);
            }
        }
        let text = String::from_utf8(bytes).unwrap();
        assert_eq!(Record::from_json(&text).unwrap(), record());
    }
}

/// The example of the format's authors, shortened: two wavelengths, s- and p-polarised light.
const EXAMPLE: &str = r#"{"metadata": {"type": "BRDF", "timestamp": "2022-01-14T12:00:00+02",
 "id": "https://example.org/example.brdf", "description": "An example.", "license": {"type": "BY-SA", "rights_holder": "Aalto"},
 "provenance": {"organization": "Aalto"}, "instrumentation": {"name": "gonioreflectometer"},
 "sample": {"name": "SRT1", "type": "diffuse", "manufacturer": "Labsphere"}},
 "data": {"wavelength_i": {"unit": "nm", "values": [550, 550, 650, 650]},
 "polarization_i": {"notation": "inStokes", "values": [[1, 1, 0, 0], [1, -1, 0, 0], [1, 1, 0, 0], [1, -1, 0, 0]]},
 "theta_i": {"unit": "°", "values": [0, 0, 0, 0]}, "phi_i": {"unit": "°", "values": [0, 0, 0, 0]},
 "theta_r": {"unit": "°", "values": [10, 10, 10, 10]}, "phi_r": {"unit": "rad", "values": [1, 1, 1, 1]},
 "BRDF": {"unit": "sr^-1", "values": [0.254, 0.264, 0.267, 0.273]}}}"#;

#[test]
fn polarised_light_is_averaged_and_faults_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("example.brdf");
    let options = ReadOptions { incomplete: true, ..ReadOptions::default() };
    let of = |text: &str| {
        std::fs::write(&path, text).unwrap();
        read(std::slice::from_ref(&path), &options)
    };
    let measured = of(EXAMPLE).unwrap();
    let point = measured[0].incidences[0].point(0);
    assert!((point[1] - 0.259).abs() < 1e-6 && (point[2] - 0.270).abs() < 1e-6, "{point:?}");
    let wo = measured[0].incidences[0].wo.at(0);
    assert!(wo.distance(from_degrees(10.0, 1.0f64.to_degrees())) < 1e-6);
    for (from, to, words) in [
        ("\"sr^-1\"", "\"lx\"", "BRDF: expected one of the units"),
        ("[10, 10, 10, 10]", "[10, 10, 10]", "theta_r: expected 4 values as of BRDF, found 3"),
        ("[10, 10, 10, 10]", "[10, 10, 10, 20]", "expected a value at every wavelength"),
        ("[1, 1, 0, 0],", "[1, 0, 0, 1],", "polarization_i: expected light that is not"),
        ("\"BRDF\": {\"unit\"", "\"position_x\": {}, \"BRDF\": {\"unit\"", "found \"position_x\""),
        ("0.264", "1e31", "BRDF: value 2: expected f of at most"),
        ("0.273]}}}", "0.273]}}", "JSON: "),
    ] {
        let text = EXAMPLE.replacen(from, to, 1);
        assert_ne!(text, EXAMPLE, "{from}");
        let error = of(&text).err().map(|e| e.to_string()).unwrap_or_default();
        assert!(error.contains(words), "{words}: {error}");
    }
    let record = Record::from_json(EXAMPLE).unwrap();
    assert_eq!((&*record.name, &*record.maker, &*record.date), ("SRT1", "Labsphere", "2022-01-14"));
    // BY-SA alone is no licence of SPDX's list.
    assert_eq!((&*record.licence, &*record.notes), ("", "An example. Licence: BY-SA."));
}

#[test]
fn totals_of_the_front_go_to_bed() {
    let parts = Lambertian {
        reflection_front: Xyz::grey(0.3),
        transmission_front: Xyz::grey(0.2),
        ..Lambertian::default()
    };
    let mut bytes = Vec::new();
    bed::write(&Bsdf::new(Metadata::default(), Vec::new(), parts), &mut bytes).unwrap();
    let file: Value = serde_json::from_slice(&bytes).unwrap();
    let points = file["data"][0]["dataPoints"].as_array().unwrap();
    assert_eq!(points.len(), 9);
    for point in points {
        assert_eq!(point["results"]["reflectance"], 0.3);
        assert_eq!(point["results"]["transmittance"], 0.2);
        assert_eq!(point["incidence"]["wavelengths"]["integral"], "visible");
        assert_eq!(point["emergence"]["direction"], "hemispherical");
    }
}
