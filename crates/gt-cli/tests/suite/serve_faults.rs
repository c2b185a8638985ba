//! The monitoring service when something around it goes wrong.

use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::TcpStream;
use std::process::{ChildStdin, Command};
use std::time::{SystemTime, UNIX_EPOCH};

use serde_json::{Value, json};

use crate::place::Place;
use crate::serving::{PATIENCE, Serving};

fn start(place: &Place, config: &str) -> Serving {
    place.write("serve.toml", config);
    Serving::start(&mut place.command(&["serve", "--config", "serve.toml"]))
}

fn machine(serving: &Serving) -> Value {
    serving.get("/api/v1/machines").json()["machines"][0].clone()
}

/// The value of a line of `/metrics`.
fn metric(serving: &Serving, name: &str) -> Option<f64> {
    let text = serving.get("/metrics").body;
    let line = text
        .lines()
        .find_map(|line| line.strip_prefix(name)?.strip_prefix(' '))?;
    line.parse().ok()
}

fn until_healthy(serving: &Serving) {
    serving.wait("a healthy turbine", |serving| {
        let own = machine(serving);
        (own["samples"].as_u64()? > 2000 && own["state"] == "healthy").then_some(())
    });
}

fn now_s() -> f64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    since.unwrap().as_secs_f64()
}

/// Lines of a machine near its full load, whose values do not matter here.
struct Lines {
    stdin: ChildStdin,
    begin_s: f64,
    sent: u32,
}

impl Lines {
    fn of(serving: &mut Serving) -> Self {
        Self {
            stdin: serving.child.stdin.take().unwrap(),
            begin_s: now_s() - 1000.0,
            sent: 0,
        }
    }

    /// Sends samples; `t3` gives the value of the tag by the sample's number. The other tags move.
    fn send(&mut self, count: u32, t3: impl Fn(u32) -> Option<f64>) {
        for _ in 0..count {
            let t3 = t3(self.sent).map_or(String::new(), |value| format!("\"t3\":{value:?},"));
            let moves = f64::from(self.sent % 2) / 1024.0;
            let (a_v, fuel) = (50.0 + moves, 0.25 + moves / 1024.0);
            let (speed, pressure, flow) = (9000.0 + moves, 101_000.0 + moves, 10.0 + moves);
            let time_s = self.begin_s + f64::from(self.sent) * 0.08;
            writeln!(
                self.stdin,
                "{{\"time\":{time_s:.6},\"values\":{{{t3}\"a_v\":{a_v},\"M_f\":{fuel},\"q_c\":{speed},\
                 \"p7\":{pressure},\"m9\":{flow}}}}}"
            )
            .unwrap();
            self.sent += 1;
        }
        self.stdin.flush().unwrap();
    }
}

const TURBINE: &[u8] = include_bytes!("../../../gt-serve/assets/turbine_detector.json");
/// Of the same tags and period.
const BANK: &[u8] = include_bytes!("../../../../fuzz/seeds/document/bank30.json");

const BY_LINES: &str = "[http]\nlisten = \"127.0.0.1:0\"\n[[machine]]\nname = \"gt1\"\n\
                        detector = \"detector.json\"\n[machine.hygiene]\nage_s = 1.0\n\
                        reorder_s = 0.0\n[lines]\nstdin = true\n";

/// A tag that vanishes is named, the machine is no longer called healthy, the others go on, and when
/// it is back all is judged again.
#[test]
fn a_tag_that_vanishes_is_named() {
    let place = Place::new();
    place.write("detector.json", TURBINE);
    let mut serving = start(&place, BY_LINES);
    let mut lines = Lines::of(&mut serving);
    let quality = |own: &Value| {
        let outputs = own["outputs"].as_array().unwrap();
        let t3 = outputs.iter().find(|own| own["tag"] == "t3").unwrap();
        t3["quality"].clone()
    };
    lines.send(50, |_| Some(850.0));
    serving.wait("the tags", |serving| {
        let own = machine(serving);
        (own["samples"].as_u64()? >= 49 && quality(&own) == "good").then_some(())
    });
    assert_ne!(machine(&serving)["state"], "stale");
    // 4 s of it, four times what it may be away.
    lines.send(50, |_| None);
    let own = serving.wait("the loss", |serving| {
        let own = machine(serving);
        (own["state"] == "stale").then_some(own)
    });
    assert_eq!(own["reason"], "no good value of t3 for too long");
    assert_eq!(quality(&own), "stale");
    lines.send(50, |_| Some(850.0));
    let own = serving.wait("its return", |serving| {
        let own = machine(serving);
        (own["state"] != "stale" && own["samples"].as_u64()? >= 149).then_some(own)
    });
    assert_eq!(quality(&own), "good");
    let missing = metric(&serving, "gtfdi_missing_total{machine=\"gt1\"}");
    assert_eq!(missing, Some(50.0));
}

