//! Measurement files of a virtual goniophotometer.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use bsdfkit::{Error, Result};
use bsdfkit_sphere::direction::to_degrees;
use bsdfkit_sphere::{DVec3, Side};
use rayon::prelude::*;

use crate::gonio::{Goniophotometer, Scan};
use crate::material::Material;

/// What [`write_measurements`] wrote.
#[derive(Clone, Debug)]
pub struct Summary {
    /// The measurement files, in order of incidence.
    pub files: Vec<PathBuf>,
    /// Points over all files.
    pub points: usize,
}

/// Measures `material` at every incidence its symmetry asks for, and writes a Mountain file for each into `folder` (of a material
/// with wavelengths a table), the truth's parameters and the settings among its comments. `progress` hears the number of files done and to do; its error
/// stops the measurement before the next files, as many as there are threads.
///
/// Files are written under another name first and then renamed.
///
/// Errors: class argument or limit as in [`Goniophotometer::validate`]; class argument where the folder holds other
/// files, which would be taken for parts of the measurement; class io; that of `progress`.
pub fn write_measurements(
    folder: &Path,
    material: &dyn Material,
    gonio: &Goniophotometer,
    mut progress: impl FnMut(usize, usize) -> Result<()>,
) -> Result<Summary> {
    gonio.validate()?;
    fs::create_dir_all(folder).map_err(|e| Error::io(folder.display(), &e))?;
    let incidences = gonio.incidences(material);
    let extension = if material.wavelengths().is_empty() { "txt" } else { "csv" };
    let name = |&(theta, phi): &(f64, f64)| format!("i_{theta:04.1}_{phi:05.1}.{extension}");
    let seen = incidences.iter().map(|&(theta, phi)| match gonio.back_to_front {
        true => (180.0 - theta, (540.0 - phi) % 360.0),
        false => (theta, phi),
    });
    let seen: Vec<(f64, f64)> = seen.collect();
    let names: Vec<String> = seen.iter().map(name).collect();
    expect_nothing_else(folder, &names)?;
    let mut summary = Summary { files: Vec::new(), points: 0 };
    let measure = |at: usize| {
        let (theta, phi) = incidences[at];
        let scan = gonio.scan(material, theta, phi);
        let text = match extension {
            "csv" => table_text(material, gonio, seen[at], &scan),
            _ => mountain_text(material, gonio, seen[at], &scan),
        };
        (text, scan.wo.len())
    };
    // As many at once as there are threads: their texts are what takes memory.
    let all: Vec<usize> = (0..incidences.len()).collect();
    for some in all.chunks(rayon::current_num_threads()) {
        progress(some[0], incidences.len())?;
        let measured: Vec<(String, usize)> = some.par_iter().map(|&at| measure(at)).collect();
        for (&at, (text, points)) in some.iter().zip(measured) {
            let path = folder.join(&names[at]);
            replace(&path, &text)?;
            summary.points += points;
            summary.files.push(path);
        }
    }
    progress(incidences.len(), incidences.len())?;
    Ok(summary)
}

fn expect_nothing_else(folder: &Path, names: &[String]) -> Result<()> {
    let io = |e: std::io::Error| Error::io(folder.display(), &e);
    for entry in folder.read_dir().map_err(io)? {
        let found = entry.map_err(io)?.file_name();
        if !names.iter().any(|n| found == n.as_str()) {
            let message = format!("expected a new or empty folder, found {found:?} in it");
            return Err(Error::argument(message).context(folder.display()));
        }
    }
    Ok(())
}

fn replace(path: &Path, text: &str) -> Result<()> {
    let part = path.with_extension("part");
    fs::write(&part, text).map_err(|e| Error::io(part.display(), &e))?;
    fs::rename(&part, path).map_err(|e| Error::io(path.display(), &e))
}

fn mountain_text(
    material: &dyn Material,
    gonio: &Goniophotometer,
    (theta, phi): (f64, f64),
    scan: &Scan,
) -> String {
    let name = material.name();
    let mut text = format!(
        "#sample_name \"{name}\"\n{}#format: theta phi BSDF\n#incident_angle {theta} {phi}\n#intheta {theta}\n\
         #inphi {phi}\n#upphi 90\n#colorimetry: CIE-Y\n#datapoints_in_file: {}\n",
        truth(material, gonio),
        scan.wo.len()
    );
    for (&w, value) in scan.wo.iter().zip(&scan.values) {
        let (theta, phi) = to_degrees(gonio.mounted(w));
        writeln!(text, "{theta:.3} {phi:.3} {value:.5e}").expect("a string takes everything");
    }
    text
}

