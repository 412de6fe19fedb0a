//! Real measurements in the formats of others, found through the environment variable BSDFKIT_DATA.

use bsdfkit::DVec3;
use bsdfkit_fit::open;
use bsdfkit_measure::{Colorimetry, Side};
use bsdfkit_sphere::direction::from_degrees;

#[path = "support/files.rs"]
mod files;

use files::{Row, about_specular, data, expect_rows, numbers, only, radians};

#[test]
fn rpc_photonics() {
    let Some(folder) = data("eds10_rpc") else { return };
    for name in ["EDS10 0-0.txt", "EDS10 10-45.txt", "EDS10 20-0.txt"] {
        let path = folder.join(name);
        let text = std::fs::read_to_string(&path).unwrap();
        let mut lines = text.lines().skip(2).map(numbers);
        let [theta, phi] = lines.next().unwrap()[..] else { panic!() };
        // The light goes on to (θ, φ) on the other side.
        let wi = from_degrees(theta, phi + 180.0);
        let (mut rows, mut normal) = (Vec::new(), Vec::new());
        for row in lines {
            match row[0] {
                0.0 => normal.push(row[2]),
                theta => rows.push((wi, from_degrees(180.0 - theta, row[1]), vec![row[2]])),
            }
        }
        let mean = normal.iter().sum::<f64>() / normal.len() as f64;
        assert_eq!(normal.len(), 360);
        rows.push((wi, -DVec3::Z, vec![mean]));
        let m = only(&path);
        assert_eq!((m.incident, m.scattered), (Side::Front, Side::Back));
        assert_eq!(m.sample_name.as_deref(), Some("EDS10"));
        expect_rows(&m, &rows);
    }
}

/// What others made of the same files has the same directions and values.
#[test]
fn rpc_photonics_is_the_mountain_form() {
    let (Some(rpc), Some(mountain)) = (data("eds10_rpc"), data("eds10_mountain")) else { return };
    for (ours, theirs) in
        [("EDS10 10-45.txt", "eds10_t10p045.txt"), ("EDS10 20-0.txt", "eds10_t20p000.txt")]
    {
        let (a, b) = (only(&rpc.join(ours)), only(&mountain.join(theirs)));
        let (a, b) = (&a.incidences[0], &b.incidences[0]);
        assert!((a.wi - b.wi).length() < 1e-9);
        assert_eq!(a.wo.len(), b.wo.len());
        let sums = [a, b].map(|i| i.channel(0).sum::<f64>());
        assert!((sums[0] / sums[1] - 1.0).abs() < 1e-4, "{sums:?}");
        for k in (0..a.wo.len()).step_by(31) {
            let near = (0..b.wo.len()).find(|&l| (b.wo.at(l) - a.wo.at(k)).length() < 1e-5);
            let (ours, theirs) = (a.value(k, 0), b.value(near.unwrap(), 0));
            // Rows along the normal are averaged here; there the first stands for them.
            assert!(ours == theirs || a.wo.at(k).z < -0.999_999, "{ours} {theirs}");
        }
    }
}

#[test]
fn cornell() {
    for (file, name) in
        [("cornell/garnet_red.brdf", Some("Garnet Red")), ("cornell/acryl_blue.brdf", None)]
    {
        let Some(path) = data(file) else { return };
        let text = std::fs::read_to_string(&path).unwrap();
        let rows =
            text.lines().filter(|l| !l.starts_with('#') && !l.is_empty()).skip(3).map(numbers);
        let row = |r: Vec<f64>| (radians(r[0], r[1]), radians(r[2], r[3]), r[4..].to_vec());
        let rows: Vec<Row> = rows.map(row).collect();
        let m = only(&path);
        assert_eq!(m.sample_name.as_deref(), name);
        assert!(matches!(&m.colorimetry, Colorimetry::Spectral(bands) if bands.count() == 31));
        expect_rows(&m, &rows);
    }
}

/// The tape sends light back to where it comes from.
#[test]
fn alta() {
    let Some(path) = data("alta_retro/retro-gray-tape.dat") else { return };
    let text = std::fs::read_to_string(&path).unwrap();
    let mut rows: Vec<Row> = Vec::new();
    for r in text.lines().filter(|l| !l.starts_with('#')).map(numbers) {
        let wo = radians(r[1].hypot(r[2]), r[2].atan2(r[1]));
        if wo.z > 1e-4 {
            rows.push((radians(r[0], 0.0), wo, vec![r[3]]));
        }
    }
    let m = only(&path);
    assert_eq!(m.sample_name.as_deref(), Some("Gray Tape"));
    expect_rows(&m, &rows);
    for incidence in &m.incidences[..2] {
        let brightest = incidence.points(0).max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
        assert!(brightest.0.dot(incidence.wi) > 0.999);
    }
}

#[test]
fn zemax() {
    let Some(path) = data("rt300s/IMX455.bsdf") else { return };
    let text = std::fs::read_to_string(&path).unwrap();
    let mut lines = text.lines().filter(|l| !l.starts_with('#'));
    let mut list = |key: &str| {
        lines.find(|l| l.starts_with(key)).unwrap();
        numbers(lines.next().unwrap())
    };
    let rotations = list("SampleRotation");
    let incidences = list("AngleOfIncidence");
    let azimuths = list("ScatterAzimuth");
    let radials = list("ScatterRadial");
    let tables = lines.skip_while(|l| *l != "DataBegin").skip(1);
    let mut values =
        tables.take_while(|l| *l != "DataEnd").filter(|l| !l.starts_with("TIS")).map(numbers);
    let mut rows: Vec<Row> = Vec::new();
    for rotation in &rotations {
        for theta in &incidences {
            let wi = from_degrees(*theta, 180.0 - rotation);
            for azimuth in &azimuths {
                let row = values.next().unwrap();
                for (radial, value) in radials.iter().zip(row) {
                    let wo = about_specular(*theta, 180.0 - rotation, *radial, *azimuth);
                    let again = *rotation == 360.0
                        || *azimuth == 360.0
                        || (*radial == 0.0 && *azimuth > 0.0);
                    if wo.z > 1e-4 && !again {
                        rows.push((wi, wo, vec![value]));
                    }
                }
            }
        }
    }
    expect_rows(&only(&path), &rows);
}