/// A tag that stands still is named where that is asked for, and judged again once it moves.
#[test]
fn a_tag_that_stands_still_is_named() {
    let place = Place::new();
    place.write("detector.json", TURBINE);
    let config = BY_LINES.replace("age_s = 1.0", "age_s = 1.0\nfrozen_s = 2.0");
    let mut serving = start(&place, &config);
    let mut lines = Lines::of(&mut serving);
    // 2 s of the same value, and the 25 samples after it.
    lines.send(50, |_| Some(850.0));
    let own = serving.wait("the standstill", |serving| {
        let own = machine(serving);
        (own["samples"].as_u64()? >= 50).then_some(own)
    });
    assert_eq!(own["state"], "stale");
    assert_eq!(own["reason"], "the same value of t3 for too long");
    let frozen = metric(&serving, "gtfdi_frozen_total{machine=\"gt1\"}");
    assert_eq!(frozen, Some(25.0));
    lines.send(10, |sample| Some(850.0 + f64::from(sample % 2)));
    let own = serving.wait("its move", |serving| {
        let own = machine(serving);
        (own["samples"].as_u64()? >= 60).then_some(own)
    });
    assert_ne!(own["state"], "stale");
}

/// A detector that is loaded while the machine runs has a log of its own, with the detector in it.
#[test]
fn each_log_holds_the_detector_that_it_is_of() {
    let place = Place::new();
    place.write("detector.json", TURBINE);
    let config = format!("{BY_LINES}[recorder]\nfolder = \"logs\"\n");
    let mut serving = start(&place, &config);
    let mut lines = Lines::of(&mut serving);
    let judged = |serving: &Serving, count: u64| {
        serving.wait("the samples", |serving| {
            (machine(serving)["samples"].as_u64()? >= count).then_some(())
        });
    };
    lines.send(100, |_| Some(850.0));
    judged(&serving, 99);
    place.write("detector.json", BANK);
    let loaded = serving.post("/api/v1/machines/gt1/reload", &json!({}));
    assert_eq!(loaded.status, 200, "{}", loaded.body);
    lines.send(100, |_| Some(850.0));
    judged(&serving, 199);
    assert_eq!(metric(&serving, "gtfdi_recorder_errors_total"), Some(0.0));
    drop(lines);
    assert_eq!(serving.wait_for_end().code(), Some(0));
    let mut logs: Vec<_> = std::fs::read_dir(place.path("logs/gt1"))
        .unwrap()
        .map(|entry| entry.unwrap().path().display().to_string())
        .collect();
    logs.sort();
    let attached = |log: &String| {
        let info = place.json(&["log", "info", log]);
        let topics = info["topics"].as_array().unwrap();
        let measured = topics.iter().find(|own| own["topic"] == "/plant/measured");
        let name = info["attachments"][0]["name"].as_str().unwrap().to_owned();
        (name, measured.unwrap()["messages"].as_u64().unwrap())
    };
    let found: Vec<_> = logs.iter().map(attached).collect();
    let names: Vec<&str> = found.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["models/paper.json", "models/filters.json"]);
    assert_eq!(found.iter().map(|own| own.1).sum::<u64>(), 200);
}

