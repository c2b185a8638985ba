//! What is remembered, as a row of numbers.

/// Visits every number of a memory in a fixed order, to write it down or to read it back.
pub(crate) trait Recall {
    /// Passes each number, which `visit` may change.
    fn recall(&mut self, visit: &mut dyn FnMut(&mut f64));
}

/// Passes a slice.
pub(super) fn numbers(values: &mut [f64], visit: &mut dyn FnMut(&mut f64)) {
    for value in values {
        visit(value);
    }
}

/// Passes a count; one that comes back beyond `most` is `most`.
pub(super) fn count(value: &mut usize, most: usize, visit: &mut dyn FnMut(&mut f64)) {
    let mut number = *value as f64;
    visit(&mut number);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // saturates
    let back = number as usize;
    *value = back.min(most);
}

/// Passes a yes or no.
pub(super) fn flag(value: &mut bool, visit: &mut dyn FnMut(&mut f64)) {
    let mut number = f64::from(u8::from(*value));
    visit(&mut number);
    *value = number != 0.0;
}
