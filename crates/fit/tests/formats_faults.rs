//! Damaged and strange files in the formats of others: a clear error each, never a panic, nothing half-read.

use std::path::Path;

use bsdfkit::ErrorClass;
use bsdfkit_fit::open::{self, Access};
use bsdfkit_measure::{ReadOptions, read};
use proptest::prelude::*;

#[path = "support/tensor_file.rs"]
mod tensor_file;

use tensor_file::{Tensor, floats, tensors};

/// The message for a file of these bytes, as a measurement; that of its function is as clear.
fn refused(folder: &Path, bytes: &[u8]) -> String {
    let path = folder.join("file");
    std::fs::write(&path, bytes).unwrap();
    let options = ReadOptions { incomplete: true, ..ReadOptions::default() };
    let error = read(std::slice::from_ref(&path), &options).expect_err("a damaged file");
    assert_eq!(error.class(), ErrorClass::Format, "{error}");
    let message = error.to_string();
    assert!(message.starts_with(&path.display().to_string()), "{message}");
    let other = open::open(&path, Access::Checked).expect_err("a damaged file").to_string();
    assert!(other.starts_with(&path.display().to_string()), "{other}");
    message
}

/// A small sound file.
fn rgl() -> Vec<Tensor> {
    vec![
        floats("theta_i", &[3], |k| 0.5 * k as f32),
        floats("phi_i", &[1], |_| 0.0),
        floats("ndf", &[2, 2], |_| 4.0),
        floats("sigma", &[2, 2], |_| 1.0),
        floats("vndf", &[1, 3, 4, 4], |k| 1.0 + (k % 3) as f32),
        floats("rgb", &[1, 3, 3, 4, 4], |k| 0.1 + (k % 5) as f32),
        ("valid", 1, vec![6], vec![0xff; 6]),
    ]
}

/// [`rgl`] with one tensor in the place of another of its name.
fn with(tensor: Tensor) -> Vec<u8> {
    let mut all = rgl();
    let at = all.iter().position(|t| t.0 == tensor.0).expect("a tensor of that name");
    all[at] = tensor;
    tensors(&all)
}

const ZEMAX: &str = "Source Measured\nSymmetry Asymmetrical\nSpectralContent Monochrome\nScatterType BRDF\n\
SampleRotation 1\n0\nAngleOfIncidence 2\n0 40\nScatterAzimuth 3\n0 120 240\nScatterRadial 2\n0 30\n\
Monochrome\nDataBegin\nTIS 0.1\n1 2\n1 2\n1 2\nTIS 0.1\n3 4\n3 4\n3 4\nDataEnd\n";

const LIGHTTOOLS: &str = "Symmetry Asymmetric\nSpectralContent Monochrome\nScatterAzimuth 2\n0 180\nScatterRadial 2\n0 30\n\
DataBegin\nAOI 0\nPOI 0\nSide Front\nWavelength 550\nScatterType BRDF\nTIS 0.1\n1 2\n1 2\nAOI 30\nTIS 0.1\n3 4\n3 4\nDataEnd\n";

const ASTM: &str =
    "NUM_POINTS 2\nVARS theta_i,phi_i,theta_s,phi_s,BRDF\n0.1,0,0.2,0,1\n0.1,0,0.3,0,2\n";

const FRED: &str = "!!EDS10 0-0 RPC Photonics\n!!BSDF Data\n0 0\n0 0 1\n10 0 2\n";

const CORNELL: &str = "# Cornell\n# Red\n# num wls\n2\n# wls\n400 500\n# rows\n0.1 0 0.2 0 1 2\n";

const ALTA: &str = "#DIM 3 1\n#VS 0\n#PARAM_IN ISOTROPIC_TV_TL_DPHI\n0.2 0.1 0 1\n";

/// What the samples are damaged of is read.
#[test]
fn samples_are_sound() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("file");
    let options = ReadOptions { incomplete: true, ..ReadOptions::default() };
    for text in [ZEMAX, LIGHTTOOLS, ASTM, FRED, CORNELL, ALTA] {
        std::fs::write(&path, text).unwrap();
        read(std::slice::from_ref(&path), &options).unwrap_or_else(|e| panic!("{e}"));
    }
    std::fs::write(&path, tensors(&rgl())).unwrap();
    read(std::slice::from_ref(&path), &options).unwrap_or_else(|e| panic!("{e}"));
}

