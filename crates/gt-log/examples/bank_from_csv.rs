//! A bank from a CSV file of healthy running: the first half of the rows makes the model, the second
//! sets the limits, and the bank is written for `gtfdi detect`, the service or another program.
//!
//! `cargo run -p gt-log --example bank_from_csv -- HEALTHY.csv INPUTS OUTPUTS BANK.json`, tags with
//! commas.

use std::env;
use std::error::Error;
use std::path::Path;

use gt_log::{DetectorFile, Selection, read_dataset, write_json};
use gtfdi::fdi::{Bank, ResidualGenerator, ResidualTest, StatisticKind, ThresholdRule};
use gtfdi::ident::{Arx, OrderKind, order_table};

/// Times the largest healthy residual.
const MARGIN: f64 = 1.2;
/// Samples in a row above the limit that make an alarm.
const CONSECUTIVE: usize = 3;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let [file, inputs, outputs, bank_file] = &arguments[..] else {
        return Err("expected HEALTHY.csv INPUTS OUTPUTS BANK.json".into());
    };
    let tags = |text: &str| text.split(',').map(str::to_owned).collect();
    let selection = Selection {
        inputs: tags(inputs),
        outputs: tags(outputs),
        ..Selection::default()
    };
    let imported = read_dataset(Path::new(file), &selection)?;
    for remark in imported.remarks() {
        eprintln!("{file}: {remark}");
    }
    let data = imported.dataset;
    let half = data.len() / 2;
    let (train, healthy) = (data.rows(0..half)?, data.rows(half..data.len())?);

    let kind = OrderKind::Diagonal { nk: vec![1] };
    let order = order_table(&train, 1..=6, &kind)?.best_mdl();
    let structure = kind.structure(order, data.ny())?;
    let model = Arx::new(structure).fit(&train)?;

    let (mut generators, mut tests) = (Vec::new(), Vec::new());
    for (index, output) in data.outputs().iter().enumerate() {
        let part = model.output_model(index)?;
        // All poles at zero: the error one step ahead.
        let poles = vec![0.0; part.model.nx()];
        let generator = ResidualGenerator::observer(part.model, part.point, &poles)?;
        let rule = ThresholdRule::Margin {
            factor: MARGIN,
            consecutive: CONSECUTIVE,
        };
        let own = std::slice::from_ref(&healthy);
        let name = &output.name;
        let test = ResidualTest::calibrate(name, &[&generator], own, StatisticKind::Modulus, rule)?;
        println!("{name}: order {order}, limit {:.4}", test.threshold.limit);
        generators.push(generator);
        tests.push(test);
    }
    let bank = Bank::new("healthy", generators, tests)?;
    let rate = bank.false_alarms();
    println!(
        "{} false alarms in {:.2} h of healthy running, at most {:.1} an hour",
        rate.alarms, rate.hours, rate.per_hour_high
    );
    write_json(Path::new(bank_file), &DetectorFile::Bank(bank))?;
    Ok(())
}
