//! The option `--poles` of `gtfdi design`.

use std::path::Path;

use gt_campaign::paper;
use gtfdi::core::Signal;
use nalgebra::Complex;

use crate::failure::Failure;

/// The poles of one output's observer with `nx` states.
pub fn poles(wishes: &[String], output: &str, nx: usize) -> Result<Vec<Complex<f64>>, Failure> {
    let (mut own, mut common) = (Vec::new(), Vec::new());
    for wish in wishes {
        match wish.split_once('=') {
            Some((tag, value)) if tag.trim() == output => own.push(number(value)?),
            Some((_, value)) => drop(number(value)?),
            None => common.push(number(wish)?),
        }
    }
    let wished = if own.is_empty() { common } else { own };
    match wished.len() {
        0 => Ok(vec![Complex::from(paper::default_pole(output)); nx]),
        1 => Ok(vec![wished[0]; nx]),
        found if found == nx => Ok(wished),
        found => Err(Failure::input(format!(
            "--poles: output `{output}` has {nx} states: expected 1 or {nx} poles, found {found}"
        ))),
    }
}

/// A real number, or a complex one such as `0.9+0.1i`.
fn number(text: &str) -> Result<Complex<f64>, Failure> {
    let text = text.trim();
    let real = text.parse::<f64>().map(Complex::from);
    real.or_else(|_| text.parse()).map_err(|_| {
        Failure::input(format!(
            "--poles: expected a number such as 0.7 or 0.9+0.1i, or TAG=NUMBER, found `{text}`"
        ))
    })
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
    use super::{Complex, poles};

    /// Real and imaginary parts of the poles that `wishes` give an output.
    fn found(wishes: &[&str], output: &str, nx: usize) -> Vec<(f64, f64)> {
        let wishes: Vec<String> = wishes.iter().map(|&wish| wish.to_owned()).collect();
        let poles = poles(&wishes, output, nx).expect("poles");
        poles.iter().map(|&Complex { re, im }| (re, im)).collect()
    }

    #[test]
    fn poles_by_tag_win_over_common_ones() {
        let wishes = ["0.6", "t3=0.3"];
        assert_eq!(found(&wishes, "t3", 2), [(0.3, 0.0); 2]);
        assert_eq!(found(&wishes, "p7", 2), [(0.6, 0.0); 2]);
        assert_eq!(found(&[], "q_c", 1), [(0.7, 0.0)]);
        assert_eq!(found(&[], "y", 2), [(0.5, 0.0); 2]);
        let error = poles(&["0.1".into(), "0.2".into()], "y", 3).expect_err("two of three");
        assert_eq!(
            error.error().to_string(),
            "--poles: output `y` has 3 states: expected 1 or 3 poles, found 2"
        );
    }

    #[test]
    fn poles_may_be_complex_and_one_a_state_of_a_tag() {
        let pair = [(0.9, 0.1), (0.9, -0.1)];
        assert_eq!(found(&["0.9+0.1i", " 0.9-0.1i"], "y", 2), pair);
        assert_eq!(found(&["t3=0.9+0.1j", "t3=0.9-0.1j", "0.5"], "t3", 2), pair);
        assert_eq!(found(&["-1e-2i", "0.2", "1e-2i"], "y", 3)[0], (0.0, -0.01));
        for bad in ["0.9+i0.1x", "0.9+0.1", "i=", ""] {
            assert!(poles(&[bad.to_owned()], "y", 1).is_err(), "{bad} accepted");
        }
    }
}
