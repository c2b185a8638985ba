//! The monitoring service from outside.

use std::io::Write as _;
use std::time::Duration;

use serde_json::{Value, json};

use crate::place::{Place, array, number};
use crate::serving::Serving;

/// A service without a configuration but on a free port.
fn embedded(place: &Place) -> Serving {
    Serving::start(&mut place.command(&["serve", "--listen", "127.0.0.1:0"]))
}

/// A service of the embedded turbine that runs so many times faster than the clock.
fn quick(place: &Place, speed: u32, more: &str) -> Serving {
    let config = format!("{more}\n[http]\nlisten = \"127.0.0.1:0\"\n[plant]\nspeed = {speed}.0\n");
    place.write("serve.toml", config);
    Serving::start(&mut place.command(&["serve", "--config", "serve.toml"]))
}

fn machine(serving: &Serving) -> Value {
    serving.get("/api/v1/machines").json()["machines"][0].clone()
}

/// The plain command: within 5 s there are samples of the embedded turbine and the page, and it stops
/// with exit code 0 when it is asked to.
#[test]
fn the_plain_command_serves_the_embedded_turbine() {
    let place = Place::new();
    let serving = embedded(&place);
    // Not a measurement: the promise is 5 s, and this machine may be busy with other tests.
    assert!(serving.ready_after < Duration::from_secs(30));
    let page = serving.get("/");
    assert_eq!(page.status, 200, "{}", page.head);
    assert!(page.body.contains("<title>"), "{}", page.body);
    let policy = page.head.to_ascii_lowercase();
    assert!(
        policy.contains("content-security-policy: default-src 'none'"),
        "{policy}"
    );
    let own = serving.wait("samples", |serving| {
        let own = machine(serving);
        (own["samples"].as_u64()? > 20).then_some(own)
    });
    assert_eq!(own["name"], "turbine");
    assert_eq!(own["detector"]["kind"], "isolator");
    let tags = |of: &str| {
        let signals = array(&own, of).iter();
        signals
            .map(|own| own["tag"].as_str().unwrap().to_owned())
            .collect::<Vec<_>>()
    };
    assert_eq!(tags("/inputs"), ["a_v", "M_f"]);
    assert_eq!(tags("/outputs").len(), 4);
    assert_eq!(serving.get("/healthz").body, "ok\n");
    assert_eq!(serving.get("/readyz").status, 200);
    let metrics = serving.get("/metrics").body;
    assert!(
        metrics.contains("gtfdi_machine_up{machine=\"turbine\"} 1"),
        "{metrics}"
    );
    let status = serving.stop();
    assert_eq!(status.code(), Some(0));
}

