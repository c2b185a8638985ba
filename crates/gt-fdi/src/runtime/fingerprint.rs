//! A number that tells two banks apart.

/// The 64-bit FNV-1a hash of what makes a detector (Fowler, Noll and Vo), which is no protection
/// against intent.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fingerprint(u64);

impl Fingerprint {
    const BASIS: u64 = 0xcbf2_9ce4_8422_2325;
    const PRIME: u64 = 0x0100_0000_01b3;

    pub(crate) fn new() -> Self {
        Self(Self::BASIS)
    }

    /// Takes eight bytes.
    pub(crate) fn add(&mut self, word: u64) {
        self.add_bytes(&word.to_le_bytes());
    }

    /// Takes a text with its end.
    pub(crate) fn add_text(&mut self, text: &str) {
        self.add_bytes(text.as_bytes());
        self.add_bytes(&[0xff]);
    }

    fn add_bytes(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(Self::PRIME);
        }
    }

    pub(crate) fn value(self) -> u64 {
        self.0
    }
}
