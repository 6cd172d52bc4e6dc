//! The page for Prometheus, served until somebody ends it.

use std::io;
use std::net::SocketAddr;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use tagbus_message::clock::monotonic_ns;
use tagbus_message::stop::Stop;
use tiny_http::{Header, Method, Request, Response};

use super::look::Look;
use super::metrics;
use crate::outcome::{Failure, Outcome, complain};

/// Roles publish so often, so no page would be newer.
const LOOK: Duration = Duration::from_millis(500);
const TYPE: &str = "text/plain; version=0.0.4; charset=utf-8";
const PATH: &str = "/metrics";

/// The address of a flag.
pub(super) fn address(text: &str) -> Result<SocketAddr, String> {
    text.parse().map_err(|_| {
        "an IP address and a port are needed, such as 127.0.0.1:9464, [::1]:9464 or 0.0.0.0:9464".to_owned()
    })
}

/// A server that has its address and no page yet.
pub(super) struct Server {
    server: Arc<tiny_http::Server>,
    page: Arc<Mutex<String>>,
}

impl Server {
    /// Takes the address and says where the page is.
    pub(super) fn start(address: SocketAddr) -> Result<Self, Failure> {
        let server = tiny_http::Server::http(address).map_err(|error| refused(address, error.as_ref()))?;
        let page = Arc::new(Mutex::new(String::new()));
        // The port is the system's choice where 0 was asked for.
        complain(format_args!("metrics are at http://{}{PATH}", server.server_addr()));
        Ok(Self { server: Arc::new(server), page })
    }

    /// Looks and serves. Who fetches never waits for a look, and a look for nobody who fetches.
    pub(super) fn serve(self, look: &mut Look, stop: &Stop) -> Result<Outcome, Failure> {
        self.write(look);
        let (server, page) = (Arc::clone(&self.server), Arc::clone(&self.page));
        let answering = thread::Builder::new().name("metrics".to_owned()).spawn(move || {
            // It ends when it is unblocked.
            server.incoming_requests().for_each(|request| answer(request, &page));
        })?;
        while !stop.wait(LOOK) {
            self.write(look);
        }
        self.server.unblock();
        // Somebody who does not read what he fetches must not keep us: the thread ends with the process then.
        drop(answering);
        Ok(Outcome::Done)
    }

    fn write(&self, look: &mut Look) {
        let page = metrics::page(look.again(), monotonic_ns());
        *self.page.lock().unwrap_or_else(PoisonError::into_inner) = page;
    }
}

fn answer(request: Request, page: &Mutex<String>) {
    let is_read = matches!(request.method(), Method::Get | Method::Head);
    let path = request.url().split('?').next().unwrap_or_default().to_owned();
    let response = match path.as_str() {
        _ if !is_read => text("only GET and HEAD are answered\n".to_owned()).with_status_code(405),
        PATH => text(page.lock().unwrap_or_else(PoisonError::into_inner).clone()),
        _ => text(format!("there is only {PATH}\n")).with_status_code(404),
    };
    // Whoever went away before the answer does not miss it.
    let _ = request.respond(response);
}

fn text(text: String) -> Response<io::Cursor<Vec<u8>>> {
    // In one piece however long it is: what fetches with a few lines of code need not know of chunks.
    let response = Response::from_string(text).with_chunked_threshold(usize::MAX);
    match Header::from_bytes("Content-Type", TYPE) {
        Ok(header) => response.with_header(header),
        Err(()) => response,
    }
}

fn refused(address: SocketAddr, error: &(dyn std::error::Error + 'static)) -> Failure {
    let kind = error.downcast_ref::<io::Error>().map(io::Error::kind);
    let advice = match kind {
        Some(io::ErrorKind::AddrInUse) => "another program listens there: end it, or choose another port",
        Some(io::ErrorKind::AddrNotAvailable) => "this machine has no such address: use 127.0.0.1 or 0.0.0.0",
        Some(io::ErrorKind::PermissionDenied) => "ports below 1024 need permission: choose a greater one",
        _ => "choose another address",
    };
    Failure::new(format!("metrics cannot be served at {address} ({error}): {advice}"))
}
