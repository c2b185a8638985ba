//! JSON files that are whole or not there.

use std::fs;

use gt_log::{LogError, read_json, write_atomically, write_json};
use serde::{Deserialize, Serialize};
use tempfile::tempdir;

#[derive(Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Model {
    order: usize,
    coefficients: Vec<f64>,
}

#[test]
fn doubles_return_to_the_bit() {
    let path = tempdir().unwrap().keep().join("model.json");
    let model = Model {
        order: 3,
        coefficients: vec![0.1, -0.0, 5e-324, f64::MAX, 1.0 / 3.0],
    };
    write_json(&path, &model).unwrap();
    let found: Model = read_json(&path).unwrap();
    let bits = |model: &Model| {
        model
            .coefficients
            .iter()
            .map(|c| c.to_bits())
            .collect::<Vec<_>>()
    };
    assert_eq!(bits(&found), bits(&model));
    assert!(fs::read_to_string(&path).unwrap().ends_with("}\n"));
    fs::remove_dir_all(path.parent().unwrap()).unwrap();
}

#[test]
fn errors_name_the_file_the_line_and_the_column() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("model.json");
    let said = |text: &str| {
        fs::write(&path, text).unwrap();
        let error = read_json::<Model>(&path).unwrap_err().to_string();
        error
            .strip_prefix(&format!("{}: ", path.display()))
            .unwrap()
            .to_owned()
    };
    assert_eq!(
        said("{\n  \"order\": \"two\"\n}"),
        "line 2, column 16: invalid type: string \"two\", expected usize"
    );
    assert_eq!(
        said("{\n  \"order\": 1,\n  \"colour\": 2\n}"),
        "line 3, column 10: unknown field `colour`, expected `order` or `coefficients`"
    );
    assert_eq!(
        said("{\"order\": 1"),
        "line 1, column 11: EOF while parsing an object"
    );
    assert!(matches!(
        read_json::<Model>(&folder.path().join("none.json")),
        Err(LogError::NotFound { .. })
    ));
    assert!(matches!(
        read_json::<Model>(folder.path()),
        Err(LogError::Directory { .. })
    ));
}

#[test]
fn a_file_is_replaced_whole() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.txt");
    write_atomically(&path, b"a long first text").unwrap();
    write_atomically(&path, b"short").unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"short");
    let names: Vec<_> = fs::read_dir(folder.path())
        .unwrap()
        .map(|e| e.unwrap().file_name())
        .collect();
    assert_eq!(names, ["a.txt"], "no .part is left");
}

#[test]
fn what_json_cannot_hold_leaves_the_old_file() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.json");
    write_json(&path, &1).unwrap();
    let keys_that_are_no_text = std::collections::BTreeMap::from([(vec![1], 2)]);
    assert!(matches!(
        write_json(&path, &keys_that_are_no_text),
        Err(LogError::NotJson { .. })
    ));
    assert_eq!(read_json::<i32>(&path).unwrap(), 1);
    assert!(matches!(
        write_json(folder.path(), &1),
        Err(LogError::Directory { .. })
    ));
}
