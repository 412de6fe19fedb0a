//! Measurements in the formats of others, in files made here of a function that is known.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};

use bsdfkit::{Components, DVec3, ErrorClass};
use bsdfkit_fit::interpolant::{Interpolant, Part};
use bsdfkit_fit::open::{self, Access, Content};
use bsdfkit_measure::{Colorimetry, Side};
use bsdfkit_sphere::direction::from_degrees;

#[path = "support/files.rs"]
mod files;
#[path = "support/tensor_file.rs"]
mod tensor_file;

use files::{Row, about_specular, expect_rows, only, plain, radians};
use tensor_file::{floats, tensors};

/// Bands come as they are; without a fit they are seen in daylight.
#[test]
fn rgl_spectra() {
    let wavelengths: Vec<f64> = (0..9).map(|k| 380.0 + 50.0 * f64::from(k)).collect();
    let spectrum: Vec<f64> = (0..9).map(|k| 0.1 + 0.07 * f64::from((k * 5) % 7)).collect();
    let file = tensors(&[
        floats("theta_i", &[3], |k| 0.5 * k as f32),
        floats("phi_i", &[1], |_| 0.0),
        floats("ndf", &[2, 2], |_| 4.0),
        floats("sigma", &[2, 2], |_| 1.0),
        floats("vndf", &[1, 3, 4, 4], |_| 1.0),
        floats("wavelengths", &[9], |k| wavelengths[k] as f32),
        floats("spectra", &[1, 3, 9, 8, 8], |k| {
            (spectrum[k / 64 % 9] * (1 + k / 576) as f64) as f32
        }),
    ]);
    let folder = tempfile::tempdir().unwrap();
    let path = put(folder.path(), "a_spec.bsdf", file);
    let m = only(&path);
    for (slice, i) in m.incidences.iter().enumerate() {
        for k in 0..i.wo.len() {
            for (band, value) in spectrum.iter().enumerate() {
                let exact = value * (1 + slice) as f64 / i.wo.at(k).z;
                assert!((i.value(k, 1 + band) - exact).abs() < 1e-5 * exact);
            }
        }
    }
    let bands = bsdfkit::spectrum::Bands::new(wavelengths).unwrap();
    let view = bsdfkit::spectrum::View::Colour(bsdfkit::spectrum::Illuminant::D65);
    let weights = view.weights(&bands).unwrap();
    let seen: Vec<f64> = weights.apply(&spectrum).collect();
    let bsdf = open::bsdf(&path).unwrap();
    // Half-way between the first two incidences.
    let (wi, wo) = (radians(0.25, 1.0), radians(0.6, 2.0));
    let f = bsdf.eval_xyz(wi, wo);
    for (found, seen) in [f.x, f.y, f.z].into_iter().zip(seen) {
        assert!((found - 1.5 * seen / wo.z).abs() < 1e-5, "{found} {seen}");
    }
}

fn put(folder: &Path, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, bytes).unwrap();
    path
}

/// Peaks at the mirror direction, and is lopsided: no mistaken azimuth gives the same.
fn f(wi: DVec3, wo: DVec3) -> f64 {
    let mirror = DVec3::new(-wi.x, -wi.y, wi.z);
    let left = mirror.cross(DVec3::Z).dot(wo);
    0.1 + 2.0 * (20.0 * (mirror.dot(wo) - 1.0)).exp() * (1.0 + 0.5 * left)
}

/// MERL's: a function of half and difference angles; nothing was measured past 85° of the half vector.
fn merl() -> Vec<u8> {
    let mut planes = vec![Vec::new(); 3];
    for i in 0..90 {
        for j in 0..90 {
            for k in 0..180 {
                let value = merl_value(i, j, k);
                for (c, scale) in [1500.0, 1500.0 / 1.15, 1500.0 / 1.66].into_iter().enumerate() {
                    planes[c].push(if i > 86 {
                        -1.0
                    } else {
                        (1.0 + 0.1 * c as f64) * value * scale
                    });
                }
            }
        }
    }
    let counts = [90_i32, 90, 180].into_iter().flat_map(i32::to_le_bytes);
    counts.chain(planes.concat().into_iter().flat_map(f64::to_le_bytes)).collect()
}

