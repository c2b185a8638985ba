//! `--report` of identify and detect: a page that needs nothing else, and figures beside it.

use serde_json::Value;

use crate::place::{Place, array, number};
use crate::signal::{Noise, csv, second_order_csv};

const IDENTIFY: [&str; 6] = ["identify", "one.csv", "--inputs", "u", "--outputs", "y"];

/// The numbers behind the charts of a page, by their titles' order.
pub fn points(html: &str) -> Vec<Value> {
    let parts = html.split("<script type=\"application/json\">").skip(1);
    parts
        .map(|part| {
            let end = part.find("</script>").expect("the element's end");
            serde_json::from_str(&part[..end]).expect("JSON")
        })
        .collect()
}

/// The chart whose first curve has a label.
pub fn chart<'a>(points: &'a [Value], label: &str) -> &'a Value {
    let mut found = points
        .iter()
        .filter(|own| own["curves"][0]["label"] == label);
    found.next().unwrap_or_else(|| panic!("no chart `{label}`"))
}

/// The curve of a label in any chart.
fn curve<'a>(points: &'a [Value], label: &str) -> &'a Value {
    let curves = points.iter().flat_map(|own| array(own, "/curves"));
    let mut found = curves.filter(|curve| curve["label"] == label);
    found.next().unwrap_or_else(|| panic!("no curve `{label}`"))
}

/// Reads a report and checks what holds of all: nothing is fetched, every chart has its files.
pub fn page(place: &Place, folder: &str) -> String {
    let html = String::from_utf8(place.read(&format!("{folder}/index.html"))).expect("UTF-8");
    let own = html.replace("http://www.w3.org/2000/svg", "");
    for outside in ["http://", "https://", "src=", "url(http", "@import"] {
        assert!(!own.contains(outside), "{outside} leaves the page");
    }
    let figures = html.matches("<figure id=\"figure_").count();
    assert_eq!(points(&html).len(), figures, "a chart without numbers");
    for part in html.split("<figure id=\"figure_").skip(1) {
        let id = part.split('"').next().expect("an id");
        for extension in ["svg", "csv"] {
            let name = format!("figures/{id}.{extension}");
            assert!(html.contains(&format!("href=\"{name}\"")), "{name}");
            let file = place.read(&format!("{folder}/{name}"));
            assert!(!file.is_empty(), "{name}");
        }
    }
    let files = std::fs::read_dir(place.path(&format!("{folder}/figures"))).expect("figures");
    assert_eq!(files.count(), 2 * figures, "files that no chart is of");
    html
}

/// A column of a figure's CSV.
fn column(place: &Place, file: &str, head: &str) -> Vec<Option<f64>> {
    let text = String::from_utf8(place.read(file)).expect("UTF-8");
    let mut lines = text.lines();
    let heads: Vec<&str> = lines.next().expect("a head").split(',').collect();
    let place = heads.iter().position(|own| *own == head);
    let place = place.unwrap_or_else(|| panic!("no column `{head}` in {heads:?}"));
    lines
        .map(|line| line.split(',').nth(place).and_then(|own| own.parse().ok()))
        .collect()
}

#[test]
fn a_model_is_shown_with_its_errors() {
    let place = Place::new();
    place.write("one.csv", second_order_csv(500, 1));
    let args = [&IDENTIFY[..], &["--order", "1..4", "--report", "out/model"]].concat();
    let report = place.json(&args);
    assert_eq!(report["report"], "out/model");
    let html = page(&place, "out/model");
    let fit = number(&report, "/outputs/0/fit_prediction_percent");
    assert!(html.contains(&format!("<td>{fit:.2}</td>")), "{fit}");
    assert!(html.contains(report["order_reason"].as_str().expect("a reason")));
    assert!(html.contains(report["input_sha256"].as_str().expect("a digest")));
    assert!(html.contains("order = &quot;1..4&quot;"), "the options");
    // What is drawn as measured is the record, and what is predicted comes that much closer to it
    // than its mean.
    let behaviour = "out/model/figures/behaviour_01_y.csv";
    let (measured, predicted) = (
        column(&place, behaviour, "measured"),
        column(&place, behaviour, "one step ahead"),
    );
    let record: Vec<f64> = second_order_csv(500, 1)
        .lines()
        .skip(1)
        .map(|line| {
            line.split(',')
                .nth(1)
                .expect("y")
                .parse()
                .expect("a number")
        })
        .collect();
    assert_eq!(measured.len(), record.len());
    assert!(measured.iter().zip(&record).all(|(a, b)| *a == Some(*b)));
    // The first samples are the past of the first prediction.
    let given = predicted.iter().take_while(|own| own.is_none()).count();
    assert_eq!(given, 2);
    let pairs: Vec<(f64, f64)> = record
        .iter()
        .zip(&predicted)
        .filter_map(|(y, predicted)| Some((*y, (*predicted)?)))
        .collect();
    let mean = pairs.iter().map(|(y, _)| y).sum::<f64>() / pairs.len() as f64;
    let square = |of: fn(&(f64, f64), f64) -> f64| -> f64 {
        pairs.iter().map(|pair| of(pair, mean).powi(2)).sum()
    };
    let share = (square(|(y, own), _| y - own) / square(|(y, _), mean| y - mean)).sqrt();
    // The CSV has all digits, so that the fit of the table comes out of it but for rounding.
    assert!((100.0 * (1.0 - share) - fit).abs() < 1e-9, "{share} {fit}");
    let points = points(&html);
    assert_eq!(array(curve(&points, "poles"), "/x").len(), 2);
    assert!(curve(&points, "gain")["band"].is_array(), "no band");
    let orders = curve(&points, "MDL");
    assert_eq!(orders["x"]["count"], 4, "{orders}");
}

