//! Goniophotometer files of every format, as points and as functions.

use bsdfkit_fit::{open, packed};
use bsdfkit_measure::{ReadOptions, read};

use crate::ask::{Trust, ask};
use crate::scratch::with_file;

/// Mountain text, tables, and the formats of others, told apart by content; measurements packed for the viewer.
pub fn measurement(bytes: &[u8]) {
    let options = ReadOptions { incomplete: true, ..ReadOptions::default() };
    let read = with_file("measured", bytes, |path| read(&[path.to_owned()], &options));
    for m in read.into_iter().chain(packed::from_bytes(bytes)).flatten() {
        m.quality();
        assert!(m.incidences.iter().all(|i| i.wo.len() * i.channels() == i.values.len()));
        if let Ok(packed) = packed::to_bytes(&[m]) {
            packed::from_bytes(&packed).expect("what was packed is unpacked");
        }
    }
}

/// The formats that are functions on a grid: RGL's tensors, MERL, Zemax.
pub fn tables(bytes: &[u8]) {
    if let Ok((_, opened)) = open::open_bytes(bytes) {
        ask(&opened.into_bsdf(), Trust::Checked);
    }
}