fn merl_value(i: usize, j: usize, k: usize) -> f64 {
    (-(i as f64) / 9.0).exp() + 0.05 + 0.001 * j as f64 + 0.0001 * k as f64
}

/// As the makers' program looks it up: degrees by turns of the incident direction.
fn merl_by_turns(wi: DVec3, wo: DVec3) -> (usize, usize, usize) {
    let h = (wi + wo).normalize();
    let (theta_h, phi_h) = (h.z.min(1.0).acos(), h.y.atan2(h.x));
    let (s, c) = (-phi_h).sin_cos();
    let a = DVec3::new(c * wi.x - s * wi.y, s * wi.x + c * wi.y, wi.z);
    let (s, c) = (-theta_h).sin_cos();
    let d = DVec3::new(c * a.x + s * a.z, a.y, c * a.z - s * a.x);
    let phi_d = d.y.atan2(d.x);
    let phi_d = if phi_d < 0.0 { phi_d + PI } else { phi_d };
    let cell = |x: f64, most: usize| (x as usize).min(most - 1);
    (
        cell((theta_h.to_degrees() * 90.0).sqrt(), 90),
        cell(d.z.min(1.0).acos().to_degrees(), 90),
        cell(phi_d.to_degrees(), 180),
    )
}

#[test]
fn merl_is_read_as_by_its_makers() {
    let folder = tempfile::tempdir().unwrap();
    let path = put(folder.path(), "plastic.binary", merl());
    let m = only(&path);
    assert_eq!((m.incidences.len(), m.sample_name.as_deref()), (17, Some("plastic")));
    assert!(
        m.notes.iter().any(|n| n.contains("48600 of 1458000 cells are below 0")),
        "{:?}",
        m.notes
    );
    assert_eq!(Content::of(&path).unwrap(), Content::Measurement);
    let bsdf = open::bsdf(&path).unwrap();
    let mut compared = 0;
    for incidence in &m.incidences {
        for k in (0..incidence.wo.len()).step_by(53) {
            let (wi, wo) = (incidence.wi, incidence.wo.at(k));
            let (i, j, l) = merl_by_turns(wi, wo);
            let alike = |j: usize, l: usize| {
                let v = merl_value(i, j, l);
                let y = 0.212_671 * v + 0.715_16 * 1.1 * v + 0.072_169 * 1.2 * v;
                (incidence.value(k, 1) - y).abs() < 1e-6 * y
            };
            let exact = alike(j, l);
            // On the border between two cells rounding chooses, and half a turn of φd is 0 again.
            let near =
                [(j, (l + 179) % 180), (j, (l + 1) % 180), (j + 1, l), (j.saturating_sub(1), l)];
            assert!(exact || near.iter().any(|(j, l)| alike(*j, *l)), "{wi} {wo}");
            compared += usize::from(exact);
            if exact {
                let f = bsdf.eval(wi, wo);
                assert!((f - incidence.value(k, 1)).abs() < 2e-3 * f, "{f}");
            }
        }
    }
    assert!(compared > 1000, "{compared}");
}

fn zemax_of(kind: &str, symmetry: &str, rotations: &[f64]) -> String {
    let azimuths: Vec<f64> = match symmetry {
        "PlaneSymmetrical" => (0..=18).map(|k| 10.0 * f64::from(k)).collect(),
        _ => (0..=36).map(|k| 10.0 * f64::from(k)).collect(),
    };
    let radials: Vec<f64> = (0..=40).map(|k| 3.0 * f64::from(k)).collect();
    let thetas = [0.0, 30.0, 60.0];
    let list = |key: &str, list: &[f64]| {
        let words: Vec<String> = list.iter().map(f64::to_string).collect();
        format!("{key}\t{}\n{}\n", list.len(), words.join("\t"))
    };
    let mut text = format!(
        "# made\nSource Measured\nSymmetry {symmetry}\nSpectralContent Monochrome\nScatterType {kind}\n"
    );
    text += &list("SampleRotation", rotations);
    text += &list("AngleOfIncidence", &thetas);
    text += &list("ScatterAzimuth", &azimuths);
    text += &list("ScatterRadial", &radials);
    text += "\nMonochrome\nDataBegin\n";
    for rotation in rotations {
        for theta in thetas {
            text += "TIS 0.5\n";
            for azimuth in &azimuths {
                let phi = 180.0 - rotation;
                let of = |radial: &f64| {
                    let wo = about_specular(theta, phi, *radial, *azimuth);
                    let value = f(from_degrees(theta, phi), wo);
                    format!("{value:.9e}")
                };
                let row: Vec<String> = radials.iter().map(of).collect();
                text += &format!("{}\n", row.join("\t"));
            }
        }
    }
    text + "DataEnd\n"
}

