//! TLS of the page and the API.

use std::path::Path;
use std::sync::Arc;

use axum_server::tls_rustls::RustlsConfig;
use rustls::ServerConfig;
use rustls::pki_types::pem::PemObject as _;
use rustls::pki_types::{CertificateDer, PrivateKeyDer};

use crate::config::HttpConfig;
use crate::error::ServeError;

/// What the configuration says of TLS; `None` where it says nothing.
///
/// # Errors
/// [`ServeError`] names the file that cannot be read or holds something else, and the certificate
/// where its key is another's.
pub fn tls(config: &HttpConfig) -> Result<Option<RustlsConfig>, ServeError> {
    let (Some(certificate), Some(key)) = (&config.tls_certificate, &config.tls_key) else {
        return Ok(None);
    };
    let chain = CertificateDer::pem_slice_iter(&read(certificate)?)
        .collect::<Result<Vec<_>, _>>()
        .unwrap_or_default();
    if chain.is_empty() {
        return Err(expected(
            "http.tls_certificate",
            "certificates",
            certificate,
        ));
    }
    // No message of the parser is shown: it might show the key.
    let own = PrivateKeyDer::from_pem_slice(&read(key)?);
    let own = own.map_err(|_| expected("http.tls_key", "a private key", key))?;
    let builder = ServerConfig::builder().with_no_client_auth();
    let server = builder.with_single_cert(chain, own);
    let mut server = server.map_err(|cause| {
        let cause = std::io::Error::other(cause);
        ServeError::io("use", certificate, &cause)
    })?;
    server.alpn_protocols = vec![b"http/1.1".to_vec()];
    Ok(Some(RustlsConfig::from_config(Arc::new(server))))
}

fn read(path: &Path) -> Result<Vec<u8>, ServeError> {
    std::fs::read(path).map_err(|cause| ServeError::io("read", path, &cause))
}

fn expected(option: &str, what: &str, path: &Path) -> ServeError {
    let found = format!("none in {}", path.display());
    ServeError::option(option, format!("{what} in PEM"), found)
}