#[test]
fn a_model_without_a_covariance_has_no_bands() {
    let place = Place::new();
    place.write("one.csv", second_order_csv(800, 1));
    let method = ["--method", "eiv", "--order", "2", "--report", "out"];
    place.done(&[&IDENTIFY[..], &method].concat());
    let html = page(&place, "out");
    assert!(html.contains("Noise on the channels"));
    assert!(html.contains("no covariance of the coefficients"));
    assert!(curve(&points(&html), "gain")["band"].is_null());
}

/// Two outputs of which one is shifted from row 600 on, under names that no file system likes.
fn shifted(rows: usize, shift: f64) -> String {
    let mut source = Noise::new(5);
    let mut x = 0.0;
    let rows: Vec<Vec<f64>> = (0..rows)
        .map(|t| {
            let u = source.next();
            x = 0.9 * x + u;
            let step = if t >= 600 { shift } else { 0.0 };
            let noise = 0.1 * source.next();
            vec![u, x + noise + step, 0.5 * x + 0.1 * source.next()]
        })
        .collect();
    csv("u,../a </script>,b", &rows)
}

#[test]
fn a_detection_is_shown_with_its_alarms() {
    let place = Place::new();
    place.write("healthy.csv", shifted(3000, 0.0));
    place.write("faulty.csv", shifted(1200, 3.0));
    let names = ["--inputs", "u", "--outputs", "../a </script>,b"];
    let identify = [
        "identify",
        "healthy.csv",
        "--order",
        "1",
        "--structure",
        "diag",
    ];
    let out = ["--sample-time", "0.5", "--out", "model.json"];
    place.done(&[&identify[..], &names, &out].concat());
    let design = [
        "design",
        "--model",
        "model.json",
        "--healthy",
        "healthy.csv",
    ];
    let cusum = [
        "--generator",
        "observer",
        "--margin",
        "1.2",
        "--out",
        "bank.json",
    ];
    let time = ["--sample-time", "0.5"];
    place.done(&[&design[..], &cusum, &time].concat());
    let detect = [
        "detect",
        "faulty.csv",
        "--bank",
        "bank.json",
        "--report",
        "out",
    ];
    let report = place.json(&[&detect[..], &time].concat());
    let html = page(&place, "out");
    assert!(html.contains("../a &lt;/script&gt;"), "escaped");
    let alarms = array(&report, "/alarms");
    assert!(!alarms.is_empty());
    let points = points(&html);
    let residual = chart(&points, "residual of ../a </script>");
    let marked: Vec<f64> = array(residual, "/marks")
        .iter()
        .filter(|mark| mark[1].as_str().is_some_and(|own| own.starts_with("alarm")))
        .map(|mark| mark[0].as_f64().expect("a time"))
        .collect();
    let times: Vec<f64> = alarms
        .iter()
        .filter(|alarm| alarm["tag"] == "../a </script>")
        .map(|alarm| number(alarm, "/time_s"))
        .collect();
    assert!(!times.is_empty() && marked == times, "{marked:?} {times:?}");
    let limit = number(&report, "/outputs/0/threshold");
    assert_eq!(residual["limits"], serde_json::json!([-limit, limit]));
    let time = format!("<td>{:.2}</td>", number(&alarms[0], "/time_s"));
    assert!(html.contains(&time), "{time}");
}

#[test]
fn a_report_that_cannot_be_written_is_refused_before_any_work() {
    let place = Place::new();
    place.write("one.csv", second_order_csv(200, 1));
    place.write("file", "");
    for (folder, text) in [
        ("file", "file: expected a folder, found a file"),
        ("file/below", "file: expected a folder, found a file"),
    ] {
        let args = [&IDENTIFY[..], &["--order", "2", "--report", folder]].concat();
        place.ends_badly(1, &mut place.command(&args), &[text]);
    }
}
