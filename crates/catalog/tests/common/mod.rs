//! Small materials in a folder, and a web host for a folder.
#![allow(dead_code)]

use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};

use bsdfkit::matrix::{KlemsBasis, KlemsMatrix};
use bsdfkit::{Bsdf, Component, Lambertian, Metadata, Side, xml};
use bsdfkit_catalog::site::{self, Built, Options};
use bsdfkit_catalog::{Library, Record};
use bsdfkit_represent::Watch;

/// Diffuse of `reflectance`, with `mirrored` of the light in the mirror direction's patch.
pub(crate) fn material(reflectance: f64, mirrored: f64) -> Bsdf {
    let basis = KlemsBasis::quarter();
    let n = basis.directions();
    let value = |k: usize| {
        let peak = if k / n == k % n { mirrored / basis.projected_solid_angle(k % n) } else { 0.0 };
        (reflectance / std::f64::consts::PI + peak) as f32
    };
    let matrix = KlemsMatrix::new(basis.clone(), basis.clone(), (0..n * n).map(value).collect());
    let component = Component::new(Side::Front, Side::Front, matrix.unwrap());
    Bsdf::new(Metadata::default(), vec![component], Lambertian::default())
}

/// Writes a file and its record.
pub(crate) fn put(folder: &Path, stem: &str, bsdf: &Bsdf, record: &Record) {
    let path = folder.join(format!("{stem}.xml"));
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    xml::write(bsdf, &path, &Default::default()).unwrap();
    let record = serde_json::to_string(record).unwrap();
    fs::write(folder.join(format!("{stem}.json")), record).unwrap();
}

pub(crate) fn named(name: &str) -> Record {
    Record { name: name.into(), ..Record::default() }
}

/// Three materials: two diffusers of nearly the same reflectance, and a mirror.
pub(crate) fn three(folder: &Path) {
    let record = |name: &str, maker: &str, class: &str| Record {
        maker: maker.into(),
        class: class.into(),
        licence: "CC-BY-4.0".into(),
        ..named(name)
    };
    put(folder, "paint/white", &material(0.8, 0.0), &record("White paint", "Acme", "paint"));
    put(folder, "paint/grey", &material(0.75, 0.0), &record("Grey paint", "Bolt", "paint"));
    put(folder, "mirror", &material(0.0, 0.9), &record("Mirror of Acme street", "Silver", "metal"));
}

pub(crate) fn open(folder: &Path) -> Library {
    Library::open(folder, &Watch::default()).unwrap()
}

pub(crate) fn options() -> Options {
    Options { title: "Test & co".into(), skip_faulty: false, viewer: None }
}

pub(crate) fn build(folder: &Path, site: &Path) -> bsdfkit::Result<Built> {
    site::build(&mut open(folder), site, &options(), &Watch::default())
}

/// All files below, with slashes.
pub(crate) fn files(folder: &Path) -> Vec<String> {
    let mut found = Vec::new();
    let mut left = vec![folder.to_path_buf()];
    while let Some(next) = left.pop() {
        for entry in fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                left.push(path);
            } else {
                found.push(path.strip_prefix(folder).unwrap().to_str().unwrap().replace('\\', "/"));
            }
        }
    }
    found.sort();
    found
}

/// Serves a folder on loopback until the test ends; its address, with a slash.
pub(crate) fn serve(folder: PathBuf) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = format!("http://{}/", listener.local_addr().unwrap());
    std::thread::spawn(move || {
        for stream in listener.incoming().map_while(Result::ok) {
            let _ = answer(stream, &folder);
        }
    });
    address
}

fn answer(mut stream: TcpStream, folder: &Path) -> std::io::Result<()> {
    let mut lines = BufReader::new(stream.try_clone()?).lines();
    let first = lines.next().transpose()?.unwrap_or_default();
    while lines.next().transpose()?.is_some_and(|line| !line.is_empty()) {}
    let path = first.split(' ').nth(1).unwrap_or("/").trim_start_matches('/').to_owned();
    match fs::read(folder.join(path)) {
        Ok(bytes) => {
            // Without a length, so that what comes is only known at its end.
            write!(stream, "HTTP/1.1 200 OK\r\nConnection: close\r\n\r\n")?;
            stream.write_all(&bytes)
        }
        Err(_) => write!(
            stream,
            "HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\nConnection: close\r\n\r\n"
        ),
    }
}
