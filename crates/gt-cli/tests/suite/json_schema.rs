//! As much of JSON Schema (draft 2020-12) as the schemas of `gtfdi config schema` use. A keyword that
//! is not known here fails the test, so that nothing passes unseen.

use serde_json::Value;

/// Keywords that say nothing of what is valid.
const REMARKS: [&str; 7] = [
    "$schema",
    "$defs",
    "title",
    "description",
    "default",
    "format",
    "writeOnly",
];

/// What is wrong with a value, a line each with its place.
pub fn errors(schema: &Value, value: &Value) -> Vec<String> {
    let mut found = Vec::new();
    check(schema, schema, value, "", &mut found);
    found
}

fn check(root: &Value, schema: &Value, value: &Value, at: &str, found: &mut Vec<String>) {
    let rules = match schema {
        Value::Bool(true) => return,
        Value::Bool(false) => return found.push(format!("{at}: nothing may be here")),
        other => other.as_object().expect("a schema"),
    };
    for (keyword, rule) in rules
        .iter()
        .filter(|(key, _)| !REMARKS.contains(&key.as_str()))
    {
        let holds = match keyword.as_str() {
            "type" => match rule {
                Value::String(name) => is(name, value),
                names => names
                    .as_array()
                    .expect("types")
                    .iter()
                    .any(|name| is(text(name), value)),
            },
            "enum" => rule.as_array().expect("values").contains(value),
            "const" => rule == value,
            "$ref" => {
                let target = root
                    .pointer(text(rule).trim_start_matches('#'))
                    .expect("a target");
                check(root, target, value, at, found);
                true
            }
            "anyOf" => matching(root, rule, value) > 0,
            "oneOf" => matching(root, rule, value) == 1,
            "minimum" => value.as_f64().is_none_or(|own| own >= number(rule)),
            "maximum" => value.as_f64().is_none_or(|own| own <= number(rule)),
            "minItems" => value
                .as_array()
                .is_none_or(|own| own.len() as f64 >= number(rule)),
            "maxItems" => value
                .as_array()
                .is_none_or(|own| own.len() as f64 <= number(rule)),
            "required" => value.as_object().is_none_or(|own| {
                rule.as_array()
                    .expect("names")
                    .iter()
                    .all(|name| own.contains_key(text(name)))
            }),
            "items" => {
                let first = rules
                    .get("prefixItems")
                    .and_then(Value::as_array)
                    .map_or(0, Vec::len);
                for (k, item) in value
                    .as_array()
                    .into_iter()
                    .flatten()
                    .enumerate()
                    .skip(first)
                {
                    check(root, rule, item, &format!("{at}/{k}"), found);
                }
                true
            }
            "prefixItems" => {
                let rules = rule.as_array().expect("schemas");
                let items = value.as_array().into_iter().flatten();
                for (k, (rule, item)) in rules.iter().zip(items).enumerate() {
                    check(root, rule, item, &format!("{at}/{k}"), found);
                }
                true
            }
            "properties" => {
                for (name, rule) in rule.as_object().expect("properties") {
                    if let Some(inner) = value.get(name) {
                        check(root, rule, inner, &format!("{at}/{name}"), found);
                    }
                }
                true
            }
            "additionalProperties" | "unevaluatedProperties" => {
                for (name, inner) in value.as_object().into_iter().flatten() {
                    if rules
                        .get("properties")
                        .and_then(|own| own.get(name))
                        .is_none()
                    {
                        check(root, rule, inner, &format!("{at}/{name}"), found);
                    }
                }
                true
            }
            other => panic!("{at}: the keyword `{other}` is not known here"),
        };
        if !holds {
            found.push(format!("{at}: {keyword} {rule}: found {value}"));
        }
    }
}

fn matching(root: &Value, schemas: &Value, value: &Value) -> usize {
    let schemas = schemas.as_array().expect("schemas").iter();
    let holds = |schema: &&Value| {
        let mut found = Vec::new();
        check(root, schema, value, "", &mut found);
        found.is_empty()
    };
    schemas.filter(holds).count()
}

fn is(kind: &str, value: &Value) -> bool {
    match kind {
        "null" => value.is_null(),
        "boolean" => value.is_boolean(),
        "integer" => value.is_i64() || value.is_u64(),
        "number" => value.is_number(),
        "string" => value.is_string(),
        "array" => value.is_array(),
        "object" => value.is_object(),
        other => panic!("the type `{other}` is not known here"),
    }
}

fn text(value: &Value) -> &str {
    value.as_str().expect("text")
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

#[test]
fn what_breaks_a_rule_is_found() {
    let schema = serde_json::json!({
        "type": "object",
        "properties": {
            "n": {"type": ["integer", "null"], "minimum": 1},
            "kind": {"anyOf": [{"enum": ["a", "b"]}, {"$ref": "#/$defs/pair"}]}
        },
        "required": ["n"],
        "additionalProperties": false,
        "$defs": {"pair": {"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2}}
    });
    for (value, count) in [
        (serde_json::json!({"n": 1, "kind": "a"}), 0),
        (serde_json::json!({"n": null, "kind": [1.5, 2]}), 0),
        (serde_json::json!({"n": 0}), 1),
        (serde_json::json!({"kind": "b"}), 1),
        (serde_json::json!({"n": 1, "kind": [1.5]}), 1),
        (serde_json::json!({"n": 1, "kind": ["x", 2]}), 1),
        (serde_json::json!({"n": 1.5, "more": 1}), 2),
        (serde_json::json!([]), 1),
    ] {
        assert_eq!(errors(&schema, &value).len(), count, "{value}");
    }
}
