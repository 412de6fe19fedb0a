//! What catalogues read of strangers: records, metadata, addresses and indices of sites.

use bsdfkit::Metadata;
use bsdfkit_catalog::Record;
use bsdfkit_catalog::exchange::bed;
use bsdfkit_catalog::get::{Cache, Choice, get};

use crate::scratch::with_file;

/// Any bytes as each of these.
pub fn record(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    for read in [Record::from_toml(&text), Record::from_json(&text)] {
        let Ok(record) = read else { continue };
        let mut metadata = Metadata::default();
        record.write_into(&mut metadata);
        let again = Record::of_metadata(&metadata);
        assert_eq!(again.licence, record.licence);
        assert_eq!(record.clone().checked().expect("checked before"), record);
    }
    let metadata = Metadata { comments: vec![text.clone().into_owned()], ..Metadata::default() };
    let of_comment = Record::of_metadata(&metadata);
    of_comment.checked().expect("what a file tells is cut to what fits");
    if let Ok(read) =
        serde_json::from_slice(bytes).map_err(drop).and_then(|v| bed::read(&v).map_err(drop))
    {
        assert!(!read.totals.is_empty());
        for total in &read.totals {
            let shares = [total.reflectance, total.transmittance];
            assert!(shares.iter().flatten().all(|s| (-0.1..=1.1).contains(s)), "{total:?}");
            assert!((0.0..=90.0).contains(&total.polar), "{total:?}");
        }
    }
    with_file("index.json", bytes, |index| {
        let site = index.parent().expect("a folder");
        let cache = Cache { folder: site.join("cache"), most_bytes: 1 << 20 };
        for id in ["a", "brushed-metal"] {
            let got = get(&format!("{}/#{id}", site.display()), &Choice::All, &cache);
            let kept = got.unwrap_or_default();
            assert!(kept.iter().all(|got| got.path.starts_with(site.join("cache"))), "{kept:?}");
        }
    });
}
