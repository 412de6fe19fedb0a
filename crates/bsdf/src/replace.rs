//! Files that are replaced whole or not at all.

use std::io::{BufWriter, Write};
use std::path::Path;

use crate::{Error, Result};

/// Writes `path` by `write`: into a temporary file beside it, then renamed.
///
/// Until the rename an existing file stays as it was; afterwards it is replaced whole.
///
/// Errors: io, naming the path; those of `write`, with the path put before.
pub fn replace_file(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<std::fs::File>) -> Result<()>,
) -> Result<()> {
    let io = |e: &std::io::Error| Error::io(path.display(), e);
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    #[cfg_attr(not(unix), expect(unused_mut, reason = "only Unix has permissions to set"))]
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // As for any new file, the process's mask applies.
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let temporary = builder.tempfile_in(folder).map_err(|e| io(&e))?;
    let (file, place) = temporary.into_parts();
    let mut out = BufWriter::new(file);
    write(&mut out).map_err(|e| e.context(path.display()))?;
    out.flush().map_err(|e| io(&e))?;
    drop(out);
    place.persist(path).map_err(|e| io(&e.error))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("a.xml");
        replace_file(&path, |w| w.write_all(b"old").map_err(|e| Error::io("", &e))).expect("old");
        let failed = replace_file(&path, |w| {
            w.write_all(b"half").map_err(|e| Error::io("", &e))?;
            Err(Error::format("no"))
        });
        assert!(failed.is_err());
        assert_eq!(std::fs::read(&path).expect("still there"), b"old");
        assert_eq!(std::fs::read_dir(folder.path()).expect("folder").count(), 1);
    }
}
