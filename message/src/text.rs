//! Short names in fixed fields: UTF-8, filled up with zero bytes.

use std::fmt;

/// Writes `text` into a field and fills the rest with zeros.
pub fn write(field: &mut [u8], text: &str) -> Result<(), TextTooLong> {
    if text.len() > field.len() {
        return Err(TextTooLong { text: text.to_owned(), limit: field.len() });
    }
    field.fill(0);
    field[..text.len()].copy_from_slice(text.as_bytes());
    Ok(())
}

/// As [`write()`], but a text that is too long loses its end, at a character's boundary.
pub fn write_cut(field: &mut [u8], text: &str) {
    let mut end = text.len().min(field.len());
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    field.fill(0);
    field[..end].copy_from_slice(&text.as_bytes()[..end]);
}

/// The text of a field: up to its first zero byte. `None` when the bytes are not UTF-8.
#[must_use]
pub fn read(field: &[u8]) -> Option<&str> {
    let end = field.iter().position(|&byte| byte == 0).unwrap_or(field.len());
    std::str::from_utf8(&field[..end]).ok()
}

/// A text does not fit its field.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TextTooLong {
    /// The text.
    pub text: String,
    /// Bytes that the field has.
    pub limit: usize,
}

impl fmt::Display for TextTooLong {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { text, limit } = self;
        write!(
            f,
            "the name \"{text}\" takes {} bytes but a message has room for {limit}: shorten it",
            text.len()
        )
    }
}

impl std::error::Error for TextTooLong {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_written_is_read() {
        let mut field = [7; 8];
        for text in ["", "a", "12345678"] {
            write(&mut field, text).unwrap();
            assert_eq!(read(&field), Some(text));
        }
    }

    #[test]
    fn a_long_text_is_refused_with_its_length() {
        let error = write(&mut [0; 4], "abcde").unwrap_err().to_string();
        assert!(error.contains("5 bytes") && error.contains("room for 4"), "{error}");
    }

    #[test]
    fn cutting_keeps_whole_characters() {
        let mut field = [0; 4];
        write_cut(&mut field, "abcé");
        assert_eq!(read(&field), Some("abc"));
    }

    #[test]
    fn bytes_that_are_no_text_are_none() {
        assert_eq!(read(&[0xff, 0]), None);
    }
}
