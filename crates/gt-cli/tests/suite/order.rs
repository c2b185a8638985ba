//! The search for the order.

use serde_json::Value;

use crate::place::{Place, array, number};
use crate::signal::{arx, csv, second_order_csv, two_outputs_csv};

const ONE: [&str; 6] = ["identify", "one.csv", "--inputs", "u", "--outputs", "y"];

fn orders(report: &Value) -> Vec<u64> {
    let rows = array(report, "/order_table/rows").iter();
    rows.map(|row| row["order"].as_u64().expect("an order"))
        .collect()
}

#[test]
fn the_order_of_a_simulated_system_is_found() {
    let place = Place::new();
    let systems: [(&[f64], &[f64]); 3] = [
        (&[0.8], &[1.0]),
        (&[1.5, -0.7], &[1.0, 0.5]),
        (&[1.2, -0.5, 0.2], &[0.3, 1.0, -0.6]),
    ];
    for (index, (a, b)) in systems.into_iter().enumerate() {
        place.write("one.csv", csv("u,y", &arx(a, b, 0.3, 2000, 11)));
        for (wish, expected) in [("auto", 1..=12), ("1..6", 1..=6), ("1..=6", 1..=6)] {
            let report = place.json(&[&ONE[..], &["--order", wish]].concat());
            assert_eq!(orders(&report), expected.collect::<Vec<u64>>());
            let order = index + 1;
            assert_eq!(report["structure"]["full"]["na"], order, "--order {wish}");
            assert_eq!(report["order_table"]["best_mdl"], order);
            let mdl = |row: &Value| number(row, "/mdl");
            let rows = array(&report, "/order_table/rows");
            let least = rows.iter().map(mdl).fold(f64::INFINITY, f64::min);
            assert!(mdl(&rows[order - 1]) <= least);
        }
    }
    let text = place.done(&[&ONE[..], &["--order", "1..4"]].concat());
    assert!(text.contains("chosen by MDL: order 3"), "{text}");
}

#[test]
fn the_reason_of_the_choice_is_printed() {
    let place = Place::new();
    place.write("one.csv", second_order_csv(500, 1));
    let args = [&ONE[..], &["--order", "1..5"]].concat();
    let report = place.json(&args);
    let mdl = |order: usize| number(&report, &format!("/order_table/rows/{}/mdl", order - 1));
    let next = [1, 3, 4, 5]
        .into_iter()
        .min_by(|a, b| mdl(*a).total_cmp(&mdl(*b)));
    let next = next.expect("four others");
    let [aic, fpe] = ["best_aic", "best_fpe"].map(|key| report["order_table"][key].clone());
    let reason = format!(
        "chosen by MDL: order 2, {:.1} below order {next}, the next best; AIC would take order \
         {aic}, FPE order {fpe}",
        mdl(next) - mdl(2)
    );
    assert_eq!(report["order_reason"], reason);
    assert!(place.done(&args).contains(&reason));
    // One order is no choice, and no order asked for has no reason.
    let report = place.json(&[&ONE[..], &["--order", "2..2"]].concat());
    let reason = report["order_reason"].as_str().expect("a reason");
    assert!(
        reason.starts_with("chosen by MDL: order 2, the only one that can be fitted"),
        "{reason}"
    );
    assert!(place.json(&[&ONE[..], &["--order", "2"]].concat())["order_reason"].is_null());
}

#[test]
fn the_criteria_are_drawn() {
    let place = Place::new();
    place.write("one.csv", second_order_csv(500, 1));
    let args = [&ONE[..], &["--order", "1..5", "--plot", "orders.svg"]].concat();
    assert_eq!(place.json(&args)["plot"], "orders.svg");
    let chart = String::from_utf8(place.read("orders.svg")).expect("text");
    assert!(chart.starts_with("<svg xmlns=") && chart.ends_with("</svg>"));
    for text in ["Order 2 chosen by MDL", ">MDL<", ">AIC<", ">order 2<"] {
        assert!(chart.contains(text), "{text}");
    }
    // Two curves of five points; what stands before them is the legend.
    let (_, view) = chart.split_once("<g class=\"view\">").expect("the curves");
    let curves: Vec<&str> = view.split("<path ").skip(1).collect();
    assert_eq!(curves.len(), 2);
    for curve in curves {
        let (points, _) = curve.split_once("/>").expect("an end");
        assert_eq!(points.matches(['M', 'L']).count(), 5, "{points}");
    }
    let eiv = ["--method", "eiv", "--order", "1..3", "--plot", "orders.svg"];
    place.done(&[&ONE[..], &eiv].concat());
    let chart = String::from_utf8(place.read("orders.svg")).expect("text");
    assert!(
        chart.contains("chosen by the likelihood's BIC")
            || chart.contains("chosen by the likelihood&#39;s BIC")
    );
    for (tail, text) in [
        (
            &["--order", "2", "--plot", "orders.svg"][..],
            "--plot: expected orders to compare, --order auto or a range such as 1..12, found \
             --order 2",
        ),
        (
            &["--na", "2", "--nb", "2", "--plot", "orders.svg"],
            "--plot: expected orders to compare, --order auto or a range such as 1..12, found no \
             --order",
        ),
        (
            &["--order", "auto", "--plot", "orders.png"],
            "--plot: expected a file that ends in .svg, found orders.png",
        ),
    ] {
        place.refused_exactly(&[&ONE[..], tail].concat(), text);
    }
    let args = [&ONE[..], &["--order", "auto", "--plot", "none/orders.svg"]].concat();
    let text = "none/orders.svg: expected the folder none, found none";
    place.ends_badly(1, &mut place.command(&args), &[text]);
}

#[test]
fn the_order_of_a_canonical_model_counts_all_states() {
    let place = Place::new();
    place.write("two.csv", two_outputs_csv(2000, 1));
    let head = ["identify", "two.csv", "--inputs", "u*", "--outputs", "y*"];
    let report = place.json(&[&head[..], &["--order", "1..8"]].concat());
    // Two outputs need two states at least; two systems of second order have four.
    assert_eq!(orders(&report), (2..=8).collect::<Vec<u64>>());
    assert_eq!(
        report["structure"]["canonical"]["indices"],
        serde_json::json!([2, 2])
    );
}

#[test]
fn auto_looks_as_far_as_the_record_bears() {
    let place = Place::new();
    // Order n of one input and one output needs 3 n + 1 rows.
    place.write("one.csv", second_order_csv(28, 1));
    let ran = place.run(&[&ONE[..], &["--order", "auto", "--json"]].concat());
    let report = crate::place::object(&ran.stdout);
    assert_eq!(orders(&report), (1..=9).collect::<Vec<u64>>());
    let warning = "28 rows bear no order above 9: --order auto looked at 1..9";
    assert!(ran.stderr.contains(warning), "{}", ran.stderr);
    let warnings = array(&report, "/warnings").iter();
    assert!(warnings.filter(|text| *text == warning).count() == 1);
    // Who names the orders gets them or an error.
    place.refused(
        &[&ONE[..], &["--order", "1..12"]].concat(),
        &["one.csv: samples: expected at least 37", "found 28"],
    );
}
