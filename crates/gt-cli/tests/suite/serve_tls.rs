//! The monitoring service beyond loopback: TLS of the page and of the broker, with certificates that
//! are made for the test.

use std::io::{Read as _, Write as _};
use std::net::{SocketAddr, TcpStream};
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use rcgen::{BasicConstraints, CertificateParams, CertifiedIssuer, DnType, IsCa, KeyPair};
use rustls::pki_types::{CertificateDer, ServerName};
use rustls::{ClientConfig, ClientConnection, RootCertStore, StreamOwned};
use serde_json::Value;

use crate::place::Place;
use crate::serving::{PATIENCE, Serving};

const TOKEN: &str = "0123456789abcdef0123456789abcdef";

/// An authority, and a certificate of it for `localhost` in `NAME.pem` with its key in `NAME.key`.
fn authority(place: &Place, name: &str) -> CertificateDer<'static> {
    let mut params = CertificateParams::new(Vec::new()).unwrap();
    let title = format!("authority of the {name}");
    params.distinguished_name.push(DnType::CommonName, title);
    params.is_ca = IsCa::Ca(BasicConstraints::Unconstrained);
    let authority = CertifiedIssuer::self_signed(params, KeyPair::generate().unwrap()).unwrap();
    let key = KeyPair::generate().unwrap();
    let own = CertificateParams::new(vec!["localhost".to_owned()]).unwrap();
    let own = own.signed_by(&key, &authority).unwrap();
    place.write(&format!("{name}_ca.pem"), authority.pem());
    place.write(&format!("{name}.pem"), own.pem());
    place.write(&format!("{name}.key"), key.serialize_pem());
    authority.der().clone()
}

/// Asks over TLS, trusting this authority alone: the status and the body, or why there is no answer.
fn ask(
    address: SocketAddr,
    authority: &CertificateDer<'static>,
    path: &str,
    headers: &str,
) -> Result<(u16, String), String> {
    let mut roots = RootCertStore::empty();
    roots.add(authority.clone()).unwrap();
    let provider = Arc::new(rustls::crypto::ring::default_provider());
    let config = ClientConfig::builder_with_provider(provider)
        .with_safe_default_protocol_versions()
        .unwrap()
        .with_root_certificates(roots)
        .with_no_client_auth();
    let name = ServerName::try_from("localhost").unwrap();
    let connection = ClientConnection::new(Arc::new(config), name).unwrap();
    let stream = TcpStream::connect(address).unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    let mut stream = StreamOwned::new(connection, stream);
    let head = format!(
        "GET {path} HTTP/1.1\r\nHost: localhost:{}\r\n{headers}Connection: close\r\n\r\n",
        address.port()
    );
    stream
        .write_all(head.as_bytes())
        .map_err(|error| error.to_string())?;
    let mut text = String::new();
    // One that closes without a goodbye has said all the same what it had to say.
    if let Err(error) = stream.read_to_string(&mut text)
        && text.is_empty()
    {
        return Err(error.to_string());
    }
    let (head, body) = text.split_once("\r\n\r\n").unwrap_or_default();
    let status = head.split(' ').nth(1).and_then(|code| code.parse().ok());
    Ok((status.unwrap_or(0), body.to_owned()))
}

fn write_tokens(place: &Place) {
    let entry =
        format!("[[token]]\nname = \"control room\"\nrole = \"read\"\ntoken = \"{TOKEN}\"\n");
    place.write("tokens.toml", entry);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        let mode = std::fs::Permissions::from_mode(0o600);
        std::fs::set_permissions(place.path("tokens.toml"), mode).unwrap();
    }
}

/// On all addresses, with tokens and TLS: who trusts the authority and has the token is answered, and
/// nobody else; in the clear nothing is said.
#[test]
fn beyond_loopback_all_is_under_tls() {
    let place = Place::new();
    let trusted = authority(&place, "page");
    let stranger = authority(&place, "stranger");
    write_tokens(&place);
    place.write(
        "serve.toml",
        "[http]\nlisten = \"0.0.0.0:0\"\ntokens_file = \"tokens.toml\"\n\
         tls_certificate = \"page.pem\"\ntls_key = \"page.key\"\n",
    );
    let serving = Serving::start(&mut place.command(&["serve", "--config", "serve.toml"]));
    let address = SocketAddr::from(([127, 0, 0, 1], serving.address.port()));
    let token = format!("Authorization: Bearer {TOKEN}\r\n");
    let (status, body) = ask(address, &trusted, "/api/v1/info", &token).unwrap();
    assert_eq!(status, 200, "{body}");
    let info: Value = serde_json::from_str(&body).unwrap();
    assert_eq!(info["role"], "read");
    let (status, _) = ask(address, &trusted, "/api/v1/info", "").unwrap();
    assert_eq!(status, 401);
    let refused = ask(address, &stranger, "/api/v1/info", &token).unwrap_err();
    assert!(refused.contains("certificate"), "{refused}");
    // In the clear.
    let mut stream = TcpStream::connect(address).unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    stream
        .write_all(b"GET /api/v1/info HTTP/1.1\r\nHost: localhost\r\n\r\n")
        .unwrap();
    let mut bytes = Vec::new();
    let _ = stream.read_to_end(&mut bytes);
    assert!(!bytes.starts_with(b"HTTP/"), "{bytes:?}");
    assert_eq!(serving.stop().code(), Some(0));
}

