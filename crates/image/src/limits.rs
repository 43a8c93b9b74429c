//! The sizes that are let pass, tested before a byte is allocated: a header of a few bytes can ask for terabytes.

use crate::error::ErrorKind;

/// The longest side of a picture in pixels.
pub const MAX_SIDE: u64 = 1 << 18;

/// The most numbers (pixels times channels) in a picture: 4 GiB of f32.
pub const MAX_SAMPLES: u64 = 1 << 30;

/// What deflate, the densest of the codecs used in pictures, can at best make of one byte [Deutsch 1996, §3.2.5:
/// 258 bytes from two bits] is 1032; run lengths stacked upon it in EXR are held to twice that.
pub(crate) const DENSEST: u64 = 2064;

/// The number of samples of a picture, or the refusal with its figures. A side of zero is a mismatch.
pub fn samples(width: u64, height: u64, channels: u64) -> Result<usize, ErrorKind> {
    if width == 0 || height == 0 || channels == 0 {
        return Err(ErrorKind::Mismatch(format!("a picture of {width} x {height} pixels with {channels} channels holds nothing")));
    }
    let total = width.saturating_mul(height).saturating_mul(channels);
    if width > MAX_SIDE || height > MAX_SIDE || total > MAX_SAMPLES {
        return Err(ErrorKind::TooLarge { width, height, channels });
    }
    usize::try_from(total).map_err(|_| ErrorKind::TooLarge { width, height, channels })
}

/// Memory for `n` samples, or the refusal where the machine has none.
pub(crate) fn zeros(width: usize, height: usize, channels: usize) -> Result<Vec<f32>, ErrorKind> {
    let (w, h, c) = (width as u64, height as u64, channels as u64);
    let n = samples(w, h, c)?;
    let mut data = Vec::new();
    data.try_reserve_exact(n).map_err(|_| ErrorKind::TooLarge { width: w, height: h, channels: c })?;
    data.resize(n, 0.0);
    Ok(data)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn absurd_sizes_are_refused() {
        assert_eq!(samples(3, 5, 4).unwrap(), 60);
        for (w, h, c) in
            [(0, 1, 3), (1, 0, 3), (1, 1, 0), (2_147_483_300, 1, 1), (1 << 18, 1 << 18, 3), (u64::MAX, u64::MAX, u64::MAX)]
        {
            assert!(samples(w, h, c).is_err(), "{w} x {h} x {c}");
        }
    }
}
