//! A slice read from the front, with an error instead of an end.

/// The unread rest of a file.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bytes<'a>(pub &'a [u8]);

/// Why a read failed: the file is over. Codecs turn it into their own error.
#[derive(Debug)]
pub(crate) struct Ended;

impl From<Ended> for String {
    fn from(_: Ended) -> String {
        "the file ends too soon".to_owned()
    }
}

impl<'a> Bytes<'a> {
    /// The next `n` bytes.
    pub fn take(&mut self, n: usize) -> Result<&'a [u8], Ended> {
        let (head, rest) = self.0.split_at_checked(n).ok_or(Ended)?;
        self.0 = rest;
        Ok(head)
    }

    /// The next `N` bytes.
    pub fn array<const N: usize>(&mut self) -> Result<[u8; N], Ended> {
        let (head, rest) = self.0.split_first_chunk::<N>().ok_or(Ended)?;
        self.0 = rest;
        Ok(*head)
    }

    /// The next byte.
    pub fn u8(&mut self) -> Result<u8, Ended> {
        self.array::<1>().map(|[b]| b)
    }

    /// Two bytes, low first.
    pub fn u16(&mut self) -> Result<u16, Ended> {
        self.array().map(u16::from_le_bytes)
    }

    /// Four bytes, low first.
    pub fn u32(&mut self) -> Result<u32, Ended> {
        self.array().map(u32::from_le_bytes)
    }

    /// Four bytes, low first, two's complement.
    pub fn i32(&mut self) -> Result<i32, Ended> {
        self.array().map(i32::from_le_bytes)
    }

    /// The text up to the next newline, which is eaten; of at most 4096 bytes.
    pub fn line(&mut self) -> Result<&'a [u8], Ended> {
        let end = self.0.iter().take(4096).position(|&b| b == b'\n').ok_or(Ended)?;
        let line = self.take(end)?;
        self.take(1)?;
        Ok(line)
    }
}
