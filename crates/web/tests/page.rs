//! What the page is told, beside slow and obvious ways to the same.

use bsdfkit::{Components, DVec3};
use bsdfkit_sphere::direction::from_degrees;
use bsdfkit_web::{Selection, Surface, map_direction, map_place};

fn open(name: &str) -> Surface {
    let path = format!("{}/../../tests/golden/xml/{name}.xml", env!("CARGO_MANIFEST_DIR"));
    Surface::read(name, &std::fs::read(path).unwrap()).unwrap()
}

fn all() -> Selection {
    Selection::new(Components::ALL.bits(), "y")
}

#[test]
fn pixels_of_a_map_are_values_of_their_directions() {
    let surface = open("t4_rf_rb_tf_tb");
    let wi = [40.0, 30.0];
    let size = 33;
    for (front, equal_angles) in [(true, false), (false, true)] {
        let map = surface.map(&wi, front, &all(), size, equal_angles);
        let mut outside = 0;
        for (k, &f) in map.iter().enumerate() {
            let at = |k: usize| (2 * k + 1) as f64 / size as f64 - 1.0;
            let wo = map_direction(at(k % size), -at(k / size), front, equal_angles);
            if wo.is_empty() {
                assert!(f.is_nan());
                outside += 1;
                continue;
            }
            let place = map_place(&wo, equal_angles);
            assert!(
                (place[0] - at(k % size)).abs() < 1e-12 && (place[1] + at(k / size)).abs() < 1e-12
            );
            assert_eq!(f, surface.value(&wi, &wo, &all()) as f32);
        }
        assert!((0.1..0.3).contains(&(f64::from(outside) / map.len() as f64)), "{outside} outside");
    }
}

#[test]
fn equal_angles_are_equally_far_apart() {
    let place = |theta| map_place(&from_degrees(theta, 0.0).to_array(), true)[0];
    for theta in [0.0, 15.0, 45.0, 89.0] {
        assert!((place(theta) - theta / 90.0).abs() < 1e-12);
        assert!((place(180.0 - theta) - theta / 90.0).abs() < 1e-12);
    }
}

#[test]
fn a_lobe_closes_without_gaps_and_is_fine_where_light_goes() {
    for (name, wi) in [
        ("t4_rf_rb_tf_tb", [30.0, 45.0]),
        ("t3_rf_rb_tf_tb", [60.0, 10.0]),
        ("kf_in_tf", [20.0, 0.0]),
    ] {
        let surface = open(name);
        for front in [true, false] {
            let lobe = surface.lobe(&wi, front, &all(), 10, 4096);
            let (directions, triangles) = (lobe.directions(), lobe.triangles());
            let at = |n: u32| {
                let n = 3 * n as usize;
                DVec3::new(directions[n].into(), directions[n + 1].into(), directions[n + 2].into())
            };
            // Seen along z each triangle has its area of the disk; together they are the disk of a polygon.
            let mut covered = 0.0;
            let mut edges = std::collections::HashMap::new();
            for t in triangles.chunks_exact(3) {
                let [a, b, c] = [at(t[0]), at(t[1]), at(t[2])];
                let area = 0.5 * (b - a).truncate().perp_dot((c - a).truncate());
                assert!(if front { area > 0.0 } else { area < 0.0 }, "a triangle turned over");
                covered += area.abs();
                for k in 0..3 {
                    let (a, b) = (t[k], t[(k + 1) % 3]);
                    *edges.entry((a.min(b), a.max(b))).or_insert(0) += 1;
                }
            }
            assert!((covered - std::f64::consts::PI).abs() < 0.01, "{covered}");
            // Every edge is shared by two triangles, but for those of the rim.
            for (&(a, b), &count) in &edges {
                let rim = |n| at(n).z.abs() < 0.01;
                assert!(
                    count == 2 || (count == 1 && rim(a) && rim(b)),
                    "an edge of {count} triangles"
                );
            }
            for (n, f) in lobe.values().iter().enumerate() {
                let f_there = surface.value(&wi, &at(n as u32).normalize().to_array(), &all());
                // Single precision moves a vertex on a border across it.
                assert!(f.is_finite() && f_there.is_finite());
            }
        }
    }
    let narrow = open("chk");
    let count =
        |surface: &Surface| surface.lobe(&[20.0, 0.0], true, &all(), 10, 4096).values().len();
    assert!(count(&narrow) >= 33 * 33);
}

