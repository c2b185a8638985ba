//! Samples of some signals in memory.

/// Samples one after the other, of which each has so many numbers, of which the first few count.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rows<'a> {
    values: &'a [f64],
    stride: usize,
}

impl<'a> Rows<'a> {
    /// The first sample begins where `values` does; the next begin each `stride` numbers further on.
    pub(crate) fn new(values: &'a [f64], stride: usize) -> Self {
        Self { values, stride }
    }

    /// The samples from `sample` on.
    pub(super) fn from(self, sample: usize) -> Self {
        let values = self.values.get(sample * self.stride..).unwrap_or(&[]);
        Self { values, ..self }
    }

    /// The first `width` numbers of `sample`; none that are not there.
    pub(super) fn at(self, sample: usize, width: usize) -> &'a [f64] {
        let begin = sample * self.stride;
        self.values.get(begin..begin + width).unwrap_or(&[])
    }

    /// The first `WIDTH` numbers of each sample, until there are no more.
    #[inline(always)]
    pub(super) fn arrays<const WIDTH: usize>(self) -> impl Iterator<Item = &'a [f64; WIDTH]> {
        let mut left = self.values;
        core::iter::from_fn(move || {
            let row = left.first_chunk::<WIDTH>()?;
            left = left.get(self.stride..).unwrap_or(&[]);
            Some(row)
        })
    }
}
