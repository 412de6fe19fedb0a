//! The same tree, read leaf by leaf or smoothly.

use std::any::Any;
use std::sync::Arc;

use super::distribution::TreeDistribution;
use super::smooth::SmoothTree;
use crate::Result;
use crate::distribution::Distribution;
use crate::lanes::Lookup;

/// A distribution read in the given way; `None` when that is how it is read already, or there is no
/// other way.
///
/// Errors: format, for values from a damaged file.
pub(crate) fn read_as(
    distribution: &Arc<dyn Distribution>,
    lookup: Lookup,
) -> Result<Option<Arc<dyn Distribution>>> {
    let any: Arc<dyn Any + Send + Sync> = distribution.clone();
    Ok(match lookup {
        Lookup::Stored => any.downcast::<SmoothTree>().ok().map(|tree| tree.leaves() as _),
        Lookup::Smooth => match any.downcast::<TreeDistribution>() {
            Ok(tree) => Some(Arc::new(SmoothTree::new(tree)?)),
            Err(_) => None,
        },
    })
}