/// In reflection and in transmission, in whole and with a mirror plane: points and function are those of the material.
#[test]
fn zemax_points_and_function() {
    let folder = tempfile::tempdir().unwrap();
    for (kind, symmetry, rotations) in [
        ("BRDF", "Asymmetrical4D", vec![0.0, 90.0, 180.0, 270.0]),
        ("BTDF", "ASymmetrical", vec![0.0]),
    ] {
        let path = put(folder.path(), "a.bsdf", zemax_of(kind, symmetry, &rotations));
        let m = only(&path);
        let down = if kind == "BTDF" { -1.0 } else { 1.0 };
        assert_eq!(m.scattered, if kind == "BTDF" { Side::Back } else { Side::Front });
        for (i, wo, value) in
            m.incidences.iter().flat_map(|i| i.points(0).map(move |(w, v)| (i, w, v)))
        {
            let exact = f(i.wi, DVec3::new(wo.x, wo.y, down * wo.z));
            assert!((value - exact).abs() < 2e-5, "{} {wo}: {value} {exact}", i.wi);
        }
        let bsdf = open::bsdf(&path).unwrap();
        for (theta, phi) in [(0.0, 0.0), (30.0, 37.0), (60.0, 200.0), (45.0, 120.0)] {
            let wi = from_degrees(theta, phi);
            for k in 0..300 {
                let wo = from_degrees(f64::from(k % 17) * 5.0 + 1.0, f64::from(k) * 13.7);
                // Past the last radial angle nothing is known.
                if DVec3::new(-wi.x, -wi.y, wi.z).dot(wo) < -0.5 {
                    continue;
                }
                let exact = f(wi, wo);
                let found = bsdf.eval(wi, DVec3::new(wo.x, wo.y, down * wo.z));
                assert!(
                    (found - exact).abs() < 0.02 * exact + 0.02,
                    "{kind} {wi} {wo}: {found} {exact}"
                );
            }
        }
    }
}

#[test]
fn plane_symmetry_adds_the_other_half() {
    let folder = tempfile::tempdir().unwrap();
    let path = put(folder.path(), "a.bsdf", zemax_of("BRDF", "PlaneSymmetrical", &[0.0]));
    let m = only(&path);
    let i = &m.incidences[1];
    for (wo, value) in i.points(0) {
        // Light comes from 180 degrees: the plane of incidence is y = 0, and the file holds the side y < 0 of the specular.
        let exact = f(i.wi, DVec3::new(wo.x, -wo.y.abs(), wo.z));
        assert!((value - exact).abs() < 2e-5, "{wo}: {value} {exact}");
    }
    assert!(i.wo.iter().any(|w| w.y > 0.1) && i.wo.iter().any(|w| w.y < -0.1));
}