#[test]
fn damaged_tensors_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let whole = tensors(&rgl());
    let without =
        |name: &str| tensors(&rgl().into_iter().filter(|t| t.0 != name).collect::<Vec<_>>());
    for (bytes, part) in [
        (whole[..whole.len() - 1].to_vec(), "found a file of"),
        (whole[..40].to_vec(), "found the end of the file"),
        (whole[..14].to_vec(), "number of tensors: expected 4 bytes"),
        (without("vndf"), "expected a tensor vndf, found theta_i, phi_i"),
        (without("rgb"), "expected a tensor rgb"),
        (with(floats("vndf", &[1, 2, 4, 4], |_| 1.0)), "vndf: expected shape [1, 3]"),
        (with(floats("vndf", &[1, 3, 16, 1], |_| 1.0)), "at least 2"),
        (with(floats("vndf", &[1, 3, 4, 4], |_| 0.0)), "vndf: expected light at incidence 0"),
        (with(floats("rgb", &[1, 3, 2, 4, 4], |_| 1.0)), "rgb: expected shape [1, 3, 3]"),
        (with(floats("rgb", &[1, 3, 3, 4, 4], |_| f32::NAN)), "rgb[0]: expected a finite number"),
        // Their sums are not numbers any more.
        (with(floats("rgb", &[1, 3, 3, 4, 4], |_| 3e38)), "a finite number of at most 1e30"),
        (
            with(floats("theta_i", &[3], |k| 1.0 - 0.1 * k as f32)),
            "theta_i: expected rising numbers",
        ),
        (
            with(floats("theta_i", &[3], |k| 30.0 * k as f32)),
            "theta_i: expected numbers from 0.0000 to 1.5709",
        ),
        (with(floats("ndf", &[4], |_| 1.0)), "ndf: expected shape"),
        (with(("ndf", 5, vec![2, 2], vec![0; 16])), "ndf: expected f32 or f64, found u32"),
        (with(("ndf", 12, vec![2, 2], vec![0; 16])), "ndf: expected a type from 1 to 11, found 12"),
        (with(("valid", 1, vec![5], vec![0xff; 5])), "valid: expected 48 bits in 6 bytes, found 5"),
        // More than there is memory for: held against the file, not believed.
        (with(("ndf", 10, vec![1 << 40, 1 << 40], vec![0; 16])), "found a file of"),
    ] {
        let message = refused(folder.path(), &bytes);
        assert!(message.contains(part), "{part}: {message}");
    }
}

/// Numbers that each are plausible and whose product is not.
#[test]
fn points_brighter_than_any_surface_are_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let mut all = rgl();
    all.retain(|t| t.0 != "ndf" && t.0 != "rgb");
    all.push(floats("ndf", &[2, 2], |_| 1e20));
    all.push(floats("rgb", &[1, 3, 3, 4, 4], |k| if k % 16 < 8 { 1e15 } else { 1e-15 }));
    let path = folder.path().join("bright.bsdf");
    std::fs::write(&path, tensors(&all)).unwrap();
    let options = ReadOptions { incomplete: true, ..ReadOptions::default() };
    let measured = read(&[path], &options).unwrap();
    let values = || measured.iter().flat_map(|m| &m.incidences).flat_map(|i| &i.values);
    assert!(
        values().count() > 0 && values().all(|v| *v <= 1e30),
        "{:?}",
        values().max_by(|a, b| a.total_cmp(b))
    );
}

#[test]
fn spectra_need_rising_wavelengths_as_many_as_channels() {
    let folder = tempfile::tempdir().unwrap();
    let spectral = |wavelengths: Tensor| {
        let mut all: Vec<Tensor> = rgl().into_iter().filter(|t| t.0 != "rgb").collect();
        all.push(wavelengths);
        all.push(floats("spectra", &[1, 3, 2, 4, 4], |_| 0.2));
        tensors(&all)
    };
    for (wavelengths, part) in [
        (floats("wavelengths", &[2], |k| 500.0 - k as f32), "wavelengths: expected rising numbers"),
        (floats("wavelengths", &[3], |k| 500.0 + k as f32), "spectra: expected shape [1, 3, 3]"),
        (floats("wavelengths", &[2], |k| 0.4 + k as f32), "wavelengths: expected numbers from 200"),
    ] {
        let message = refused(folder.path(), &spectral(wavelengths));
        assert!(message.contains(part), "{part}: {message}");
    }
}