fn table_text(
    material: &dyn Material,
    gonio: &Goniophotometer,
    (theta, phi): (f64, f64),
    scan: &Scan,
) -> String {
    let wavelengths = material.wavelengths();
    let names: String = wavelengths.iter().map(|w| format!(",{w}nm")).collect();
    let mut text = format!(
        "#sample_name \"{}\"\n{}theta_i,phi_i,theta_o,phi_o{names}\n",
        material.name(),
        truth(material, gonio)
    );
    for (&w, bands) in scan.wo.iter().zip(scan.bands.chunks_exact(wavelengths.len())) {
        let (theta_o, phi_o) = to_degrees(gonio.mounted(w));
        write!(text, "{theta},{phi},{theta_o:.3},{phi_o:.3}").expect("a string takes everything");
        for v in bands {
            write!(text, ",{v:.4e}").expect("a string takes everything");
        }
        text.push('\n');
    }
    text
}

/// What was measured and how, as comments of a Mountain file: one key a line.
fn truth(material: &dyn Material, gonio: &Goniophotometer) -> String {
    let side = if material.scattered() == Side::Front { "reflection" } else { "transmission" };
    let mounted = if gonio.back_to_front { "back" } else { "front" };
    let retro_hole =
        if material.scattered() == Side::Front { gonio.retro_hole_degrees } else { 0.0 };
    let mut text = format!(
        "#simulated {mounted} {side}, {} symmetry\n#relative_noise {}\n#absolute_noise {}\n\
         #retro_hole_degrees {retro_hole}\n#grazing_limit_degrees {}\n#seed {}\n",
        material.symmetry().name(),
        gonio.relative_noise,
        gonio.absolute_noise,
        gonio.grazing_limit_degrees,
        gonio.seed
    );
    if !material.peaks(DVec3::Z).is_empty() {
        writeln!(text, "#aperture_degrees {}", gonio.aperture_degrees)
            .expect("a string takes everything");
    }
    for (name, value) in material.parameters() {
        writeln!(text, "#parameter {name} {value}").expect("a string takes everything");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::{Fabric, RotatedMetal};

    fn rows(path: &Path) -> Vec<Vec<f64>> {
        let text = fs::read_to_string(path).unwrap();
        let data = text.lines().filter(|line| !line.starts_with('#'));
        data.map(|line| line.split(' ').map(|word| word.parse().unwrap()).collect()).collect()
    }

    #[test]
    fn back_to_front_is_the_front_turned_about_up() {
        let gonio = Goniophotometer {
            sweeps: 4,
            points_per_sweep: 9,
            spiral_points: 5,
            ..Goniophotometer::default()
        };
        let turned = Goniophotometer { back_to_front: true, ..gonio.clone() };
        let (metal, fabric) = (RotatedMetal::default(), Fabric::default());
        for material in [&metal as &dyn Material, &fabric] {
            let folder = tempfile::tempdir().unwrap();
            let at = |name: &str| folder.path().join(name);
            let front = write_measurements(&at("front"), material, &gonio, |_, _| Ok(())).unwrap();
            let back = write_measurements(&at("back"), material, &turned, |_, _| Ok(())).unwrap();
            for (front, back) in front.files.iter().zip(&back.files) {
                for (front, back) in rows(front).iter().zip(rows(back)) {
                    assert!((front[0] + back[0] - 180.0).abs() < 2e-3);
                    let apart = (front[1] + back[1] - 180.0).rem_euclid(360.0);
                    assert!(apart.min(360.0 - apart) < 2e-3, "{front:?} {back:?}");
                    assert_eq!(front[2], back[2]);
                }
            }
            // `i_THETA_PHI.txt`: the light, too.
            let light = |path: &PathBuf| -> Vec<f64> {
                let name = path.file_stem().unwrap().to_str().unwrap();
                name.split('_').skip(1).map(|word| word.parse().unwrap()).collect()
            };
            for (front, back) in front.files.iter().zip(&back.files) {
                let (front, back) = (light(front), light(back));
                assert!((front[0] + back[0] - 180.0).abs() < 1e-9);
                assert!(
                    (front[1] + back[1] - 180.0).rem_euclid(360.0) < 1e-9,
                    "{front:?} {back:?}"
                );
            }
        }
    }
}
