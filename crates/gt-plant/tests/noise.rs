//! Sensor noise in runs: engineering units, colour, resolution, streams; and as text.
#![expect(
    clippy::unwrap_used,
    reason = "the helpers stand outside the test functions"
)]

use gt_plant::{
    Channel, ChannelNoise, ChannelRow, Deviations, Noise, NoiseLevel, Profile, Run, Scenario,
    Variant, simulate, steady_state,
};
use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha12Rng;
use rand_distr::{Distribution, StandardNormal};

fn run(noise: Noise, profile: &str, duration_s: f64) -> Run {
    simulate(&Scenario {
        duration_s,
        seed: 11,
        run_index: 3,
        noise,
        profile: Profile::named(Variant::Prototype, profile).unwrap(),
        ..Scenario::default()
    })
    .unwrap()
}

fn only(entries: &[(&str, ChannelNoise)]) -> Noise {
    Noise {
        level: NoiseLevel::None,
        channels: entries
            .iter()
            .map(|(name, noise)| (Channel::named(name).unwrap(), *noise))
            .collect(),
    }
}

fn deviation(deviation: f64) -> ChannelNoise {
    ChannelNoise {
        deviation: Some(deviation),
        ..ChannelNoise::default()
    }
}

/// Truth and reading of a channel.
fn rows(run: &Run, channel: Channel) -> [Vec<f64>; 2] {
    [&run.truth, &run.measured].map(|data| {
        let row = match channel.row() {
            ChannelRow::Input(row) => data.u().row(row),
            ChannelRow::Output(row) => data.y().row(row),
        };
        row.iter().copied().collect()
    })
}

fn noise_of(run: &Run, name: &str) -> Vec<f64> {
    let [truth, reading] = rows(run, Channel::named(name).unwrap());
    reading.iter().zip(&truth).map(|(a, b)| a - b).collect()
}

fn root_mean_square(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt()
}

/// The white noise of a level is a fixed function of seed, run index and channel: `ChaCha12` of
/// the key (seed, run index) and stream 1000 + row of the input, 2000 + row of the output.
#[test]
fn regress_the_streams_of_white_noise() {
    for level in [NoiseLevel::Low, NoiseLevel::Table8] {
        let run = run(level.into(), "standard", 8.0);
        let deviations = Deviations::of(run.truth.u(), run.truth.y());
        for channel in Channel::of(Variant::Prototype) {
            let [truth, reading] = rows(&run, channel);
            let share = match (level, channel.name()) {
                (_, "w_ref" | "p_a" | "T_a") => 0.0,
                (NoiseLevel::Low, _) => 0.01,
                (_, "a_v") => 0.1417,
                (_, "M_f") => 0.2623,
                (_, name) => match &name[..1] {
                    "p" => 0.2497,
                    "m" => 0.2345,
                    "q" | "P" => 0.2909,
                    _ => 0.0941,
                },
            };
            let size = share * deviations.channel(channel);
            let mut key = [0; 32];
            key[0] = 11;
            key[8] = 3;
            let mut generator = ChaCha12Rng::from_seed(key);
            generator.set_stream(match channel.row() {
                ChannelRow::Input(row) => 1000 + row as u64,
                ChannelRow::Output(row) => 2000 + row as u64,
            });
            for (truth, reading) in truth.iter().zip(&reading) {
                let normal: f64 = StandardNormal.sample(&mut generator);
                let expected = if size > 0.0 {
                    truth + size * normal
                } else {
                    *truth
                };
                assert_eq!(reading.to_bits(), expected.to_bits(), "{level} {channel}");
            }
        }
    }
}

