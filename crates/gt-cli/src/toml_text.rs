//! What is wrong with a TOML file, in words that help: with the nearest known key.

use std::collections::BTreeSet;

use schemars::Schema;
use serde_json::Value;

/// Most edits between a wrong key and one that is offered in its place, as a share of its letters.
const NEAR: f64 = 0.4;

/// The error of a parser, and where a key or a value is not known the nearest one that is: of those
/// that the parser names, else of all in the schema.
pub fn explained(error: &toml::de::Error, schema: &Schema) -> String {
    let text = error.to_string().trim_end().to_owned();
    let message = error.message();
    let (what, rest) = match message.strip_prefix("unknown field `") {
        Some(rest) => ("key", rest),
        None => match message.strip_prefix("unknown variant `") {
            Some(rest) => ("value", rest),
            None => return text,
        },
    };
    let Some((found, expected)) = rest.split_once('`') else {
        return text;
    };
    // Every second piece between the marks is a name.
    let named: BTreeSet<String> = expected
        .split('`')
        .skip(1)
        .step_by(2)
        .map(str::to_owned)
        .collect();
    let known = if named.is_empty() {
        keys(schema)
    } else {
        named
    };
    match nearest(found, &known) {
        Some(near) => format!("{text}\nnearest known {what}: `{near}`"),
        None => text,
    }
}

/// The name that is nearest to a wrong one, if any is near.
pub fn nearest<'a>(found: &str, known: &'a BTreeSet<String>) -> Option<&'a str> {
    let lower = |text: &str| text.to_lowercase().replace('_', "-");
    let wrong = lower(found);
    let distance = |name: &String| strsim::damerau_levenshtein(&wrong, &lower(name));
    let near = known.iter().min_by_key(|name| distance(name))?;
    // A word that is cut off, or goes on, is near however many letters that are.
    let is_part = |name: &&String| {
        let name = lower(name);
        wrong.len().min(name.len()) > 2 && (name.starts_with(&wrong) || wrong.starts_with(&name))
    };
    let is_near = distance(near) as f64 <= NEAR * found.chars().count() as f64;
    let near = is_near.then_some(near);
    near.or_else(|| known.iter().find(is_part))
        .map(String::as_str)
}

/// The names of all properties in a schema.
pub fn keys(schema: &Schema) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    collect(schema.as_value(), &mut found);
    found
}

fn collect(value: &Value, found: &mut BTreeSet<String>) {
    match value {
        Value::Object(map) => {
            if let Some(Value::Object(properties)) = map.get("properties") {
                found.extend(properties.keys().cloned());
            }
            map.values().for_each(|inner| collect(inner, found));
        }
        Value::Array(items) => items.iter().for_each(|inner| collect(inner, found)),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::nearest;

    #[test]
    fn a_near_name_is_offered_and_a_far_one_is_not() {
        let known = ["sample-time", "seed", "order"].map(str::to_owned).into();
        for (found, near) in [
            ("sample_time", Some("sample-time")),
            ("sed", Some("seed")),
            ("ORDER", Some("order")),
            ("ord", Some("order")),
            ("orderly-conduct", Some("order")),
            ("odrer", Some("order")),
            ("x", None),
            ("", None),
            ("colour", None),
        ] {
            assert_eq!(nearest(found, &known), near, "{found}");
        }
    }
}
