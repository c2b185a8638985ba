//! The reproduction as a whole: its numbers against the paper's, its files, its determinism.

#![allow(clippy::unwrap_used, clippy::expect_used)] // a test may stop where it fails
#![allow(clippy::float_cmp)] // ones and zeros here are exact by construction

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use gt_campaign::tables::Origin;
use gt_campaign::{Depth, Reproduction, Silent, paper, reproduce};

/// One reproduction serves all tests: it is the expensive part.
fn reproduction() -> &'static Reproduction {
    static ONCE: OnceLock<Reproduction> = OnceLock::new();
    ONCE.get_or_init(|| reproduce(1, Depth::Short, &Silent).expect("the reproduction runs"))
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(files(&path));
        } else {
            found.push(path);
        }
    }
    found.sort();
    found
}

#[test]
fn published_table3_is_met_but_for_what_it_contradicts_itself() {
    let tables = &reproduction().tables;
    let (rows, notes) = (&tables.table3, &tables.table3_notes);
    assert_eq!(rows.len(), paper::TABLE3.len());
    let mut count = [0; 4];
    for row in rows {
        // Calibrated: what trimming leaves. Reconciled: the largest change that the plant's
        // calibration states. Checks: e_t is 1.6 % off, as the printed one gives another power.
        let (index, limit) = match row.origin {
            Origin::Calibrated => (0, 2e-4),
            Origin::Reconciled => (1, 1.2),
            Origin::Check => (2, 1.7),
            Origin::Defined => (3, 0.3),
        };
        count[index] += 1;
        assert!(row.error_percent.abs() <= limit, "{row:?}");
    }
    assert_eq!(count, [16, 7, 6, 1]);
    let mean = rows.iter().map(|row| row.error_percent.abs()).sum::<f64>() / rows.len() as f64;
    assert!((mean - notes.mean_absolute_error_percent).abs() < 1e-12);
    // 0.25 % measured, below 0.8 % asked for; a parameter that slips moves several entries.
    assert!(mean < 0.3, "mean absolute error {mean} %");
    assert_eq!(notes.largest_error_variable, "e_t");
    // What the printed t2, t3 and pressure ratio imply with real heat capacities.
    assert!((notes.map_isentropic_efficiency - 0.839).abs() < 5e-4);
}

#[test]
fn published_table6_is_met_with_every_seed_at_one_degree() {
    let tables = &reproduction().tables;
    let [standard, lively] = tables.table6_seeds.as_slice() else {
        panic!("two profiles: {:?}", tables.table6_seeds);
    };
    assert_eq!(
        (standard.valve_amplitude_deg, lively.valve_amplitude_deg),
        (1.0, 1.5)
    );
    for seeds in [standard, lively] {
        assert_eq!(seeds.seeds, (1..=10).collect::<Vec<u64>>());
        assert_eq!(seeds.rows.len(), 5);
        // The first seed is that of Table 6, its records are other arithmetic (lanes): the error
        // of a free run moves with the rounding of its model, 1e-16 times a condition of 1e7.
        for (row, single) in standard.rows.iter().zip(&tables.table6) {
            let pairs = [
                (row.identification, single.identification),
                (row.validation1, single.validation1),
                (row.validation2, single.validation2),
            ];
            for (worst, single) in pairs {
                assert!(worst >= single.map(|error| error * (1.0 - 1e-6)), "{row:?}");
            }
        }
    }
    for row in &standard.rows {
        assert_eq!(row.met, 10, "{row:?}");
    }
    // What the plant's non-linearity leaves grows with the amplitude: the speed misses the paper's
    // 0.01 on the identification record with each seed, and is within 0.025 everywhere.
    for row in &lively.rows {
        assert_eq!(row.met, if row.output == "w_t" { 0 } else { 10 }, "{row:?}");
        for error in [row.identification, row.validation1, row.validation2] {
            assert!(error.is_some_and(|error| error < 0.025), "{row:?}");
        }
    }
}