#[test]
fn engineering_units_need_no_excitation_and_touch_their_channel_alone() {
    let named = [
        ("t3", 2.0),
        ("T_a", 0.5),
        ("p_a", 40.0),
        ("a_v", 0.1),
        ("w_ref", 1.0),
    ];
    let noise = only(&named.map(|(name, size)| (name, deviation(size))));
    let run = run(noise, "steady", 600.0);
    assert!(run.warnings.is_empty());
    for channel in Channel::of(Variant::Prototype) {
        let [truth, reading] = rows(&run, channel);
        let Some((name, size)) = named.iter().find(|(name, _)| *name == channel.name()) else {
            assert_eq!(truth, reading, "{channel}");
            continue;
        };
        let found = root_mean_square(&noise_of(&run, name));
        // Standard error of a deviation: 1 / sqrt(2 N) = 0.8 %; five of them.
        assert!((found / size - 1.0).abs() < 0.041, "{name}: {found}");
    }
}

#[test]
fn one_channel_changes_no_other() {
    let base = run(NoiseLevel::Table8.into(), "standard", 8.0);
    let mut noise = Noise::from(NoiseLevel::Table8);
    let own = ChannelNoise {
        pole: 0.9,
        resolution: 0.1,
        ..deviation(3.0)
    };
    noise.channels.insert(Channel::named("t3").unwrap(), own);
    let changed = run(noise, "standard", 8.0);
    for channel in Channel::of(Variant::Prototype) {
        let same = rows(&base, channel) == rows(&changed, channel);
        assert_eq!(same, channel.name() != "t3", "{channel}");
    }
}

#[test]
fn shares_are_those_of_the_level() {
    // Table 8 of t3, by name and by number.
    let share = ChannelNoise {
        share: Some(0.0941),
        ..ChannelNoise::default()
    };
    let [by_level, by_share] = [NoiseLevel::Table8.into(), only(&[("t3", share)])]
        .map(|noise| noise_of(&run(noise, "standard", 8.0), "t3"));
    assert_eq!(by_level, by_share);
}

#[test]
fn published_table_8_variance_is_the_square_of_its_deviation() {
    let [first, second] = [NoiseLevel::Table8, NoiseLevel::Table8Variance]
        .map(|level| run(level.into(), "standard", 8.0));
    for (name, printed) in [
        ("a_v", 0.1417_f64),
        ("M_f", 0.2623),
        ("p7", 0.2497),
        ("m9", 0.2345),
        ("q_c", 0.2909),
        ("t3", 0.0941),
    ] {
        for (a, b) in noise_of(&first, name).iter().zip(noise_of(&second, name)) {
            // The same draws; rounding of (truth + noise) - truth where the truth is 1e3 deviations.
            let (a, b) = (a / printed, b / printed.sqrt());
            assert!(
                (a - b).abs() <= 1e-9 * (a.abs() + b.abs()) + 1e-9,
                "{name}: {a} {b}"
            );
        }
    }
}

#[test]
fn published_tables_4_and_5() {
    let run = run(NoiseLevel::Tables4And5.into(), "steady", 600.0);
    assert!(run.warnings.is_empty());
    let steady = steady_state(&gt_plant::PlantParameters::for_maps(
        gt_plant::MapSet::default(),
    ))
    .unwrap();
    let value = |name| steady.value(name).unwrap();
    for (name, three_deviations) in [
        ("T_a", 14.0),
        (
            "p_a",
            0.10 * rows(&run, Channel::named("p_a").unwrap())[0][0],
        ),
        (
            "M_f",
            0.10 * rows(&run, Channel::named("M_f").unwrap())[0][0],
        ),
        ("a_v", 9.0),
        ("m9", 0.10 * value("m9")),
        ("p7", 0.15 * value("p7")),
        ("q_c", 0.10 * value("q_c")),
        ("t3", 15.0),
        ("w_t", 0.10 * value("w_t")),
    ] {
        let found = root_mean_square(&noise_of(&run, name));
        // Standard error of a deviation: 1 / sqrt(2 N) = 0.8 %; five of them.
        assert!(
            (3.0 * found / three_deviations - 1.0).abs() < 0.041,
            "{name}: {found}"
        );
    }
    let [truth, reading] = rows(&run, Channel::named("w_ref").unwrap());
    assert_eq!(truth, reading);
}

