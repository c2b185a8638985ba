//! Whether the lists of a Parquet file can be as long as they say.
//!
//! What a file says of itself and of its pages is in Thrift's compact protocol. A list says how many
//! elements it has, and the reader goes through those of a field that it does not know one by one, even
//! where the elements are truth values, for which it reads nothing: a few bytes would keep it busy for
//! hours. Such lists are refused here before it sees them.

/// No file of the format nests deeper.
const DEPTH: usize = 32;
/// Where a page's header has the size of what follows.
const COMPRESSED_PAGE_SIZE: u64 = 3;

/// Kinds of values, as the protocol numbers them.
const TRUE: u8 = 1;
const FALSE: u8 = 2;
const I32: u8 = 5;

/// Looks at what a file says of itself.
///
/// # Errors
/// A list that is too long, in words. Whatever else is wrong is left to the reader.
pub(super) fn check_footer(file: &[u8]) -> Result<(), String> {
    let Some((body, [length @ .., _, _, _, _])) = file.split_last_chunk::<8>() else {
        return Ok(());
    };
    let length = u32::from_le_bytes(*length);
    let length = usize::try_from(length).unwrap_or(usize::MAX);
    let Some(begin) = body.len().checked_sub(length) else {
        return Ok(());
    };
    match (Walk {
        rest: &body[begin..],
    })
    .skip_struct(DEPTH)
    {
        Err(Stop::Refused(cause)) => Err(cause),
        Ok(_) | Err(Stop::Broken) => Ok(()),
    }
}

/// Looks at the headers of the pages of a column.
///
/// # Errors
/// As [`check_footer`].
pub(super) fn check_pages(mut pages: &[u8]) -> Result<(), String> {
    while !pages.is_empty() {
        let mut walk = Walk { rest: pages };
        let size = match walk.skip_struct(DEPTH) {
            Ok(size) => size.and_then(|size| usize::try_from(size).ok()),
            Err(Stop::Broken) => None,
            Err(Stop::Refused(cause)) => return Err(cause),
        };
        let Some(next) = size.and_then(|size| walk.rest.get(size..)) else {
            return Ok(());
        };
        pages = next;
    }
    Ok(())
}

/// Why a walk ends early.
enum Stop {
    /// At something that is no value of the protocol, or at the end.
    Broken,
    /// At a list that is too long.
    Refused(String),
}

/// A walk over values, which moves by a byte at least with each.
struct Walk<'a> {
    rest: &'a [u8],
}

impl Walk<'_> {
    fn skip_bytes(&mut self, count: u64) -> Result<(), Stop> {
        let count = usize::try_from(count).map_err(|_| Stop::Broken)?;
        self.rest = self.rest.get(count..).ok_or(Stop::Broken)?;
        Ok(())
    }

    fn byte(&mut self) -> Result<u8, Stop> {
        let (byte, rest) = self.rest.split_first().ok_or(Stop::Broken)?;
        self.rest = rest;
        Ok(*byte)
    }

    fn varint(&mut self) -> Result<u64, Stop> {
        let mut value = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            value |= u64::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Ok(value);
            }
        }
        Err(Stop::Broken)
    }

    /// Passes over a value.
    fn skip(&mut self, kind: u8, depth: usize) -> Result<(), Stop> {
        match kind {
            TRUE | FALSE => Ok(()),
            3 => self.skip_bytes(1),
            4..=6 => self.varint().map(drop),
            7 => self.skip_bytes(8),
            8 => {
                let length = self.varint()?;
                self.skip_bytes(length)
            }
            9 | 10 => {
                let head = self.byte()?;
                let size = match head >> 4 {
                    15 => self.varint()?,
                    size => u64::from(size),
                };
                self.elements(size, &[head & 0xf], depth)
            }
            11 => {
                let size = self.varint()?;
                if size == 0 {
                    return Ok(());
                }
                let kinds = self.byte()?;
                self.elements(size, &[kinds >> 4, kinds & 0xf], depth)
            }
            12 => self.skip_struct(depth).map(drop),
            13 => self.skip_bytes(16),
            _ => Err(Stop::Broken),
        }
    }

    /// Passes over the elements of a list or a map.
    fn elements(&mut self, size: u64, kinds: &[u8], depth: usize) -> Result<(), Stop> {
        let depth = depth.checked_sub(1).ok_or(Stop::Broken)?;
        let found = self.rest.len();
        // Lists of truth values are in none of the structures that are read.
        if size > 0 && kinds.iter().any(|kind| matches!(*kind, TRUE | FALSE)) {
            return Err(Stop::Refused(format!(
                "a list of {size} truth values where the format has none"
            )));
        }
        if size > found as u64 {
            return Err(Stop::Refused(format!(
                "a list of {size} elements in {found} bytes"
            )));
        }
        for _ in 0..size {
            for kind in kinds {
                self.skip(*kind, depth)?;
            }
        }
        Ok(())
    }

    /// Passes over a structure; what a page's header gives as the size of the page.
    fn skip_struct(&mut self, depth: usize) -> Result<Option<u64>, Stop> {
        let depth = depth.checked_sub(1).ok_or(Stop::Broken)?;
        let (mut field, mut size) = (0_u64, None);
        loop {
            let head = self.byte()?;
            let kind = head & 0xf;
            if kind == 0 {
                return Ok(size);
            }
            field = match head >> 4 {
                0 => from_zigzag(self.varint()?),
                step => field + u64::from(step),
            };
            if (field, kind) == (COMPRESSED_PAGE_SIZE, I32) {
                size = Some(from_zigzag(self.varint()?));
            } else {
                self.skip(kind, depth)?;
            }
        }
    }
}

