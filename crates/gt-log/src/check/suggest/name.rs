//! What a tag's name says of its role.

use super::Role;

/// Words of what is set: manipulated variables, set points, controller outputs, actuators.
const SET: &[&str] = &[
    "u",
    "mv",
    "xmv",
    "op",
    "sp",
    "setpoint",
    "ref",
    "reference",
    "cmd",
    "command",
    "demand",
    "valve",
    "vlv",
    "fcv",
    "lcv",
    "pcv",
    "tcv",
    "input",
];
/// Words of what is measured.
const MEASURED: &[&str] = &[
    "y", "pv", "meas", "xmeas", "measured", "output", "fi", "li", "pi", "ti", "ft", "lt", "pt",
    "tt",
];

/// The role that a name tells, and the word of it; none where two words disagree.
pub(super) fn hint(name: &str) -> Option<(Role, String)> {
    let mut found: Option<(Role, String)> = None;
    for word in words(name) {
        let role = if SET.contains(&word.as_str()) {
            Role::Input
        } else if MEASURED.contains(&word.as_str()) {
            Role::Output
        } else {
            continue;
        };
        match &found {
            Some((before, _)) if *before != role => return None,
            Some(_) => {}
            None => found = Some((role, word)),
        }
    }
    found
}

/// The words of a name in small letters: what stands between digits, signs and humps.
fn words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut was_small = false;
    for letter in name.chars() {
        let begins = letter.is_uppercase() && was_small;
        was_small = letter.is_lowercase();
        if begins || !letter.is_alphabetic() {
            words.push(String::new());
        }
        if let Some(word) = words.last_mut().filter(|_| letter.is_alphabetic()) {
            word.extend(letter.to_lowercase());
        }
    }
    words.retain(|word| !word.is_empty());
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_historians_tell_roles() {
        let role = |name: &str| hint(name).map(|(role, word)| (role, word.clone()));
        for (name, word) in [
            ("xmv11", "xmv"),
            ("u1", "u"),
            ("TIC-101.OP", "op"),
            ("fuelValve", "valve"),
            ("w_ref", "ref"),
            ("PCV204", "pcv"),
        ] {
            assert_eq!(role(name), Some((Role::Input, word.to_owned())), "{name}");
        }
        for (name, word) in [("xmeas23", "xmeas"), ("TIC-101.PV", "pv"), ("TI4711", "ti")] {
            assert_eq!(role(name), Some((Role::Output, word.to_owned())), "{name}");
        }
        for name in ["flow", "reflux", "P_t", "valve_meas", "", "42"] {
            assert_eq!(role(name), None, "{name}");
        }
    }
}