/// A fault that is injected becomes an alarm with its name and an onset whose interval holds the
/// time of the injection; it is acknowledged, and returns when the fault is taken away.
#[test]
fn an_injected_fault_is_named_and_acknowledged() {
    let place = Place::new();
    let serving = quick(&place, 20, "");
    // The detector has to settle and to have seen healthy running.
    let before = serving.wait("a healthy turbine", |serving| {
        let own = machine(serving);
        let long = own["samples"].as_u64()? > 2000;
        (long && own["state"] == "healthy").then_some(own)
    });
    let now_ms = number(&before, "/last_time_ms");
    // 0.4 % of the reading in a minute, five times what is found in that time with this noise.
    let fault = json!({"case": "thermocouple_drift", "rate_per_h": 24.0, "limit": 0.8});
    let answer = serving.post("/api/v1/faults", &fault);
    assert_eq!(answer.status, 201, "{}", answer.body);
    let alarm = serving.wait("a name", |serving| {
        let alarms = serving.open_alarms();
        alarms.into_iter().find(|alarm| alarm["finding"] == "named")
    });
    assert_eq!(alarm["fault"], "thermocouple_drift", "{alarm}");
    let delay_s = (number(&alarm, "/raised_ms") - now_ms) / 1e3;
    assert!((0.0..120.0).contains(&delay_s), "{delay_s}");
    // As more comes in, the interval holds the injection, of which the samples between asking and
    // being injected are not known: 20 times the time of a request.
    serving.wait("the onset", |serving| {
        let alarm = serving.open_alarms().into_iter().next()?;
        let low = number(&alarm, "/onset_interval_ms/0");
        let high = number(&alarm, "/onset_interval_ms/1");
        (low < now_ms + 4e3 && high > now_ms - 1e3).then_some(())
    });
    let id = alarm["id"].as_u64().unwrap();
    let path = |what: &str| format!("/api/v1/alarms/{id}/{what}");
    let body = json!({"by": "shift 2", "comment": "seen"});
    let done = serving.post(&path("acknowledge"), &body).json();
    assert_eq!(done["state"], "active_acknowledged");
    assert_eq!(done["acknowledged"]["by"], "shift 2");
    // As a client does whose answer was lost: who was first stays.
    let again = json!({"by": "shift 3", "comment": "seen too"});
    let twice = serving.post(&path("acknowledge"), &again);
    assert_eq!(twice.status, 200);
    assert_eq!(twice.json()["acknowledged"], done["acknowledged"]);
    let shelf = json!({"by": "shift 2", "reason": "recalibration", "minutes": 10});
    assert_eq!(
        serving.post(&path("shelve"), &shelf).json()["shelved"]["reason"],
        "recalibration"
    );
    let too_long = json!({"by": "shift 2", "reason": "x", "minutes": 1e9});
    assert_eq!(serving.post(&path("shelve"), &too_long).status, 422);
    assert_eq!(
        serving.post(&path("unshelve"), &json!({"by": "x"})).json()["shelved"],
        Value::Null
    );
    assert_eq!(
        serving.send("DELETE", "/api/v1/faults", "", b"").status,
        200
    );
    let over = serving.wait("its return", |serving| {
        let own = serving.get(&format!("/api/v1/alarms/{id}")).json();
        (own["state"] == "normal").then_some(own)
    });
    assert!(number(&over, "/ended_ms") > number(&over, "/raised_ms"));
    // Sent once more after its end, it is answered too, and nothing happens.
    let late = serving.post(&path("acknowledge"), &again);
    assert_eq!((late.status, late.json()), (200, over));
    let events = serving.get(&path("events")).json();
    let events: Vec<&str> = array(&events, "/events")
        .iter()
        .map(|event| event["event"].as_str().unwrap())
        .collect();
    let expected = [
        "raised",
        "named",
        "acknowledged",
        "shelved",
        "unshelved",
        "returned",
        "cleared",
    ];
    // A name may be given twice.
    let distinct: Vec<&str> = events
        .iter()
        .copied()
        .filter(|own| *own != "named")
        .collect();
    assert_eq!(distinct[0], expected[0], "{events:?}");
    assert_eq!(distinct[1..], expected[2..], "{events:?}");
}

/// What is wrong with a request is said with the right status, and nothing happens.
#[test]
fn bad_requests_are_refused() {
    let place = Place::new();
    let serving = embedded(&place);
    let json_headers = "Content-Type: application/json\r\n";
    let large = vec![b' '; (1 << 20) + 1];
    let post = |path: &str, headers: &str, body: &[u8]| serving.send("POST", path, headers, body);
    for (answer, status) in [
        (post("/api/v1/faults", json_headers, &large), 413),
        (post("/api/v1/faults", json_headers, b"{"), 400),
        (
            post("/api/v1/faults", "", b"{\"case\":\"turbine_damage\"}"),
            415,
        ),
        (
            post(
                "/api/v1/faults",
                json_headers,
                b"{\"case\":\"turbine_damage\"}",
            ),
            422,
        ),
        (
            post(
                "/api/v1/faults",
                json_headers,
                b"{\"case\":\"rust\",\"limit\":1}",
            ),
            422,
        ),
        (
            post(
                "/api/v1/faults",
                json_headers,
                b"{\"case\":\"turbine_damage\",\"x\":1}",
            ),
            422,
        ),
        (
            post(
                "/api/v1/alarms/1/acknowledge",
                json_headers,
                b"{\"by\":\"a\"}",
            ),
            404,
        ),
        (
            post(
                "/api/v1/alarms/-1/acknowledge",
                json_headers,
                b"{\"by\":\"a\"}",
            ),
            400,
        ),
        (serving.get("/api/v1/machines/other"), 404),
        (
            serving.get("/api/v1/machines/turbine/trend?seconds=-1"),
            422,
        ),
        (serving.get("/api/v1/machines/turbine/trend?points=0"), 422),
        (serving.get("/api/v1/alarms?limit=many"), 400),
        (serving.get("/api/v1/alarms?sort=x"), 400),
        (serving.get("/api/v1/nothing"), 404),
        (serving.get("/../../etc/passwd"), 404),
        (
            serving.send("PUT", "/api/v1/faults", json_headers, b"{}"),
            405,
        ),
        // A page of another origin, and a name that another site made lead here.
        (
            post(
                "/api/v1/faults",
                "Origin: http://evil.example\r\nContent-Type: application/json\r\n",
                b"{}",
            ),
            403,
        ),
        (
            serving.send("GET", "/api/v1/machines", "Host: evil.example\r\n", b""),
            403,
        ),
    ] {
        assert_eq!(answer.status, status, "{}\n{}", answer.head, answer.body);
    }
    let none = serving.get("/api/v1/faults").json();
    assert_eq!(none, json!({"faults": []}));
    let case = serving
        .post("/api/v1/faults", &json!({"case": "rust", "limit": 1}))
        .json();
    assert_eq!(
        case["error"]["message"],
        "case: expected one of compressor_fouling, thermocouple_drift, turbine_damage, \
         fuel_actuator_lag, found `rust`"
    );
}

