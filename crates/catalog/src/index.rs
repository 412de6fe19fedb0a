//! A library's index on disk: what was read of each group of files, kept until they change.

use std::path::Path;

use bsdfkit::{Error, Result};
use rusqlite::{Connection, OptionalExtension, params};

use crate::entry::Entry;
use crate::look::Look;

/// The index's file in a library's folder.
pub(crate) const FILE: &str = ".bsdf-catalog.sqlite";

/// Of the tables below and of what is in them; an index of another version is made anew.
const VERSION: i64 = 1;

/// Bytes of the index that are mapped.
const MAPPED: i64 = 1 << 30;

const TABLES: &str = "
    CREATE TABLE entries (stem TEXT PRIMARY KEY, print TEXT NOT NULL, entry TEXT NOT NULL, look BLOB NOT NULL);
    CREATE TABLE pictures (sha256 TEXT PRIMARY KEY, png BLOB NOT NULL);
    CREATE VIRTUAL TABLE words USING fts5(
        stem, name, maker, class, instrument, date, licence, doi, notes, symmetry, components,
        tokenize = \"unicode61 remove_diacritics 2\"
    );
";

/// The index of a library, an SQLite database.
#[derive(Debug)]
pub(crate) struct Index {
    database: Connection,
}

fn sqlite(e: &rusqlite::Error) -> Error {
    Error::io("index", &std::io::Error::other(e.to_string()))
}

impl Index {
    /// Opens or makes the index of `folder`; one that is damaged or of another version is made anew. Where nothing can
    /// be written it is kept in memory.
    ///
    /// Errors: io, where another process holds it for a minute.
    pub(crate) fn open(folder: &Path) -> Result<Self> {
        use rusqlite::ErrorCode::{CannotOpen, DatabaseCorrupt, NotADatabase, ReadOnly};
        let path = folder.join(FILE);
        let in_memory = || Connection::open_in_memory().and_then(Self::with_tables);
        let opened = match Self::of(&path) {
            Ok(Some(index)) => return Ok(index),
            Ok(None) => Self::anew(&path),
            Err(e) => match e.sqlite_error_code() {
                Some(DatabaseCorrupt | NotADatabase) => Self::anew(&path),
                Some(CannotOpen | ReadOnly) => in_memory(),
                _ => Err(e),
            },
        };
        opened.map_err(|e| sqlite(&e).context(path.display()))
    }

    /// `None`: of another version.
    fn of(path: &Path) -> rusqlite::Result<Option<Self>> {
        let database = Connection::open(path)?;
        database.busy_timeout(std::time::Duration::from_secs(60))?;
        // Looks are 20 MB of 2,000 materials: mapped, not read page by page.
        database.pragma_update(None, "mmap_size", MAPPED)?;
        let number = |query: &str| database.query_row(query, [], |row| row.get::<_, i64>(0));
        if number("PRAGMA user_version")? == VERSION {
            number("SELECT count(*) FROM entries")?;
            return Ok(Some(Self { database }));
        }
        match number("SELECT count(*) FROM sqlite_schema")? {
            0 => Self::with_tables(database).map(Some),
            _ => Ok(None),
        }
    }

    fn anew(path: &Path) -> rusqlite::Result<Self> {
        // If it cannot be removed, opening it fails, too.
        let _ = std::fs::remove_file(path);
        Connection::open(path).and_then(Self::with_tables)
    }

    fn with_tables(database: Connection) -> rusqlite::Result<Self> {
        database
            .execute_batch(&format!("BEGIN; {TABLES} PRAGMA user_version = {VERSION}; COMMIT;"))?;
        Ok(Self { database })
    }

    /// Every stem with the print of its files.
    pub(crate) fn prints(&self) -> Result<Vec<(String, String)>> {
        self.rows("SELECT stem, print FROM entries", |row| Ok((row.get(0)?, row.get(1)?)))
    }

    /// Every entry by its stem, in order.
    pub(crate) fn entries(&self) -> Result<Vec<(String, Entry)>> {
        let rows: Vec<(String, String)> = self
            .rows("SELECT stem, entry FROM entries ORDER BY stem", |row| {
                Ok((row.get(0)?, row.get(1)?))
            })?;
        let read = |(stem, text): (String, String)| {
            let entry = serde_json::from_str(&text)
                .map_err(|e| Error::format(format!("index: {stem}: {e}")))?;
            Ok((stem, entry))
        };
        rows.into_iter().map(read).collect()
    }

