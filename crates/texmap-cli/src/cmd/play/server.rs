//! A server of HTTP/1.1 for one folder and this machine: GET and HEAD, one request a connection.

use std::io::{self, BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::Duration;

use crate::cmd::play::pages::{Pages, plain};
use crate::failure::{Exit, Failure};

/// Bytes of a request's head at most.
const HEAD: u64 = 16 * 1024;
/// Connections that are served at once; more wait in the system's queue.
const CONNECTIONS: usize = 32;
/// A browser that says nothing for so long is gone.
const PATIENCE: Duration = Duration::from_secs(10);

/// Serves until a signal ends the program.
pub(crate) fn serve(listener: &TcpListener, pages: &Pages) -> Result<Exit, Failure> {
    let open = &AtomicUsize::new(0);
    thread::scope(|scope| {
        for stream in listener.incoming() {
            // A connection that was given up meanwhile is no fault of the server; without any, a short rest.
            let Ok(stream) = stream else {
                thread::sleep(Duration::from_millis(20));
                continue;
            };
            while open.load(Ordering::Relaxed) >= CONNECTIONS {
                thread::sleep(Duration::from_millis(5));
            }
            open.fetch_add(1, Ordering::Relaxed);
            scope.spawn(move || {
                let _ = answer(&stream, pages);
                open.fetch_sub(1, Ordering::Relaxed);
            });
        }
    });
    Ok(Exit::Done)
}

fn answer(mut stream: &TcpStream, pages: &Pages) -> io::Result<()> {
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    let head = read_head(stream)?;
    let response = respond(&head, pages);
    stream.write_all(&response)
}

/// The lines of a request up to the empty one.
fn read_head(stream: impl Read) -> io::Result<Vec<String>> {
    let mut lines = Vec::new();
    let mut reader = BufReader::new(stream.take(HEAD));
    loop {
        let mut line = String::new();
        let read = reader.read_line(&mut line)?;
        let line = line.trim_end_matches(['\r', '\n']);
        if read == 0 || line.is_empty() {
            return Ok(lines);
        }
        lines.push(line.to_owned());
    }
}

/// The whole response to a request.
fn respond(head: &[String], pages: &Pages) -> Vec<u8> {
    let mut words = head.first().map_or("", String::as_str).split(' ');
    let (method, path) = (words.next().unwrap_or(""), words.next().unwrap_or(""));
    if !matches!(method, "GET" | "HEAD") {
        return message(
            "405 Method Not Allowed",
            "text/plain",
            b"only GET and HEAD",
            true,
        );
    }
    // A page of another host whose name was made to lead here must not read this one.
    if !head.iter().any(|line| is_here(line)) {
        return message(
            "403 Forbidden",
            "text/plain",
            b"only as 127.0.0.1 or localhost",
            true,
        );
    }
    let body = method == "GET";
    let found = plain(path).and_then(|name| pages.read(&name).map(|bytes| (name, bytes)));
    match found {
        Some((name, bytes)) => message("200 OK", kind(&name), &bytes, body),
        None => message(
            "404 Not Found",
            "text/plain",
            b"there is no such page",
            body,
        ),
    }
}

fn is_here(line: &str) -> bool {
    let Some((name, value)) = line.split_once(':') else {
        return false;
    };
    let host = value.trim();
    let host = host.rsplit_once(':').map_or(host, |(host, _)| host);
    name.eq_ignore_ascii_case("host") && matches!(host, "127.0.0.1" | "localhost")
}

fn message(status: &str, kind: &str, bytes: &[u8], body: bool) -> Vec<u8> {
    let head = format!(
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nX-Content-Type-Options: nosniff\r\n\
         Cross-Origin-Resource-Policy: same-origin\r\nReferrer-Policy: no-referrer\r\nCache-Control: no-cache\r\nConnection: close\r\n\r\n",
        bytes.len()
    );
    let mut message = head.into_bytes();
    if body {
        message.extend_from_slice(bytes);
    }
    message
}

/// The media type of a file by the ending of its name.
fn kind(name: &str) -> &'static str {
    match name.rsplit_once('.').map_or("", |(_, ending)| ending) {
        "html" => "text/html; charset=utf-8",
        "js" => "text/javascript; charset=utf-8",
        "css" => "text/css; charset=utf-8",
        "json" => "application/json",
        "wasm" => "application/wasm",
        "svg" => "image/svg+xml",
        "png" => "image/png",
        "gif" => "image/gif",
        "scene" | "obj" | "mtl" => "text/plain; charset=utf-8",
        _ => "application/octet-stream",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(request: &str) -> String {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("index.html"), "first").unwrap();
        let pages = Pages::find(Some(folder.path())).unwrap();
        let head = read_head(request.as_bytes()).unwrap();
        String::from_utf8(respond(&head, &pages)).unwrap()
    }

    #[test]
    fn get_has_the_file_and_head_its_size() {
        let get = asked("GET / HTTP/1.1\r\nHost: 127.0.0.1:8017\r\n\r\n");
        assert!(
            get.starts_with("HTTP/1.1 200")
                && get.ends_with("\r\n\r\nfirst")
                && get.contains("text/html")
        );
        let head = asked("HEAD /index.html HTTP/1.1\r\nhost: localhost:1\r\n\r\n");
        assert!(head.contains("Content-Length: 5") && head.ends_with("\r\n\r\n"));
    }

    #[test]
    fn all_else_is_refused() {
        for (request, status) in [
            ("POST / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n", "405"),
            ("GET / HTTP/1.1\r\nHost: other.example\r\n\r\n", "403"),
            ("GET / HTTP/1.1\r\n\r\n", "403"),
            (
                "GET /../index.html HTTP/1.1\r\nHost: localhost\r\n\r\n",
                "404",
            ),
            ("GET /none HTTP/1.1\r\nHost: localhost\r\n\r\n", "404"),
            ("", "405"),
        ] {
            let answer = asked(request);
            assert!(
                answer.starts_with(&format!("HTTP/1.1 {status}")),
                "{request:?}: {answer}"
            );
        }
    }

    #[test]
    fn endless_heads_end() {
        let lines = read_head(io::repeat(b'a').take(1 << 20));
        assert_eq!(lines.unwrap()[0].len() as u64, HEAD);
    }
}
