//! Who may do what.

use std::collections::HashMap;
use std::net::IpAddr;
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use subtle::ConstantTimeEq;

use crate::error::ServeError;

/// The least characters of a token: 32 of them cannot be guessed.
const SHORTEST_TOKEN: usize = 32;
/// Wrong tokens from one address within [`WINDOW`] after which it has to wait.
const PATIENCE: u32 = 20;
/// How long wrong tokens are remembered.
const WINDOW: Duration = Duration::from_secs(60);
/// Addresses that are remembered at most.
const ADDRESSES: usize = 10_000;

/// What somebody may do; each may do what those before it may.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// To look.
    Read,
    /// To acknowledge and to set aside.
    Operate,
    /// To load detectors and to inject faults.
    Administer,
}

/// Somebody who asks.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Caller {
    /// The name of the token; `None` where none is needed.
    pub name: Option<String>,
    /// What they may do.
    pub role: Role,
}

/// Why somebody is not let in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refused {
    /// No token, or a wrong one.
    Token,
    /// Too many wrong ones from this address.
    TooMany,
}

struct Token {
    name: String,
    role: Role,
    /// Of the token: compared in its place, it has one length and says nothing of it.
    digest: [u8; 32],
}

/// The tokens, or that none is needed.
#[derive(Default)]
pub struct Access {
    tokens: Option<Vec<Token>>,
    wrong: Mutex<HashMap<IpAddr, (u32, Instant)>>,
}

/// A file of tokens.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TokensFile {
    token: Vec<TokenEntry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TokenEntry {
    name: String,
    role: Role,
    token: String,
}

impl Access {
    /// Everybody who reaches the service may do everything: for loopback alone.
    pub fn open() -> Self {
        Self::default()
    }

    /// Those of a file. No message of it says a token.
    ///
    /// # Errors
    /// [`ServeError`] when the file cannot be read, others may read it, it is not of its form, or a
    /// token is short.
    pub fn read(path: &Path) -> Result<Self, ServeError> {
        check_mode(path)?;
        let text = std::fs::read_to_string(path);
        let text = text.map_err(|cause| ServeError::io("read", path, &cause))?;
        // The parser's own message shows the line, and with it perhaps a token.
        let file: TokensFile = toml::from_str(&text).map_err(|cause| ServeError::Config {
            path: path.to_owned(),
            cause: format!(
                "expected [[token]] with name, role (read, operate, administer) and token: {}",
                place(&text, &cause)
            ),
        })?;
        let mut tokens = Vec::new();
        for entry in file.token {
            if entry.token.chars().count() < SHORTEST_TOKEN {
                return Err(ServeError::option(
                    format!("{}: token `{}`", path.display(), entry.name),
                    format!("{SHORTEST_TOKEN} characters or more"),
                    entry.token.chars().count().to_string(),
                ));
            }
            tokens.push(Token {
                name: entry.name,
                role: entry.role,
                digest: Sha256::digest(entry.token.as_bytes()).into(),
            });
        }
        if tokens.is_empty() {
            let found = "none";
            return Err(ServeError::option(
                path.display().to_string(),
                "a token",
                found,
            ));
        }
        Ok(Self {
            tokens: Some(tokens),
            ..Self::default()
        })
    }

    /// Whether a token is needed.
    pub fn needs_token(&self) -> bool {
        self.tokens.is_some()
    }

    /// Who it is that comes from an address with a header `Authorization`.
    ///
    /// # Errors
    /// [`Refused`] when they are not let in.
    pub fn admit(&self, address: IpAddr, header: Option<&[u8]>) -> Result<Caller, Refused> {
        let Some(tokens) = &self.tokens else {
            return Ok(Caller {
                name: None,
                role: Role::Administer,
            });
        };
        if self.waits(address) {
            return Err(Refused::TooMany);
        }
        let Some(token) = header.and_then(|header| header.strip_prefix(b"Bearer ")) else {
            // No guess was made.
            return Err(Refused::Token);
        };
        let digest = Sha256::digest(token);
        // All are compared, whichever it is.
        let mut found = None;
        for own in tokens {
            if bool::from(own.digest[..].ct_eq(&digest[..])) {
                found = Some(own);
            }
        }
        if let Some(token) = found {
            return Ok(Caller {
                name: Some(token.name.clone()),
                role: token.role,
            });
        }
        self.remember(address);
        Err(Refused::Token)
    }

