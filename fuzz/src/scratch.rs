//! Bytes as a file, for readers that take a path.

use std::cell::RefCell;
use std::path::Path;

use tempfile::TempDir;

thread_local! {
    static FOLDER: RefCell<Option<TempDir>> = const { RefCell::new(None) };
}

/// Runs `f` on a file of that name and content, which is gone afterwards.
pub(crate) fn with_file<T>(name: &str, bytes: &[u8], f: impl FnOnce(&Path) -> T) -> T {
    FOLDER.with_borrow_mut(|folder| {
        let folder = folder.get_or_insert_with(|| tempfile::tempdir().expect("a folder for files"));
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).expect("a file in it");
        let result = f(&path);
        std::fs::remove_file(&path).expect("the file is there");
        result
    })
}
