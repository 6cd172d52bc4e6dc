//! A frame's number in the frame itself, so that what is seen is known however many frames are lost, and when it was shown
//! however late a stamp is.
//!
//! ```text
//! top-left corner: 16 squares of 8x8 pixels side by side, white for 1: eight bits, then their complement
//! ```

/// Pixels along a square.
const SQUARE: usize = 8;
/// Bits of a number.
const BITS: usize = 8;
/// Columns and rows that the number takes.
pub const AREA: (usize, usize) = (2 * BITS * SQUARE, SQUARE);

const WHITE: u8 = 235;
const BLACK: u8 = 16;

/// Writes a number into rows of `width` bytes, at least [`AREA`] of them.
///
/// # Panics
/// When there are fewer.
pub fn write(luma: &mut [u8], width: usize, number: u8) {
    for y in 0..SQUARE {
        for x in 0..AREA.0 {
            luma[y * width + x] = if bit(number, x / SQUARE) { WHITE } else { BLACK };
        }
    }
}

/// Reads the number, pixel by pixel through `at(x, y)`, the luma of a column and a row within [`AREA`]; `None` where bits and complement do
/// not fit.
pub fn read(at: impl Fn(usize, usize) -> u8) -> Option<u8> {
    let seen = |place: usize| at(place * SQUARE + SQUARE / 2, SQUARE / 2) > 128;
    let number = (0..BITS).filter(|&place| seen(place)).map(|place| 1 << place).sum();
    (0..2 * BITS).all(|place| seen(place) == bit(number, place)).then_some(number)
}

fn bit(number: u8, place: usize) -> bool {
    let value = number >> (place % BITS) & 1 == 1;
    value != (place >= BITS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_read_back_and_a_damaged_one_is_none() {
        for number in [0, 1, 7, 128, 200, 255] {
            let mut luma = vec![100; 160 * 10];
            write(&mut luma, 160, number);
            assert_eq!(read(|x, y| luma[y * 160 + x]), Some(number));
            luma[4 * 160 + 12] ^= 255;
            assert_eq!(read(|x, y| luma[y * 160 + x]), None);
        }
    }
}
