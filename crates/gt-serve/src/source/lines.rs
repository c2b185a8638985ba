//! Lines of JSON, from standard input or over TCP.

use std::io::{BufRead, BufReader, Read};
use std::net::{TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::Duration;

use super::message::{self, Origin};
use crate::clock::now_ns;
use crate::hub::Hub;
use crate::metrics::count;

/// Malformed lines of one source that are shown; all are counted.
const SHOWN: u32 = 5;
/// How long a connection may say nothing.
const SILENCE: Duration = Duration::from_secs(3600);
/// How often a waiting listener looks whether to stop.
const PATIENCE: Duration = Duration::from_millis(100);

/// Reads lines until the end. A line that is too long, or no message, is counted and skipped.
pub fn read_all(hub: &Hub, source: impl Read, longest_line: usize, name: &str) {
    let mut source = BufReader::new(source);
    let mut line = Vec::new();
    let mut shown = 0;
    let mut complain = |what: &dyn std::fmt::Display| {
        count(&hub.metrics.malformed);
        shown += 1;
        if shown <= SHOWN {
            tracing::warn!(source = name, "{what}");
        }
    };
    while !hub.is_stopping() {
        line.clear();
        let limit = longest_line as u64 + 1;
        match source.by_ref().take(limit).read_until(b'\n', &mut line) {
            Ok(0) => return,
            Ok(_) => {}
            Err(cause) => {
                tracing::warn!(source = name, %cause, "reading ends");
                return;
            }
        }
        if line.len() > longest_line && line.last() != Some(&b'\n') {
            complain(&format_args!("a line of more than {longest_line} bytes"));
            if !skip_line(&mut source) {
                return;
            }
            continue;
        }
        if line.iter().all(u8::is_ascii_whitespace) {
            continue;
        }
        match message::read(hub, &line, Origin::default(), now_ns()) {
            Ok(understood) => {
                let unknown = understood.unknown as u64;
                hub.metrics.unknown.fetch_add(unknown, Ordering::Relaxed);
                if !hub.offer(understood.batch) {
                    return;
                }
            }
            Err(error) => complain(&error),
        }
    }
}

/// Goes to the end of a line without keeping it; false at the end of all.
fn skip_line(source: &mut impl BufRead) -> bool {
    loop {
        let (used, found) = match source.fill_buf() {
            Ok([]) | Err(_) => return false,
            Ok(buffer) => match buffer.iter().position(|byte| *byte == b'\n') {
                Some(place) => (place + 1, true),
                None => (buffer.len(), false),
            },
        };
        source.consume(used);
        if found {
            return true;
        }
    }
}

/// Takes connections and reads their lines, each on a thread of its own, until the service stops.
pub fn listen(hub: &Arc<Hub>, listener: &TcpListener, longest_line: usize, connections: usize) {
    let open = Arc::new(AtomicUsize::new(0));
    if let Err(cause) = listener.set_nonblocking(true) {
        tracing::error!(%cause, "lines over TCP");
        return;
    }
    while !hub.is_stopping() {
        match listener.accept() {
            Ok((stream, peer)) => {
                if open.load(Ordering::SeqCst) >= connections {
                    tracing::warn!(%peer, connections, "refused: too many connections");
                    continue;
                }
                open.fetch_add(1, Ordering::SeqCst);
                let (hub, own) = (Arc::clone(hub), Arc::clone(&open));
                let read = move || {
                    if let Err(cause) = prepare(&stream) {
                        tracing::warn!(%peer, %cause, "connection");
                    } else {
                        read_all(&hub, stream, longest_line, &peer.to_string());
                    }
                    own.fetch_sub(1, Ordering::SeqCst);
                };
                if let Err(cause) = thread::Builder::new().name("lines".to_owned()).spawn(read) {
                    tracing::error!(%cause, "no thread for a connection");
                    open.fetch_sub(1, Ordering::SeqCst);
                }
            }
            Err(_) => thread::sleep(PATIENCE),
        }
    }
}

fn prepare(stream: &TcpStream) -> std::io::Result<()> {
    stream.set_nonblocking(false)?;
    stream.set_read_timeout(Some(SILENCE))
}
