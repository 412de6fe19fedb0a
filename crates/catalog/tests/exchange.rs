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

#[test]
fn what_goes_to_bed_comes_back() {
    let parts = Lambertian {
        reflection_front: Xyz::grey(0.3),
        transmission_front: Xyz::grey(0.2),
        ..Lambertian::default()
    };
    let mut bytes = Vec::new();
    bed::write(&Bsdf::new(Metadata::default(), Vec::new(), parts), &mut bytes).unwrap();
    let read = bed::read(&serde_json::from_slice(&bytes).unwrap()).unwrap();
    assert_eq!((read.record, read.passed_over.len()), (Record::default(), 0));
    let polar: Vec<f64> = read.totals.iter().map(|t| t.polar).collect();
    assert_eq!(polar, [0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0]);
    for total in &read.totals {
        assert_eq!((&*total.surface, &*total.band, total.azimuth), ("prime", "visible", None));
        assert_eq!((total.reflectance, total.transmittance), (Some(0.3), Some(0.2)));
    }
}

/// A component as databases hand it out: who makes it, one total, one value with its uncertainty, points of other kinds.
const COMPONENT: &str = r#"{"components": [{"id": "11aa", "name": "Float <b>glass</b>", "description": "Clear.",
 "roles": {"manufacturer": {"name": "Acme Glass"}}, "categories": {"componentType": ["material", "layer"]},
 "optical": [{"id": {"value": "22bb", "issuedBy": "33cc"}, "timestamp": "2021-06-09T04:26:06+00:00",
  "appliedMethod": {"method": {"id": "44dd", "name": "integrating sphere"}},
  "data": [{"data": [
   {"componentCharacteristics": {"surface": "prime"}, "dataPoints": [
    {"incidence": {"direction": {"polar": 8}, "wavelengths": {"integral": "visible"}},
     "emergence": {"direction": "hemispherical"}, "results": {"reflectance": 0.08, "colorReflectance": {"name": "grey"}}},
    {"incidence": {"direction": {"polar": 8, "azimuth": 90}, "wavelengths": {"integral": "solar"}, "polarization": {"s": 0.5, "p": 0.5}},
     "emergence": {"direction": "hemispherical"},
     "results": {"transmittance": {"uncertainValue": 0.83, "uncertainty": 0.01, "confidenceInterval": 95.4}}}]},
   {"dataPoints": [
    {"incidence": {"direction": {"polar": 8}, "wavelengths": {"wavelength": 550}},
     "emergence": {"direction": "hemispherical"}, "results": {"reflectance": 0.081}},
    {"incidence": {"direction": {"polar": 8}, "wavelengths": {"integral": "visible"}, "polarization": {"s": 1, "p": 0}},
     "emergence": {"direction": "hemispherical"}, "results": {"reflectance": 0.09}},
    {"incidence": {"direction": "hemispherical", "wavelengths": {"integral": "visible"}},
     "emergence": {"direction": "hemispherical"}, "results": {"reflectance": 0.15}},
    {"incidence": {"direction": {"polar": 8}, "wavelengths": {"integral": "visible"}},
     "emergence": {"direction": {"polar": 8}}, "results": {"reflectance": 0.07}}]}]}]}]}]}"#;

#[test]
fn a_component_of_bed_is_a_record_and_totals() {
    let read = bed::read(&serde_json::from_str(COMPONENT).unwrap()).unwrap();
    let expected = Record {
        name: "Float <b>glass</b>".into(),
        maker: "Acme Glass".into(),
        class: "material, layer".into(),
        instrument: "integrating sphere".into(),
        date: "2021-06-09".into(),
        notes: "Clear. Component 11aa. Data set 22bb.".into(),
        ..Record::default()
    };
    assert_eq!(read.record, expected);
    assert_eq!(Record::from_json(COMPONENT).unwrap(), expected);
    let told: Vec<_> = read
        .totals
        .iter()
        .map(|t| (&*t.band, t.polar, t.azimuth, t.reflectance, t.transmittance))
        .collect();
    assert_eq!(
        told,
        [("visible", 8.0, None, Some(0.08), None), ("solar", 8.0, Some(90.0), None, Some(0.83))]
    );
    assert_eq!(
        read.passed_over,
        [
            "1 of light from the whole hemisphere",
            "1 of light into one direction",
            "1 of polarised light",
            "1 of single wavelengths"
        ]
    );
}

#[test]
fn faults_of_bed_are_named_with_their_place() {
    let of = |text: &str| {
        let error = Record::from_json(text).err();
        error.map(|e| e.to_string()).unwrap_or_default()
    };
    let point = "components[0].optical[0].data[0].data[0].dataPoints[0]";
    for (from, to, words) in [
        (
            "0.08",
            "\"0.08\"",
            format!(
                "{point}.results.reflectance: expected a number from -0.1 to 1.1, found \"0.08\""
            ),
        ),
        (
            "0.08",
            "9.9999",
            format!(
                "{point}.results.reflectance: expected a number from -0.1 to 1.1, found 9.9999"
            ),
        ),
        (
            "\"polar\": 8",
            "\"polar\": 98",
            format!("{point}.incidence.direction.polar: expected a number from 0 to 90, found 98"),
        ),
        (
            "\"hemispherical\"",
            "\"everywhere\"",
            format!(
                "{point}.emergence.direction: expected an object, \"diffuse\" or \"hemispherical\", found \"everywhere\""
            ),
        ),
        (
            "\"integral\": \"visible\"",
            "\"integral\": \"green\"",
            format!("{point}.incidence.wavelengths.integral: expected one of visible,"),
        ),
        (
            "\"emergence\"",
            "\"emergent\"",
            format!("{point}: expected an object with \"emergence\""),
        ),
        (
            "\"prime\"",
            "\"front\"",
            "componentCharacteristics.surface: expected \"prime\" or \"nonPrime\", found \"front\""
                .into(),
        ),
        (
            "\"optical\": [",
            "\"optical\": [], \"optics\": [",
            "components[0].optical: expected an array that is not empty".into(),
        ),
        ("\"components\": [", "\"components\": [{}, ", "components: expected one component".into()),
    ] {
        let text = COMPONENT.replacen(from, to, 1);
        assert_ne!(text, COMPONENT, "{from}");
        let error = of(&text);
        assert!(error.starts_with("BED-JSON: ") && error.contains(&words), "{words}: {error}");
    }
    // Nothing that is shared: what there is instead is told.
    let spectrum = COMPONENT
        .replace("\"integral\": \"visible\"", "\"wavelength\": 600")
        .replace("\"integral\": \"solar\"", "\"wavelength\": 600");
    let error = of(&spectrum);
    assert!(error.contains("found points: 1 of light from the whole hemisphere, 1 of light into one direction, 4 of single wavelengths"), "{error}");
}
