//! Makes the corpus anew: `cargo run --release -p bsdfkit-fuzz --example seeds`.

use std::fs;
use std::path::{Path, PathBuf};

use bsdfkit::specular::{Curve, Law};
use bsdfkit::xml::{self, WriteOptions};
use bsdfkit::{Bsdf, Lambertian, Metadata, Result, Side, Specular, Xyz};
use bsdfkit_catalog::Library;
use bsdfkit_catalog::site::{self, Options};
use bsdfkit_fit::deliver::{Kind, Order, Subject};
use bsdfkit_fit::interpolant::{Encoding, FitSettings, Interpolant};
use bsdfkit_fit::packed;
use bsdfkit_fuzz::mutate::Random;
use bsdfkit_measure::{Measurement, ReadOptions};
use bsdfkit_represent::Watch;
use bsdfkit_simulate::material::{BrushedMetal, FrittedGlass, PearlPaint};
use bsdfkit_simulate::{Goniophotometer, Material, write_measurements};

fn corpus() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus")
}

fn put(target: &str, name: &str, bytes: impl AsRef<[u8]>) {
    let folder = corpus().join(target);
    fs::create_dir_all(&folder).expect("a folder");
    fs::write(folder.join(name), bytes).expect("a file");
}

fn main() -> Result<()> {
    measurements();
    tables();
    virtual_specimens()?;
    put("sir", "isotropic.sir", sir(1, 3));
    put("sir", "quadrilateral.sir", sir(15, 4));
    records()?;
    let mut random = Random(4);
    for (target, longest) in [("xml_parts", 4096), ("container_parts", 128), ("c_abi", 512)] {
        for k in 0..8 {
            let length = 16 + random.bits() as usize % longest;
            let bytes: Vec<u8> = (0..length).map(|_| random.bits() as u8).collect();
            put(target, &format!("{k}"), bytes);
        }
    }
    Ok(())
}

/// Few points of few incidences.
fn measured(name: &str, material: &dyn Material, step: f64) -> Result<Vec<Measurement>> {
    let folder = tempfile::tempdir().expect("a folder");
    let gonio = Goniophotometer {
        azimuth_step_degrees: step,
        sweeps: 6,
        points_per_sweep: 24,
        spiral_points: 30,
        ..Goniophotometer::default()
    };
    let written = write_measurements(folder.path(), material, &gonio, |_, _| Ok(()))?;
    let some = &written.files[written.files.len() / 2];
    let text = fs::read_to_string(some).expect("was written");
    let lines = text.lines().take(if text.len() > 20_000 { 12 } else { 60 });
    let cut: String = lines.flat_map(|line| [line, "\n"]).collect();
    put("measurement", &format!("virtual-{name}"), cut);
    bsdfkit_measure::read(&[folder.path().to_owned()], &ReadOptions::default())
}

/// Containers of every kind, and XML with peaks of no width.
fn virtual_specimens() -> Result<()> {
    let settings = FitSettings { detail_cells: 8, ..FitSettings::default() };
    let specimens: [(&str, &dyn Material, Encoding); 3] = [
        ("glass", &FrittedGlass::default(), Encoding::Plain),
        ("metal", &BrushedMetal::default(), Encoding::Compact),
        ("paint", &PearlPaint::default(), Encoding::Compact),
    ];
    for (name, material, encoding) in specimens {
        let mut m = measured(name, material, 45.0)?;
        // Every second polar angle is enough for a mesh.
        let thetas: Vec<i64> = m[0].incidences.iter().map(|i| (i.wi.z * 1e3) as i64).collect();
        let mut distinct = thetas.clone();
        distinct.dedup();
        m[0].incidences.retain(|i| {
            let at = distinct.iter().position(|z| *z == (i.wi.z * 1e3) as i64);
            at.is_some_and(|at| at.is_multiple_of(3))
        });
        let interpolant = Interpolant::fit(&m, &settings, &Watch::default())?;
        put("container", &format!("{name}.safetensors"), interpolant.to_bytes(encoding)?);
        if name == "glass" {
            put("measurement", "packed", packed::to_bytes(&m)?);
            let order = Order::new(Kind::TensorTree);
            let order = Order { max_leaves: Some(300), ..order };
            let subject = Subject::Continuous(&interpolant);
            let tree = order.deliver(subject, Metadata::default(), &Watch::default())?.bsdf;
            put("container", "tree.safetensors", bsdfkit::container::to_bytes(&tree)?);
        }
    }
    let curve = Curve::tabulated(7, 1, |w| Xyz::grey(0.2 + 0.5 * w.z))?;
    let peaks = vec![
        Specular::new((Side::Front, Side::Front), Law::OPPOSITE, curve.clone()),
        Specular::new((Side::Front, Side::Back), Law::OPPOSITE, curve),
    ];
    let diffuse = Lambertian { reflection_front: Xyz::grey(0.2), ..Lambertian::default() };
    let bsdf = Bsdf::new(Metadata::default(), Vec::new(), diffuse).with_specular(peaks);
    let mut text = Vec::new();
    xml::write_to(&bsdf, &mut text, &WriteOptions::default())?;
    put("xml", "peaks.xml", text);
    put("container", "peaks.safetensors", bsdfkit::container::to_bytes(&bsdf)?);
    Ok(())
}