/// Each path of the published description answers, and says no other status than it should.
#[test]
fn the_description_has_the_paths_that_there_are() {
    let place = Place::new();
    let serving = embedded(&place);
    let document = serving.get("/api/v1/openapi.json").json();
    assert_eq!(document["openapi"], "3.1.0");
    let paths = document["paths"].as_object().unwrap();
    assert!(paths.len() > 12);
    for (path, methods) in paths {
        let path = path.replace("{name}", "turbine").replace("{id}", "7");
        for method in methods.as_object().unwrap().keys() {
            if path.ends_with("/events") && !path.contains("alarms") {
                continue;
            }
            let headers = "Content-Type: application/json\r\n";
            let answer = serving.send(&method.to_uppercase(), &path, headers, b"");
            let known = matches!(answer.status, 200 | 201 | 400 | 422 | 503)
                || (answer.status == 404 && path.contains("alarms/7"));
            assert!(known, "{method} {path}: {}\n{}", answer.head, answer.body);
        }
        let answer = serving.send("PATCH", &path, "", b"");
        assert_eq!(answer.status, 405, "{path}");
    }
}

/// Filters of a noisy turbine (`bank.json`) and a record with a drift (`faulty.mcap`), by the command
/// line.
fn bank_and_record(place: &Place) {
    let fault = "[[fault]]\ncase = \"thermocouple_drift\"\nonset_s = 300.0\n\
                 rate_percent_per_h = 60.0\nlimit_percent = 1.0\n";
    place.write("drift.toml", fault);
    for command in [
        "simulate --seconds 600 --seed 1 --noise table8 --out train.mcap",
        "simulate --seconds 7200 --seed 2 --noise table8 --out healthy.mcap",
        "simulate --seconds 900 --seed 3 --noise table8 --faults drift.toml --out faulty.mcap",
        "identify train.mcap --inputs a_v,M_f --outputs q_c,t3,p7,m9 --method eiv --order 2 --nk 0 \
         --out model.json",
        "design --model model.json --healthy healthy.mcap --generator kalman --statistic cusum \
         --arl0 24h --out bank.json",
    ] {
        let arguments: Vec<&str> = command.split_whitespace().collect();
        place.done(&arguments);
    }
}

/// A record that is played: the alarms are those of `detect`, to the sample.
#[test]
fn a_replayed_record_has_the_alarms_of_detect() {
    let place = Place::new();
    bank_and_record(&place);
    let expected = place.json(&["detect", "--bank", "bank.json", "faulty.mcap"]);
    let expected: Vec<(String, i64)> = array(&expected, "/alarms")
        .iter()
        .map(|alarm| {
            let tag = alarm["tag"].as_str().unwrap().to_owned();
            #[allow(clippy::cast_possible_truncation)] // milliseconds of a short record
            (tag, (number(alarm, "/time_s") * 1e3).round() as i64)
        })
        .collect();
    assert!(!expected.is_empty());
    let config = "\
[http]\nlisten = \"127.0.0.1:0\"
[[machine]]\nname = \"gt1\"\ndetector = \"bank.json\"
[machine.alarms]\noff_delay_s = 0.0
[[replay]]\nfile = \"faulty.mcap\"\nmachine = \"gt1\"\n";
    place.write("serve.toml", config);
    let serving = Serving::start(&mut place.command(&["serve", "--config", "serve.toml"]));
    let samples = 900 * 25 / 2;
    serving.wait("the end of the record", |serving| {
        (machine(serving)["samples"] == samples).then_some(())
    });
    let alarms = serving.get("/api/v1/alarms?limit=1000").json();
    let mut found: Vec<(String, i64)> = array(&alarms, "/alarms")
        .iter()
        .map(|alarm| {
            let source = alarm["source"].as_str().unwrap().to_owned();
            (source, alarm["raised_ms"].as_i64().unwrap())
        })
        .collect();
    found.sort_by_key(|own| own.1);
    // Logs of the simulator begin at a fixed time.
    let start_ms = found[0].1 - expected[0].1;
    for own in &mut found {
        own.1 -= start_ms;
    }
    // An alarm that comes back before anybody saw it is the same one: the first of each test.
    let first = |all: &[(String, i64)]| {
        let mut seen = Vec::<(String, i64)>::new();
        for own in all {
            if !seen.iter().any(|other| other.0 == own.0) {
                seen.push(own.clone());
            }
        }
        seen.sort();
        seen
    };
    assert_eq!(first(&found), first(&expected));
}

