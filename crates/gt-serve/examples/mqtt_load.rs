//! Many turbines at a broker, to see what the service bears.
//!
//! `cargo run --release -p gt-serve --example mqtt_load [MACHINES [SECONDS [PORT [tags|samples]]]]`
//! publishes samples of healthy turbines at 12.5 Hz under `plant/mN` (a message a sample) or
//! `plant/mN/TAG` (a message a value), and says how many values the broker has taken. The machines
//! are named `m0`, `m1`, ...

use std::error::Error;
use std::thread;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use gt_campaign::isolation::{Ambient, Setting};
use gtfdi::plant::{MapSet, NoiseLevel};
use rumqttc::{Client, Event, MqttOptions, Outgoing, Packet, QoS};

const PERIOD_S: f64 = 0.08;

fn argument(place: usize, default: &str) -> String {
    std::env::args()
        .nth(place)
        .unwrap_or_else(|| default.to_owned())
}

fn main() -> Result<(), Box<dyn Error>> {
    let machines: usize = argument(1, "200").parse()?;
    let seconds: f64 = argument(2, "60").parse()?;
    let port: u16 = argument(3, "1883").parse()?;
    let by_tag = argument(4, "tags") == "tags";
    let setting = Setting::new(MapSet::Paper, NoiseLevel::Table8, Ambient::Constant, 1)?;
    let runs: Vec<_> = (0..8).map(|run| (2_000_000 + run, Vec::new())).collect();
    let records = setting.records(&runs, seconds + 1.0)?;
    let mut options = MqttOptions::new("mqtt_load", "localhost", port);
    options.set_inflight(1000);
    // What the broker has not acknowledged when it goes is sent again when it comes.
    options.set_clean_session(false);
    let (client, mut connection) = Client::new(options, 100_000);
    let acknowledged = thread::spawn(move || {
        let mut count = 0_u64;
        for event in connection.iter() {
            match event {
                Ok(Event::Incoming(Packet::PubAck(_))) => count += 1,
                Ok(Event::Outgoing(Outgoing::Disconnect)) => break,
                Ok(_) => {}
                Err(cause) => {
                    eprintln!("{cause}");
                    thread::sleep(Duration::from_millis(200));
                }
            }
        }
        count
    });
    let start = Instant::now();
    let epoch_s = SystemTime::now().duration_since(UNIX_EPOCH)?.as_secs_f64();
    let (mut sent, mut k) = (0_u64, 0_usize);
    while (k as f64) * PERIOD_S < seconds {
        let due = Duration::from_secs_f64(k as f64 * PERIOD_S);
        thread::sleep(due.saturating_sub(start.elapsed()));
        let time_s = epoch_s + k as f64 * PERIOD_S;
        for machine in 0..machines {
            let record = &records[machine % records.len()];
            let signals = record.inputs().iter().chain(record.outputs());
            let values = record
                .u()
                .column(k)
                .iter()
                .chain(record.y().column(k).iter())
                .copied()
                .collect::<Vec<f64>>();
            let pairs = signals.map(|signal| &signal.name).zip(values);
            if by_tag {
                for (tag, value) in pairs {
                    let payload = format!("{{\"time\":{time_s:.6},\"value\":{value}}}");
                    client.publish(
                        format!("plant/m{machine}/{tag}"),
                        QoS::AtLeastOnce,
                        false,
                        payload,
                    )?;
                    sent += 1;
                }
            } else {
                let values: Vec<String> = pairs
                    .map(|(tag, value)| format!("\"{tag}\":{value}"))
                    .collect();
                let payload = format!(
                    "{{\"time\":{time_s:.6},\"values\":{{{}}}}}",
                    values.join(",")
                );
                client.publish(
                    format!("plant/m{machine}"),
                    QoS::AtLeastOnce,
                    false,
                    payload,
                )?;
                sent += 1;
            }
        }
        k += 1;
    }
    // What is on its way is waited for.
    thread::sleep(Duration::from_secs(5));
    client.disconnect()?;
    let acknowledged = acknowledged.join().map_err(|_| "the connection's thread")?;
    println!(
        "{k} samples of {machines} machines in {:.1} s: {sent} messages, {acknowledged} acknowledged by the broker",
        start.elapsed().as_secs_f64()
    );
    Ok(())
}
