//! What the page may load.

use std::borrow::Cow;
use std::path::PathBuf;

use bsdfkit::{Error, Result};
use bsdfkit_fit::open::Content;
use bsdfkit_fit::packed;
use bsdfkit_measure::ReadOptions;

/// Files that answer queries and are shown at a time.
const MOST: usize = 2;

/// A file, or the content of one.
#[derive(Clone, Debug)]
pub enum Offer {
    /// A file, opened when it is asked for.
    File(PathBuf),
    /// Content that is in no file, and what it is called.
    Content(String, Vec<u8>),
}

impl Offer {
    /// Files that answer queries as they are, at most two; measurement files and folders of them together as their points,
    /// for a browser opens no folders.
    ///
    /// Errors: io; those of [`bsdfkit_measure::read`]; argument for nothing, and for more files than are shown.
    pub fn of(paths: &[PathBuf]) -> Result<Vec<Self>> {
        let mut measured = Vec::new();
        let mut offers = Vec::new();
        for path in paths {
            match Content::of(path)? {
                Content::Measurement => measured.push(path.clone()),
                _ => offers.push(Self::File(path.clone())),
            }
        }
        if paths.is_empty() || offers.len() > MOST {
            return Err(Error::argument(format!(
                "expected one or {MOST} files that answer queries, or measurements, found {}",
                offers.len()
            )));
        }
        if let Some(first) = measured.first() {
            let name = first.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let whatever = ReadOptions { incomplete: true, ..ReadOptions::default() };
            let points = packed::to_bytes(&bsdfkit_measure::read(&measured, &whatever)?)?;
            offers.push(Self::Content(name, points));
        }
        Ok(offers)
    }

    pub(crate) fn name(&self) -> Cow<'_, str> {
        match self {
            Self::File(path) => path.file_name().unwrap_or_default().to_string_lossy(),
            Self::Content(name, _) => name.into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_offered_as_they_are_and_measurements_as_points() {
        let folder = tempfile::tempdir().unwrap();
        let xml = folder.path().join("a.xml");
        std::fs::write(&xml, b"<WindowElement/>").unwrap();
        let table = folder.path().join("points.txt");
        std::fs::write(&table, "theta_i phi_i theta_o phi_o bsdf\n0 0 10 0 0.5\n0 0 20 90 0.25\n")
            .unwrap();
        let offers = Offer::of(&[table.clone(), xml.clone()]).unwrap();
        assert!(matches!(&offers[0], Offer::File(path) if *path == xml));
        let Offer::Content(name, bytes) = &offers[1] else { panic!("points") };
        assert_eq!(name, "points.txt");
        // Two that were measured, and the image of the one beside the mirror plane.
        assert_eq!(packed::from_bytes(bytes).unwrap()[0].points(), 3);
        for wrong in [vec![], vec![xml.clone(); 3], vec![folder.path().join("none.xml")]] {
            assert!(Offer::of(&wrong).is_err(), "{wrong:?}");
        }
    }
}