#[test]
fn lighttools_all_four_components() {
    let mut text =
        "# LightTools\nSymmetry Asymmetric\nSpectralContent Monochrome\nScatterAzimuth 37\n"
            .to_owned();
    text += &(0..37).map(|k| format!("{} ", 10 * k)).collect::<String>();
    text += "\nScatterRadial 18\n";
    text += &(0..18).map(|k| format!("{} ", 5 * k)).collect::<String>();
    text += "\nDataBegin\n";
    for (side, kind) in [("Front", "BRDF"), ("Front", "BTDF"), ("Back", "BRDF"), ("Back", "BTDF")] {
        for theta in [0.0, 40.0] {
            text += &format!(
                "AOI {theta}\nPOI 0\nSide {side}\nWavelength 550\nScatterType {kind}\nTIS 0.4\n"
            );
            for azimuth in 0..37 {
                for radial in 0..18 {
                    let wo = from_degrees(5.0 * f64::from(radial), 10.0 * f64::from(azimuth));
                    text += &format!("{:.8e} ", f(from_degrees(theta, 90.0), wo));
                }
                text += "\n";
            }
        }
    }
    text += "DataEnd\n";
    let folder = tempfile::tempdir().unwrap();
    let path = put(folder.path(), "a.bsdf", text);
    let components = plain(std::slice::from_ref(&path));
    assert_eq!(components.len(), 4);
    for m in components {
        assert_eq!(m.incidences.len(), 2);
        for (i, wo, value) in
            m.incidences.iter().flat_map(|i| i.points(0).map(move |(w, v)| (i, w, v)))
        {
            let up = |w: DVec3| DVec3::new(w.x, w.y, w.z.abs());
            let exact = f(up(i.wi), up(wo));
            assert!((value - exact).abs() < 1e-5, "{} {wo}: {value} {exact}", i.wi);
        }
    }
    let error = open::open(&path, Access::Checked).unwrap_err();
    assert_eq!(error.class(), ErrorClass::Argument, "{error}");
}

#[test]
fn lighttools_colour_has_three_tables() {
    let mut text = "Symmetry Asymmetric\nSpectralContent XYZ\nScatterAzimuth 2\n0 180\nScatterRadial 2\n0 30\nDataBegin\n".to_owned();
    for (k, name) in ["TrisX", "TrisY", "TrisZ"].iter().enumerate() {
        text += &format!(
            "AOI 10\nPOI 0\nSide Front\nTristimulusValue {name}\nScatterType BRDF\nTIS 0\n{k}1 {k}2\n{k}1 {k}3\n"
        );
    }
    let folder = tempfile::tempdir().unwrap();
    let m = only(&put(folder.path(), "a.bsdf", format!("{text}DataEnd\n")));
    assert_eq!(m.colorimetry, Colorimetry::Xyz);
    assert_eq!(m.incidences[0].point(2), [3.0, 13.0, 23.0]);
}

#[test]
fn astm_has_radians_and_channels_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let mut rows: Vec<Row> = Vec::new();
    let mut text = String::new();
    for k in 0..60 {
        let (theta, phi) = (0.02 * f64::from(k), 0.1 * f64::from(k));
        let value = 0.25 + f64::from(k);
        text += &format!("0.5,0.25,{theta:.6},{phi:.6},{value}\n");
        let of = |x: f64| format!("{x:.6}").parse::<f64>().unwrap();
        rows.push((radians(0.5, 0.25), radians(of(theta), of(phi)), vec![value]));
    }
    for head in [
        "NUM_POINTS 60\nVARS theta_i,phi_i,theta_s,phi_s,BRDF\n",
        "TITLE paint\nNUM_POINTS=60\nVARS=theta_i,phi_i,theta_s,phi_s,BRDF\n",
    ] {
        let m = only(&put(folder.path(), "a.astm", format!("{head}{text}")));
        expect_rows(&m, &rows);
    }
    let spectral = "VARS theta_i,phi_i,theta_s,phi_s,450nm,550nm\n0.1,0,0.2,0,1,2\n";
    let m = only(&put(folder.path(), "s.astm", spectral));
    assert_eq!(m.incidences[0].value(0, m.incidences[0].channels() - 1), 2.0);
    let white =
        "VARS theta_i,phi_i,theta_s,phi_s,R,G,B\n0.1,0,0.2,0,0.5,0.5,0.5\n0.1,0,0.3,0,0,-1,0\n";
    let m = only(&put(folder.path(), "w.astm", white));
    assert_eq!(m.colorimetry, Colorimetry::Xyz);
    assert!(m.incidences[0].point(0).iter().all(|v| (v - 0.5).abs() < 1e-5));
    assert!(m.notes.iter().any(|n| n.contains("3 tristimulus values below 0")), "{:?}", m.notes);
}