#[test]
fn published_table8_is_recovered_from_the_noisy_records() {
    let tables = &reproduction().tables;
    let signals: Vec<&str> = tables
        .table8
        .iter()
        .map(|row| row.signal.as_str())
        .collect();
    let once = ["q_c", "t3", "p7", "m9", "a_v", "M_f"];
    assert_eq!(signals, [once, once].concat());
    for (row, plant) in tables.table8.iter().zip(0..) {
        let twin = plant < once.len();
        let name = if twin {
            "linearised twin"
        } else {
            "non-linear plant"
        };
        assert_eq!(row.plant, name);
        let error = 100.0 * (row.found / row.put_in - 1.0);
        assert!((error - row.error_percent).abs() < 1e-9, "{row:?}");
        assert!(
            row.worst_error_percent.abs() >= error.abs() - 1e-9,
            "{row:?}"
        );
        assert_eq!(row.put_in, row.paper);
        // 10 % is asked for. A record of 7500 samples tells a deviation to 1 / sqrt(2 N) = 0.8 % at
        // best; the estimate says about that of itself. 3 % is what the README says of these seeds.
        assert!(row.met && row.worst_error_percent.abs() <= 3.0, "{row:?}");
        let share = row.standard_error.expect("a standard error") / row.found;
        assert!(share > 0.007 && share < 0.03, "{row:?}");
        // With no more than five of its standard errors it is not off by luck alone.
        assert!(error.abs() <= 100.0 * 5.0 * share, "{row:?}");
    }
    let number = |signal: &str| tables.table8.iter().find(|row| row.signal == signal);
    assert_eq!(number("p7").map(|row| row.put_in), Some(0.2497));
    assert_eq!(number("M_f").map(|row| row.paper), Some(0.2623));
}

#[test]
fn published_table7_is_met_at_the_order_that_the_likelihood_chooses() {
    let tables = &reproduction().tables;
    assert_eq!(tables.table7.len(), 16);
    for row in &tables.table7 {
        let errors = [row.identification, row.validation];
        let worst = [row.worst_identification, row.worst_validation];
        for (error, worst) in errors.into_iter().zip(worst) {
            assert!(error.is_some() && worst >= error, "{row:?}");
        }
        // Order 8 is more than the records tell: its numbers are printed as they come.
        if row.order != 8 {
            // Slow rotor and direct terms: one or two poles an output are told at this noise.
            assert!(row.order <= 3, "{row:?}");
            assert!(
                errors.iter().all(|error| *error <= Some(row.paper)),
                "{row:?}"
            );
        }
    }
}

#[test]
fn the_effects_of_the_faults_are_complete_and_said_as_they_are() {
    let tables = &reproduction().tables;
    let sets: Vec<&str> = tables.fault_effects.keys().map(String::as_str).collect();
    assert_eq!(sets, ["axial", "paper"]);
    for effects in tables.fault_effects.values() {
        assert_eq!(effects.outputs.len(), 28);
        // The healthy shadow gets the same fuel at every stage: the same arithmetic, no effect.
        assert_eq!(effects.delivered_fuel_rms_percent, vec![0.0; 28]);
        for (reading, range) in [
            (&effects.raw, &effects.case4_raw_range_percent),
            (
                &effects.inputs_held,
                &effects.case4_inputs_held_range_percent,
            ),
        ] {
            assert_eq!(reading.rms_percent.shape(), (28, 4));
            for (output, [low, high]) in range.iter().enumerate() {
                // A lag has no settled effect; over all runs it is between the single runs.
                assert_eq!(reading.static_percent[(output, 3)], 0.0);
                let pooled = reading.rms_percent[(output, 3)];
                let rounding = 1e-12 * high;
                assert!(
                    *low - rounding <= pooled && pooled <= *high + rounding,
                    "{output}: {pooled}"
                );
                // Case 2 touches the sensor of t3 alone, by its size.
                let is_t3 = effects.outputs[output].name == "t3";
                let sensor = reading.static_percent[(output, 1)];
                let expected = if is_t3 { 5.0 } else { 0.0 };
                assert!((sensor - expected).abs() < 1e-9, "{output}: {sensor}");
            }
        }
        // At 2 s of lag another case moves m9 more, in either reading.
        assert!(!effects.signature_raw.diagonal && !effects.signature_inputs_held.diagonal);
    }
    // Linear stability of the speed loop; the specification's prototype found about 3.05 s.
    let limit = tables.lag_limit["paper"].expect("a limit");
    assert!((limit.lag_s - 3.05).abs() < 0.005, "{limit:?}");
    assert!((limit.frequency_rad_s - 0.93).abs() < 0.005, "{limit:?}");
    assert_eq!(tables.lag_limit["axial"], None);
}