const ZEMAX: &str = "Source Measured\nSymmetry Asymmetrical\nSpectralContent Monochrome\nScatterType BRDF\n\
SampleRotation 1\n0\nAngleOfIncidence 2\n0 40\nScatterAzimuth 3\n0 120 240\nScatterRadial 2\n0 30\n\
Monochrome\nDataBegin\nTIS 0.1\n1 2\n1 2\n1 2\nTIS 0.1\n3 4\n3 4\n3 4\nDataEnd\n";

const PLANE: &str = "Source Measured\nSymmetry PlaneSymmetrical\nSpectralContent XYZ\nScatterType BTDF\n\
SampleRotation 2\n0 90\nAngleOfIncidence 1\n20\nScatterAzimuth 2\n0 180\nScatterRadial 3\n0 30 60\n\
TristimulusX\nDataBegin\nTIS 0.1\n1 2 1\n1 2 1\nTIS 0.1\n3 4 1\n3 4 1\nDataEnd\n\
TristimulusY\nDataBegin\nTIS 0.1\n1 2 1\n1 2 1\nTIS 0.1\n3 4 1\n3 4 1\nDataEnd\n\
TristimulusZ\nDataBegin\nTIS 0.1\n1 2 1\n1 2 1\nTIS 0.1\n3 4 1\n3 4 1\nDataEnd\n";

const OTHERS: [(&str, &str); 10] = [
    (
        "lighttools",
        "Symmetry Asymmetric\nSpectralContent Monochrome\nScatterAzimuth 2\n0 180\nScatterRadial 2\n0 30\n\
DataBegin\nAOI 0\nPOI 0\nSide Front\nWavelength 550\nScatterType BRDF\nTIS 0.1\n1 2\n1 2\nAOI 30\nTIS 0.1\n3 4\n3 4\nDataEnd\n",
    ),
    ("astm", "NUM_POINTS 2\nVARS theta_i,phi_i,theta_s,phi_s,BRDF\n0.1,0,0.2,0,1\n0.1,0,0.3,0,2\n"),
    ("fred", "!!EDS10 0-0 RPC Photonics\n!!BSDF Data\n0 0\n0 0 1\n10 0 2\n"),
    ("cornell", "# Cornell\n# Red\n# num wls\n2\n# wls\n400 500\n# rows\n0.1 0 0.2 0 1 2\n"),
    (
        "bird",
        r#"{"metadata": {"type": "BRDF", "sample": {"name": "a"}}, "data": {"theta_i": {"unit": "deg", "values": [10, 10]},
"phi_i": {"unit": "deg", "values": [0, 0]}, "theta_r": {"unit": "rad", "values": [0.2, 0.3]}, "phi_r": {"unit": "deg", "values": [0, 90]},
"wavelength_i": {"unit": "nm", "values": [550, 550]}, "polarization_i": {"notation": "sp", "values": ["u", "u"]},
"BRDF": {"unit": "sr^-1", "values": [1, 2]}}}"#,
    ),
    ("alta", "#DIM 3 1\n#VS 0\n#PARAM_IN ISOTROPIC_TV_TL_DPHI\n0.2 0.1 0 1\n"),
    (
        "mountain",
        "#sample_name \"a\"\n#intheta 30\n#inphi 0\n#upphi 90\n#format: theta phi DSF\n10 0 0.5\n20 90 0.4\n-30 180 .3\n170 3 0.1\n",
    ),
    (
        "semicolons",
        "sep=;\n\"theta_i [rad]\";phi_i;theta_o;phi_o;450nm;550nm;650nm\n0,1;0;10;0;1;2;3\n0,1;0;20;0;1;2;3\n0,4;0;20;0;1;2;3\n",
    ),
    (
        "xyz",
        "# sample_name: b\ntheta_i,phi_i,theta_o,phi_o,x,y,z\n0,0,10,0,1,2,3\n40,0,10,90,1,2,3\n40,90,100,0,.1,.2,.3\n",
    ),
    (
        "blanks",
        "theta_in\tphi_in\ttheta_out\tphi_out\tBRDF*cos\tsigma\n0\t0\t10\t0\t1\t0.1\n60\t180\t10\t0\t1\t0.1\n",
    ),
];