/// The convention of azimuths and rotations is right: the instrument's own rows of the same sensor have their spikes there,
/// and not where a mirror image would have them. The rows are of another calibration: values differ.
#[test]
fn zemax_spikes_are_where_the_instrument_saw_them() {
    let (Some(path), Some(folder)) = (data("rt300s/IMX455.bsdf"), data("rt300s_mountain")) else {
        return;
    };
    let zemax = only(&path);
    let (mut ours, mut mirrored) = (Vec::new(), Vec::new());
    for theta in [10, 30, 50, 70] {
        for phi in [100, 120, 140, 160] {
            let own = only(&folder.join(format!("IMX455_t{theta}p{phi}.txt")));
            let own = &own.incidences[0];
            let wi = from_degrees(f64::from(theta), f64::from(phi));
            let incidence = zemax.incidences.iter().find(|i| i.wi.dot(wi) > 1.0 - 1e-9).unwrap();
            let across = DVec3::new(-wi.y, wi.x, 0.0).normalize();
            for (wo, value) in incidence.points(0).filter(|(w, v)| w.z > 0.2 && *v > 0.0) {
                let image = wo - 2.0 * wo.dot(across) * across;
                for (wo, pairs) in [(wo, &mut ours), (image, &mut mirrored)] {
                    let near =
                        own.points(0).max_by(|a, b| a.0.dot(wo).total_cmp(&b.0.dot(wo))).unwrap();
                    if near.0.dot(wo) > 1.5_f64.to_radians().cos() {
                        pairs.push((value.ln(), near.1.max(1e-6).ln()));
                    }
                }
            }
        }
    }
    let (ours, mirrored) = (correlation(&ours), correlation(&mirrored));
    assert!(ours > 0.6 && mirrored < 0.45, "{ours} {mirrored}");
}

fn correlation(pairs: &[(f64, f64)]) -> f64 {
    let n = pairs.len() as f64;
    let mean = |f: &dyn Fn(&(f64, f64)) -> f64| pairs.iter().map(f).sum::<f64>() / n;
    let (a, b) = (mean(&|p| p.0), mean(&|p| p.1));
    let of = |f: &dyn Fn(f64, f64) -> f64| mean(&|p| f(p.0 - a, p.1 - b));
    of(&|x, y| x * y) / (of(&|x, _| x * x) * of(&|_, y| y * y)).sqrt()
}

const RGL: [&str; 4] =
    ["acrylic_felt_green_rgb", "cc_ibiza_sunset_rgb", "chm_mint_rgb", "satin_purple_rgb"];

/// Points are what the function answers there; the function is held against Mitsuba by tests/interop.
#[test]
fn rgl_points_are_of_the_function() {
    for name in RGL {
        let Some(path) = data(&format!("rgl_iso/{name}.bsdf")) else { return };
        let m = only(&path);
        assert_eq!((m.incidences.len(), &m.colorimetry), (7, &Colorimetry::Xyz));
        let bsdf = open::bsdf(&path).unwrap();
        for incidence in &m.incidences {
            // Nodes of the first and the last azimuth are one place, and along the normal all are: there the file says two
            // things. Directions are kept in single precision, which moves a point in its cell.
            let (mut alike, mut count, mut sums) = (0, 0, [0.0; 2]);
            for (k, wo) in incidence.wo.iter().enumerate() {
                let [x, y, z] = incidence.point(k)[..] else { panic!() };
                let f = bsdf.eval_xyz(incidence.wi, wo);
                let off = [f64::from(x) - f.x, f64::from(y) - f.y, f64::from(z) - f.z];
                alike += usize::from(off.iter().all(|d| d.abs() < 1e-3 * f.y + 1e-5));
                count += 1;
                sums = [sums[0] + f64::from(y) * wo.z, sums[1] + f.y * wo.z];
            }
            assert!(
                alike as f64 > 0.9 * f64::from(count),
                "{name} {}: {alike} of {count}",
                incidence.wi
            );
            assert!((sums[0] / sums[1] - 1.0).abs() < 0.01, "{name} {}: {sums:?}", incidence.wi);
        }
    }
}

#[test]
fn rgl_tells_what_it_leaves_out() {
    let Some(folder) = data("rgl_iso") else { return };
    for (name, told) in [
        ("chm_mint_rgb", "nodes with R, G or B below 0"),
        ("satin_purple_rgb", "its mask says 1 for what is invalid"),
        ("acrylic_felt_green_rgb", "nodes along or below the horizon"),
        ("cc_ibiza_sunset_rgb", "read as an RGL tensor file"),
    ] {
        let m = only(&folder.join(format!("{name}.bsdf")));
        assert!(m.notes.iter().any(|n| n.contains(told)), "{name}: {:?}", m.notes);
        assert!(m.incidences.iter().all(|i| i.values.iter().all(|v| *v >= 0.0)));
    }
}