#[test]
fn both_load_reductions_do_what_section_3_1_says() {
    let cogeneration = &reproduction().tables.cogeneration;
    assert_eq!(cogeneration.manoeuvres.len(), 4);
    for manoeuvre in &cogeneration.manoeuvres {
        let change = |name: &str| {
            let signal = manoeuvre.signals.iter().find(|row| row.signal == name);
            let signal = signal.expect("a signal of the manoeuvre");
            signal.last - signal.initial
        };
        assert!(change("M_f") < 0.0 && change("P_e") < 0.0);
        match manoeuvre.profile.as_str() {
            // The controller closes the vanes and holds the temperature within a few kelvin.
            "load_reduction_igv" => {
                assert!(!manoeuvre.vanes_closed && change("IGV") > 0.0);
                assert!(manoeuvre.largest_deviation_k.abs() < 3.0, "{manoeuvre:?}");
                assert!(change("T_ot").abs() < 0.1);
            }
            "load_reduction_fuel" => {
                assert!(manoeuvre.vanes_closed);
                assert!(change("T_ot") < -10.0, "{manoeuvre:?}");
            }
            other => panic!("unknown manoeuvre {other}"),
        }
        // The plant follows the fuel within seconds; the record lasts 220 s more.
        for signal in &manoeuvre.signals {
            assert!(signal.settles_after_s < 30.0, "{signal:?}");
        }
    }
    for loads in cogeneration.steady.windows(2) {
        if loads[0].map_set == loads[1].map_set {
            assert!(loads[1].electric_power_w < loads[0].electric_power_w);
            assert!(loads[1].guide_vane_deg >= loads[0].guide_vane_deg);
        }
    }
    assert_eq!(cogeneration.steady.len(), 18);
}

#[test]
fn published_table6_is_met_in_free_run_on_all_three_records() {
    let rows = &reproduction().tables.table6;
    let outputs: Vec<&str> = rows.iter().map(|row| row.output.as_str()).collect();
    assert_eq!(outputs, ["q_c", "t3", "p7", "m9", "w_t"]);
    for row in rows {
        let ours = [row.identification, row.validation1, row.validation2];
        for (ours, paper) in ours.iter().zip(row.paper) {
            assert!(
                ours.expect("the free run stays bounded") <= paper,
                "{row:?}"
            );
        }
        assert!(row.met);
        // One step ahead is far easier than a free run; were they equal, one would be the other.
        assert!(
            row.identification_prediction < 0.1 * row.identification.unwrap(),
            "{row:?}"
        );
    }
}

