//! The server as a browser and as strangers meet it.

use std::io::{Read, Write};
use std::net::TcpStream;

use bsdfkit_viewer::{Offer, Server, page};

/// Sends a request as it is; status, headers and body.
fn ask(address: &str, request: &str) -> (u16, String, Vec<u8>) {
    let mut stream = TcpStream::connect(address).unwrap();
    stream.write_all(request.as_bytes()).unwrap();
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).unwrap();
    let end = answer.windows(4).position(|w| w == b"\r\n\r\n").unwrap();
    let head = String::from_utf8(answer[..end].to_vec()).unwrap();
    let status = head.split(' ').nth(1).unwrap().parse().unwrap();
    (status, head, answer[end + 4..].to_vec())
}

/// Stops the server also where the test fails, which would wait for it otherwise.
struct Stops<'a>(&'a Server);

impl Drop for Stops<'_> {
    fn drop(&mut self) {
        self.0.stop();
    }
}

#[test]
fn hands_out_the_page_and_the_files_alone() {
    if page().is_err() {
        eprintln!("no page in this build: the server is not tried");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a b#<c>.xml");
    std::fs::write(&path, b"content").unwrap();
    let gone = folder.path().join("gone.xml");
    let files =
        [Offer::File(path), Offer::Content("points".into(), vec![1, 2, 3]), Offer::File(gone)];
    let server = Server::new(files.into(), 0).unwrap();
    let link = server.link();
    let (address, rest) = link.strip_prefix("http://").unwrap().split_once('/').unwrap();
    let (token, open) = rest.split_once("/#").unwrap();
    assert!(address.starts_with("127.0.0.1:"), "{link}");
    assert_eq!(token.len(), 32);
    assert!(open.starts_with("open=files/0/a%20b%23%3Cc%3E%2Exml&open=files/1/points&"), "{open}");
    std::thread::scope(|scope| {
        scope.spawn(|| server.run());
        let _stops = Stops(&server);
        let get = |path: &str, more: &str| {
            ask(
                address,
                &format!(
                    "GET {path} HTTP/1.1\r\nHost: {address}\r\n{more}Connection: close\r\n\r\n"
                ),
            )
        };
        let (status, head, body) = get(&format!("/{token}/"), "");
        assert_eq!((status, body.as_slice()), (200, page().unwrap().as_bytes()));
        for header in
            ["nosniff", "frame-ancestors 'none'", "same-origin", "no-referrer", "no-store"]
        {
            assert!(head.contains(header), "{header}: {head}");
        }
        let found = get(&format!("/{token}/files/0/any"), "");
        assert_eq!((found.0, found.2.as_slice()), (200, &b"content"[..]));
        let found = get(&format!("/{token}/files/1/points"), "");
        assert_eq!((found.0, found.2.as_slice()), (200, &[1, 2, 3][..]));
        assert_eq!(get(&format!("/{token}/files/2/gone.xml"), "").0, 404);
        assert_eq!(get(&format!("/{token}/files/3/x"), "").0, 404);
        assert_eq!(get(&format!("/{token}/files/0/../../../etc/passwd"), "").0, 404);
        assert_eq!(get("/", "").0, 404);
        assert_eq!(get(&format!("/{token}/"), "Origin: http://evil.example\r\n").0, 403);
        assert_eq!(get(&format!("/{token}/"), "Sec-Fetch-Site: cross-site\r\n").0, 403);
        let foreign =
            format!("GET /{token}/ HTTP/1.1\r\nHost: evil.example\r\nConnection: close\r\n\r\n");
        assert_eq!(ask(address, &foreign).0, 403);
        let post = format!(
            "POST /{token}/ HTTP/1.1\r\nHost: {address}\r\nContent-Length: 0\r\nConnection: close\r\n\r\n"
        );
        assert_eq!(ask(address, &post).0, 405);
    });
}

#[test]
fn a_page_needs_nothing_from_elsewhere() {
    let Ok(page) = page() else {
        eprintln!("no page in this build: not looked at");
        return;
    };
    assert!(page.len() < 3_000_000, "{} bytes", page.len());
    assert!(page.contains("default-src 'none'"));
    for element in ["<script src", "<link rel=\"stylesheet\"", "<img", "<iframe"] {
        assert!(!page.contains(element), "{element}");
    }
}
