//! The monitoring service with a real broker; skipped where there is no mosquitto.

use std::net::{TcpListener, TcpStream};
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::place::Place;
use crate::serving::{PATIENCE, Serving};

/// A broker without memory, killed when it is dropped.
struct Broker {
    child: Child,
    port: u16,
}

impl Broker {
    fn start(port: u16) -> Option<Self> {
        let command = |program: &str| {
            Command::new(program)
                .args(["-p", &port.to_string()])
                .stdout(Stdio::null())
                .stderr(Stdio::null())
                .spawn()
        };
        let Ok(child) = command("mosquitto").or_else(|_| command("/usr/sbin/mosquitto")) else {
            eprintln!("skipped: no mosquitto on this machine");
            return None;
        };
        let broker = Self { child, port };
        let started = Instant::now();
        while TcpStream::connect(("127.0.0.1", port)).is_err() {
            assert!(started.elapsed() < PATIENCE, "the broker does not listen");
            thread::sleep(Duration::from_millis(20));
        }
        Some(broker)
    }

    fn publish(&self, topic: &str, payload: &str) {
        let port = self.port.to_string();
        let arguments = [
            "-h",
            "127.0.0.1",
            "-p",
            &port,
            "-q",
            "1",
            "-t",
            topic,
            "-m",
            payload,
        ];
        let status = Command::new("mosquitto_pub").args(arguments).status();
        assert!(status.unwrap().success());
    }

    /// What is retained under a topic, or comes there within a second.
    fn heard(&self, topic: &str) -> Vec<(String, String)> {
        let port = self.port.to_string();
        let arguments = ["-h", "127.0.0.1", "-p", &port, "-W", "1", "-v", "-t", topic];
        let output = Command::new("mosquitto_sub")
            .args(arguments)
            .output()
            .unwrap();
        let text = String::from_utf8(output.stdout).unwrap();
        let lines = text.lines().filter_map(|line| line.split_once(' '));
        lines
            .map(|(topic, payload)| (topic.to_owned(), payload.to_owned()))
            .collect()
    }
}

impl Drop for Broker {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

pub fn free_port() -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    listener.local_addr().unwrap().port()
}

/// Readings come in, alarms are retained, and a broker that goes and comes back hears all again.
#[test]
fn readings_come_from_a_broker_and_alarms_go_there() {
    let port = free_port();
    let Some(broker) = Broker::start(port) else {
        return;
    };
    let place = Place::new();
    let config = format!(
        "[http]\nlisten = \"127.0.0.1:0\"\n[plant]\nspeed = 20.0\n\
         [mqtt]\nhost = \"127.0.0.1\"\nport = {port}\n"
    );
    place.write("serve.toml", config);
    let serving = Serving::start(&mut place.command(&["serve", "--config", "serve.toml"]));
    let metric = |serving: &Serving, name: &str| {
        let text = serving.get("/metrics").body;
        let line = text
            .lines()
            .find(|line| line.starts_with(name))
            .unwrap_or_default();
        line.rsplit(' ')
            .next()
            .and_then(|value| value.parse::<f64>().ok())
    };
    serving.wait("the broker", |serving| {
        (metric(serving, "gtfdi_mqtt_connects_total")? >= 1.0).then_some(())
    });
    serving.wait("the status", |_| {
        let heard = broker.heard("gtfdi/status");
        (heard == [("gtfdi/status".to_owned(), "online".to_owned())]).then_some(())
    });
    // One is late, as the turbine's time runs ahead; one is no message; one is of no machine.
    broker.publish("plant/turbine/t3", "{\"time\": 1, \"value\": 1}");
    broker.publish("plant/turbine", "garbage");
    broker.publish("plant/nobody/t3", "1");
    serving.wait("the messages", |serving| {
        let late = metric(serving, "gtfdi_late_total{machine=\"turbine\"}")?;
        let malformed = metric(serving, "gtfdi_malformed_total")?;
        (late >= 1.0 && malformed >= 2.0).then_some(())
    });
    serving.wait("a healthy turbine", |serving| {
        let own = serving.get("/api/v1/machines").json()["machines"][0].clone();
        (own["samples"].as_u64()? > 2000 && own["state"] == "healthy").then_some(())
    });
    let fault = json!({"case": "thermocouple_drift", "rate_per_h": 24.0, "limit": 0.8});
    assert_eq!(serving.post("/api/v1/faults", &fault).status, 201);
    let id = serving.wait("an alarm", |serving| {
        serving.open_alarms().first()?["id"].as_u64()
    });
    let topic = format!("gtfdi/alarms/turbine/{id}");
    let retained = |broker: &Broker| -> Option<Value> {
        let heard = broker.heard(&topic);
        serde_json::from_str(&heard.last()?.1).ok()
    };
    let alarm = serving.wait("the retained alarm", |_| retained(&broker));
    assert_eq!(alarm["id"], id);
    assert_eq!(alarm["machine"], "turbine");
    drop(broker);
    thread::sleep(Duration::from_secs(1));
    let broker = Broker::start(port).unwrap();
    serving.wait("the alarm at the new broker", |_| retained(&broker));
    assert_eq!(serving.stop().code(), Some(0));
    assert_eq!(broker.heard("gtfdi/status")[0].1, "offline");
}
