//! Files are told apart by their content, and answer alike.

use bsdfkit::{Bsdf, Components, DVec3, ErrorClass, container, xml};

fn golden(name: &str) -> String {
    format!("{}/../../tests/golden/xml/{name}.xml", env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn either_kind_opens_under_any_name() {
    for name in ["t4_rf_rb_tf_tb", "t3_tf", "kf_in_tf", "color_tree_0.6_0.3"] {
        let read = xml::read(golden(name)).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let compiled = folder.path().join("compiled.xml");
        container::save(&read, &compiled).unwrap();
        let bytes = |path: &std::path::Path| std::fs::read(path).unwrap();
        let opened = [
            Bsdf::open(golden(name)).unwrap(),
            Bsdf::open(&compiled).unwrap(),
            Bsdf::from_bytes(&bytes(golden(name).as_ref())).unwrap(),
            Bsdf::from_bytes(&bytes(&compiled)).unwrap(),
        ];
        for k in 0..500_u32 {
            let w = |k: f64| {
                let (z, angle) = (1.0 - 2.0 * (k * 0.618_034).fract(), k * 2.4);
                DVec3::new(angle.cos(), angle.sin(), 0.0) * (1.0 - z * z).sqrt() + DVec3::Z * z
            };
            let (wi, wo, u) = (w(f64::from(k)), w(f64::from(k) + 0.3), f64::from(k) / 500.0);
            for other in &opened {
                assert_eq!(other.eval_xyz(wi, wo), read.eval_xyz(wi, wo));
                let sample = |b: &Bsdf| b.sample(wi, u, Components::ALL);
                assert_eq!(sample(other), sample(&read));
            }
        }
    }
}

#[test]
fn faults_have_their_class() {
    let class = |bytes: &[u8]| Bsdf::from_bytes(bytes).unwrap_err().class();
    assert_eq!(class(b""), ErrorClass::Format);
    assert_eq!(class(b"\x10\0\0\0\0\0\0\0{\"broken\": \"json"), ErrorClass::Format);
    assert_eq!(class(b"<nothing>{</nothing>"), ErrorClass::Format);
    let error = Bsdf::open(golden("missing")).unwrap_err();
    assert_eq!(error.class(), ErrorClass::Io);
    assert!(error.to_string().contains("missing.xml: "), "{error}");
}

/// A pipe that nobody writes to would never open, a device never end.
#[cfg(unix)]
#[test]
fn pipes_and_devices_are_refused_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe.xml");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    assert!(made.unwrap().success());
    let zeros = folder.path().join("zeros.safetensors");
    std::os::unix::fs::symlink("/dev/zero", &zeros).unwrap();
    for path in [&pipe, &zeros] {
        let refused = [
            Bsdf::open(path).unwrap_err(),
            xml::read(path).unwrap_err(),
            container::load(path).unwrap_err(),
            container::open(path).unwrap_err(),
            container::kind(path).unwrap_err(),
        ];
        for error in refused {
            assert_eq!(error.class(), ErrorClass::Argument);
            assert!(error.to_string().contains("expected a regular file, found a pipe"), "{error}");
        }
    }
}