/// Lines of JSON: what is malformed is counted and skipped, and the service ends with its input.
#[test]
fn lines_are_read_to_their_end() {
    let place = Place::new();
    let config = "[http]\nlisten = \"127.0.0.1:0\"\n[plant]\nmachine = \"other\"\n[lines]\nstdin = true\nlongest_line = 1000\n";
    place.write("serve.toml", config);
    let mut serving = Serving::start(&mut place.command(&["serve", "--config", "serve.toml"]));
    let mut stdin = serving.child.stdin.take().unwrap();
    let long = format!("{{\"machine\":\"{}\"}}\n", "x".repeat(2000));
    for line in [
        "not json\n",
        "[]\n",
        "{}\n",
        "\n",
        "{\"machine\":\"none\",\"time\":1,\"values\":{}}\n",
        "{\"machine\":\"other\",\"time\":\"yesterday\",\"values\":{\"t3\":1}}\n",
        long.as_str(),
        "{\"machine\":\"other\",\"values\":{\"unheard_of\":1,\"t3\":\"Bad\"}}\n",
    ] {
        stdin.write_all(line.as_bytes()).unwrap();
    }
    stdin.flush().unwrap();
    serving.wait("the lines", |serving| {
        let metrics = serving.get("/metrics").body;
        let has = |line: &str| metrics.lines().any(|own| own == line);
        (has("gtfdi_malformed_total 6") && has("gtfdi_unknown_total 1")).then_some(())
    });
    drop(stdin);
    let status = serving.wait_for_end();
    assert_eq!(status.code(), Some(0));
}

/// Kill -9 at whatever moment: no alarm is lost and none is there twice.
#[test]
fn alarms_outlive_a_kill() {
    let place = Place::new();
    let state = "state_dir = \"state\"\nsnapshot_s = 1.0";
    let serving = quick(&place, 20, state);
    serving.wait("a healthy turbine", |serving| {
        let own = machine(serving);
        (own["samples"].as_u64()? > 2000 && own["state"] == "healthy").then_some(())
    });
    let fault = json!({"case": "thermocouple_drift", "rate_per_h": 24.0, "limit": 0.8});
    assert_eq!(serving.post("/api/v1/faults", &fault).status, 201);
    let alarm = serving.wait("an alarm", |serving| {
        serving.open_alarms().into_iter().next()
    });
    serving.kill();
    let serving = quick(&place, 20, state);
    let open = serving.open_alarms();
    assert_eq!(open.len(), 1, "{open:?}");
    assert_eq!(open[0]["id"], alarm["id"]);
    // The turbine that starts again is healthy: what is not seen again returns by itself.
    serving.wait("its return", |serving| {
        (serving.open_alarms()[0]["state"] == "returned_unacknowledged").then_some(())
    });
    let all = serving.get("/api/v1/alarms").json();
    assert_eq!(array(&all, "/alarms").len(), 1, "{all}");
}