#[test]
fn published_signature_is_diagonal_with_the_papers_maps_and_the_axial_maps_are_shown_too() {
    let tables = &reproduction().tables.table9;
    let sets: Vec<&str> = tables.iter().map(|table| table.map_set.as_str()).collect();
    assert_eq!(sets, ["paper", "axial"]);
    assert!(tables[0].diagonal, "{:?}", tables[0].matrix);
    for table in tables.iter().chain(&reproduction().tables.table9_observers) {
        assert_eq!(table.columns, ["q_c", "t3", "p7", "m9"]);
        for column in 0..4 {
            let entries = table.matrix.iter().map(|row| row[column]);
            assert_eq!(
                entries.fold(0.0, f64::max),
                1.0,
                "{}: column {column}",
                table.map_set
            );
        }
        // A sensor fault touches the residual of its own sensor alone: the others are driven by
        // inputs and outputs that it cannot reach, so the zeros are exact.
        for column in [0, 2, 3] {
            assert_eq!(table.raw[1][column], 0.0, "{}", table.map_set);
        }
    }
    // Full-size faults, 0.5 cut: the pattern of the paper's Table 9; isolating residuals, learned on
    // other records, leave half of that.
    for (matrix, most) in [(&tables[0].matrix, 0.5), (&tables[0].matrix_isolated, 0.25)] {
        for (row, entries) in matrix.iter().enumerate() {
            for (column, entry) in entries.iter().enumerate() {
                assert!(
                    row == column || *entry <= most,
                    "({row}, {column}): {entry}"
                );
            }
        }
    }
}

#[test]
fn every_nominal_fault_is_seen_by_the_papers_output_after_its_onset() {
    for row in &reproduction().tables.detection {
        let own = row
            .delays_s
            .iter()
            .find(|delay| delay.output == row.expected)
            .unwrap();
        let delay = own.delay_s.expect("seen within the run");
        assert!(delay > 0.0, "{row:?}");
        let size = own.size.unwrap();
        assert!(size > 0.0 && size <= row.final_size, "{row:?}");
    }
}

#[test]
fn false_alarm_rates_leave_the_settling_out_and_carry_their_intervals() {
    for row in &reproduction().tables.observers {
        // Four healthy records of 600 s and a fifth, each less the same settling.
        let [four, one] = [&row.false_alarms_cross_validated, &row.false_alarms_test];
        assert!(one.hours < 600.0 / 3600.0, "{row:?}");
        assert!((four.hours - 4.0 * one.hours).abs() < 1e-12, "{row:?}");
        for rate in [four, one] {
            assert!(rate.per_hour_low <= rate.per_hour && rate.per_hour <= rate.per_hour_high);
        }
    }
}

/// Twenty runs a limit: the upper end of an interval is the largest of them or beyond the range.
/// The bounds are those asked of many runs, with a quarter for so few.
#[test]
fn table10_and_the_naming_of_faults_are_within_their_bounds() {
    let tables = &reproduction().tables;
    let own: Vec<_> = tables.table10.iter().take(4).collect();
    assert_eq!(
        own.iter().map(|row| row.case).collect::<Vec<_>>(),
        [1, 2, 3, 4]
    );
    let [noise_free, noisy] = [[0.04, 0.04, 0.06], [0.12, 0.10, 0.35]];
    for ((row, noise_free), noisy) in own.iter().zip(noise_free).zip(noisy) {
        assert!(
            row.noise_free_percent.unwrap() <= 1.25 * noise_free,
            "{row:?}"
        );
        assert!(row.noisy_percent.unwrap() <= 1.25 * noisy, "{row:?}");
        assert!(
            row.noisy_accuracy_percent.is_none(),
            "computed in full only"
        );
    }
    let isolation = tables.isolation.as_ref().unwrap();
    assert_eq!(isolation.map_set, "paper");
    assert_eq!(isolation.noise, "table8");
    // All of 60 named rightly has the interval 94 to 100 %; two errors would be below it.
    assert!(isolation.summary.accuracy_percent >= 98.0, "{isolation:?}");
    assert!(isolation.summary.detected_percent >= 95.0, "{isolation:?}");
}

