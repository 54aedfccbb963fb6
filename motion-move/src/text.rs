//! Text of files and of messages.

use std::io::{self, ErrorKind, Read};

use motion_core::wire::print::is_hidden;

/// Escapes line ends and all other characters that [`is_hidden`] names, because files and their names may contain them.
pub(crate) fn one_line(message: &str) -> String {
    let escape = |char: char| match char {
        char if is_hidden(char) => char.escape_default().to_string(),
        char => char.to_string(),
    };
    message.chars().map(escape).collect()
}

/// Reads a whole text in UTF-8, or in UTF-16 with a byte order mark, as some programs of Windows write it.
pub(crate) fn read_text(mut input: impl Read) -> io::Result<String> {
    let mut bytes = Vec::new();
    input.read_to_end(&mut bytes)?;
    let unit: fn([u8; 2]) -> u16 = match bytes.get(..2) {
        Some([0xff, 0xfe]) => u16::from_le_bytes,
        Some([0xfe, 0xff]) => u16::from_be_bytes,
        _ => return String::from_utf8(bytes).map_err(|_| not_text("it is not text in UTF-8 or UTF-16")),
    };
    let pairs = bytes.chunks_exact(2);
    if !pairs.remainder().is_empty() {
        return Err(not_text("the UTF-16 text ends within a character"));
    }
    let units = pairs.filter_map(|pair| pair.try_into().ok()).map(unit);
    let text: Result<String, _> = char::decode_utf16(units).collect();
    text.map_err(|_| not_text("it is not text in UTF-8 or UTF-16"))
}

fn not_text(why: &str) -> io::Error {
    io::Error::new(ErrorKind::InvalidData, why)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_read_in_utf_8_and_in_utf_16_of_both_orders() {
        let text = "\u{feff}Pan 30° 🎥";
        let [low, high] =
            [u16::to_le_bytes, u16::to_be_bytes].map(|bytes| text.encode_utf16().flat_map(bytes).collect::<Vec<u8>>());
        for bytes in [text.as_bytes(), &low, &high] {
            assert_eq!(read_text(bytes).unwrap(), text);
        }
        for bytes in [&[0xff, 0xfe, 0x41][..], &[0xff, 0xfe, 0x00, 0xd8], &[0x80, 0x81]] {
            assert_eq!(read_text(bytes).unwrap_err().kind(), ErrorKind::InvalidData);
        }
    }

    #[test]
    fn hidden_characters_are_escaped() {
        assert_eq!(one_line("a\nb\u{1b}é\u{85}\u{202e}"), "a\\nb\\u{1b}é\\u{85}\\u{202e}");
    }
}
