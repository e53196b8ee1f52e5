//! The server: HTTP for the page, a socket for each page that is open.
//!
//! | request | answer |
//! |---|---|
//! | `GET /?token=T` | the page |
//! | `GET /preview.js?token=T`, `/preview.css?token=T` | its script and style |
//! | `GET /view/N?token=T` | finished render number N as a page of `holo-viewer` |
//! | `GET /socket?token=T`, upgrade | the socket |
//!
//! A request needs the token, so that only who has the address gets anything, and a `Host` of this server, so that a name
//! that an attacker points to 127.0.0.1 is refused. The socket needs an `Origin` of this server too: browsers send it with
//! every socket, and no page can change it.

mod socket;

use std::io::{self, Read, Write};
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use holo_io::{LightFieldReader, ReadOptions};
use tungstenite::handshake::machine::TryParse;
use tungstenite::handshake::server::{Request, create_response, write_response};

use crate::protocol::Opened;
use crate::render::Shared;
use crate::studio::Studio;
use crate::{Error, Preview};

/// The largest head of a request.
const MAX_HEAD: usize = 16 << 10;

/// How long a request may take to arrive.
const PATIENCE: Duration = Duration::from_secs(5);

/// How often the server looks whether it is to stop.
const PAUSE: Duration = Duration::from_millis(5);

/// Open connections: a page needs one, and a few while it loads.
const MAX_CONNECTIONS: usize = 32;

const PAGE: &str = include_str!("page/page.html");
const STYLE: &str = include_str!("page/preview.css");

/// The scripts in the order of their dependencies.
const SCRIPTS: [&str; 6] = [
    include_str!("page/connection.js"),
    include_str!("page/state.js"),
    include_str!("page/orbit.js"),
    include_str!("page/images.js"),
    include_str!("page/controls.js"),
    include_str!("page/main.js"),
];

/// What the page may load: only from this server.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; \
                      connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// What the page of a finished render may load: it is complete.
const VIEW_POLICY: &str = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; \
                           img-src data: blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// A server that listens.
#[derive(Debug)]
pub struct Server {
    listener: TcpListener,
    address: SocketAddr,
    token: String,
    preview: Preview,
    /// The folders of finished renders.
    rendered: Mutex<Vec<PathBuf>>,
    open: AtomicUsize,
}

impl Server {
    pub(crate) fn bind(preview: Preview, port: u16) -> Result<Self, Error> {
        let wanted = SocketAddr::new(preview.listen, port);
        let failed = |source| Error::Listen { address: wanted.to_string(), source };
        let listener = TcpListener::bind(wanted).map_err(failed)?;
        listener.set_nonblocking(true).map_err(failed)?;
        let address = listener.local_addr().map_err(failed)?;
        let mut bytes = [0_u8; 16];
        getrandom::fill(&mut bytes).map_err(|why| Error::Random(why.to_string()))?;
        let token = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        Ok(Self { listener, address, token, preview, rendered: Mutex::default(), open: AtomicUsize::new(0) })
    }

    /// Returns the address of the page, with the token. Who has it can use the page.
    #[must_use]
    pub fn address(&self) -> String {
        let host = match self.address.ip() {
            ip if ip.is_unspecified() => SocketAddr::new(IpAddr::from([127, 0, 0, 1]), self.address.port()),
            _ => self.address,
        };
        format!("http://{host}/?token={}", self.token)
    }

    /// Serves pages until `stop` is set, and ends the renders of pages then.
    ///
    /// # Errors
    /// [`Error::Serve`] if no connection can be accepted any more.
    pub fn run(&self, stop: &AtomicBool) -> Result<(), Error> {
        // While the browser starts, its scene is loaded.
        let first = Opened::new();
        let (inbox, events) = (first.inbox.clone(), first.events.clone());
        let ahead = Mutex::new(Some(first));
        let shared = Shared { preview: &self.preview, rendered: &self.rendered, stop, ahead: &ahead };
        std::thread::scope(|scope| {
            let studio = Studio::new(&self.preview, &inbox, events);
            scope.spawn(|| studio.run_ahead());
            let mut served = Ok(());
            while !stop.load(Ordering::SeqCst) {
                match self.listener.accept() {
                    Ok((stream, _)) if self.open.load(Ordering::SeqCst) < MAX_CONNECTIONS => {
                        self.open.fetch_add(1, Ordering::SeqCst);
                        scope.spawn(move || {
                            // A browser that goes away is no error of the server.
                            let _ = self.answer(stream, &shared);
                            self.open.fetch_sub(1, Ordering::SeqCst);
                        });
                    }
                    // Too many, or one that ended before it was accepted.
                    Ok(_) => {}
                    Err(why) if is_passing(&why) => std::thread::sleep(PAUSE),
                    Err(why) => {
                        stop.store(true, Ordering::SeqCst);
                        served = Err(why.into());
                    }
                }
            }
            inbox.close();
            served
        })
    }

