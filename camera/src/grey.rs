//! Colour to grey.

/// Grey of a colour by BT.601, in OpenCV's fixed point: weights 0.299, 0.587, 0.114 scaled by 2^14, rounded to nearest.
pub(crate) fn bt601(red: u8, green: u8, blue: u8) -> u8 {
    let sum = u32::from(red) * 4899 + u32::from(green) * 9617 + u32::from(blue) * 1868 + 8192;
    // The weights add up to 2^14, so that 255 stays 255.
    (sum >> 14) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_channels_keep_their_value() {
        for value in 0..=255 {
            assert_eq!(bt601(value, value, value), value);
        }
    }

    #[test]
    fn pure_colours_have_their_published_weights() {
        assert_eq!([bt601(255, 0, 0), bt601(0, 255, 0), bt601(0, 0, 255)], [76, 150, 29]);
    }
}
