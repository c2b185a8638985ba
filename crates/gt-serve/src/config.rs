//! The configuration file.

use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::error::ServeError;
use crate::pipeline::{AlarmOptions, HygieneOptions};
use crate::queue::QueuePolicy;

/// Where the page is unless the configuration says otherwise.
pub const DEFAULT_LISTEN: SocketAddr =
    SocketAddr::new(std::net::IpAddr::V4(std::net::Ipv4Addr::LOCALHOST), 8471);

/// All of it. What is left out keeps its default; without a machine the embedded turbine runs.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ServeConfig {
    /// Where alarms and snapshots are kept; in memory alone where it is left out.
    pub state_dir: Option<PathBuf>,
    /// Seconds between two snapshots of a machine; 10 unless given.
    pub snapshot_s: Option<f64>,
    /// The page and the API.
    pub http: HttpConfig,
    /// Between sources and detectors.
    pub queue: QueueConfig,
    /// The embedded turbine; runs where there is this section or no machine.
    pub plant: Option<PlantConfig>,
    /// The machines.
    #[serde(rename = "machine")]
    pub machines: Vec<MachineConfig>,
    /// Lines of JSON.
    pub lines: LinesConfig,
    /// A broker.
    pub mqtt: Option<MqttConfig>,
    /// Records that are played.
    #[serde(rename = "replay")]
    pub replays: Vec<ReplayConfig>,
    /// Logs of all that comes and is said.
    pub recorder: Option<RecorderConfig>,
}

/// The page and the API.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct HttpConfig {
    /// The address; 127.0.0.1:8471 unless given, or a free port if that is taken.
    pub listen: Option<SocketAddr>,
    /// A file of tokens (`[[token]]` with `name`, `role`, `token`), needed beyond loopback.
    pub tokens_file: Option<PathBuf>,
    /// A chain of certificates in PEM, needed beyond loopback.
    pub tls_certificate: Option<PathBuf>,
    /// Its private key in PEM.
    pub tls_key: Option<PathBuf>,
    /// Streams of events at once, one for each open page; who comes when there are as many is told so.
    pub streams: usize,
}

impl Default for HttpConfig {
    fn default() -> Self {
        Self {
            listen: None,
            tokens_file: None,
            tls_certificate: None,
            tls_key: None,
            streams: 64,
        }
    }
}

/// Between sources and detectors.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct QueueConfig {
    /// Messages that wait at most, for each of the threads that judge.
    pub capacity: usize,
    /// What a full queue does.
    pub policy: QueuePolicy,
    /// Threads that judge; as many as there are cores unless given.
    pub workers: Option<usize>,
}

impl Default for QueueConfig {
    fn default() -> Self {
        Self {
            capacity: 8192,
            policy: QueuePolicy::default(),
            workers: None,
        }
    }
}

/// The embedded turbine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PlantConfig {
    /// The machine's name.
    pub machine: String,
    /// How much faster than the clock it runs.
    pub speed: f64,
    /// Seed of its movements and noise.
    pub seed: u64,
    /// A detector of its own; the built-in one where it is left out.
    pub detector: Option<PathBuf>,
}

impl Default for PlantConfig {
    fn default() -> Self {
        Self {
            machine: "turbine".to_owned(),
            speed: 1.0,
            seed: 1,
            detector: None,
        }
    }
}

/// A machine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MachineConfig {
    /// Its name: letters, digits, `_`, `-` and `.`.
    pub name: String,
    /// Its bank or isolator, as `gtfdi design` writes them.
    pub detector: PathBuf,
    /// What its sources call the detector's tags, where they call them otherwise: from their names
    /// to the detector's.
    #[serde(default)]
    pub tags: BTreeMap<String, String>,
    /// How readings become samples.
    #[serde(default)]
    pub hygiene: HygieneOptions,
    /// How alarms come and go.
    #[serde(default)]
    pub alarms: AlarmOptions,
}

/// Lines of JSON.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LinesConfig {
    /// Whether standard input has them; the service stops at its end.
    pub stdin: bool,
    /// An address to listen on for them: loopback only.
    pub tcp: Option<SocketAddr>,
    /// Bytes of a line at most.
    pub longest_line: usize,
    /// Connections at most.
    pub connections: usize,
}

impl Default for LinesConfig {
    fn default() -> Self {
        Self {
            stdin: false,
            tcp: None,
            longest_line: 65_536,
            connections: 64,
        }
    }
}