fn measurements() {
    for (name, text) in OTHERS {
        put("measurement", name, text);
    }
    put("measurement", "zemax", ZEMAX);
    let utf16 = OTHERS[6].1.encode_utf16().flat_map(u16::to_le_bytes);
    put("measurement", "utf-16", [vec![0xff, 0xfe], utf16.collect()].concat());
    put("measurement", "rgl", tensors(false));
}

fn tables() {
    put("tables", "zemax", ZEMAX);
    put("tables", "zemax-plane", PLANE);
    put("tables", "rgl", tensors(false));
    put("tables", "rgl-spectra", tensors(true));
    let counts = [90_i32, 90, 180].into_iter().flat_map(i32::to_le_bytes);
    put("tables", "merl-cut", counts.chain([0; 64]).collect::<Vec<u8>>());
}

/// A small file of RGL's: name, type, shape, bytes.
fn tensors(spectra: bool) -> Vec<u8> {
    let floats = |name: &'static str, shape: &[u64], value: &dyn Fn(u64) -> f32| {
        let count: u64 = shape.iter().product();
        let bytes: Vec<u8> = (0..count).flat_map(|k| value(k).to_le_bytes()).collect();
        (name, 10, shape.to_vec(), bytes)
    };
    let mut all = vec![
        floats("theta_i", &[3], &|k| 0.5 * k as f32),
        floats("phi_i", &[1], &|_| 0.0),
        floats("ndf", &[2, 2], &|_| 4.0),
        floats("sigma", &[2, 2], &|_| 1.0),
        floats("vndf", &[1, 3, 4, 4], &|k| 1.0 + (k % 3) as f32),
        ("valid", 1, vec![6], vec![0xff; 6]),
    ];
    if spectra {
        all.push(floats("wavelengths", &[9], &|k| 380.0 + 50.0 * k as f32));
        all.push(floats("spectra", &[1, 3, 9, 4, 4], &|k| 0.1 + (k % 5) as f32));
    } else {
        all.push(floats("rgb", &[1, 3, 3, 4, 4], &|k| 0.1 + (k % 5) as f32));
    }
    let mut file = b"tensor_file\0\x01\x00".to_vec();
    file.extend((all.len() as u32).to_le_bytes());
    let head: usize = all.iter().map(|(n, _, s, _)| 2 + n.len() + 2 + 1 + 8 + 8 * s.len()).sum();
    let mut at = (file.len() + head) as u64;
    for (name, kind, shape, bytes) in &all {
        file.extend((name.len() as u16).to_le_bytes());
        file.extend(name.as_bytes());
        file.extend((shape.len() as u16).to_le_bytes());
        file.push(*kind);
        file.extend(at.to_le_bytes());
        shape.iter().for_each(|n| file.extend(n.to_le_bytes()));
        at += bytes.len() as u64;
    }
    all.iter().for_each(|(_, _, _, bytes)| file.extend(bytes));
    file
}