    /// Answers one request.
    fn answer(&self, mut stream: TcpStream, shared: &Shared) -> io::Result<()> {
        stream.set_nonblocking(false)?;
        stream.set_nodelay(true)?;
        let Some(request) = read_head(&mut stream)? else {
            return respond(&mut stream, "400 Bad Request", "text/plain", "", b"not a request of this page");
        };
        if let Err(why) = self.check(&request) {
            return respond(&mut stream, "403 Forbidden", "text/plain", "", why.as_bytes());
        }
        let path = request.uri().path();
        let with_token = |text: &str| text.replace("{{token}}", &self.token).into_bytes();
        match path {
            "/socket" => {
                let Ok(response) = create_response(&request) else {
                    return respond(&mut stream, "400 Bad Request", "text/plain", "", b"not a socket");
                };
                write_response(&mut stream, &response).map_err(io::Error::other)?;
                stream.set_read_timeout(None)?;
                socket::serve(stream, shared)
            }
            "/" => respond(&mut stream, "200 OK", "text/html; charset=utf-8", POLICY, &with_token(PAGE)),
            "/preview.css" => respond(&mut stream, "200 OK", "text/css; charset=utf-8", POLICY, STYLE.as_bytes()),
            "/preview.js" => {
                let script = format!("(() => {{\n'use strict';\n{}}})();\n", SCRIPTS.concat());
                respond(&mut stream, "200 OK", "text/javascript; charset=utf-8", POLICY, script.as_bytes())
            }
            _ => match path.strip_prefix("/view/").and_then(|n| n.parse().ok()).and_then(|n| shared.folder(n)) {
                Some(folder) => match view(&folder) {
                    Ok(page) => respond(&mut stream, "200 OK", "text/html; charset=utf-8", VIEW_POLICY, &page),
                    Err(why) => respond(&mut stream, "500 Internal Server Error", "text/plain", "", why.as_bytes()),
                },
                None => respond(&mut stream, "404 Not Found", "text/plain", "", b"no such page"),
            },
        }
    }

    /// Checks token, host and origin of a request.
    fn check(&self, request: &Request) -> Result<(), &'static str> {
        let query = request.uri().query().unwrap_or_default();
        let token = query.split('&').find_map(|pair| pair.strip_prefix("token=")).unwrap_or_default();
        if !is_same(token.as_bytes(), self.token.as_bytes()) {
            return Err("the token is not that of this preview: open the address that the program printed");
        }
        let header = |name: &str| request.headers().get(name).and_then(|value| value.to_str().ok());
        let is_own = |host: &str| self.is_own(host);
        if !header("host").is_some_and(is_own) {
            return Err("the host is not that of this preview");
        }
        let origin = header("origin").map(|origin| origin.strip_prefix("http://").is_some_and(is_own));
        let needs_origin = request.uri().path() == "/socket";
        if origin == Some(false) || needs_origin && origin.is_none() {
            return Err("the request comes from another page");
        }
        Ok(())
    }

    /// Whether a request names this server. A name but `localhost` may be one of another page that leads here; an address
    /// is none.
    fn is_own(&self, host: &str) -> bool {
        let (own, port) = (self.address.ip(), self.address.port());
        let is_local = own.is_loopback() || own.is_unspecified();
        match host.parse::<SocketAddr>() {
            Ok(named) => {
                let is_here =
                    own.is_unspecified() || named.ip() == own || is_local && named.ip() == Ipv4Addr::LOCALHOST;
                named.port() == port && is_here
            }
            Err(_) => is_local && host.strip_prefix("localhost:").is_some_and(|named| named == port.to_string()),
        }
    }
}

/// Whether accepting may work later.
fn is_passing(why: &io::Error) -> bool {
    use io::ErrorKind::{ConnectionAborted, ConnectionReset, Interrupted, WouldBlock};
    matches!(why.kind(), WouldBlock | Interrupted | ConnectionAborted | ConnectionReset)
}

/// Compares texts in a time that does not depend on where they differ.
fn is_same(a: &[u8], b: &[u8]) -> bool {
    a.len() == b.len() && a.iter().zip(b).fold(0, |sum, (a, b)| sum | (a ^ b)) == 0
}

/// Reads the head of a request; `None` if it is none, too long or too slow.
fn read_head(stream: &mut TcpStream) -> io::Result<Option<Request>> {
    let end = Instant::now() + PATIENCE;
    let mut head = Vec::new();
    let mut part = [0; 2048];
    loop {
        let left = end.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Ok(None);
        }
        stream.set_read_timeout(Some(left))?;
        let count = stream.read(&mut part)?;
        head.extend_from_slice(&part[..count]);
        if count == 0 || head.len() > MAX_HEAD {
            return Ok(None);
        }
        match Request::try_parse(&head) {
            Ok(Some((_, request))) => return Ok(Some(request)),
            Ok(None) => {}
            Err(_) => return Ok(None),
        }
    }
}

fn respond(stream: &mut TcpStream, status: &str, kind: &str, policy: &str, body: &[u8]) -> io::Result<()> {
    let policy = if policy.is_empty() { "default-src 'none'" } else { policy };
    let head = format!(
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nContent-Security-Policy: {policy}\r\n\
         X-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\nCache-Control: no-store\r\n\
         Cross-Origin-Resource-Policy: same-origin\r\nConnection: close\r\n\r\n",
        body.len()
    );
    stream.write_all(head.as_bytes())?;
    stream.write_all(body)?;
    stream.flush()
}

/// The page of a finished render.
fn view(folder: &std::path::Path) -> Result<Vec<u8>, String> {
    let title = folder.file_name().map_or_else(|| "light field".into(), |name| name.to_string_lossy().into_owned());
    let reader = LightFieldReader::open(folder, &ReadOptions::default()).map_err(|why| why.to_string())?;
    let mut page = Vec::new();
    holo_viewer::Page::new(title, reader)
        .map_err(|why| why.to_string())?
        .write(&mut page)
        .map_err(|why| why.to_string())?;
    Ok(page)
}

#[cfg(test)]
mod tests;