#[test]
fn coloured_noise_is_stationary() {
    for pole in [0.0, 0.9, -0.5] {
        let own = ChannelNoise {
            pole,
            ..deviation(2.0)
        };
        let run = run(only(&[("t3", own), ("q_c", own)]), "steady", 2400.0);
        for name in ["t3", "q_c"] {
            let noise = noise_of(&run, name);
            let n = noise.len() as f64;
            let found = root_mean_square(&noise);
            // Standard error of a variance under a pole a: sqrt(2 (1 + a^2) / (1 - a^2) / N); the
            // deviation's is half of it. Five of them.
            let square = pole * pole;
            let error = 0.5 * (2.0 * (1.0 + square) / (1.0 - square) / n).sqrt();
            assert!(
                (found / 2.0 - 1.0).abs() < 5.0 * error,
                "{name}, {pole}: {found}"
            );
            let products: f64 = noise.windows(2).map(|w| w[0] * w[1]).sum();
            let lag_one = products / n / found.powi(2);
            // Standard error of the lag-one correlation: sqrt((1 - a^2) / N), and for white 1 /
            // sqrt(N); five of them, and the bias of order 1 / N.
            let error = ((1.0 - square) / n).sqrt();
            assert!(
                (lag_one - pole).abs() < 5.0 * error + 5.0 / n,
                "{name}, {pole}: {lag_one}"
            );
        }
    }
}

#[test]
fn coloured_noise_begins_stationary() {
    // The first value has the whole deviation: the white draws of the same stream begin alike.
    let own = ChannelNoise {
        pole: 0.99,
        ..deviation(2.0)
    };
    let [white, coloured] =
        [deviation(2.0), own].map(|own| noise_of(&run(only(&[("t3", own)]), "steady", 0.8), "t3"));
    assert_eq!(white[0].to_bits(), coloured[0].to_bits());
    assert_ne!(white[1].to_bits(), coloured[1].to_bits());
}

#[test]
fn readings_are_multiples_of_the_resolution() {
    let own = ChannelNoise {
        resolution: 0.25,
        ..deviation(2.0)
    };
    let alone = ChannelNoise {
        resolution: 500.0,
        ..ChannelNoise::default()
    };
    let run_of = |noise| run(noise, "standard", 40.0);
    let rough = run_of(only(&[("t3", own), ("p3", alone)]));
    let fine = run_of(only(&[("t3", deviation(2.0))]));
    let t3 = Channel::named("t3").unwrap();
    let [rounded, exact] = [&rough, &fine].map(|run| rows(run, t3)[1].clone());
    for (rounded, exact) in rounded.iter().zip(&exact) {
        // After the noise; quarters are exact.
        assert_eq!(rounded.to_bits(), ((exact * 4.0).round() / 4.0).to_bits());
    }
    let [truth, reading] = rows(&rough, Channel::named("p3").unwrap());
    for (truth, reading) in truth.iter().zip(&reading) {
        let multiple = (reading / 500.0).round() * 500.0;
        assert_eq!(reading.to_bits(), multiple.to_bits());
        assert!((truth - reading).abs() <= 250.0);
    }
}