/// Pages that are open and never read: places are limited, samples go on, others are answered.
#[test]
fn clients_that_do_not_read_hold_up_nobody() {
    let place = Place::new();
    let serving = start(
        &place,
        "[http]\nlisten = \"127.0.0.1:0\"\nstreams = 8\n[plant]\nspeed = 50.0\n",
    );
    let listen = || {
        let mut stream = TcpStream::connect(serving.address).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let head = format!(
            "GET /api/v1/events HTTP/1.1\r\nHost: {}\r\n\r\n",
            serving.address
        );
        stream.write_all(head.as_bytes()).unwrap();
        let mut reader = BufReader::new(stream);
        let mut line = String::new();
        reader.read_line(&mut line).unwrap();
        (line, reader)
    };
    let mut greedy: Vec<_> = (0..8).map(|_| listen()).collect();
    assert!(greedy.iter().all(|(line, _)| line == "HTTP/1.1 200 OK\r\n"));
    let (refused, mut rest) = listen();
    assert_eq!(refused, "HTTP/1.1 503 Service Unavailable\r\n");
    let mut text = String::new();
    let _ = rest
        .get_mut()
        .set_read_timeout(Some(std::time::Duration::from_millis(500)));
    let _ = rest.read_to_string(&mut text);
    assert!(
        text.contains("expected fewer streams of events than http.streams"),
        "{text}"
    );
    let before = machine(&serving)["samples"].as_u64().unwrap();
    serving.wait("samples beside them", |serving| {
        (machine(serving)["samples"].as_u64()? > before + 5000).then_some(())
    });
    // A place is free again when its client goes.
    greedy.pop();
    serving.wait("a free place", |_| listen().0.contains("200").then_some(()));
    assert_eq!(serving.stop().code(), Some(0));
}

/// A small disk in memory, where this process may mount one.
#[cfg(target_os = "linux")]
struct SmallDisk(std::path::PathBuf);

#[cfg(target_os = "linux")]
impl SmallDisk {
    fn new(folder: std::path::PathBuf, bytes: u64) -> Option<Self> {
        std::fs::create_dir(&folder).unwrap();
        let size = format!("size={bytes}");
        let mount = Command::new("mount")
            .args(["-t", "tmpfs", "-o", &size, "tmpfs"])
            .arg(&folder)
            .stderr(std::process::Stdio::null())
            .status();
        mount.is_ok_and(|own| own.success()).then_some(Self(folder))
    }

    fn fill(&self) {
        let mut file = std::fs::File::create(self.0.join("fill")).unwrap();
        while file.write_all(&[0; 4096]).is_ok() {}
    }

    fn make_room(&self) {
        std::fs::remove_file(self.0.join("fill")).unwrap();
    }
}

#[cfg(target_os = "linux")]
impl Drop for SmallDisk {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg("-l").arg(&self.0).status();
    }
}

/// A full disk: the service judges and tells on, says what it could not write, and when there is room
/// again the history is whole, what happened meanwhile included.
#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_costs_no_alarm() {
    let place = Place::new();
    let Some(disk) = SmallDisk::new(place.path("disk"), 4 << 20) else {
        println!("skipped: a_full_disk_costs_no_alarm may not mount a small disk");
        return;
    };
    let config = "state_dir = \"disk/state\"\n[http]\nlisten = \"127.0.0.1:0\"\n[plant]\nspeed = 20.0\n\
                  [recorder]\nfolder = \"disk/logs\"\nkeep_bytes = 1000000\nmax_bytes = 300000\n";
    std::fs::create_dir(place.path("disk/state")).unwrap();
    let serving = start(&place, config);
    until_healthy(&serving);
    disk.fill();
    let fault = json!({"case": "thermocouple_drift", "rate_per_h": 24.0, "limit": 0.8});
    assert_eq!(serving.post("/api/v1/faults", &fault).status, 201);
    let alarm = serving.wait("an alarm", |serving| {
        serving.open_alarms().into_iter().next()
    });
    serving.wait("the errors", |serving| {
        let journal = metric(serving, "gtfdi_journal_errors_total")?;
        let recorder = metric(serving, "gtfdi_recorder_errors_total")?;
        (journal > 0.0 && recorder > 0.0).then_some(())
    });
    disk.make_room();
    let path = format!("/api/v1/alarms/{}/acknowledge", alarm["id"]);
    let done = serving.post(&path, &json!({"by": "shift 1"}));
    assert_eq!(done.status, 200, "{}", done.body);
    // Killed: what is there is what had been written.
    serving.kill();
    let journal = String::from_utf8(place.read("disk/state/alarms.jsonl")).unwrap();
    let events: Vec<Value> = journal
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    let of = |what: &str| events.iter().filter(|event| event["event"] == what).count();
    assert!(of("raised") >= 1, "{journal}");
    assert_eq!(of("acknowledged"), 1, "{journal}");
    let serving = start(&place, config);
    let open = serving.open_alarms();
    assert!(
        open.iter()
            .any(|own| own["id"] == alarm["id"] && own["acknowledged"]["by"] == "shift 1"),
        "{open:?}"
    );
}
