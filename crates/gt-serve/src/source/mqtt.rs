//! A broker: readings come from it, alarms go to it.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::thread;
use std::time::Duration;

use rumqttc::{
    Client, Connection, Event, LastWill, MqttOptions, Packet, QoS, TlsConfiguration, Transport,
};
use serde_json::json;
use tokio::sync::broadcast::error::RecvError;

use super::message::{self, Origin};
use crate::clock::now_ns;
use crate::config::MqttConfig;
use crate::error::ServeError;
use crate::hub::Hub;
use crate::metrics::count;

/// Messages on their way to the broker at most.
const OUTGOING: usize = 4096;
/// The largest message that is taken, in bytes.
const LARGEST: usize = 1 << 20;
/// How long after a lost connection the next is tried.
const RETRY: Duration = Duration::from_secs(1);
/// Time without a message after which the broker is asked whether it is there.
const KEEP_ALIVE: Duration = Duration::from_secs(15);
/// Alarms that are over, the last of them, that the broker is told so again after it was away.
const RETRACTED: usize = 200;
/// Malformed messages that are shown; all are counted.
const SHOWN: u32 = 20;

/// A topic with places for the machine and the tag.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Pattern {
    levels: Vec<String>,
}

impl Pattern {
    fn new(topic: &str) -> Self {
        Self {
            levels: topic.split('/').map(str::to_owned).collect(),
        }
    }

    /// What the broker is asked for.
    fn filter(&self) -> String {
        let levels = self.levels.iter().map(|level| match level.as_str() {
            "{machine}" | "{tag}" => "+",
            own => own,
        });
        levels.collect::<Vec<_>>().join("/")
    }

    /// The machine and the tag of a topic of this pattern.
    fn origin<'a>(&self, topic: &'a str) -> Option<Origin<'a>> {
        let mut origin = Origin::default();
        let mut levels = topic.split('/');
        for own in &self.levels {
            let level = levels.next()?;
            match own.as_str() {
                "{machine}" => origin.machine = Some(level),
                "{tag}" => origin.tag = Some(level),
                same if same == level => {}
                _ => return None,
            }
        }
        levels.next().is_none().then_some(origin)
    }
}

/// A broker that is about to be used.
pub struct Broker {
    client: Client,
    connection: Connection,
    patterns: Vec<Pattern>,
    prefix: String,
}

impl Broker {
    /// Nothing is sent yet: a broker that is not there is waited for.
    ///
    /// # Errors
    /// [`ServeError`] when a file that the configuration names cannot be read.
    pub fn new(config: &MqttConfig) -> Result<Self, ServeError> {
        let default = if config.ca_file.is_some() { 8883 } else { 1883 };
        let port = config.port.unwrap_or(default);
        let mut options = MqttOptions::new(&config.client_id, &config.host, port);
        options.set_keep_alive(KEEP_ALIVE);
        // What comes while the service is away is kept by the broker.
        options.set_clean_session(false);
        options.set_max_packet_size(LARGEST, LARGEST);
        let will = LastWill::new(
            format!("{}/status", config.alarms),
            "offline",
            QoS::AtLeastOnce,
            true,
        );
        options.set_last_will(will);
        if let Some(username) = &config.username {
            let password = match &config.password_file {
                Some(path) => std::fs::read_to_string(path)
                    .map_err(|cause| ServeError::io("read", path, &cause))?,
                None => String::new(),
            };
            options.set_credentials(username, password.trim_end_matches(['\r', '\n']));
        }
        if let Some(path) = &config.ca_file {
            let ca = std::fs::read(path).map_err(|cause| ServeError::io("read", path, &cause))?;
            options.set_transport(Transport::Tls(TlsConfiguration::Simple {
                ca,
                alpn: None,
                client_auth: None,
            }));
        }
        let (client, connection) = Client::new(options, OUTGOING);
        Ok(Self {
            client,
            connection,
            patterns: config
                .readings
                .iter()
                .map(|topic| Pattern::new(topic))
                .collect(),
            prefix: config.alarms.clone(),
        })
    }

    /// To publish with from another thread.
    pub fn publisher(&self) -> Publisher {
        Publisher {
            client: self.client.clone(),
            prefix: self.prefix.clone(),
        }
    }