/// A certificate that is none is said before anything listens.
#[test]
fn a_certificate_that_is_none_is_refused() {
    let place = Place::new();
    authority(&place, "page");
    authority(&place, "stranger");
    write_tokens(&place);
    place.write("none.pem", "not a certificate\n");
    for (certificate, key, said) in [
        (
            "none.pem",
            "page.key",
            "http.tls_certificate: expected certificates in PEM, found none in none.pem",
        ),
        (
            "page.pem",
            "page.pem",
            "http.tls_key: expected a private key in PEM, found none in page.pem",
        ),
        ("page.pem", "not_there.key", "not_there.key"),
        ("page.pem", "stranger.key", "page.pem: cannot use"),
    ] {
        place.write(
            "serve.toml",
            format!(
                "[http]\nlisten = \"127.0.0.1:0\"\ntokens_file = \"tokens.toml\"\n\
                 tls_certificate = \"{certificate}\"\ntls_key = \"{key}\"\n"
            ),
        );
        place.refused(&["serve", "--config", "serve.toml"], &[said]);
    }
}

/// A broker with TLS and a password, killed when it is dropped.
struct Broker(Child);

impl Broker {
    fn start(place: &Place, port: u16) -> Option<Self> {
        let mut passwd = Command::new("mosquitto_passwd");
        let file = place.path("passwords");
        passwd.args(["-b", "-c"]).arg(&file);
        let made = passwd.args(["gtfdi", "not a secret"]).status();
        if !made.is_ok_and(|own| own.success()) {
            println!("skipped: no mosquitto on this machine");
            return None;
        }
        let at = |name: &str| place.path(name).display().to_string();
        // A broker that root starts would give up the right to read these files.
        place.write(
            "broker.conf",
            format!(
                "user root\nlistener {port} 127.0.0.1\nallow_anonymous false\npassword_file {}\n\
                 cafile {}\ncertfile {}\nkeyfile {}\n",
                at("passwords"),
                at("broker_ca.pem"),
                at("broker.pem"),
                at("broker.key"),
            ),
        );
        let start = |program: &str| {
            let mut command = Command::new(program);
            command.arg("-c").arg(place.path("broker.conf"));
            command.stdout(Stdio::null()).stderr(Stdio::null()).spawn()
        };
        let child = start("mosquitto").or_else(|_| start("/usr/sbin/mosquitto"));
        let broker = Self(child.ok()?);
        let started = Instant::now();
        while TcpStream::connect(("127.0.0.1", port)).is_err() {
            assert!(started.elapsed() < PATIENCE, "the broker does not listen");
            thread::sleep(Duration::from_millis(20));
        }
        Some(broker)
    }
}

impl Drop for Broker {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A broker that wants TLS and a password is reached with the right authority; with another one it is
/// not, which the log says, and the service goes on without it.
#[test]
fn a_broker_is_reached_over_tls() {
    let place = Place::new();
    authority(&place, "broker");
    authority(&place, "stranger");
    place.write("password", "not a secret\n");
    let port = crate::serve_mqtt::free_port();
    let Some(_broker) = Broker::start(&place, port) else {
        return;
    };
    let start = |ca: &str| {
        place.write(
            "serve.toml",
            format!(
                "[http]\nlisten = \"127.0.0.1:0\"\n[plant]\nspeed = 20.0\n\
                 [mqtt]\nhost = \"localhost\"\nport = {port}\nclient_id = \"{ca}\"\n\
                 username = \"gtfdi\"\npassword_file = \"password\"\nca_file = \"{ca}_ca.pem\"\n"
            ),
        );
        Serving::start(&mut place.command(&["serve", "--config", "serve.toml"]))
    };
    let connects = |serving: &Serving| {
        let text = serving.get("/metrics").body;
        let mut lines = text.lines();
        let line = lines.find_map(|line| line.strip_prefix("gtfdi_mqtt_connects_total "));
        line.and_then(|value| value.parse::<f64>().ok())
    };
    let right = start("broker");
    right.wait("the broker", |serving| {
        (connects(serving)? >= 1.0).then_some(())
    });
    assert!(!right.log().contains("not a secret"), "{}", right.log());
    let wrong = start("stranger");
    wrong.wait("the refusal", |serving| {
        serving.log().contains("UnknownIssuer").then_some(())
    });
    assert_eq!(connects(&wrong), Some(0.0));
    assert_eq!(wrong.get("/healthz").status, 200);
}