#[test]
fn freds_own_form() {
    let text = "type bsdf_data\nformat angles=deg bsdf=log scale=2\n0 0\n0 0 -1\n10 90 0\n30 0\n-20 0 -2\n30 0 1\n";
    let folder = tempfile::tempdir().unwrap();
    let m = only(&put(folder.path(), "a.txt", text));
    assert_eq!((m.incident, m.scattered), (Side::Front, Side::Front));
    assert!((m.incidences[1].wi - from_degrees(30.0, 180.0)).length() < 1e-12);
    // A row along the normal comes last.
    let values = |k: usize| m.incidences[k].channel(0).map(|v| v as f32).collect::<Vec<_>>();
    assert_eq!((values(0), values(1)), (vec![2.0, 0.2], vec![0.02, 20.0]));
    assert!((m.incidences[1].wo.at(0) - from_degrees(20.0, 180.0)).length() < 1e-6);
    assert!((m.incidences[1].wo.at(1) - from_degrees(30.0, 0.0)).length() < 1e-6);
}

#[test]
fn altas_parametrisations() {
    let folder = tempfile::tempdir().unwrap();
    for (name, row) in [
        ("SPHERICAL_TL_PL_TV_PV", "0.5 0.25 0.7 1.2"),
        ("ISOTROPIC_TV_TL_DPHI", "0.7 0.5 0.95"),
        (
            "ISOTROPIC_TL_TV_PROJ_DPHI",
            &format!("0.5 {} {}", 0.7 * 0.95_f64.cos(), 0.7 * 0.95_f64.sin()),
        ),
        ("CARTESIAN", &{
            let (l, v) = (radians(0.5, 0.25), radians(0.7, 1.2));
            format!("{} {} {} {} {} {}", v.x, v.y, v.z, l.x, l.y, l.z)
        }),
    ] {
        let text = format!(
            "#DIM 0 1\n#PARAM_IN {name}\n#PARAM_OUT INV_STERADIAN_COSINE_FACTOR\n{row} 3\n"
        );
        let m = only(&put(folder.path(), "a.dat", text));
        let (wi, wo) = (m.incidences[0].wi, m.incidences[0].wo.at(0));
        assert!(
            (wi.z - 0.5_f64.cos()).abs() < 1e-9 && (wo.z - 0.7_f64.cos()).abs() < 1e-6,
            "{name}"
        );
        let turned =
            (wi.truncate().perp_dot(wo.truncate())).atan2(wi.truncate().dot(wo.truncate()));
        assert!((turned - 0.95).abs() < 1e-6, "{name}: {turned}");
        assert!((m.incidences[0].value(0, 0) * 0.7_f64.cos() - 3.0).abs() < 1e-5, "{name}");
    }
}

/// What answers without a fit answers in every form, and comes back from a container.
#[test]
fn functions_are_kept_and_tabulated() {
    let folder = tempfile::tempdir().unwrap();
    let path = put(folder.path(), "a.bsdf", zemax_of("BRDF", "Asymmetrical", &[0.0]));
    let (content, opened) = open::open(&path, Access::Checked).unwrap();
    assert_eq!(content, Content::Measurement);
    let open::Opened::Interpolant(interpolant) = opened else { panic!("expected a function") };
    assert!(matches!(interpolant.components[..], [Part::Dense(_)]));
    let bytes = interpolant.to_bytes(Default::default()).unwrap();
    let back = Interpolant::from_bytes(&bytes).unwrap();
    let (a, b) = (interpolant.bsdf(), back.bsdf());
    let c = open::bsdf_from_bytes(&std::fs::read(&path).unwrap()).unwrap();
    let wi = from_degrees(33.0, 20.0);
    for k in 0..50 {
        let wo = from_degrees(f64::from(k) * 1.7, f64::from(k) * 41.0);
        assert_eq!(a.eval(wi, wo), b.eval(wi, wo));
        assert_eq!(a.eval(wi, wo), c.eval(wi, wo));
    }
    let total = a.directional_hemispherical(wi, Components::ALL);
    let sum: f64 = (0..4000)
        .map(|k| {
            let point = bsdfkit_sphere::sequence::plastic(k);
            let wo = bsdfkit_sphere::concentric::square_to_hemisphere(point, Side::Front);
            a.eval(wi, wo) * PI / 4000.0
        })
        .sum();
    assert!((total - sum).abs() < 0.02 * sum, "{total} {sum}");
}
