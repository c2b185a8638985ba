//! What a damaged file says that an id means, perhaps in several places and not the same in each.

/// More meanings of one id than these are not kept: a file that has them is no log.
const KEPT: usize = 8;

/// The meanings that were found, in the order of the file.
#[derive(Debug)]
pub(super) struct Claims<T>(Vec<Claim<T>>);

#[derive(Debug)]
struct Claim<T> {
    what: T,
    /// Whether a checksum says that it is as it was written.
    vouched: bool,
}

impl<T> Default for Claims<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T: PartialEq> Claims<T> {
    /// One more place that says what the id means.
    pub(super) fn add(&mut self, what: T, vouched: bool) {
        if let Some(known) = self.0.iter_mut().find(|own| own.what == what) {
            known.vouched |= vouched;
        } else if self.0.len() < KEPT || vouched && self.vouched().is_none() {
            self.0.push(Claim { what, vouched });
        }
    }

    /// The first meaning that a checksum vouches for.
    pub(super) fn vouched(&self) -> Option<&T> {
        let vouched = self.0.iter().find(|own| own.vouched);
        vouched.map(|own| &own.what)
    }

    /// The meanings in the order of the file.
    pub(super) fn all(&self) -> impl Iterator<Item = &T> {
        self.0.iter().map(|own| &own.what)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_vouched_meaning_is_kept_beside_any_number_of_others() {
        let mut claims = Claims::default();
        for meaning in 0..20 {
            claims.add(meaning, false);
        }
        assert_eq!(claims.vouched(), None);
        claims.add(100, true);
        claims.add(101, true);
        assert_eq!(claims.vouched(), Some(&100));
        assert_eq!(claims.all().count(), KEPT + 1);
    }

    #[test]
    fn a_meaning_that_is_repeated_under_a_checksum_is_vouched() {
        let mut claims = Claims::default();
        claims.add("a", false);
        claims.add("b", false);
        claims.add("b", true);
        assert_eq!(claims.vouched(), Some(&"b"));
        assert_eq!(claims.all().count(), 2);
    }
}
