//! The monitoring service is killed again and again.

use std::collections::BTreeMap;
use std::io::Write as _;
use std::net::TcpStream;
use std::path::Path;
use std::thread;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use serde_json::Value;

use crate::place::Place;
use crate::serve_mqtt::free_port;
use crate::serving::{PATIENCE, Serving};

const KILLS: u32 = 50;
/// How much faster than the machine its record is fed.
const SPEED: f64 = 100.0;
const PERIOD_S: f64 = 0.08;
/// How long what was recorded may wait until it is on the disk: the recorder's own 5 s and the time
/// until it looks, and room for a machine that is busy.
const UNFLUSHED_S: f64 = 10.0;

/// A record of a machine that is fed on and on; it waits while nobody takes it.
struct Feed {
    rows: Vec<String>,
    sent: usize,
    start_s: f64,
}

impl Feed {
    /// Feeds until `end`, as many lines a second as there are.
    fn run(&mut self, port: u16, end: Instant) {
        let started = Instant::now();
        let mut stream = loop {
            match TcpStream::connect(("127.0.0.1", port)) {
                Ok(stream) => break stream,
                Err(error) => assert!(started.elapsed() < PATIENCE, "{error}"),
            }
        };
        let first = self.sent;
        while Instant::now() < end {
            let passed_s = started.elapsed().as_secs_f64();
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // some thousands
            let due = first + (passed_s * SPEED / PERIOD_S) as usize;
            let mut text = String::new();
            while self.sent < due {
                let time_s = self.start_s + self.sent as f64 * PERIOD_S;
                let row = &self.rows[self.sent % self.rows.len()];
                let line = format!("{{\"time\":{time_s:.6},\"values\":{{{row}}}}}\n");
                text.push_str(&line);
                self.sent += 1;
            }
            if stream.write_all(text.as_bytes()).is_err() {
                return;
            }
            thread::sleep(Duration::from_millis(10));
        }
    }
}

/// Lines of a record, as the inside of `values`.
fn rows(place: &Place, record: &str) -> Vec<String> {
    place.done(&[
        "log",
        "export",
        record,
        "--topic",
        "/plant/measured",
        "--time",
        "seconds",
        "--out",
        "rows.csv",
    ]);
    let text = String::from_utf8(place.read("rows.csv")).unwrap();
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let row = |line: &str| {
        let pairs = names.iter().zip(line.split(',')).skip(1);
        let pairs = pairs.filter(|(_, value)| !value.is_empty());
        let pairs = pairs.map(|(name, value)| format!("\"{name}\":{value}"));
        pairs.collect::<Vec<_>>().join(",")
    };
    lines.map(row).collect()
}

/// Every alarm by its number.
fn alarms(serving: &Serving) -> BTreeMap<u64, Value> {
    let answer = serving.get("/api/v1/alarms?limit=1000").json();
    let all = answer["alarms"].as_array().unwrap().clone();
    let numbered = all
        .into_iter()
        .map(|alarm| (alarm["id"].as_u64().unwrap(), alarm));
    numbered.collect()
}

/// Recovered or whole, all logs of a folder are sound; the time of the last sample in them, or when
/// it began where there is none, in ms.
fn last_recorded_ms(place: &Place, folder: &Path, begin_s: f64) -> i64 {
    #[allow(clippy::cast_possible_truncation)] // of a time since 1970
    let mut last_ms = (begin_s * 1e3) as i64;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|own| own != "mcap") {
            continue;
        }
        let name = path.display().to_string();
        let found = place.json(&["log", "verify", &name]);
        assert_eq!(found["sound"], true, "{found}");
        let found = place.json(&["log", "info", &name]);
        let end_ns = found["last_ns"].as_i64().unwrap_or(0);
        last_ms = last_ms.max(end_ns / 1_000_000);
    }
    last_ms
}

