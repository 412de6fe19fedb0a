//! MERL's tables over half and difference angles.

use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

use bsdfkit::limits::{MAGNITUDE, is_plausible};
use bsdfkit::{DVec3, Result, Side, Xyz};
use bsdfkit_sphere::direction::from_degrees;

use super::Whole;
use bsdfkit_represent::dense::{Dense, mirror_peak};

use super::DenseFile;
use crate::Colorimetry;
use crate::block::{Block, FileContent, HORIZON_COSINE, Remark};
use bsdfkit_represent::{Peak, Slice, Source};

/// Cells along θh, θd and φd; φd runs over half a turn.
const CELLS: [usize; 3] = [90, 90, 180];
/// Cells of one colour.
const COUNT: usize = CELLS[0] * CELLS[1] * CELLS[2];
/// What stored red, green and blue are multiplied with to be f.
const SCALES: [f64; 3] = [1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0];
/// Three counts, then numbers of 8 bytes by colour.
const BYTES: usize = 12 + 3 * 8 * COUNT;

/// Incident polar angles that are handed on as a measurement, degrees: the instrument saw little past 80.
const INCIDENT_DEGREES: [f64; 17] = [
    0.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0, 45.0, 50.0, 55.0, 60.0, 65.0, 70.0, 75.0,
    80.0,
];

/// Azimuths of half vectors there.
const AZIMUTHS: usize = 72;

/// Reflection of the front, isotropic: constant in each cell, as the makers' program reads it.
#[derive(Debug)]
struct Merl {
    /// Y, X, Z by cell; NaN where a colour is below 0, which marks what was not measured.
    cells: Vec<[f32; 3]>,
}

impl Merl {
    /// Errors: the message for counts and sizes that are not MERL's, and for what is not finite.
    fn from_bytes(bytes: &[u8]) -> std::result::Result<Self, String> {
        let count = |k: usize| {
            bytes.get(4 * k..4 * k + 4).map(|b| i32::from_le_bytes([b[0], b[1], b[2], b[3]]))
        };
        let counts = [count(0), count(1), count(2)].map(|c| c.unwrap_or(0));
        if counts != CELLS.map(|c| c as i32) {
            return Err(format!("expected {CELLS:?} cells, found {counts:?}"));
        }
        if bytes.len() != BYTES {
            return Err(format!("expected {BYTES} bytes, found {}", bytes.len()));
        }
        let number = |k: usize| {
            let at = 12 + 8 * k;
            f64::from_le_bytes(bytes[at..at + 8].try_into().unwrap_or_default())
        };
        let mut cells = Vec::with_capacity(COUNT);
        for k in 0..COUNT {
            let rgb = [0, 1, 2].map(|c| SCALES[c] * number(c * COUNT + k));
            if let Some(v) = rgb.iter().find(|v| !is_plausible(**v)) {
                return Err(format!(
                    "cell {k}: expected a finite value of at most {MAGNITUDE:e}, found {v}"
                ));
            }
            let Xyz { x, y, z } = Xyz::from_linear_rgb(rgb);
            let known = rgb.iter().all(|v| *v >= 0.0);
            cells.push(if known { [y as f32, x as f32, z as f32] } else { [f32::NAN; 3] });
        }
        Ok(Self { cells })
    }

    /// Y, X, Z of f in 1/sr; NaN where nothing was measured.
    fn value(&self, wi: DVec3, wo: DVec3) -> [f32; 3] {
        self.cells[cell(wi, wo)]
    }
}

/// The cell of two directions above the horizon.
fn cell(wi: DVec3, wo: DVec3) -> usize {
    let h = (wi + wo).normalize();
    let radius = h.truncate().length();
    let theta_h = radius.atan2(h.z);
    // The frame of h: z along it, x in its plane with the normal, away from the normal.
    let (sin, cos) = if radius > 0.0 { (h.y / radius, h.x / radius) } else { (0.0, 1.0) };
    let y = DVec3::new(-sin, cos, 0.0);
    let x = y.cross(h);
    let d = DVec3::new(wi.dot(x), wi.dot(y), wi.dot(h));
    let theta_d = d.truncate().length().atan2(d.z);
    let phi_d = d.y.atan2(d.x);
    let phi_d = if phi_d < 0.0 { phi_d + PI } else { phi_d };
    let index = |share: f64, k: usize| ((share * CELLS[k] as f64) as usize).min(CELLS[k] - 1);
    let i = index((theta_h / FRAC_PI_2).max(0.0).sqrt(), 0);
    let j = index(theta_d / FRAC_PI_2, 1);
    (i * CELLS[1] + j) * CELLS[2] + index(phi_d / PI, 2)
}

