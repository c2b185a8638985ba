//! The option `--poles` of `gtfdi design`.

use std::path::Path;

use gt_campaign::paper;
use gtfdi::core::Signal;

use crate::failure::Failure;

/// The poles of one output's observer with `nx` states.
pub fn poles(wishes: &[String], output: &str, nx: usize) -> Result<Vec<f64>, Failure> {
    let number = |text: &str| {
        text.trim().parse::<f64>().map_err(|_| {
            Failure::input(format!(
                "--poles: expected a number or TAG=NUMBER, found `{text}`"
            ))
        })
    };
    let mut common = Vec::new();
    for wish in wishes {
        match wish.split_once('=') {
            Some((tag, value)) if tag.trim() == output => return Ok(vec![number(value)?; nx]),
            Some((_, value)) => drop(number(value)?),
            None => common.push(number(wish)?),
        }
    }
    match common.len() {
        0 => Ok(vec![paper::default_pole(output); nx]),
        1 => Ok(vec![common[0]; nx]),
        found if found == nx => Ok(common),
        found => Err(Failure::input(format!(
            "--poles: output `{output}` has {nx} states: expected 1 or {nx} poles, found {found}"
        ))),
    }
}

/// Refuses a pole for an output that the model has not.
pub fn check_tags(wishes: &[String], outputs: &[Signal], model: &Path) -> Result<(), Failure> {
    let names: Vec<&str> = outputs.iter().map(|output| output.name.as_str()).collect();
    let tags = wishes.iter().filter_map(|wish| wish.split_once('='));
    for tag in tags.map(|(tag, _)| tag.trim()) {
        if !names.contains(&tag) {
            return Err(Failure::input(format!(
                "--poles: expected an output of {} ({}), found `{tag}`",
                model.display(),
                names.join(", ")
            )));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::poles;

    #[test]
    fn poles_by_tag_win_over_common_ones() {
        let wishes = ["0.6".to_owned(), "t3=0.3".to_owned()];
        assert_eq!(poles(&wishes, "t3", 2).expect("by tag"), [0.3, 0.3]);
        assert_eq!(poles(&wishes, "p7", 2).expect("common"), [0.6, 0.6]);
        assert_eq!(poles(&[], "q_c", 1).expect("the paper's"), [0.7]);
        assert_eq!(poles(&[], "y", 2).expect("any tag's"), [0.5, 0.5]);
        let error = poles(&["0.1".into(), "0.2".into()], "y", 3).expect_err("two of three");
        assert_eq!(
            error.error().to_string(),
            "--poles: output `y` has 3 states: expected 1 or 3 poles, found 2"
        );
    }
}