#[test]
fn merl_of_a_wrong_size_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let head =
        |counts: [i32; 3]| -> Vec<u8> { counts.into_iter().flat_map(i32::to_le_bytes).collect() };
    let mut short = head([90, 90, 180]);
    short.extend([0; 1000]);
    let message = refused(folder.path(), &short);
    assert!(message.contains("expected 34992012 bytes, found 1012"), "{message}");
    let mut double = head([90, 90, 360]);
    double.extend([0; 1000]);
    let message = refused(folder.path(), &double);
    assert!(message.contains("expected [90, 90, 180] cells, found [90, 90, 360]"), "{message}");
    let mut infinite = head([90, 90, 180]);
    infinite.resize(34_992_012, 0);
    infinite[12 + 8..12 + 16].copy_from_slice(&f64::INFINITY.to_le_bytes());
    let message = refused(folder.path(), &infinite);
    assert!(
        message.contains("cell 1: expected a finite value of at most 1e30, found inf"),
        "{message}"
    );
}

#[test]
fn damaged_texts_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    for (text, from, to, part) in [
        (ZEMAX, "1 2\nTIS", "1\nTIS", "value: expected a number, found \"TIS\""),
        (ZEMAX, "3 4\nDataEnd\n", "", "found the end of the file"),
        (ZEMAX, "DataEnd", "5 6\nDataEnd", "expected DataEnd after the last"),
        (ZEMAX, "0 40", "40 0", "AngleOfIncidence: expected rising angles, found 0 after 40"),
        (ZEMAX, "0 40", "0 95", "AngleOfIncidence: expected degrees from 0"),
        (ZEMAX, "AngleOfIncidence 2", "AngleOfIncidence 2e9", "expected a count"),
        (ZEMAX, "ScatterRadial 2", "ScatterRadial 2.5", "expected a count"),
        (ZEMAX, "3 4\n3 4", "3 4\n3 inf", "expected a finite number"),
        (ZEMAX, "Asymmetrical", "Round", "Symmetry: expected PlaneSymmetrical"),
        (ZEMAX, "SpectralContent Monochrome", "SpectralContent RGB", "expected Monochrome or XYZ"),
        (
            ZEMAX,
            "SpectralContent Monochrome",
            "SpectralContent XYZ",
            "expected 3 blocks of values, found 1",
        ),
        (
            ZEMAX,
            "Monochrome\nDataBegin",
            "TristimulusX\nDataBegin",
            "expected XYZ, found Monochrome",
        ),
        (ZEMAX, "BRDF", "BSSRDF", "ScatterType: expected BRDF or BTDF"),
        (ZEMAX, "ScatterRadial 2\n0 30\n", "ScatterRadial 1\n0\nDensity 4\n", "keyword: expected"),
        (LIGHTTOOLS, "3 4\nDataEnd\n", "3 4\n", "expected DataEnd, found the end of the file"),
        (LIGHTTOOLS, "AOI 30", "AOI 95", "AOI: expected degrees"),
        (LIGHTTOOLS, "Side Front", "Side Left", "Side: expected Front or Back"),
        (LIGHTTOOLS, "AOI 30", "AOI 30\nWavelength 650", "expected 2 tables, one a wavelength"),
        (
            LIGHTTOOLS,
            "SpectralContent Monochrome",
            "SpectralContent XYZ",
            "expected TristimulusValue before TIS",
        ),
        (ASTM, "NUM_POINTS 2", "NUM_POINTS 3", "NUM_POINTS: expected 3 rows, found 2"),
        (ASTM, "NUM_POINTS 2", "NUM_POINTS many", "NUM_POINTS: expected a count"),
        (ASTM, "theta_s", "theta_s [mm]", "expected an angle in deg or rad, found the unit \"mm\""),
        (ASTM, "theta_s,", "", "expected a column theta_o"),
        (ASTM, ",BRDF", ",BRDF (%)", "expected values in 1/sr"),
        (ASTM, "0.1,0,0.3,0,2", "0.1,0,0.3,0", "expected 5 columns, found 4"),
        (ASTM, "0.1,0,0.3,0,2", "30,0,30,0,2", "theta_i: expected degrees from -720 to 720"),
        (ASTM, "0.1,0,0.3,0,2", "0.1,0,0.3,0,1e99", "expected f of at most"),
        (FRED, "10 0 2", "10 0 2 3", "expected 3 columns, found 4"),
        (FRED, "10 0 2", "110 0 2", "theta: expected degrees from -90 to 90, found 110"),
        (FRED, "0 0\n0 0 1", "0 0 1", "expected the specular direction"),
        (CORNELL, "400 500", "500 400", "wls: expected rising wavelengths, found 400 after 500"),
        (CORNELL, "400 500", "400 500 600", "wls: expected 2 wavelengths, found more"),
        (CORNELL, "wls\n2", "wls\n20000000", "num wls: expected 1 to 2000"),
        (CORNELL, "0 1 2", "0 1", "expected 6 columns, found 5"),
        (ALTA, "ISOTROPIC_TV_TL_DPHI", "RUSIN_TH_TD_PD", "PARAM_IN: expected one of"),
        (ALTA, "#DIM 3 1", "#DIM 3 0", "DIM: expected at least one value"),
        (ALTA, "#DIM 3 1", "#DIM 3 5000", "DIM: expected a whole number of at most 64"),
        (ALTA, "0.2 0.1 0 1", "0.2 0.1 0 1 7", "expected 4 columns, found 5"),
        (ALTA, "0.2 0.1 0 1", "20 0.1 0 1", "expected polar angles up to half a turn"),
    ] {
        let damaged = text.replacen(from, to, 1);
        assert_ne!(damaged, text, "{from}");
        let message = refused(folder.path(), damaged.as_bytes());
        assert!(message.contains(part), "{from} -> {to}: {part}: {message}");
    }
}

