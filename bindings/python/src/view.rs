//! Files in a browser.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;

use bsdfkit_viewer::{Offer, Server};
use pyo3::prelude::*;

use crate::error::raised;

/// A server on this machine alone that shows files in a browser until it is closed: what `view` returns.
#[pyclass(module = "bsdfkit", frozen)]
pub(crate) struct Viewer {
    server: Arc<Server>,
    thread: Mutex<Option<JoinHandle<()>>>,
}

#[pymethods]
impl Viewer {
    /// The address to open; it holds a secret, without which nothing is answered.
    #[getter]
    fn link(&self) -> String {
        self.server.link()
    }

    /// Stops the server; a page that is open keeps what it has loaded.
    fn close(&self, py: Python<'_>) {
        let thread = self.thread.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some(thread) = thread {
            self.server.stop();
            // Nothing in it fails; it has nothing to tell.
            let _ = py.detach(|| thread.join());
        }
    }

    fn __enter__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    #[pyo3(signature = (*_exception))]
    fn __exit__(&self, py: Python<'_>, _exception: &Bound<'_, PyAny>) {
        self.close(py);
    }

    fn __repr__(&self) -> String {
        format!("<bsdfkit.Viewer {}>", self.link())
    }

    /// In a notebook: a link.
    fn _repr_html_(&self) -> String {
        let link = self.link().replace('&', "&amp;");
        format!("<a href=\"{link}\" target=\"_blank\" rel=\"noreferrer\">bsdfkit viewer</a>")
    }
}

impl Drop for Viewer {
    fn drop(&mut self) {
        self.server.stop();
    }
}

/// Shows files in a browser: lobe, hemisphere, slice, lit object.
///
/// Args:
///     paths: XML, compiled BSDFs, interpolants, Radiance interpolants: one, or two to compare; and
///         goniophotometer files or folders, whose points are shown beside them.
///     port: Port on 127.0.0.1; 0 takes a free one.
///     browser: Open the browser; else only the link is made.
///
/// Raises:
///     IoError: A file cannot be read, or the port is taken.
///     FormatError: A measurement is none.
///     ArgumentError: No file, or more than two beside measurements; or the package was built
///         without the viewer.
#[pyfunction]
#[pyo3(signature = (paths, *, port = 0, browser = true))]
pub(crate) fn view(
    py: Python<'_>,
    paths: &Bound<'_, PyAny>,
    port: u16,
    browser: bool,
) -> PyResult<Viewer> {
    let paths: Vec<PathBuf> = match paths.extract::<PathBuf>() {
        Ok(path) => vec![path],
        Err(_) => paths.extract()?,
    };
    let server = py.detach(|| Offer::of(&paths).and_then(|files| Server::new(files, port)));
    let server = Arc::new(server.map_err(|e| raised(&e))?);
    let running = server.clone();
    let thread = std::thread::spawn(move || running.run());
    if browser {
        py.import("webbrowser")?.call_method1("open", (server.link(),))?;
    }
    Ok(Viewer { server, thread: Mutex::new(Some(thread)) })
}

/// The viewer as one HTML document that needs no server: open it, drop files on it.
///
/// Raises:
///     ArgumentError: The package was built without it.
#[pyfunction]
pub(crate) fn viewer_page() -> PyResult<&'static str> {
    bsdfkit_viewer::page().map_err(|e| raised(&e))
}