/// What would not be safe, or makes no sense, is refused before anything starts.
#[test]
fn configurations_that_make_no_sense_are_refused() {
    let place = Place::new();
    for (config, expected) in [
        (
            "[http]\nlisten = \"0.0.0.0:8471\"\n",
            "http.tokens_file: expected a file, because http.listen is 0.0.0.0:8471, not loopback, \
             found none",
        ),
        (
            "[lines]\ntcp = \"0.0.0.0:7000\"\n",
            "lines.tcp: expected a loopback address: these lines carry no token; beyond it use MQTT \
             with TLS, found 0.0.0.0:7000",
        ),
        (
            "[plant]\nspeed = 0.0\n",
            "plant.speed: expected 0.01 to 1000, found 0",
        ),
        (
            "[[replay]]\nfile = \"x.mcap\"\nmachine = \"gt1\"\n",
            "replay.machine: expected one of turbine, found `gt1`",
        ),
        (
            "[plant]\nmachine = \"../x\"\n",
            "machine.name: expected 1 to 64 letters, digits, `_`, `-` and `.`, not first a `.`, \
             found `../x`",
        ),
        (
            "[mqtt]\nhost = \"broker\"\nreadings = [\"a/#\"]\n",
            "mqtt.readings: expected levels between `/`, one of them `{machine}`, at most one \
             `{tag}`, no wildcard, found `a/#`",
        ),
    ] {
        place.write("serve.toml", config);
        place.refused(&["serve", "--config", "serve.toml"], &[expected]);
    }
    place.write("serve.toml", "[htp]\n");
    place.refused(
        &["serve", "--config", "serve.toml"],
        &["serve.toml", "line 1", "htp"],
    );
}

/// With tokens each caller does what its role may, the history has the token's name whatever the
/// caller says, and who guesses is held off while the service goes on.
#[cfg(unix)]
#[test]
fn tokens_say_who_may_do_what() {
    use std::os::unix::fs::PermissionsExt as _;

    let place = Place::new();
    let token = |role: &str| format!("{role}-0123456789abcdef0123456789abcdef");
    let entry = |role: &str| {
        let token = token(role);
        format!("[[token]]\nname = \"the {role} desk\"\nrole = \"{role}\"\ntoken = \"{token}\"\n")
    };
    place.write(
        "tokens.toml",
        ["read", "operate", "administer"].map(entry).concat(),
    );
    let config = "[http]\nlisten = \"127.0.0.1:0\"\ntokens_file = \"tokens.toml\"\n";
    place.write("serve.toml", config);
    let path = place.path("tokens.toml");
    let mode = |bits| std::fs::set_permissions(&path, std::fs::Permissions::from_mode(bits));
    mode(0o644).unwrap();
    place.refused(
        &["serve", "--config", "serve.toml"],
        &["mode", "600", "644"],
    );
    mode(0o600).unwrap();
    let serving = Serving::start(&mut place.command(&["serve", "--config", "serve.toml"]));
    let ask = |method: &str, path: &str, token: &str, body: &str| {
        let headers =
            format!("Authorization: Bearer {token}\r\nContent-Type: application/json\r\n");
        serving.send(method, path, &headers, body.as_bytes())
    };
    assert_eq!(serving.get("/").status, 200, "the page asks for the token");
    assert_eq!(serving.get("/healthz").status, 200);
    for path in [
        "/api/v1/info",
        "/api/v1/machines",
        "/api/v1/events",
        "/metrics",
    ] {
        assert_eq!(serving.get(path).status, 401, "{path}");
    }
    let info = ask("GET", "/api/v1/info", &token("operate"), "").json();
    assert_eq!(info["role"], "operate");
    assert_eq!(info["token_required"], true);
    let fault = "{\"case\": \"thermocouple_drift\", \"limit\": 5.0}";
    assert_eq!(
        ask("POST", "/api/v1/faults", &token("read"), fault).status,
        403
    );
    assert_eq!(
        ask("POST", "/api/v1/faults", &token("operate"), fault).status,
        403
    );
    assert_eq!(
        ask("POST", "/api/v1/faults", &token("administer"), fault).status,
        201
    );
    assert_eq!(
        ask("POST", "/api/v1/alarms/1/acknowledge", &token("read"), "{}").status,
        403
    );
    let guesses: Vec<u16> = (0..500)
        .map(|guess| ask("GET", "/api/v1/info", &token(&format!("guess{guess}")), "").status)
        .collect();
    assert_eq!(guesses[..20], [401; 20]);
    assert!(
        guesses[20..].iter().all(|status| *status == 429),
        "{guesses:?}"
    );
    assert_eq!(serving.get("/healthz").status, 200);
    let log = serving.log();
    assert!(!log.contains("0123456789abcdef"), "{log}");
}
