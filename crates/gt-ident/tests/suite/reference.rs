//! Public laboratory and plant records against ARX parameters and fits that two independent
//! solvers agree on (`arx_reference.json` in the folder that `GTFDI_REFERENCE_DATA` names).

use std::path::PathBuf;

use gt_core::{Dataset, Signal};
use gt_ident::{Arx, ArxModel, ArxStructure, Channel, validate};
use nalgebra::DMatrix;
use serde_json::Value;

/// Relative to the coefficient, at least 1: the solvers behind the file agree to 1.2e-13.
const COEFFICIENT_TOLERANCE: f64 = 1e-8;
/// Per cent; the file is rounded to three decimals.
const FIT_TOLERANCE_PERCENT: f64 = 1e-3;

fn folder(test: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("GTFDI_REFERENCE_DATA").map(PathBuf::from);
    if folder.is_none() {
        println!("skipped: {test}: GTFDI_REFERENCE_DATA is not set");
    }
    folder
}

fn names(value: &Value) -> Vec<String> {
    value
        .as_array()
        .unwrap()
        .iter()
        .map(|name| name.as_str().unwrap().to_owned())
        .collect()
}

fn size(value: &Value) -> usize {
    usize::try_from(value.as_u64().unwrap()).unwrap()
}

fn read_csv(path: &PathBuf, inputs: &[String], outputs: &[String]) -> Dataset {
    let text = std::fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let rows: Vec<Vec<f64>> = lines
        .map(|line| {
            line.split(',')
                .map(|field| field.trim().parse().unwrap())
                .collect()
        })
        .collect();
    let matrix = |names: &[String]| {
        let columns: Vec<usize> = names
            .iter()
            .map(|name| {
                header
                    .iter()
                    .position(|column| column.trim() == name)
                    .unwrap()
            })
            .collect();
        DMatrix::from_fn(names.len(), rows.len(), |row, sample| {
            rows[sample][columns[row]]
        })
    };
    let (u, y) = (matrix(inputs), matrix(outputs));
    Dataset::new(Signal::named(inputs), Signal::named(outputs), u, y, 1.0).unwrap()
}

/// The largest difference from the listed coefficients, relative as in `COEFFICIENT_TOLERANCE`.
fn coefficient_error(model: &ArxModel, regression: &Value) -> f64 {
    let mut worst: f64 = 0.0;
    for (row, listed) in model.rows().iter().zip(regression.as_array().unwrap()) {
        let listed = listed.as_array().unwrap();
        assert_eq!(row.terms.len(), listed.len());
        for (term, entry) in row.terms.iter().zip(listed) {
            let name = match term.channel {
                Channel::Output(index) => &model.outputs()[index].name,
                Channel::Input(index) => &model.inputs()[index].name,
            };
            assert_eq!(name, entry["signal"].as_str().unwrap());
            assert_eq!(term.lag, size(&entry["lag"]));
            let expected = entry["coefficient"].as_f64().unwrap();
            worst = worst.max((term.coefficient - expected).abs() / expected.abs().max(1.0));
        }
    }
    worst
}

fn check_percent(found: &[f64], listed: &Value, what: &str) -> f64 {
    let mut worst: f64 = 0.0;
    for (found, listed) in found.iter().zip(listed.as_array().unwrap()) {
        let error = (found - listed.as_f64().unwrap()).abs();
        assert!(
            error <= FIT_TOLERANCE_PERCENT,
            "{what}: {found} against {listed}"
        );
        worst = worst.max(error);
    }
    worst
}

#[test]
fn published_records_give_the_reference_arx_models() {
    let Some(folder) = folder("published_records_give_the_reference_arx_models") else {
        return;
    };
    let text = std::fs::read_to_string(folder.join("arx_reference.json")).unwrap();
    let reference: Value = serde_json::from_str(&text).unwrap();
    let mut checked = 0;
    for (name, case) in reference["arx"].as_object().unwrap() {
        let path = folder.join(case["csv"].as_str().unwrap());
        let data = read_csv(&path, &names(&case["u"]), &names(&case["y"]));
        assert_eq!(data.len(), size(&case["rows"]));
        let block = |key: &str| data.rows(size(&case[key][0])..size(&case[key][1])).unwrap();
        let (na, nb, nk) = (
            size(&case["na"]),
            vec![size(&case["nb"])],
            vec![size(&case["nk"])],
        );
        for (key, structure) in [
            (
                "diag",
                ArxStructure::Diagonal {
                    na,
                    nb: nb.clone(),
                    nk: nk.clone(),
                },
            ),
            (
                "full",
                ArxStructure::Full {
                    na,
                    nb: nb.clone(),
                    nk: nk.clone(),
                },
            ),
        ] {
            let Some(expected) = case.get(key) else {
                continue;
            };
            let model = Arx::new(structure).fit(&block("train")).unwrap();
            let worst = coefficient_error(&model, &expected["regression"]);
            assert!(worst < COEFFICIENT_TOLERANCE, "{name} {key}: {worst:e}");
            for (row, listed) in model
                .rows()
                .iter()
                .zip(expected["mse_train"].as_array().unwrap())
            {
                let listed = listed.as_f64().unwrap();
                assert!(
                    (row.residual_variance - listed).abs() < 1e-8 * listed,
                    "{name} {key}"
                );
            }
            let fits = validate(&model, &block("val")).unwrap().outputs;
            let column = |value: fn(&gt_ident::OutputFit) -> f64| -> Vec<f64> {
                fits.iter().map(value).collect()
            };
            let percent = [
                (column(|fit| fit.fit_prediction_percent), "fit_pred"),
                (column(|fit| fit.fit_simulation_percent.unwrap()), "fit_sim"),
                (column(|fit| fit.ppcre_prediction_percent), "ppre_pred"),
                (
                    column(|fit| fit.ppcre_simulation_percent.unwrap()),
                    "ppre_sim",
                ),
            ]
            .map(|(found, entry)| {
                check_percent(&found, &expected[entry], &format!("{name} {key} {entry}"))
            });
            println!(
                "{name} {key}: coefficients {worst:.1e}, per cent {percent:.4?}, condition {:.4?} (listed {})",
                model.condition(),
                expected["cond"]
            );
            checked += 1;
        }
    }
    assert_eq!(checked, 7, "structures in the file");
}