#[test]
fn noise_is_a_name_or_a_table() {
    let read = |text: &str| {
        toml::from_str::<Scenario>(text)
            .map(|scenario| scenario.noise)
            .map_err(|error| error.message().to_owned())
    };
    for level in NoiseLevel::ALL {
        assert_eq!(read(&format!("noise = '{level}'")), Ok(level.into()));
        assert_eq!(read(&format!("noise.level = '{level}'")), Ok(level.into()));
        assert_eq!(level.name().parse::<Noise>(), Ok(level.into()));
    }
    let text = "[noise]\nlevel = 'low'\n[noise.channels.t3]\ndeviation = 0.5\npole = 0.9\n\
                resolution = 0.1\n[noise.channels.a_v]\nshare = 0.2";
    let mut expected = only(&[
        (
            "t3",
            ChannelNoise {
                pole: 0.9,
                resolution: 0.1,
                ..deviation(0.5)
            },
        ),
        (
            "a_v",
            ChannelNoise {
                share: Some(0.2),
                ..ChannelNoise::default()
            },
        ),
    ]);
    expected.level = NoiseLevel::Low;
    assert_eq!(read(text), Ok(expected.clone()));
    assert_eq!(expected.validate(), Ok(()));
    let names = "expected one of none, low, table8, table8_variance, tables4_5, found `high`";
    for (text, expected) in [
        ("noise = 'high'", format!("noise: {names}")),
        ("noise.level = 'high'", format!("noise: {names}")),
        (
            "noise.size = 1",
            "unknown field `size`, expected `level` or `channels`".to_owned(),
        ),
        (
            "noise.channels.t3.size = 1",
            "unknown field `size`, expected one of `deviation`, `share`, `pole`, `resolution`"
                .to_owned(),
        ),
    ] {
        assert_eq!(read(text), Err(expected), "{text}");
    }
    let message = read("noise.channels.t33.deviation = 1").unwrap_err();
    assert!(
        message.starts_with("channel: expected one of a_v, M_f,") && message.ends_with("`t33`"),
        "{message}"
    );
}

#[test]
fn impossible_noise_is_refused() {
    let refusal = |own: ChannelNoise| {
        let scenario = Scenario {
            noise: only(&[("t3", own)]),
            ..Scenario::default()
        };
        let error = scenario.validate().unwrap_err();
        assert_eq!(
            simulate(&scenario).unwrap_err().to_string(),
            error.to_string()
        );
        error.to_string()
    };
    let plain = ChannelNoise::default();
    let at_least = "expected a number from 0 to 1e12, found";
    for (own, expected) in [
        (deviation(-1.0), format!("deviation: {at_least} -1")),
        (
            deviation(f64::INFINITY),
            format!("deviation: {at_least} inf"),
        ),
        (
            ChannelNoise {
                share: Some(f64::NAN),
                ..plain
            },
            format!("share: {at_least} NaN"),
        ),
        (
            ChannelNoise {
                resolution: -0.5,
                ..plain
            },
            format!("resolution: {at_least} -0.5"),
        ),
        (
            ChannelNoise { pole: 1.0, ..plain },
            "pole: expected a number between -1 and 1, found 1".to_owned(),
        ),
    ] {
        assert_eq!(refusal(own), format!("noise of t3, {expected}"));
    }
    assert_eq!(
        refusal(ChannelNoise {
            share: Some(0.1),
            ..deviation(1.0)
        }),
        "noise of t3: expected deviation or share, found both"
    );
}

proptest! {
    #[test]
    fn prop_what_is_written_reads_the_same(
        level in proptest::sample::select(NoiseLevel::ALL.to_vec()),
        entries in proptest::collection::btree_map(
            proptest::sample::select(Channel::of(Variant::Prototype).collect::<Vec<_>>()),
            (proptest::option::of(0.0..1e6f64), proptest::option::of(0.0..2.0f64), -1.0..1.0f64,
             prop_oneof![Just(0.0), 0.0..1e3f64]),
            0..4,
        ),
    ) {
        let channels = entries.into_iter().map(|(channel, (deviation, share, pole, resolution))| {
            (channel, ChannelNoise { deviation, share, pole, resolution })
        });
        let written =
            Scenario { noise: Noise { level, channels: channels.collect() }, ..Scenario::default() };
        let text = toml::to_string(&written).unwrap();
        prop_assert_eq!(toml::from_str::<Scenario>(&text), Ok(written.clone()), "{}", text);
        let text = serde_json::to_string(&written).unwrap();
        prop_assert_eq!(serde_json::from_str::<Scenario>(&text).unwrap(), written);
    }

    #[test]
    fn prop_no_text_panics(
        text in "(noise|level|channels|deviation|share|pole|resolution|t3|\\.| = |\n|\\[|\\]|[0-9.e-]{1,8}|'[a-z_0-9]{1,9}'){0,12}"
    ) {
        if let Ok(scenario) = toml::from_str::<Scenario>(&text) {
            let _ = scenario.validate();
        }
    }
}
