//! What a stage is made of, and its results by number.

use std::sync::Arc;

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::store::Cache;
use crate::interpolant::FitSettings;
use bsdfkit_measure::Measurement;

/// Raised when a stage means something else than before although the version of the library stays.
const VERSION: u32 = 1;

/// One stage of a fit: its results are kept by number.
pub(crate) struct Stage {
    /// The folder, and the hash of all that the stage is made of; `None`: nothing is kept.
    kept: Option<(Arc<Cache>, blake3::Hasher)>,
}

impl Stage {
    /// The stage `name` of a fit to `m`. `more`: on what else its results depend.
    ///
    /// Cost: a hash of all points, some 10 ms a million, where there is a cache.
    pub(crate) fn of(
        name: &str,
        m: &Measurement,
        settings: &FitSettings,
        more: &impl Serialize,
    ) -> Self {
        let kept = settings.cache.as_ref().map(|cache| {
            let mut hash = blake3::Hasher::new();
            let mut add = |bytes: &[u8]| {
                hash.update(&(bytes.len() as u64).to_le_bytes());
                hash.update(bytes);
            };
            add(env!("CARGO_PKG_VERSION").as_bytes());
            add(&VERSION.to_le_bytes());
            add(name.as_bytes());
            // Text tells numbers apart to the bit.
            add(format!("{:?} {:?} {}", settings.frame, settings.lobes, settings.detail_cells)
                .as_bytes());
            add(&postcard::to_stdvec(more).unwrap_or_default());
            let about = (m.incident, m.scattered, m.symmetry, &m.colorimetry);
            add(format!("{about:?}").as_bytes());
            for i in &m.incidences {
                i.wi.to_array().iter().for_each(|x| add(&x.to_le_bytes()));
                let numbers = i.wo.numbers().chain(i.values.iter().copied());
                add(&numbers.flat_map(f32::to_le_bytes).collect::<Vec<u8>>());
            }
            (cache.clone(), hash)
        });
        Self { kept }
    }

    /// Result `number` as it was kept, or computed, and kept.
    pub(crate) fn result<T: Serialize + DeserializeOwned>(
        &self,
        number: usize,
        compute: impl FnOnce() -> T,
    ) -> T {
        self.result_of(&(number as u64), compute)
    }

    /// The result of `question`, likewise.
    pub(crate) fn result_of<T: Serialize + DeserializeOwned>(
        &self,
        question: &impl Serialize,
        compute: impl FnOnce() -> T,
    ) -> T {
        self.kept(question).unwrap_or_else(|| {
            let result = compute();
            self.keep(question, &result);
            result
        })
    }

    /// The result of `question`, if it was kept.
    pub(crate) fn kept<T: DeserializeOwned>(&self, question: &impl Serialize) -> Option<T> {
        let (cache, hash) = self.kept.as_ref()?;
        postcard::from_bytes(&cache.get(&key(hash, question)?)?).ok()
    }

    /// Keeps the result of `question`.
    pub(crate) fn keep(&self, question: &impl Serialize, result: &impl Serialize) {
        if let Some((cache, hash)) = &self.kept
            && let (Some(key), Ok(bytes)) = (key(hash, question), postcard::to_stdvec(result))
        {
            cache.put(&key, &bytes);
        }
    }
}

fn key(hash: &blake3::Hasher, question: &impl Serialize) -> Option<blake3::Hash> {
    Some(hash.clone().update(&postcard::to_stdvec(question).ok()?).finalize())
}