#[test]
fn the_folder_is_complete_whole_and_self_contained() {
    let folder = tempfile::tempdir().unwrap();
    reproduction().write(folder.path(), &Silent).unwrap();
    let files = files(folder.path());
    assert!(
        files
            .iter()
            .all(|path| path.extension().is_none_or(|end| end != "part"))
    );
    let count = |end: &str| {
        files
            .iter()
            .filter(|path| path.extension().is_some_and(|e| e == end))
            .count()
    };
    let figures = reproduction().figures.len();
    // Beside the figures' data: the effects of the faults on two map sets, and the steady loads.
    assert_eq!((count("svg"), count("csv")), (figures, figures + 3));
    let effects = fs::read_to_string(folder.path().join("tables/fault_effects_paper.csv")).unwrap();
    let columns: Vec<usize> = effects
        .lines()
        .map(|line| line.split(',').count())
        .collect();
    // Output, unit, steady; in two readings 4 settled, 4 rms, 2 of the range; delivered fuel.
    assert_eq!(columns, vec![24; 29]);

    let whole = fs::read_to_string(folder.path().join("index.html")).unwrap();
    let (page, script) = whole.split_once("<script>").expect("what lets charts zoom");
    // The name of SVG's elements is no address; a clip is one within the page.
    let script = script.replace("http://www.w3.org/2000/svg", "");
    let script = script.replace("url(#", "");
    for text in [page, &script] {
        for outside in ["http://", "https://", "src=", "url(", "@import", "fetch("] {
            assert!(!text.contains(outside), "{outside} leaves the page");
        }
    }
    for figure in &reproduction().figures {
        let link = format!("figures/{}.svg", figure.chart.id);
        assert!(
            page.contains(&link) && folder.path().join(&link).is_file(),
            "{link}"
        );
    }
    for file in [
        "fault_effects_paper",
        "fault_effects_axial",
        "cogeneration_steady",
    ] {
        let link = format!("href=\"tables/{file}.csv\"");
        assert!(page.contains(&link), "{file}");
    }
    // The numbers behind the charts are JSON and Base64, which may spell anything.
    let mut parts = page.split("<script type=\"application/json\">");
    let first = parts.next().unwrap();
    let rest = parts.map(|part| part.split_once("</script>").expect("an end").1);
    assert!(
        std::iter::once(first)
            .chain(rest)
            .all(|text| !text.contains("NaN"))
    );
    // Small enough to be opened anywhere.
    assert!(whole.len() < 5_000_000, "{} bytes", whole.len());

    let tables = fs::read_to_string(folder.path().join("tables.json")).unwrap();
    let tables: serde_json::Value = serde_json::from_str(&tables).unwrap();
    assert_eq!(tables["table3"].as_array().unwrap().len(), 30);

    let info = gt_log::info(&folder.path().join("logs/paper_case2_nominal.mcap")).unwrap();
    let topics: Vec<(&str, u64)> = info
        .topics
        .iter()
        .map(|topic| (topic.topic.as_str(), topic.messages))
        .collect();
    // 1800 s at 0.08 s.
    for topic in ["/plant/truth", "/plant/measured", "/plant/faults"] {
        assert!(topics.contains(&(topic, 22_500)), "{topics:?}");
    }
}

/// The whole folder, byte for byte: pages, tables, figures and logs.
#[test]
fn one_thread_writes_the_same_bytes_as_all_into_another_folder() {
    let written = |what: &Reproduction| {
        let folder = tempfile::tempdir().unwrap();
        what.write(folder.path(), &Silent).unwrap();
        folder
    };
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .unwrap();
    let alone = pool.install(|| written(&reproduce(1, Depth::Short, &Silent).unwrap()));
    let all = written(reproduction());
    let names = |folder: &Path| -> Vec<PathBuf> {
        let inside = |path: &PathBuf| path.strip_prefix(folder).unwrap().to_owned();
        files(folder).iter().map(inside).collect()
    };
    assert_eq!(names(alone.path()), names(all.path()));
    for name in names(all.path()) {
        let bytes = |folder: &Path| fs::read(folder.join(&name)).unwrap();
        assert!(
            bytes(alone.path()) == bytes(all.path()),
            "{} differs",
            name.display()
        );
    }
}
