//! The server: loopback only, one page, the given files.

use std::fs::File;
use std::net::{Ipv4Addr, SocketAddr};

use bsdfkit::{Error, Result};
use percent_encoding::{NON_ALPHANUMERIC, utf8_percent_encode};
use tiny_http::{Header, Method, Request, Response, StatusCode};

use crate::offer::Offer;
use crate::page;
use crate::reply::{self, Reply};

/// Threads that answer: a page asks for two files at a time.
const THREADS: usize = 4;

/// Sent with everything: nobody else may show, load or guess at what is answered.
const HEADERS: [(&str, &str); 5] = [
    ("Content-Security-Policy", "frame-ancestors 'none'"),
    ("Cross-Origin-Resource-Policy", "same-origin"),
    ("X-Content-Type-Options", "nosniff"),
    ("Referrer-Policy", "no-referrer"),
    ("Cache-Control", "no-store"),
];

/// Hands the viewer and some files to a browser on this machine.
pub struct Server {
    http: tiny_http::Server,
    address: SocketAddr,
    token: String,
    files: Vec<Offer>,
}

impl Server {
    /// Listens on 127.0.0.1 at `port`, at any free one for 0.
    ///
    /// Errors: argument where this build has no page; io where the port is taken.
    pub fn new(files: Vec<Offer>, port: u16) -> Result<Self> {
        page()?;
        let io = |text: &dyn std::fmt::Display| {
            Error::io(format!("127.0.0.1:{port}"), &std::io::Error::other(text.to_string()))
        };
        let http = tiny_http::Server::http((Ipv4Addr::LOCALHOST, port)).map_err(|e| io(&e))?;
        let address = http.server_addr().to_ip().ok_or_else(|| io(&"expected an address"))?;
        let mut secret = [0; 16];
        getrandom::fill(&mut secret).map_err(|e| io(&e))?;
        let token = secret.iter().map(|byte| format!("{byte:02x}")).collect();
        Ok(Self { http, address, token, files })
    }

    /// The link that opens the files in the viewer. It holds a secret: without it nothing is answered.
    pub fn link(&self) -> String {
        let files = self.files.iter().enumerate().map(|(n, offer)| {
            format!("open=files/{n}/{}", utf8_percent_encode(&offer.name(), NON_ALPHANUMERIC))
        });
        let files = files.collect::<Vec<_>>().join("&");
        format!("http://{}/{}/#{files}", self.address, self.token)
    }

    /// Answers until [`Server::stop`] is called.
    pub fn run(&self) {
        std::thread::scope(|scope| {
            for _ in 0..THREADS {
                scope.spawn(|| {
                    while let Ok(request) = self.http.recv() {
                        // Whoever has gone meanwhile needs no answer.
                        let _ = self.answer(request);
                    }
                });
            }
        });
    }

    /// Ends [`Server::run`].
    pub fn stop(&self) {
        (0..THREADS).for_each(|_| self.http.unblock());
    }

    fn answer(&self, request: Request) -> std::io::Result<()> {
        let header = |name: &'static str| {
            let found = request.headers().iter().find(|h| h.field.equiv(name));
            found.map(|h| h.value.as_str())
        };
        let asked = reply::Request {
            path: request.url(),
            reads: matches!(request.method(), Method::Get | Method::Head),
            host: header("Host"),
            origin: header("Origin"),
            site: header("Sec-Fetch-Site"),
        };
        match Reply::to(&asked, self.address, &self.token, self.files.len()) {
            Reply::Page => match page() {
                Ok(page) => request
                    .respond(with_headers(Response::from_string(page), "text/html; charset=utf-8")),
                Err(e) => refuse(request, 404, &e.to_string()),
            },
            Reply::File(number) => self.hand_out(request, number),
            Reply::Refused(status, why) => refuse(request, status, why),
        }
    }

    fn hand_out(&self, request: Request, number: usize) -> std::io::Result<()> {
        let content = "application/octet-stream";
        match &self.files[number] {
            Offer::Content(_, bytes) => {
                let whole = Some(bytes.len());
                let response =
                    Response::new(StatusCode(200), Vec::new(), bytes.as_slice(), whole, None);
                request.respond(with_headers(response, content))
            }
            Offer::File(path) => match File::open(path) {
                Ok(file) => request.respond(with_headers(Response::from_file(file), content)),
                Err(e) => refuse(request, 404, &e.to_string()),
            },
        }
    }
}

fn refuse(request: Request, status: u16, why: &str) -> std::io::Result<()> {
    let response = Response::from_string(why).with_status_code(StatusCode(status));
    request.respond(with_headers(response, "text/plain; charset=utf-8"))
}

/// Lengths are known, so they are sent: nothing comes in chunks.
fn with_headers<R: std::io::Read>(response: Response<R>, content: &str) -> Response<R> {
    let mut response = response.with_chunked_threshold(usize::MAX);
    for (name, value) in HEADERS.into_iter().chain([("Content-Type", content)]) {
        response.add_header(Header::from_bytes(name, value).expect("plain text"));
    }
    response
}