/// A number whose sign is in its last bit, as nothing that is ever asked for where it is negative.
fn from_zigzag(value: u64) -> u64 {
    if value & 1 == 0 {
        value >> 1
    } else {
        u64::MAX >> 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file whose footer is this.
    fn file(footer: &[u8]) -> Vec<u8> {
        let length = u32::try_from(footer.len()).unwrap();
        [b"PAR1", footer, &length.to_le_bytes(), b"PAR1"].concat()
    }

    /// The largest number of the protocol's lists.
    const MOST: [u8; 5] = [0xff, 0xff, 0xff, 0xff, 0x07];

    #[test]
    fn lists_longer_than_their_bytes_are_refused() {
        // Field 15, a list of so many elements of a kind.
        let list = |kind: u8| [&[0xf9, 0xf0 | kind][..], &MOST, &[0]].concat();
        let refused = check_footer(&file(&list(TRUE)));
        assert_eq!(
            refused.unwrap_err(),
            "a list of 2147483647 truth values where the format has none"
        );
        for kind in [3, 5, 8, 9, 12] {
            assert_eq!(
                check_footer(&file(&list(kind))).unwrap_err(),
                "a list of 2147483647 elements in 1 bytes"
            );
        }
        // A map, and a list within a structure within a list.
        let map = [&[0xfb][..], &MOST, &[0x51, 0]].concat();
        assert!(
            check_footer(&file(&map))
                .unwrap_err()
                .contains("truth values")
        );
        let nested = [&[0xf9, 0x1c][..], &list(TRUE), &[0]].concat();
        assert!(check_footer(&file(&nested)).is_err());
    }

    #[test]
    fn what_is_broken_otherwise_is_left_to_the_reader() {
        for footer in [
            &b""[..],
            &[0],
            &[0x15],
            &[0x15, 0x80],
            &[0xff],
            &[0x18, 0x25, 2],
        ] {
            assert_eq!(check_footer(&file(footer)), Ok(()), "{footer:?}");
        }
        assert_eq!(check_footer(b"PAR1"), Ok(()));
        assert_eq!(check_footer(&[0xff; 20]), Ok(()));
        let deep = vec![0x1c; 100_000];
        assert_eq!(check_footer(&file(&deep)), Ok(()));
    }

    #[test]
    fn every_page_of_a_column_is_looked_at() {
        // The kind of page 0, 3 bytes unpacked, 3 packed; then the bytes.
        let page = [0x15, 0, 0x15, 6, 0x15, 6, 0, 1, 2, 3];
        let bad = [&[0x15, 0, 0xf9, 0xf1][..], &MOST, &[0]].concat();
        assert_eq!(check_pages(&[page, page].concat()), Ok(()));
        assert!(check_pages(&[&page[..], &page, &bad].concat()).is_err());
    }
}
