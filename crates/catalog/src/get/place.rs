//! Where a site or a file is: on a web host or in a folder.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::Duration;

use bsdfkit::{Error, Result};

use crate::hash::Sha256;
use crate::site::INDEX;

/// What an address names.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Address {
    /// A file whose hash is known: its name beside `root`.
    File { root: Root, name: String, sha256: Sha256 },
    /// A material of the site at `root`, by its id.
    Material { root: Root, id: Option<String> },
}

/// What other addresses start from.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Root {
    /// With its slash at the end.
    Web(String),
    Folder(PathBuf),
}

const HASH: &str = "sha256=";
const MATERIALS: &str = "/materials/";

impl Address {
    /// Errors: argument: a scheme other than http and https; a hash that is none.
    pub(super) fn parse(text: &str) -> Result<Self> {
        let web = ["http://", "https://"].iter().any(|s| text.starts_with(s));
        if let Some((scheme, _)) = text.split_once("://").filter(|_| !web) {
            let text = format!("address: expected https://, http:// or a path, found {scheme}://");
            return Err(Error::argument(text));
        }
        let (place, fragment) = match text.rsplit_once('#') {
            Some((place, fragment)) => (place, Some(fragment)),
            None => (text, None),
        };
        let root = |folder: &str| match web {
            true => Root::Web(format!("{}/", folder.trim_end_matches('/'))),
            false if folder.is_empty() && text.starts_with('/') => Root::Folder("/".into()),
            false => Root::Folder(if folder.is_empty() { "." } else { folder }.into()),
        };
        if let Some(hash) = fragment.and_then(|f| f.strip_prefix(HASH)) {
            let sha256 = hash.parse::<Sha256>().map_err(|e| Error::argument(e.to_string()))?;
            let (folder, name) = place.rsplit_once('/').unwrap_or(("", place));
            return Ok(Self::File { root: root(folder), name: name.to_owned(), sha256 });
        }
        if let Some((site, page)) = place.rsplit_once(MATERIALS)
            && let Some(id) = page.strip_suffix(".html")
        {
            return Ok(Self::Material { root: root(site), id: Some(id.to_owned()) });
        }
        let place = place.split_once('?').filter(|_| web).map_or(place, |(place, _)| place);
        let site =
            [INDEX, "index.html"].iter().find_map(|page| place.strip_suffix(page)).unwrap_or(place);
        Ok(Self::Material { root: root(site), id: fragment.map(str::to_owned) })
    }
}

impl Root {
    /// Opens what lies at `path` from here on, of which at most `most` bytes are wanted.
    ///
    /// Errors: io; limit: a server that says that it has more.
    pub(super) fn open(&self, path: &str, most: u64) -> Result<Box<dyn Read>> {
        match self {
            Self::Folder(folder) => {
                let path = folder.join(Path::new(path));
                let file = File::open(&path).map_err(|e| Error::io(path.display(), &e))?;
                Ok(Box::new(file))
            }
            Self::Web(root) => {
                let response = agent().get(format!("{root}{path}")).call();
                let body = response.map_err(|e| Error::io("fetching", &e.into_io()))?.into_body();
                match body.content_length() {
                    Some(length) if length > most => {
                        Err(Error::limit(format!("expected at most {most} bytes, found {length}")))
                    }
                    // One more than wanted, so that too much is seen.
                    _ => {
                        Ok(Box::new(body.into_with_config().limit(most.saturating_add(1)).reader()))
                    }
                }
            }
        }
    }
}

/// Gives up on servers that do not answer, send nothing for a minute, or send for an hour.
fn agent() -> ureq::Agent {
    let minute = Some(Duration::from_secs(60));
    let config = ureq::Agent::config_builder()
        .timeout_connect(minute)
        .timeout_recv_response(minute)
        .timeout_per_read(minute)
        .timeout_global(Some(Duration::from_secs(3600)))
        .max_redirects(5)
        .user_agent(concat!("bsdfkit/", env!("CARGO_PKG_VERSION")));
    config.build().new_agent()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn material(text: &str) -> (Root, Option<String>) {
        match Address::parse(text).unwrap() {
            Address::Material { root, id } => (root, id),
            Address::File { .. } => panic!("{text}"),
        }
    }

    #[test]
    fn addresses_of_materials() {
        let web = || Root::Web("https://h/s/".into());
        for text in [
            "https://h/s/materials/a.html",
            "https://h/s/#a",
            "https://h/s#a",
            "https://h/s/index.html?class=metal#a",
            "https://h/s/index.json#a",
        ] {
            assert_eq!(material(text), (web(), Some("a".into())), "{text}");
        }
        assert_eq!(material("https://h/s/"), (web(), None));
        assert_eq!(material("s/materials/a.html"), (Root::Folder("s".into()), Some("a".into())));
        assert_eq!(material("/s#a"), (Root::Folder("/s".into()), Some("a".into())));
    }

    #[test]
    fn addresses_of_files_and_what_is_none() {
        let hash = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        let file = Address::parse(&format!("https://h/d/f.xml#sha256={hash}")).unwrap();
        let Address::File { root, name, .. } = file else { panic!("{file:?}") };
        assert_eq!((root, &*name), (Root::Web("https://h/d/".into()), "f.xml"));
        assert!(Address::parse("f.xml#sha256=12").is_err());
        assert!(Address::parse("file:///etc/passwd#a").is_err());
    }
}
