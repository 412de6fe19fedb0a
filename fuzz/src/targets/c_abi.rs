//! The C library by its own names: bytes opened, numbers of any value, counts that do not fit.
#![allow(unsafe_code, reason = "functions of C; each call says why its pointers hold")]

use std::ffi::{CStr, CString, c_char, c_int};
use std::ptr::{null, null_mut};
use std::sync::OnceLock;

use arbitrary::{Arbitrary, Result, Unstructured};
use bsdfkit_c_abi as _;

use crate::corpus;
use crate::scratch::with_file;

/// `bsdfkit_bsdf`.
#[repr(C)]
struct Bsdf([u8; 0]);

/// `bsdfkit_error`.
#[repr(C)]
struct Error([u8; 0]);

/// `bsdfkit_component` and `bsdfkit_sample` are written into as many words, of which neither needs more.
type Record = [u64; 32];

#[rustfmt::skip]
unsafe extern "C" {
    fn bsdfkit_open(path: *const c_char, error: *mut *mut Error) -> *mut Bsdf;
    fn bsdfkit_open_memory(bytes: *const u8, length: usize, error: *mut *mut Error) -> *mut Bsdf;
    fn bsdfkit_open_smooth(bsdf: *const Bsdf, error: *mut *mut Error) -> *mut Bsdf;
    fn bsdfkit_close(bsdf: *mut Bsdf);
    fn bsdfkit_error_class(error: *const Error) -> c_int;
    fn bsdfkit_error_message(error: *const Error) -> *const c_char;
    fn bsdfkit_error_free(error: *mut Error);
    fn bsdfkit_name(bsdf: *const Bsdf) -> *const c_char;
    fn bsdfkit_property_count(bsdf: *const Bsdf) -> usize;
    fn bsdfkit_property_key(bsdf: *const Bsdf, index: usize) -> *const c_char;
    fn bsdfkit_property_value(bsdf: *const Bsdf, index: usize) -> *const c_char;
    fn bsdfkit_component_count(bsdf: *const Bsdf) -> usize;
    fn bsdfkit_component_at(bsdf: *const Bsdf, index: usize, out: *mut Record, error: *mut *mut Error) -> c_int;
    fn bsdfkit_tree_at(bsdf: *const Bsdf, index: usize, out: *mut Record, error: *mut *mut Error) -> c_int;
    fn bsdfkit_matrix_at(bsdf: *const Bsdf, index: usize, out: *mut Record, error: *mut *mut Error) -> c_int;
    fn bsdfkit_eval(bsdf: *const Bsdf, wi: *const f64, wo: *const f64) -> f64;
    fn bsdfkit_eval_xyz(bsdf: *const Bsdf, wi: *const f64, wo: *const f64, xyz: *mut f64);
    fn bsdfkit_pdf(bsdf: *const Bsdf, wi: *const f64, wo: *const f64, components: u32) -> f64;
    fn bsdfkit_hemispherical(bsdf: *const Bsdf, wi: *const f64, components: u32) -> f64;
    fn bsdfkit_projected_solid_angle(bsdf: *const Bsdf, wi: *const f64, wo: *const f64, range: *mut f64);
    fn bsdfkit_sample_1(bsdf: *const Bsdf, wi: *const f64, u: f64, components: u32, out: *mut Record) -> c_int;
    fn bsdfkit_sample_2(bsdf: *const Bsdf, wi: *const f64, u: *const f64, components: u32, out: *mut Record) -> c_int;
    fn bsdfkit_eval_many(bsdf: *const Bsdf, wi: *const f64, wi_count: usize, wo: *const f64, wo_count: usize, out: *mut f64, count: usize, error: *mut *mut Error) -> c_int;
    fn bsdfkit_sample_1_many(bsdf: *const Bsdf, wi: *const f64, wi_count: usize, u: *const f64, u_count: usize, components: u32, out: *mut u64, count: usize, error: *mut *mut Error) -> c_int;
    fn bsdfkit_frame_new(normal: *const f64, up: *const f64, out: *mut f64, error: *mut *mut Error) -> c_int;
}