/// A broker.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MqttConfig {
    /// Its host.
    pub host: String,
    /// Its port; 1883 unless given, 8883 with TLS.
    pub port: Option<u16>,
    /// The client's name, unique at the broker; the broker keeps what it misses under it.
    #[serde(default = "client_id")]
    pub client_id: String,
    /// The user.
    pub username: Option<String>,
    /// A file with the password alone.
    pub password_file: Option<PathBuf>,
    /// Certificates in PEM that the broker's must come from; with it, TLS.
    pub ca_file: Option<PathBuf>,
    /// Topics with readings: one level is `{machine}`, another may be `{tag}`.
    #[serde(default = "reading_topics")]
    pub readings: Vec<String>,
    /// What the topics of alarms begin with.
    #[serde(default = "alarm_prefix")]
    pub alarms: String,
}

fn client_id() -> String {
    "gtfdi".to_owned()
}

fn reading_topics() -> Vec<String> {
    ["plant/{machine}", "plant/{machine}/{tag}"]
        .map(str::to_owned)
        .to_vec()
}

fn alarm_prefix() -> String {
    "gtfdi".to_owned()
}

/// A record that is played.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ReplayConfig {
    /// An MCAP, CSV or Parquet file.
    pub file: PathBuf,
    /// The machine that it is of.
    pub machine: String,
    /// How much faster than the clock; as fast as it goes where it is 0.
    #[serde(default)]
    pub speed: f64,
}

/// Logs of all that comes and is said, a folder a machine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RecorderConfig {
    /// Where they are.
    pub folder: PathBuf,
    /// Seconds that a file spans.
    #[serde(default = "an_hour")]
    pub span_s: u64,
    /// Bytes after which a file ends.
    #[serde(default = "a_gibibyte")]
    pub max_bytes: u64,
    /// How long files are kept, in seconds.
    pub keep_s: Option<u64>,
    /// How many bytes of a machine's files are kept.
    pub keep_bytes: Option<u64>,
    /// What is done when the disk takes less than comes. Without it the oldest is dropped and
    /// counted, so that no disk holds up an alarm, but where records are played and nothing else:
    /// they wait.
    pub policy: Option<QueuePolicy>,
}

fn an_hour() -> u64 {
    3600
}

fn a_gibibyte() -> u64 {
    1 << 30
}

impl ServeConfig {
    /// Reads and checks a file; relative paths in it are from its folder.
    ///
    /// # Errors
    /// [`ServeError`] names the file and the line, or the option.
    pub fn read(path: &Path) -> Result<Self, ServeError> {
        let text = std::fs::read_to_string(path);
        let text = text.map_err(|cause| ServeError::io("read", path, &cause))?;
        let mut config: Self = toml::from_str(&text).map_err(|cause| ServeError::Config {
            path: path.to_owned(),
            cause: cause.to_string(),
        })?;
        if let Some(folder) = path.parent() {
            config.rebase(folder);
        }
        config.check()?;
        Ok(config)
    }

    fn rebase(&mut self, folder: &Path) {
        let mut paths: Vec<&mut PathBuf> = Vec::new();
        paths.extend(&mut self.state_dir);
        let http = &mut self.http;
        for path in [
            &mut http.tokens_file,
            &mut http.tls_certificate,
            &mut http.tls_key,
        ] {
            paths.extend(path);
        }
        if let Some(plant) = &mut self.plant {
            paths.extend(&mut plant.detector);
        }
        paths.extend(
            self.machines
                .iter_mut()
                .map(|machine| &mut machine.detector),
        );
        paths.extend(self.replays.iter_mut().map(|replay| &mut replay.file));
        if let Some(mqtt) = &mut self.mqtt {
            paths.extend(&mut mqtt.password_file);
            paths.extend(&mut mqtt.ca_file);
        }
        paths.extend(self.recorder.iter_mut().map(|own| &mut own.folder));
        for path in paths {
            *path = folder.join(&*path);
        }
    }

    /// The embedded turbine, where it runs.
    pub fn embedded(&self) -> Option<PlantConfig> {
        let default = || self.machines.is_empty().then(PlantConfig::default);
        self.plant.clone().or_else(default)
    }

    /// Whether something comes that does not wait: a machine at work.
    pub(crate) fn has_live_source(&self) -> bool {
        let lines = &self.lines;
        self.embedded().is_some() || self.mqtt.is_some() || lines.stdin || lines.tcp.is_some()
    }