    /// Takes readings until the service stops; a broker that goes away is waited for.
    pub fn run(mut self, hub: &Arc<Hub>) {
        let mut shown = 0;
        // Why there is no broker, as it was last said.
        let mut lost: Option<String> = None;
        let publisher = self.publisher();
        for event in self.connection.iter() {
            if hub.is_stopping() {
                return;
            }
            match event {
                Ok(Event::Incoming(Packet::ConnAck(_))) => {
                    lost = None;
                    count(&hub.metrics.mqtt_connects);
                    tracing::info!("connected to the broker");
                    for pattern in &self.patterns {
                        // The queue to the broker is empty now, or it is told at the next connection.
                        let _ = self
                            .client
                            .try_subscribe(pattern.filter(), QoS::AtLeastOnce);
                    }
                    publisher.say_all(hub);
                }
                Ok(Event::Incoming(Packet::Publish(publish))) => {
                    let mut patterns = self.patterns.iter();
                    let Some(origin) = patterns.find_map(|own| own.origin(&publish.topic)) else {
                        continue;
                    };
                    match message::read(hub, &publish.payload, origin, now_ns()) {
                        Ok(understood) => {
                            let unknown = understood.unknown as u64;
                            hub.metrics.unknown.fetch_add(unknown, Ordering::Relaxed);
                            if !hub.offer(understood.batch) {
                                return;
                            }
                        }
                        Err(error) => {
                            count(&hub.metrics.malformed);
                            shown += 1;
                            if shown <= SHOWN {
                                tracing::warn!(topic = publish.topic, "{error}");
                            }
                        }
                    }
                }
                Ok(_) => {}
                Err(cause) => {
                    let cause = cause.to_string();
                    if lost.as_ref() != Some(&cause) {
                        tracing::warn!(cause, "no broker; it is tried again");
                    }
                    lost = Some(cause);
                    thread::sleep(RETRY);
                }
            }
        }
    }
}

/// Tells the broker of alarms.
#[derive(Clone)]
pub struct Publisher {
    client: Client,
    prefix: String,
}

impl Publisher {
    /// Tells the broker of what happens to alarms until the service stops.
    pub async fn run(self, hub: Arc<Hub>) {
        let mut events = hub.events();
        loop {
            match events.recv().await {
                Ok(event) => {
                    let alarm = &event.alarm;
                    self.send_alarm(&alarm.machine, alarm.id, alarm.is_open().then_some(alarm));
                    if event.event.is_kept() {
                        let topic = format!("{}/events/{}", self.prefix, alarm.machine);
                        self.send(topic, false, json!(&*event).to_string());
                    }
                }
                // What was missed is said again as a whole.
                Err(RecvError::Lagged(_)) => self.say_all(&hub),
                Err(RecvError::Closed) => return,
            }
            if hub.is_stopping() {
                return;
            }
        }
    }

    /// Says that the service is there, and all open alarms.
    fn say_all(&self, hub: &Hub) {
        self.send(format!("{}/status", self.prefix), true, "online".to_owned());
        for alarm in hub.open_alarms() {
            self.send_alarm(&alarm.machine, alarm.id, Some(&alarm));
        }
        // Those that ended while the broker was away may still be retained there.
        let over = hub.history();
        let over = over.alarms().filter(|alarm| !alarm.is_open());
        for alarm in over.take(RETRACTED) {
            self.send_alarm(&alarm.machine, alarm.id, None);
        }
    }

    /// A retained message an open alarm; one that is over is taken back.
    fn send_alarm(&self, machine: &str, id: u64, alarm: Option<&crate::pipeline::Alarm>) {
        let topic = format!("{}/alarms/{machine}/{id}", self.prefix);
        let payload = alarm.map_or_else(String::new, |alarm| json!(alarm).to_string());
        self.send(topic, true, payload);
    }

    fn send(&self, topic: String, retain: bool, payload: String) {
        // A full queue means a broker that is away: all is said again when it is back.
        let _ = self
            .client
            .try_publish(topic, QoS::AtLeastOnce, retain, payload);
    }

    /// Says that the service goes.
    pub fn say_goodbye(&self) {
        self.send(
            format!("{}/status", self.prefix),
            true,
            "offline".to_owned(),
        );
        let _ = self.client.disconnect();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn topics_tell_machine_and_tag() {
        let pattern = Pattern::new("site/{machine}/raw/{tag}");
        assert_eq!(pattern.filter(), "site/+/raw/+");
        let origin = pattern.origin("site/gt1/raw/t3").unwrap();
        assert_eq!((origin.machine, origin.tag), (Some("gt1"), Some("t3")));
        for other in ["site/gt1/raw", "site/gt1/raw/t3/x", "plant/gt1/raw/t3", ""] {
            assert!(pattern.origin(other).is_none(), "{other}");
        }
        let whole = Pattern::new("plant/{machine}");
        assert_eq!(whole.origin("plant/gt1").unwrap().machine, Some("gt1"));
        assert!(whole.origin("plant/gt1/t3").is_none());
    }
}
