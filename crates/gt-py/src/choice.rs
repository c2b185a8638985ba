//! Options that are given by name.

use crate::error::Failure;

/// The value that `given` names; `values` are all there are.
pub fn named<T: Copy>(
    option: &'static str,
    given: &str,
    values: &[(&str, T)],
) -> Result<T, Failure> {
    let found = values.iter().find(|(name, _)| *name == given);
    found.map(|(_, value)| *value).ok_or_else(|| {
        let names: Vec<&str> = values.iter().map(|(name, _)| *name).collect();
        let expected = match names.split_last() {
            Some((last, first)) if !first.is_empty() => format!("{} or {last}", first.join(", ")),
            _ => names.concat(),
        };
        Failure::Option {
            option,
            expected,
            found: format!("{given:?}"),
        }
    })
}