/// Reads bytes in every way; whatever comes of it, it comes.
fn read_anyhow(folder: &Path, bytes: &[u8]) {
    let path = folder.join("file");
    std::fs::write(&path, bytes).expect("a temporary file");
    let options = ReadOptions { incomplete: true, most_bytes: 1_600_000, ..ReadOptions::default() };
    if let Ok(measured) = read(std::slice::from_ref(&path), &options) {
        for i in measured.iter().flat_map(|m| &m.incidences) {
            assert!(i.values.iter().all(|v| v.is_finite()));
            assert!(i.wo.iter().all(|w| (w.length() - 1.0).abs() < 1e-5));
        }
    }
    let bsdf = open::bsdf_from_bytes(bytes);
    if let Ok(bsdf) = bsdf {
        let w = bsdfkit_sphere::direction::from_degrees(30.0, 40.0);
        assert!(bsdf.eval(w, w) >= 0.0);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    #[test]
    fn whatever_follows_a_start_is_survived(
        start in prop::sample::select(vec![
            &b"tensor_file\0\x01\0"[..], b"\x5a\0\0\0\x5a\0\0\0\xb4\0\0\0", b"!!a\n",
            b"type bsdf_data\n", b"# num wls\n", b"#PARAM_IN CARTESIAN\n#DIM 6 1\n", b"VARS theta_i,",
            b"AngleOfIncidence 1\n0\nScatterRadial ", b"ScatterAzimuth 2\n0 9\nScatterRadial ",
        ]),
        rest in prop::collection::vec(any::<u8>(), 0..400),
    ) {
        let folder = tempfile::tempdir().unwrap();
        read_anyhow(folder.path(), &[start, &rest[..]].concat());
    }

    #[test]
    fn sound_files_with_wrong_bytes_are_survived(
        which in 0..7_usize,
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        cut in any::<prop::sample::Index>(),
        cuts in any::<bool>(),
    ) {
        let texts = [ZEMAX, LIGHTTOOLS, ASTM, FRED, CORNELL, ALTA];
        let mut bytes = texts.get(which).map_or_else(|| tensors(&rgl()), |t| t.as_bytes().to_vec());
        for (at, byte) in changes {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        if cuts {
            bytes.truncate(cut.index(bytes.len()));
        }
        let folder = tempfile::tempdir().unwrap();
        read_anyhow(folder.path(), &bytes);
    }
}