    /// Refuses what makes no sense, and what would not be safe.
    ///
    /// # Errors
    /// [`ServeError::Option`] with the first such option.
    pub fn check(&self) -> Result<(), ServeError> {
        self.check_machines()?;
        self.check_http()?;
        let in_range = |option: &str, found: f64, low: f64, high: f64| {
            if (low..=high).contains(&found) {
                return Ok(());
            }
            let expected = format!("{low} to {high}");
            Err(ServeError::option(option, expected, found.to_string()))
        };
        in_range("queue.capacity", self.queue.capacity as f64, 16.0, 1e7)?;
        if let Some(workers) = self.queue.workers {
            in_range("queue.workers", workers as f64, 1.0, 256.0)?;
        }
        if let Some(snapshot_s) = self.snapshot_s {
            in_range("snapshot_s", snapshot_s, 1.0, 3600.0)?;
        }
        let lines = &self.lines;
        in_range("lines.longest_line", lines.longest_line as f64, 64.0, 1e7)?;
        in_range("lines.connections", lines.connections as f64, 1.0, 1e4)?;
        in_range("http.streams", self.http.streams as f64, 1.0, 1e4)?;
        if let Some(address) = lines.tcp.filter(|address| !address.ip().is_loopback()) {
            return Err(ServeError::option(
                "lines.tcp",
                "a loopback address: these lines carry no token; beyond it use MQTT with TLS",
                address.to_string(),
            ));
        }
        for replay in &self.replays {
            in_range("replay.speed", replay.speed, 0.0, 1e6)?;
        }
        self.check_mqtt()
    }

    fn check_machines(&self) -> Result<(), ServeError> {
        let embedded = self.embedded();
        if let Some(plant) = &embedded
            && !(plant.speed >= 0.01 && plant.speed <= 1000.0)
        {
            let found = plant.speed.to_string();
            return Err(ServeError::option("plant.speed", "0.01 to 1000", found));
        }
        let own = self.machines.iter().map(|machine| &machine.name);
        let names: Vec<&String> = own
            .chain(embedded.iter().map(|plant| &plant.machine))
            .collect();
        for (place, name) in names.iter().enumerate() {
            let is_safe = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '.');
            if name.is_empty()
                || name.len() > 64
                || !name.chars().all(is_safe)
                || name.starts_with('.')
            {
                return Err(ServeError::option(
                    "machine.name",
                    "1 to 64 letters, digits, `_`, `-` and `.`, not first a `.`",
                    format!("`{name}`"),
                ));
            }
            if names[..place].contains(name) {
                let found = format!("`{name}` twice");
                return Err(ServeError::option(
                    "machine.name",
                    "names that differ",
                    found,
                ));
            }
        }
        for replay in &self.replays {
            if !names.contains(&&replay.machine) {
                let all: Vec<&str> = names.iter().map(|name| name.as_str()).collect();
                return Err(ServeError::option(
                    "replay.machine",
                    format!("one of {}", all.join(", ")),
                    format!("`{}`", replay.machine),
                ));
            }
        }
        Ok(())
    }

    fn check_http(&self) -> Result<(), ServeError> {
        let http = &self.http;
        if http.tls_certificate.is_some() != http.tls_key.is_some() {
            let (option, other) = if http.tls_key.is_some() {
                ("http.tls_certificate", "http.tls_key")
            } else {
                ("http.tls_key", "http.tls_certificate")
            };
            let expected = format!("a file, because there is {other}");
            return Err(ServeError::option(option, expected, "none"));
        }
        if let Some(address) = http.listen.filter(|address| !address.ip().is_loopback()) {
            let needed = [
                ("http.tokens_file", &http.tokens_file),
                ("http.tls_certificate", &http.tls_certificate),
            ];
            for (option, file) in needed {
                if file.is_none() {
                    let expected =
                        format!("a file, because http.listen is {address}, not loopback");
                    return Err(ServeError::option(option, expected, "none"));
                }
            }
        }
        Ok(())
    }

    fn check_mqtt(&self) -> Result<(), ServeError> {
        let Some(mqtt) = &self.mqtt else {
            return Ok(());
        };
        for topic in &mqtt.readings {
            let levels: Vec<&str> = topic.split('/').collect();
            let machines = levels.iter().filter(|level| **level == "{machine}").count();
            let tags = levels.iter().filter(|level| **level == "{tag}").count();
            let odd = levels
                .iter()
                .any(|level| level.contains(['#', '+', '\0']) || level.is_empty());
            if machines != 1 || tags > 1 || odd {
                return Err(ServeError::option(
                    "mqtt.readings",
                    "levels between `/`, one of them `{machine}`, at most one `{tag}`, no wildcard",
                    format!("`{topic}`"),
                ));
            }
        }
        let is_local = mqtt.host == "localhost"
            || mqtt
                .host
                .parse()
                .is_ok_and(|ip: std::net::IpAddr| ip.is_loopback());
        if mqtt.password_file.is_some() && mqtt.ca_file.is_none() && !is_local {
            return Err(ServeError::option(
                "mqtt.ca_file",
                "a file, because a password would go over the network in the clear",
                "none",
            ));
        }
        if mqtt.alarms.is_empty() || mqtt.alarms.contains(['#', '+', '\0']) {
            let found = format!("`{}`", mqtt.alarms);
            return Err(ServeError::option(
                "mqtt.alarms",
                "a topic without wildcards",
                found,
            ));
        }
        Ok(())
    }
}