/// Fifty times kill -9 at moments without a pattern, with alarms coming and going about once a second:
/// none that was told is lost, none is there twice, every log can be read, and of the samples at most
/// those of the last seconds are missing.
#[test]
#[ignore = "takes some minutes; run it with --ignored"]
fn fifty_kills_lose_no_alarm() {
    let place = Place::new();
    for command in [
        "simulate --seconds 600 --seed 1 --noise table8 --out train.mcap",
        "simulate --seconds 7200 --seed 2 --noise table8 --out healthy.mcap",
        "identify train.mcap --inputs a_v,M_f --outputs q_c,t3,p7,m9 --method eiv --order 2 --nk 0 \
         --out model.json",
        // An alarm every two minutes of the machine's time from each of four tests.
        "design --model model.json --healthy healthy.mcap --generator kalman --statistic cusum \
         --arl0 2min --out bank.json",
    ] {
        place.done(&command.split_whitespace().collect::<Vec<_>>());
    }
    let port = free_port();
    place.write(
        "serve.toml",
        format!(
            "state_dir = \"state\"\nsnapshot_s = 1.0\n[http]\nlisten = \"127.0.0.1:0\"\n\
             [[machine]]\nname = \"gt1\"\ndetector = \"bank.json\"\n[machine.alarms]\n\
             latch = false\noff_delay_s = 0.0\n[lines]\ntcp = \"127.0.0.1:{port}\"\n[recorder]\nfolder = \"logs\"\n"
        ),
    );
    let now_s = SystemTime::now().duration_since(UNIX_EPOCH).unwrap();
    let mut feed = Feed {
        rows: rows(&place, "healthy.mcap"),
        sent: 0,
        // Days ago: it is fed faster than the clock.
        start_s: now_s.as_secs_f64() - 864_000.0,
    };
    let mut told: BTreeMap<u64, Value> = BTreeMap::new();
    let mut moment = 7_u64;
    for kill in 0..KILLS {
        let serving = Serving::start(&mut place.command(&["serve", "--config", "serve.toml"]));
        let after = alarms(&serving);
        for id in told.keys() {
            assert!(after.contains_key(id), "alarm {id} is lost at kill {kill}");
        }
        moment = moment
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        let end = Instant::now() + Duration::from_millis(500 + (moment >> 33) % 4000);
        feed.run(port, end);
        told.extend(alarms(&serving));
        let machines = serving.get("/api/v1/machines").json();
        let seen_ms = machines["machines"][0]["last_time_ms"]
            .as_i64()
            .unwrap_or(0);
        serving.kill();
        // What the next start makes of the logs.
        let serving = Serving::start(&mut place.command(&["serve", "--config", "serve.toml"]));
        serving.wait("the logs", |_| {
            let mut entries = std::fs::read_dir(place.path("logs/gt1")).unwrap();
            let is_part = |entry: std::io::Result<std::fs::DirEntry>| {
                entry
                    .unwrap()
                    .path()
                    .extension()
                    .is_some_and(|own| own == "part")
            };
            (!entries.any(is_part)).then_some(())
        });
        serving.kill();
        let recorded_ms = last_recorded_ms(&place, &place.path("logs/gt1"), feed.start_s);
        let missing_s = (seen_ms - recorded_ms) as f64 / 1e3 / SPEED;
        assert!(
            missing_s <= UNFLUSHED_S,
            "kill {kill}: {missing_s} s are missing"
        );
    }
    let serving = Serving::start(&mut place.command(&["serve", "--config", "serve.toml"]));
    let all = alarms(&serving);
    println!("{} alarms in {KILLS} kills", all.len());
    assert!(all.len() > 20, "{}", all.len());
    // None twice: of one test no two alarms at the same time.
    let mut by_source: BTreeMap<String, Vec<(i64, i64)>> = BTreeMap::new();
    for alarm in all.values() {
        let raised_ms = alarm["raised_ms"].as_i64().unwrap();
        let ended_ms = alarm["ended_ms"].as_i64().unwrap_or(i64::MAX);
        let source = alarm["source"].as_str().unwrap().to_owned();
        by_source
            .entry(source)
            .or_default()
            .push((raised_ms, ended_ms));
    }
    for (source, mut spans) in by_source {
        spans.sort_unstable();
        for pair in spans.windows(2) {
            assert!(pair[0].1 <= pair[1].0, "{source}: {pair:?}");
        }
    }
    drop(serving);
    let journal = String::from_utf8(place.read("state/alarms.jsonl")).unwrap();
    let mut raised: BTreeMap<u64, usize> = BTreeMap::new();
    for line in journal.lines() {
        let event: Value = serde_json::from_str(line).unwrap();
        if event["event"] == "raised" {
            *raised
                .entry(event["alarm"]["id"].as_u64().unwrap())
                .or_default() += 1;
        }
    }
    assert!(raised.keys().eq(all.keys()), "{raised:?}");
}