/// Reads such a file: f about half vectors in the middle of the cells along θh, as CIE XYZ, at incidences every 5 degrees.
///
/// Convention: what is below 0 was not measured; it is counted and left out.
/// Errors: class format: counts and sizes other than MERL's.
pub(super) fn read(whole: &Whole<'_>) -> Result<FileContent> {
    let merl = Merl::from_bytes(whole.bytes).map_err(|m| whole.error(m))?;
    let (mut blocks, mut unknown) = (Vec::new(), 0_usize);
    for theta in INCIDENT_DEGREES {
        let wi = from_degrees(theta, 0.0);
        let mut block = Block::new(wi);
        let mut add = |h: DVec3| {
            let wo = 2.0 * wi.dot(h) * h - wi;
            if wi.dot(h) <= 0.0 || wo.z < HORIZON_COSINE {
                return;
            }
            match merl.value(wi, wo) {
                [y, x, z] if y >= 0.0 => {
                    block.wo.push(wo);
                    block.values.extend([x, y, z].map(|v| v.max(0.0)));
                }
                _ => unknown += 1,
            }
        };
        for k in 0..CELLS[0] {
            let middle = (k as f64 + 0.5) / CELLS[0] as f64;
            let azimuths = if k == 0 { 8 } else { AZIMUTHS };
            for a in 0..azimuths {
                let phi = 360.0 * (a as f64 + 0.5) / azimuths as f64;
                add(from_degrees(90.0 * middle * middle, phi));
            }
        }
        whole.budget.spend_all(block.wo.len() as u64, 3, whole.path)?;
        blocks.push(block);
    }
    let invalid = merl.cells.iter().filter(|c| c[0].is_nan()).count();
    let mut remarks = Vec::new();
    if invalid > 0 {
        remarks.push(Remark::of_file(format!(
            "{invalid} of {COUNT} cells are below 0, so not measured: {unknown} points left out"
        )));
    }
    let (path, colorimetry) = (whole.path.to_owned(), Colorimetry::Xyz);
    Ok(FileContent {
        path,
        sample_name: name_of(whole),
        colorimetry,
        blocks,
        remarks,
        wavelength: None,
    })
}

/// Files do not name their material but by their own name.
fn name_of(whole: &Whole<'_>) -> Option<String> {
    Some(whole.path.file_stem()?.to_string_lossy().into_owned())
}

/// The function of a file; what was not measured is 0.
///
/// Errors: as [`read`].
pub(super) fn dense(whole: &Whole<'_>) -> Result<DenseFile> {
    let merl = Merl::from_bytes(whole.bytes).map_err(|m| whole.error(m))?;
    Ok(DenseFile { name: name_of(whole), functions: vec![Arc::new(merl)] })
}

impl Source for Merl {
    fn incident(&self) -> Side {
        Side::Front
    }

    fn scattered(&self) -> Side {
        Side::Front
    }

    fn isotropic(&self) -> bool {
        true
    }

    fn channels(&self) -> usize {
        3
    }

    fn slice<'a>(&'a self, wi: DVec3) -> Box<dyn Slice + 'a> {
        Box::new(At { merl: self, wi })
    }
}

impl Dense for Merl {
    fn incidences(&self) -> usize {
        CELLS[1]
    }

    fn structure(&self) -> &'static str {
        "MERL's cells of half and difference angles"
    }
}

/// One incident direction.
struct At<'a> {
    merl: &'a Merl,
    wi: DVec3,
}

impl Slice for At<'_> {
    fn eval(&self, wo: &[DVec3], out: &mut [f32]) {
        for (wo, out) in wo.iter().zip(out.chunks_exact_mut(3)) {
            let above = self.wi.z > 0.0 && wo.z > 0.0;
            let value = if above { self.merl.value(self.wi, *wo) } else { [0.0; 3] };
            out.copy_from_slice(&value.map(|v| if v > 0.0 { v } else { 0.0 }));
        }
    }

    fn peaks(&self, out: &mut Vec<Peak>) {
        out.push(mirror_peak(self, self.wi, 3));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The makers' definition, step by step: turn by −φh about z, then by −θh about y.
    fn slowly(wi: DVec3, wo: DVec3) -> [f64; 3] {
        let h = (wi + wo).normalize();
        let (theta_h, phi_h) = (h.z.clamp(-1.0, 1.0).acos(), h.y.atan2(h.x));
        let turn = |w: DVec3, angle: f64| {
            let (s, c) = angle.sin_cos();
            DVec3::new(c * w.x - s * w.y, s * w.x + c * w.y, w.z)
        };
        let about_z = turn(wi, -phi_h);
        let (s, c) = (-theta_h).sin_cos();
        let d = DVec3::new(c * about_z.x + s * about_z.z, about_z.y, c * about_z.z - s * about_z.x);
        let phi_d = d.y.atan2(d.x);
        [theta_h, d.z.clamp(-1.0, 1.0).acos(), if phi_d < 0.0 { phi_d + PI } else { phi_d }]
    }

    #[test]
    fn cells_are_the_makers() {
        let mut seen = 0;
        for k in 0..20_000_u32 {
            let of = |m: u32, n: u32| f64::from(m.wrapping_mul(2_654_435_761) % n);
            let wi = from_degrees(of(k, 890) / 10.0, of(k + 7, 3600) / 10.0);
            let wo = from_degrees(of(k + 13, 891) / 10.0, of(k + 29, 3601) / 10.0);
            let [theta_h, theta_d, phi_d] = slowly(wi, wo);
            let place =
                [(theta_h.to_degrees() * 90.0).sqrt(), theta_d.to_degrees(), phi_d.to_degrees()];
            // Away from the border between two cells, where rounding decides.
            if place.iter().any(|x| (x - x.round()).abs() < 1e-6) {
                continue;
            }
            seen += 1;
            let [i, j, l] = place.map(|x| x as usize);
            assert_eq!(cell(wi, wo), (i * 90 + j) * 180 + l, "{wi} {wo}");
        }
        assert!(seen > 19_000);
    }

    #[test]
    fn sizes_are_merls_or_nothing() {
        let head =
            |counts: [i32; 3]| counts.into_iter().flat_map(i32::to_le_bytes).collect::<Vec<u8>>();
        let short = Merl::from_bytes(&head([90, 90, 180])).unwrap_err();
        assert!(short.contains(&format!("expected {BYTES} bytes, found 12")), "{short}");
        let double = Merl::from_bytes(&head([90, 90, 360])).unwrap_err();
        assert!(double.contains("[90, 90, 360]"), "{double}");
    }
}
