//! Files and folders that a manifest names, one by one or by patterns.

use std::path::{Path, PathBuf};

use bsdfkit::{Error, Result};

/// Files and folders that one pattern may name.
const MOST_MATCHES: usize = 100_000;

/// The files and folders that `text` names beside the manifest: itself, or what it matches as a pattern (`*`, `?`, `[...]`, `**`).
///
/// Errors: io where there is nothing; format for a pattern that is none; limit.
pub(super) fn found(folder: &Path, text: &str) -> Result<Vec<PathBuf>> {
    let path = folder.join(text);
    if path.exists() {
        return Ok(vec![path]);
    }
    let nothing = || {
        let text = format!(
            "{}: expected a file, a folder or a pattern of them, found nothing",
            path.display()
        );
        Error::io(text, &std::io::ErrorKind::NotFound.into())
    };
    if !text.contains(['*', '?', '[']) {
        return Err(nothing());
    }
    let pattern = match Path::new(text).is_absolute() {
        true => text.to_owned(),
        false => format!("{}/{text}", glob::Pattern::escape(&folder.to_string_lossy())),
    };
    let options = glob::MatchOptions {
        case_sensitive: true,
        require_literal_separator: true,
        require_literal_leading_dot: true,
    };
    let matches = glob::glob_with(&pattern, options)
        .map_err(|e| Error::format(format!("expected a pattern, found {text:?} ({})", e.msg)))?;
    let mut paths = Vec::new();
    for path in matches {
        let path = path.map_err(|e| Error::io(e.path().display(), e.error()))?;
        if paths.len() == MOST_MATCHES {
            let text = format!("{text:?}: expected at most {MOST_MATCHES} files, found more");
            return Err(Error::limit(text));
        }
        paths.push(path);
    }
    if paths.is_empty() { Err(nothing()) } else { Ok(paths) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_name_files_in_order_and_hidden_ones_by_name_alone() {
        let place = tempfile::tempdir().unwrap();
        // A folder whose own name looks like a pattern.
        let folder = place.path().join("[ab]*");
        std::fs::create_dir_all(folder.join("deep/er")).unwrap();
        for name in ["b.txt", "a.txt", ".c.txt", "x[1].txt", "deep/er/d.txt"] {
            std::fs::write(folder.join(name), "").unwrap();
        }
        let names = |text: &str| -> Vec<String> {
            let paths = found(&folder, text).unwrap();
            let name = |p: &PathBuf| p.strip_prefix(&folder).unwrap().display().to_string();
            paths.iter().map(name).collect()
        };
        assert_eq!(names("?.txt"), ["a.txt", "b.txt"]);
        assert_eq!(names("x[1].txt"), ["x[1].txt"]);
        assert_eq!(names("**/d.txt"), ["deep/er/d.txt"]);
        assert_eq!(names("deep"), ["deep"]);
        assert_eq!(names(".c.txt"), [".c.txt"]);
        for (text, words) in
            [("c*", "found nothing"), ("c", "found nothing"), ("a[", "expected a pattern")]
        {
            let error = found(&folder, text).unwrap_err().to_string();
            assert!(error.contains(words), "{text}: {error}");
        }
    }
}