/// Words of a `bsdfkit_sample`.
const SAMPLE: usize = 6;

/// `BSDFKIT_INTERNAL`: a panic was caught.
const INTERNAL: c_int = 5;

/// Bytes as a file to open, or as what is asked of one that is sound.
pub fn c_abi(bytes: &[u8]) {
    let mut choices = Unstructured::new(bytes);
    // Ends where the bytes do.
    let _ = calls(&mut choices);
}

/// Handles on what the corpus has, never closed.
fn sound() -> &'static [usize] {
    static OPEN: OnceLock<Vec<usize>> = OnceLock::new();
    OPEN.get_or_init(|| {
        corpus::containers().iter().map(|b| open(b).expect("sound") as usize).collect()
    })
}

fn open(bytes: &[u8]) -> Option<*mut Bsdf> {
    let mut error = null_mut();
    // SAFETY: the slice lives, and the error is ours.
    let bsdf = unsafe { bsdfkit_open_memory(bytes.as_ptr(), bytes.len(), &raw mut error) };
    failed(error, bsdf.is_null());
    (!bsdf.is_null()).then_some(bsdf)
}

/// Looks at an error, if there is one, and gives it back.
fn failed(error: *mut Error, expected: bool) {
    assert_eq!(expected, !error.is_null(), "an error when and only when a call failed");
    // SAFETY: null, or what the call handed out, not yet given back.
    unsafe {
        let class = bsdfkit_error_class(error);
        let message = CStr::from_ptr(bsdfkit_error_message(error)).to_string_lossy().into_owned();
        assert_ne!(class, INTERNAL, "{message}");
        bsdfkit_error_free(error);
    }
}

fn calls(choices: &mut Unstructured<'_>) -> Result<()> {
    match choices.int_in_range(0..=7)? {
        0 => {
            let bytes = choices.bytes(choices.len())?;
            with_file("opened", bytes, |path| {
                let path = CString::new(path.to_str().expect("UTF-8")).expect("no zero");
                let mut error = null_mut();
                // SAFETY: the path lives, and the error is ours.
                let bsdf = unsafe { bsdfkit_open(path.as_ptr(), &raw mut error) };
                failed(error, bsdf.is_null());
                // SAFETY: null, or open and closed once.
                unsafe { bsdfkit_close(bsdf) };
            });
            Ok(())
        }
        1 => {
            let Some(bsdf) = open(choices.bytes(choices.len())?) else { return Ok(()) };
            let fixed = [0x3b; 400];
            let asked = ask(bsdf, &mut Unstructured::new(&fixed));
            // SAFETY: open, and closed once, after all other calls.
            unsafe { bsdfkit_close(bsdf) };
            asked
        }
        2 => ask(null_mut(), choices),
        3 => {
            let bsdf = *choices.choose(sound())? as *mut Bsdf;
            let mut error = null_mut();
            // SAFETY: the handle is open; the second one is closed once.
            unsafe {
                let smooth = bsdfkit_open_smooth(bsdf, &raw mut error);
                failed(error, smooth.is_null());
                let asked = ask(smooth, choices);
                bsdfkit_close(smooth);
                asked
            }
        }
        _ => ask(*choices.choose(sound())? as *mut Bsdf, choices),
    }
}

/// Three numbers, or no pointer to them.
fn vector(choices: &mut Unstructured<'_>) -> Result<Option<[f64; 3]>> {
    Ok(match choices.int_in_range(0..=7)? {
        0 => None,
        1 => Some(<[f64; 3]>::arbitrary(choices)?),
        2 => Some(crate::DIRECTIONS[choices.choose_index(crate::DIRECTIONS.len())?].to_array()),
        _ => {
            let v = <[i8; 3]>::arbitrary(choices)?.map(f64::from);
            let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
            Some(v.map(|x| x / length))
        }
    })
}

fn pointer<const N: usize>(v: &Option<[f64; N]>) -> *const f64 {
    v.as_ref().map_or(null(), |v| v.as_ptr())
}

/// All that can be asked, in a loop until choices run out.
fn ask(bsdf: *mut Bsdf, choices: &mut Unstructured<'_>) -> Result<()> {
    for _ in 0..16 {
        one(bsdf, choices)?;
    }
    Ok(())
}

