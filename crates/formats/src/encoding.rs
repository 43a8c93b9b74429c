//! Bytes into text: UTF-8, with or without its mark, and UTF-16 where a mark announces it.

/// The text of a file, or why there is none.
pub(crate) fn decode(mut bytes: Vec<u8>) -> Result<String, String> {
    match bytes.get(..2) {
        Some([0xFF, 0xFE]) => return utf16(&bytes[2..], u16::from_le_bytes),
        Some([0xFE, 0xFF]) => return utf16(&bytes[2..], u16::from_be_bytes),
        _ => {}
    }
    if bytes.starts_with(b"\xEF\xBB\xBF") {
        bytes.drain(..3);
    }
    if bytes.starts_with(b"\x1F\x8B") {
        return Err("it is compressed by gzip; unpack it first".to_owned());
    }
    String::from_utf8(bytes).map_err(|error| {
        let bad = error.utf8_error().valid_up_to();
        let bytes = error.as_bytes();
        let line = bytes[..bad].iter().filter(|&&b| b == b'\n').count() + 1;
        let byte = bytes[bad];
        if bytes.contains(&0) {
            return "it is no text".to_owned();
        }
        format!("it is not UTF-8: byte 0x{byte:02X} in line {line}, as Latin-1 or Windows files have them; save it as UTF-8")
    })
}

fn utf16(bytes: &[u8], unit: impl Fn([u8; 2]) -> u16) -> Result<String, String> {
    let units = bytes.chunks_exact(2).map(|pair| unit([pair[0], pair[1]]));
    let text: Result<String, _> = char::decode_utf16(units).collect();
    match text {
        Ok(text) if bytes.len().is_multiple_of(2) => Ok(text),
        _ => Err("it begins as UTF-16 and is not; save it as UTF-8".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::decode;

    #[test]
    fn marks_and_strangers() {
        assert_eq!(decode(b"\xEF\xBB\xBF<a/>".to_vec()).unwrap(), "<a/>");
        let le: Vec<u8> = [0xFEFFu16].into_iter().chain("<ä/>".encode_utf16()).flat_map(u16::to_le_bytes).collect();
        let be: Vec<u8> = [0xFEFFu16].into_iter().chain("<ä/>".encode_utf16()).flat_map(u16::to_be_bytes).collect();
        assert_eq!(decode(le.clone()).unwrap(), "<ä/>");
        assert_eq!(decode(be).unwrap(), "<ä/>");
        assert!(decode(le[..le.len() - 1].to_vec()).unwrap_err().contains("UTF-16"));
        let latin = decode(b"<a>\n<b n='gr\xFC\xDF'/>".to_vec()).unwrap_err();
        assert!(latin.contains("byte 0xFC in line 2"), "{latin}");
        assert!(decode(b"\x1F\x8B\x08".to_vec()).unwrap_err().contains("gzip"));
        assert_eq!(decode(b"\x7FELF\x00\xFF".to_vec()).unwrap_err(), "it is no text");
    }
}