    /// Every look by its stem, in order.
    pub(crate) fn looks(&self) -> Result<Vec<(String, Look)>> {
        let rows: Vec<(String, Vec<u8>)> = self
            .rows("SELECT stem, look FROM entries ORDER BY stem", |row| {
                Ok((row.get(0)?, row.get(1)?))
            })?;
        rows.into_iter().map(|(stem, bytes)| Ok((stem, Look::from_bytes(&bytes)?))).collect()
    }

    /// Calls `take` with the bytes of every look, in the order of the stems.
    pub(crate) fn each_look(&self, mut take: impl FnMut(&[u8]) -> Result<()>) -> Result<()> {
        let query = "SELECT look FROM entries ORDER BY stem";
        let mut statement = self.database.prepare(query).map_err(|e| sqlite(&e))?;
        let mut rows = statement.query([]).map_err(|e| sqlite(&e))?;
        while let Some(row) = rows.next().map_err(|e| sqlite(&e))? {
            let look = row.get_ref(0).map_err(|e| sqlite(&e))?;
            take(look.as_blob().map_err(|e| sqlite(&rusqlite::Error::from(e)))?)?;
        }
        Ok(())
    }

    /// Stems of what an FTS5 expression finds, the best first.
    pub(crate) fn matching(&self, expression: &str) -> Result<Vec<String>> {
        let find = || -> rusqlite::Result<Vec<String>> {
            let query = "SELECT stem FROM words WHERE words MATCH ?1 ORDER BY rank";
            self.database.prepare(query)?.query_map([expression], |row| row.get(0))?.collect()
        };
        find().map_err(|e| sqlite(&e))
    }

    fn rows<T>(
        &self,
        query: &str,
        row: impl FnMut(&rusqlite::Row<'_>) -> rusqlite::Result<T>,
    ) -> Result<Vec<T>> {
        let find = || -> rusqlite::Result<Vec<T>> {
            self.database.prepare(query)?.query_map([], row)?.collect()
        };
        find().map_err(|e| sqlite(&e))
    }

    /// Forgets `gone`, and keeps `read` instead of what it had of the same stems; all or nothing.
    pub(crate) fn replace<'a>(
        &mut self,
        gone: impl Iterator<Item = &'a str>,
        read: &[Read],
    ) -> Result<()> {
        self.try_replace(gone, read).map_err(|e| sqlite(&e))
    }

    fn try_replace<'a>(
        &mut self,
        gone: impl Iterator<Item = &'a str>,
        read: &[Read],
    ) -> rusqlite::Result<()> {
        let change = self.database.transaction()?;
        let forget = |stem: &str| {
            let words =
                "DELETE FROM words WHERE rowid IN (SELECT rowid FROM entries WHERE stem = ?1)";
            change.execute(words, [stem])?;
            change.execute("DELETE FROM entries WHERE stem = ?1", [stem])
        };
        for stem in gone {
            forget(stem)?;
        }
        for Read { stem, print, entry, look } in read {
            forget(stem)?;
            let text = serde_json::to_string(entry).unwrap_or_default();
            let kept = params![stem, print, text, look.to_bytes()];
            change.execute("INSERT INTO entries VALUES (?1, ?2, ?3, ?4)", kept)?;
            let (r, f) = (&entry.record, &entry.facts);
            change.execute(
                "INSERT INTO words (rowid, stem, name, maker, class, instrument, date, licence, doi, notes, symmetry, components)
                 VALUES (last_insert_rowid(), ?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11)",
                params![
                    stem, r.name, r.maker, r.class, r.instrument, r.date, r.licence, r.doi, r.notes,
                    f.symmetry, f.components.join(", ")
                ],
            )?;
        }
        change.commit()
    }

    /// A picture that was drawn of files with these hashes.
    pub(crate) fn picture(&self, key: &str) -> Result<Option<Vec<u8>>> {
        let query = "SELECT png FROM pictures WHERE sha256 = ?1";
        let found = self.database.query_row(query, [key], |row| row.get(0));
        found.optional().map_err(|e| sqlite(&e))
    }

    /// Keeps pictures.
    pub(crate) fn keep_pictures(&mut self, pictures: &[(String, Vec<u8>)]) -> Result<()> {
        self.try_keep_pictures(pictures).map_err(|e| sqlite(&e))
    }

    fn try_keep_pictures(&mut self, pictures: &[(String, Vec<u8>)]) -> rusqlite::Result<()> {
        let change = self.database.transaction()?;
        for (key, png) in pictures {
            change.execute("INSERT OR REPLACE INTO pictures VALUES (?1, ?2)", params![key, png])?;
        }
        change.commit()
    }
}

/// A material that was read.
pub(crate) struct Read {
    pub(crate) stem: String,
    /// Of its files.
    pub(crate) print: String,
    pub(crate) entry: Entry,
    pub(crate) look: Look,
}