#[test]
fn parts_add_up_and_channels_are_those_of_colour() {
    let surface = open("color_mtx_0.45_0.41");
    let wi = [25.0, 100.0];
    for wo in [[25.0, 280.0], [60.0, 10.0], [155.0, 280.0]] {
        let of = |bits: Components, channel| {
            surface.value(&wi, &wo, &Selection::new(bits.bits(), channel))
        };
        let whole = of(Components::ALL, "y");
        let parts = of(Components::LAMBERTIAN, "y") + of(Components::NON_LAMBERTIAN, "y");
        assert!((parts - whole).abs() < 1e-6 * (1.0 + whole), "{parts} {whole}");
        let xyz = surface.value_xyz(&wi, &wo);
        assert!((of(Components::ALL, "x") - xyz[0]).abs() < 1e-9);
        assert!((of(Components::ALL, "z") - xyz[2]).abs() < 1e-9);
    }
}

#[test]
fn a_section_is_f_round_its_plane() {
    let surface = open("t4_rf_rb_tf_tb");
    let wi = [40.0, 30.0];
    let section = surface.section(&wi, 210.0, &all(), 360);
    for (k, f) in section.iter().enumerate() {
        let theta = k as f64 + 0.5;
        let (theta, phi) = if theta < 180.0 { (theta, 210.0) } else { (360.0 - theta, 30.0) };
        let expected = surface.value(&wi, &[theta, phi], &all()) as f32;
        assert!((f - expected).abs() < 1e-6, "{theta} {phi}: {f}, not {expected}");
    }
}

#[test]
fn a_matt_white_sphere_is_as_bright_as_the_cosine() {
    let surface = open("diffuse_matrix_0.3");
    let (size, light) = (65, from_degrees(30.0, 0.0));
    let picture = surface.scene("sphere", &light.to_array(), 0.0, size, 0, size);
    let albedo = surface.bsdf().directional_hemispherical(DVec3::Z, Components::REFLECTION);
    let mut lit = 0;
    for (k, pixel) in picture.chunks_exact(4).enumerate() {
        let at = |k: usize| (2 * k + 1) as f64 / size as f64 - 1.0;
        let (x, y) = (at(k % size), -at(k / size));
        let z2 = 0.95 * 0.95 - x * x - y * y;
        if z2 <= 0.0 {
            assert_eq!(pixel[3], 0);
            continue;
        }
        let cos = DVec3::new(x, y, z2.sqrt()).normalize().dot(light);
        let linear = (0.8 * albedo * cos.max(0.0)).min(1.0);
        let encoded = if linear <= 0.003_130_8 {
            12.92 * linear
        } else {
            1.055 * linear.powf(1.0 / 2.4) - 0.055
        };
        for channel in &pixel[..3] {
            assert!(
                (f64::from(*channel) - 255.0 * encoded).abs() < 1.6,
                "{x} {y}: {pixel:?}, not {encoded}"
            );
        }
        lit += usize::from(cos > 0.0);
    }
    assert!(lit > 1000);
}

#[test]
fn rows_of_a_picture_are_the_picture() {
    let surface = open("t4_rf_rb_tf_tb");
    for shape in ["sphere", "drape", "plane"] {
        let light = [130.0, 20.0];
        let whole = surface.scene(shape, &light, 1.0, 24, 0, 24);
        let rows: Vec<u8> =
            (0..24).step_by(5).flat_map(|k| surface.scene(shape, &light, 1.0, 24, k, 5)).collect();
        assert_eq!(rows, whole);
        assert_eq!(whole.len(), 24 * 24 * 4);
    }
}

#[test]
fn what_a_file_says_is_json_and_rubbish_an_error_that_names_it() {
    let about: serde_json::Value = serde_json::from_str(&open("t4_rf_rb_tf_tb").about()).unwrap();
    assert_eq!(about["content"], "BSDF in XML");
    assert_eq!(about["components"].as_array().unwrap().len(), 4);
    for bytes in [&b""[..], b"rubbish", b"<html></html>", &[0; 100], b"#?RADIANCE\n"] {
        let error = Surface::read("mine.xml", bytes).err().expect("refused").to_string();
        assert!(error.starts_with("mine.xml: ") && error.len() > 20, "{error}");
    }
}

#[test]
fn totals_are_told_by_sides() {
    let surface = open("t4_rf_rb_tf_tb");
    let wi = from_degrees(50.0, 20.0);
    let totals = surface.totals(&wi.to_array(), &all());
    let of = |components| surface.bsdf().directional_hemispherical(wi, components);
    assert_eq!(totals, [of(Components::REFLECTION), of(Components::TRANSMISSION)]);
    let map = surface.energy(true, &all(), 9, false);
    let centre = surface.bsdf().directional_hemispherical(DVec3::Z, Components::ALL);
    assert!((f64::from(map[40]) - centre).abs() < 1e-6);
}