    fn waits(&self, address: IpAddr) -> bool {
        let wrong = self.wrong.lock().unwrap_or_else(PoisonError::into_inner);
        wrong
            .get(&address)
            .is_some_and(|(count, since)| *count >= PATIENCE && since.elapsed() < WINDOW)
    }

    fn remember(&self, address: IpAddr) {
        let mut wrong = self.wrong.lock().unwrap_or_else(PoisonError::into_inner);
        if wrong.len() >= ADDRESSES {
            wrong.retain(|_, (_, since)| since.elapsed() < WINDOW);
            if wrong.len() >= ADDRESSES {
                wrong.clear();
            }
        }
        let own = wrong.entry(address).or_insert((0, Instant::now()));
        if own.1.elapsed() >= WINDOW {
            *own = (0, Instant::now());
        }
        own.0 += 1;
    }
}

/// The line of an error of the parser.
fn place(text: &str, cause: &toml::de::Error) -> String {
    let start = cause.span().map_or(0, |span| span.start);
    let line = text
        .get(..start)
        .map_or(0, |before| before.matches('\n').count())
        + 1;
    format!("line {line}")
}

#[cfg(unix)]
fn check_mode(path: &Path) -> Result<(), ServeError> {
    use std::os::unix::fs::PermissionsExt as _;

    let metadata = std::fs::metadata(path).map_err(|cause| ServeError::io("read", path, &cause))?;
    let mode = metadata.permissions().mode() & 0o777;
    if mode & 0o077 != 0 {
        return Err(ServeError::option(
            format!("{}: mode", path.display()),
            "600: nobody but the service may read it (chmod 600)",
            format!("{mode:o}"),
        ));
    }
    Ok(())
}

#[cfg(not(unix))]
fn check_mode(_path: &Path) -> Result<(), ServeError> {
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const HERE: IpAddr = IpAddr::V4(std::net::Ipv4Addr::LOCALHOST);
    const GOOD: &str = "0123456789abcdef0123456789abcdef";

    fn access(text: &str) -> Result<Access, ServeError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("tokens.toml");
        std::fs::write(&path, text).unwrap();
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt as _;
            std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o600)).unwrap();
        }
        Access::read(&path)
    }

    fn one() -> Access {
        let text = format!("[[token]]\nname = \"desk\"\nrole = \"operate\"\ntoken = \"{GOOD}\"\n");
        access(&text).unwrap()
    }

    #[test]
    fn a_right_token_has_its_role_and_no_other_is_let_in() {
        let access = one();
        let header = |token: &str| format!("Bearer {token}").into_bytes();
        let caller = access.admit(HERE, Some(&header(GOOD))).unwrap();
        assert_eq!(caller.name.as_deref(), Some("desk"));
        assert_eq!(caller.role, Role::Operate);
        for wrong in [&GOOD[..31], "", "0123456789abcdef0123456789abcdeg"] {
            let refused = access.admit(HERE, Some(&header(wrong)));
            assert_eq!(refused, Err(Refused::Token), "{wrong}");
        }
        assert_eq!(access.admit(HERE, None), Err(Refused::Token));
        assert_eq!(access.admit(HERE, Some(b"Basic x")), Err(Refused::Token));
    }

    #[test]
    fn who_guesses_has_to_wait_and_others_do_not() {
        let access = one();
        let there = IpAddr::V4(std::net::Ipv4Addr::new(10, 0, 0, 1));
        for _ in 0..PATIENCE {
            assert_eq!(access.admit(there, Some(b"Bearer x")), Err(Refused::Token));
        }
        let right = format!("Bearer {GOOD}").into_bytes();
        for _ in 0..10_000 {
            assert_eq!(
                access.admit(there, Some(b"Bearer x")),
                Err(Refused::TooMany)
            );
        }
        assert_eq!(access.admit(there, Some(&right)), Err(Refused::TooMany));
        assert!(access.admit(HERE, Some(&right)).is_ok());
    }

    #[test]
    fn what_is_wrong_with_a_file_is_said_without_its_tokens() {
        let secret = "hunter2hunter2hunter2";
        for text in [
            format!("[[token]]\nname = \"a\"\nrole = \"read\"\ntoken = \"{secret}\"\n"),
            format!("[[token]]\nname = \"a\"\nrole = \"king\"\ntoken = \"{secret}\"\n"),
            format!("[[token]]\nname = \"a\"\ntoken = {secret}\n"),
            format!("token = \"{secret}\"\n"),
        ] {
            let error = access(&text).map(|_| ()).unwrap_err().to_string();
            assert!(!error.contains(secret), "{error}");
        }
    }
}
