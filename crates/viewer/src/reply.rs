//! What is answered to whom.

use std::net::SocketAddr;

/// The headers of a request that decide.
#[derive(Clone, Debug, Default)]
pub(crate) struct Request<'a> {
    pub(crate) path: &'a str,
    /// Whether something is only asked for: GET or HEAD.
    pub(crate) reads: bool,
    pub(crate) host: Option<&'a str>,
    pub(crate) origin: Option<&'a str>,
    /// `Sec-Fetch-Site`: how the page that asks is related to this server.
    pub(crate) site: Option<&'a str>,
}

/// What is answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reply {
    Page,
    /// The file of this number.
    File(usize),
    /// A status and why.
    Refused(u16, &'static str),
}

impl Reply {
    /// Decides by the request alone. Files are told by number, so that no path can lead elsewhere; `token` keeps out
    /// other people on this machine, the host's name pages of other sites that resolve to this machine.
    pub(crate) fn to(
        request: &Request<'_>,
        address: SocketAddr,
        token: &str,
        files: usize,
    ) -> Self {
        let port = address.port();
        let own = [format!("127.0.0.1:{port}"), format!("localhost:{port}")];
        let Some(host) = request.host.filter(|host| own.iter().any(|own| own == host)) else {
            return Self::Refused(403, "expected this machine's own address as host");
        };
        if request.origin.is_some_and(|origin| origin.strip_prefix("http://") != Some(host)) {
            return Self::Refused(403, "expected a request by the viewer itself");
        }
        if request.site.is_some_and(|site| !["none", "same-origin"].contains(&site)) {
            return Self::Refused(403, "expected a request by the viewer itself");
        }
        if !request.reads {
            return Self::Refused(405, "expected GET or HEAD");
        }
        let path = request.path.split('?').next().unwrap_or_default();
        let mut parts = path.split('/').skip(1);
        if !parts.next().is_some_and(|found| same(found, token)) {
            return Self::Refused(404, "expected the link that `bsdf view` printed");
        }
        let parts: Vec<&str> = parts.collect();
        match parts[..] {
            [""] => Self::Page,
            ["files", number, _name] => match number.parse() {
                Ok(number) if number < files => Self::File(number),
                _ => Self::Refused(404, "no such file"),
            },
            _ => Self::Refused(404, "nothing here"),
        }
    }
}

/// Equality in a time that tells nothing of where the two differ.
fn same(a: &str, b: &str) -> bool {
    a.len() == b.len() && a.bytes().zip(b.bytes()).fold(0, |d, (a, b)| d | (a ^ b)) == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    const TOKEN: &str = "0123456789abcdef";

    fn reply(change: impl FnOnce(&mut Request<'_>)) -> Reply {
        let mut request = Request {
            path: "/0123456789abcdef/files/1/fabric.xml",
            reads: true,
            host: Some("127.0.0.1:4000"),
            ..Request::default()
        };
        change(&mut request);
        Reply::to(&request, "127.0.0.1:4000".parse().unwrap(), TOKEN, 2)
    }

    fn status(reply: Reply) -> u16 {
        match reply {
            Reply::Refused(status, _) => status,
            _ => 200,
        }
    }

    #[test]
    fn page_and_files_are_handed_out() {
        assert_eq!(reply(|_| ()), Reply::File(1));
        assert_eq!(reply(|r| r.path = "/0123456789abcdef/"), Reply::Page);
        assert_eq!(reply(|r| r.path = "/0123456789abcdef/?x"), Reply::Page);
        assert_eq!(reply(|r| r.host = Some("localhost:4000")), Reply::File(1));
        assert_eq!(reply(|r| r.origin = Some("http://127.0.0.1:4000")), Reply::File(1));
        assert_eq!(reply(|r| r.site = Some("same-origin")), Reply::File(1));
        assert_eq!(reply(|r| r.site = Some("none")), Reply::File(1));
    }

    #[test]
    fn foreign_pages_and_hosts_are_refused() {
        for host in [None, Some("evil.example:4000"), Some("127.0.0.1"), Some("127.0.0.1:4001")] {
            assert_eq!(status(reply(|r| r.host = host)), 403, "{host:?}");
        }
        for origin in
            ["http://evil.example", "null", "http://127.0.0.1:4001", "https://127.0.0.1:4000"]
        {
            assert_eq!(status(reply(|r| r.origin = Some(origin))), 403, "{origin}");
        }
        assert_eq!(status(reply(|r| r.site = Some("cross-site"))), 403);
        assert_eq!(status(reply(|r| r.site = Some("same-site"))), 403);
        assert_eq!(status(reply(|r| r.reads = false)), 405);
    }

    #[test]
    fn paths_lead_to_the_given_files_alone() {
        for path in [
            "",
            "/",
            "/files/0/a",
            "/0123456789abcde/",
            "/0123456789abcdeg/",
            "/0123456789abcdef",
            "/0123456789abcdef/files/2/a",
            "/0123456789abcdef/files/-1/a",
            "/0123456789abcdef/files/0",
            "/0123456789abcdef/files/../../etc/passwd",
            "/0123456789abcdef/files/0/../../Cargo.toml",
            "/0123456789abcdef/../x",
            "/0123456789abcdef/files/0x0/a",
            "/0123456789abcdef/etc/passwd",
            "http://evil.example/0123456789abcdef/",
            "/%2e%2e/0123456789abcdef/",
        ] {
            assert_eq!(status(reply(|r| r.path = path)), 404, "{path}");
        }
    }
}