fn one(bsdf: *const Bsdf, choices: &mut Unstructured<'_>) -> Result<()> {
    let (wi, wo) = (vector(choices)?, vector(choices)?);
    let (i, o) = (pointer(&wi), pointer(&wo));
    let components = *choices.choose(&[63, 0, 1, 2, 4, 8, 64, 128, u32::MAX])?;
    let index = choices.int_in_range(0..=4)?;
    let u = f64::from(u8::arbitrary(choices)?) / 255.0;
    let mut record: Record = [0; 32];
    let out = &raw mut record;
    let mut xyz = [0.0; 3];
    let mut error = null_mut();
    // SAFETY: every pointer is null or leads to as much as the header asks for; errors are given back.
    unsafe {
        match choices.int_in_range(0..=9)? {
            0 => drop(bsdfkit_eval(bsdf, i, o)),
            1 => bsdfkit_eval_xyz(bsdf, i, o, xyz.as_mut_ptr()),
            2 => drop(bsdfkit_pdf(bsdf, i, o, components)),
            3 => drop(bsdfkit_hemispherical(bsdf, i, components)),
            4 => bsdfkit_projected_solid_angle(bsdf, i, o, xyz.as_mut_ptr()),
            5 => drop(bsdfkit_sample_1(bsdf, i, u, components, out)),
            6 => drop(bsdfkit_sample_2(bsdf, i, [u, 0.5].as_ptr(), components, out)),
            7 => {
                let at = [bsdfkit_component_at, bsdfkit_tree_at, bsdfkit_matrix_at];
                let status = at[choices.choose_index(3)?](bsdf, index, out, &raw mut error);
                failed(error, status != 0);
                let names = [
                    bsdfkit_name(bsdf),
                    bsdfkit_property_key(bsdf, index),
                    bsdfkit_property_value(bsdf, index),
                ];
                for name in names.into_iter().filter(|name| !name.is_null()) {
                    let _ = CStr::from_ptr(name).to_bytes();
                }
                bsdfkit_property_count(bsdf);
                bsdfkit_component_count(bsdf);
            }
            8 => {
                let status = bsdfkit_frame_new(i, o, record.as_mut_ptr().cast(), &raw mut error);
                failed(error, status != 0);
            }
            _ => many(bsdf, &wi, components, choices)?,
        }
    }
    Ok(())
}

/// Batches with buffers of exactly as much as their counts say.
fn many(
    bsdf: *const Bsdf,
    wi: &Option<[f64; 3]>,
    components: u32,
    choices: &mut Unstructured<'_>,
) -> Result<()> {
    let count = choices.int_in_range(0..=20)?;
    let of = |choices: &mut Unstructured<'_>| -> Result<usize> {
        Ok(*choices.choose(&[count, 1, count + 1])?)
    };
    let (wi_count, wo_count) = (of(choices)?, of(choices)?);
    let wi = wi.map(|v| v.repeat(wi_count));
    let wo: Vec<f64> = (0..3 * wo_count).map(|k| [0.0, 0.6, 0.8][k % 3]).collect();
    let u: Vec<f64> = (0..wo_count).map(|k| k as f64 / 7.0).collect();
    let first = wi.as_ref().map_or(null(), Vec::as_ptr);
    let mut values = vec![0.0; count];
    let mut samples = vec![0; SAMPLE * count];
    let mut error = null_mut();
    // SAFETY: each buffer has as many elements as its count says, or is null.
    unsafe {
        let out = values.as_mut_ptr();
        let wo = wo.as_ptr();
        let status =
            bsdfkit_eval_many(bsdf, first, wi_count, wo, wo_count, out, count, &raw mut error);
        failed(error, status != 0);
        error = null_mut();
        let (u, out) = (u.as_ptr(), samples.as_mut_ptr());
        let status = bsdfkit_sample_1_many(
            bsdf,
            first,
            wi_count,
            u,
            wo_count,
            components,
            out,
            count,
            &raw mut error,
        );
        failed(error, status != 0);
    }
    Ok(())
}