/// A file of `nodes` nodes with two lobes each, neighbours joined; `symmetry` is Radiance's code.
fn sir(symmetry: u32, nodes: u32) -> Vec<u8> {
    let float = |x: f64| {
        let exponent = if x == 0.0 { 0 } else { x.abs().log2().floor() as i32 + 1 };
        let mantissa = (x / f64::from(exponent).exp2() * f64::from(i32::MAX)) as i32;
        [&mantissa.to_be_bytes()[..], &(exponent as i8).to_be_bytes()].concat()
    };
    let mut bytes = format!(
        "#?RADIANCE\nNAME=a\nSYMMETRY={symmetry}\nIO_SIDES= 1 1\nCOLORIMETRY=CIE-XYZ\nGRIDRES=256\n\
         BSDFMIN=0.001\nBSDFSPEC= 0.5 0.2\nFORMAT=BSDF_RBFmesh\n\n"
    )
    .into_bytes();
    bytes.extend(b"\x5a\x3c");
    for k in 0..nodes {
        bytes.extend(k.to_be_bytes());
        let theta = (1.0 + 80.0 * f64::from(k) / f64::from(nodes)).to_radians();
        let phi = (if symmetry == 1 { 0.0 } else { 30.0 * f64::from(k) }).to_radians();
        let w = [theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()];
        w.into_iter().chain([0.5]).for_each(|x| bytes.extend(float(x)));
        bytes.extend(2_u32.to_be_bytes());
        for cell in [100, 140] {
            bytes.extend(float(0.1));
            [49750_u16, 1000, cell, 100].into_iter().for_each(|x| bytes.extend(x.to_be_bytes()));
        }
    }
    bytes.extend((-1_i32).to_be_bytes());
    for from in 0..nodes {
        for to in from + 1..nodes.min(if symmetry == 1 { from + 2 } else { nodes }) {
            bytes.extend([from.to_be_bytes(), to.to_be_bytes()].concat());
            for zeros in [0, 2] {
                bytes.push(zeros);
                bytes.extend(float(1.0));
            }
            bytes.push(0);
        }
    }
    bytes.extend([-1_i32, -1].map(i32::to_be_bytes).concat());
    bytes
}

/// A component of BED-JSON with one total and one point that is none.
const BED: &str = r#"{"components": [{"id": "11aa", "name": "Float glass", "roles": {"manufacturer": {"name": "Acme"}},
 "categories": {"componentType": ["layer"]}, "optical": [{"id": {"value": "22bb"}, "timestamp": "2021-06-09T04:26:06+00:00",
 "appliedMethod": {"method": {"name": "sphere"}}, "data": [{"data": [{"componentCharacteristics": {"surface": "prime"}, "dataPoints": [
 {"incidence": {"direction": {"polar": 8, "azimuth": 90}, "wavelengths": {"integral": "visible"}, "polarization": {"s": 0.5, "p": 0.5}},
 "emergence": {"direction": "hemispherical"}, "results": {"reflectance": {"uncertainValue": 0.08, "uncertainty": 0.01,
 "confidenceInterval": 95.4}, "transmittance": 0.8}},
 {"incidence": {"direction": "hemispherical", "wavelengths": {"wavelength": 550}},
 "emergence": {"direction": {"polar": 8}}, "results": {"reflectance": 0.1}}]}]}]}]}]}"#;

fn records() -> Result<()> {
    let toml = "name = \"Brushed metal\"\nmaker = \"Acme\"\nclass = \"metal\"\nlicence = \"CC-BY-4.0 OR MIT\"\n\
                date = 2024-02-29\ndoi = \"https://doi.org/10.5281/zenodo.1\"\nnotes = \"\"\"two\nlines\"\"\"\n";
    put("record", "record.toml", toml);
    let json =
        r#"{"title": "A", "licence": "CC0-1.0", "date": "2024-02", "doi": "10.5281/zenodo.1"}"#;
    put("record", "record.json", json);
    put("record", "bed.json", BED);
    put("record", "comment", format!("bsdfkit record: {json}"));
    let folder = tempfile::tempdir().expect("a folder");
    let [library, made] = ["library", "site"].map(|name| folder.path().join(name));
    fs::create_dir(&library).expect("a folder");
    let diffuse = Lambertian { reflection_front: Xyz::grey(0.2), ..Lambertian::default() };
    let bsdf = Bsdf::new(Metadata::default(), Vec::new(), diffuse);
    xml::write(&bsdf, library.join("a.xml"), &WriteOptions::default())?;
    let mut library = Library::open(&library, &Watch::default())?;
    let options = Options { title: "a".into(), skip_faulty: false, viewer: None };
    site::build(&mut library, &made, &options, &Watch::default())?;
    put("record", "index.json", fs::read(made.join("index.json")).expect("was written"));
    Ok(())
}
