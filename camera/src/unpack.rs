//! Luma of 8 bits out of deeper, packed or mosaic values, in the one pass from a driver's memory, or a file's bytes, into a loan.
//!
//! ```text
//! Y10 Y12 Y16   two bytes a value, low byte first; the value in the low 10, 12 or 16 bits
//! Y10P          | v0 high 8 | v1 high 8 | v2 high 8 | v3 high 8 | low 2 bits of v3 v2 v1 v0 |    four values in five bytes
//! Bayer         G R G R     every second pixel is green, which is the luma there; between four
//!               B G B G     of them it is their mean
//! ```
//!
//! The eight high bits are kept: two more bits are below the noise of the sensors that deliver them.

use tagbus_message::frame::Fourcc;

/// How luma is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Unpack {
    /// Words of 16 bits, shifted so far to the right.
    Words {
        /// Bits that are dropped.
        shift: u32,
    },
    /// Four values of ten bits in five bytes.
    Packed10,
    /// A mosaic with green where column plus row is even (0) or odd (1).
    Bayer {
        /// The parity of green.
        green: usize,
    },
}

impl Unpack {
    /// How a format stores luma; `None` for one that is published as it is, or that is not known.
    pub(crate) const fn of(format: Fourcc) -> Option<Unpack> {
        Some(match &format.0.to_le_bytes() {
            b"Y10P" => Self::Packed10,
            b"Y10 " => Self::Words { shift: 2 },
            b"Y12 " => Self::Words { shift: 4 },
            b"Y16 " => Self::Words { shift: 8 },
            b"GRBG" | b"GBRG" => Self::Bayer { green: 0 },
            b"RGGB" | b"BA81" => Self::Bayer { green: 1 },
            _ => return None,
        })
    }

    /// Bytes that a row of `width` values takes.
    pub(crate) fn row_bytes(self, width: usize) -> usize {
        match self {
            Self::Words { .. } => 2 * width,
            Self::Packed10 => width.div_ceil(4) * 5,
            Self::Bayer { .. } => width,
        }
    }

    /// Writes rows of `width` bytes to `luma`, out of rows that lie `stride` bytes apart in `from`.
    pub(crate) fn unpack(self, from: &[u8], stride: usize, width: usize, luma: &mut [u8]) {
        let height = luma.len() / width;
        let row = |y: usize| &from[y * stride..][..self.row_bytes(width)];
        for (y, luma) in luma.chunks_exact_mut(width).enumerate() {
            match self {
                Self::Words { shift } => words(row(y), shift, luma),
                Self::Packed10 => packed10(row(y), luma),
                Self::Bayer { green } => {
                    let (above, below) = (
                        row(if y == 0 { 1 } else { y - 1 }),
                        row(if y + 1 == height { y - 1 } else { y + 1 }),
                    );
                    mosaic([above, row(y), below], (green + y) % 2, luma);
                }
            }
        }
    }
}

fn words(row: &[u8], shift: u32, luma: &mut [u8]) {
    for (value, word) in luma.iter_mut().zip(row.chunks_exact(2)) {
        // A driver that fills more bits than it promises must not wrap to black.
        *value = (u16::from_le_bytes([word[0], word[1]]) >> shift).min(255) as u8;
    }
}

fn packed10(row: &[u8], luma: &mut [u8]) {
    for (values, group) in luma.chunks_mut(4).zip(row.chunks_exact(5)) {
        values.copy_from_slice(&group[..values.len()]);
    }
}

/// One row; `green` is the parity of its green columns. At the rims the neighbours inside stand for those outside.
fn mosaic([above, row, below]: [&[u8]; 3], green: usize, luma: &mut [u8]) {
    let last = luma.len() - 1;
    for (x, value) in luma.iter_mut().enumerate() {
        *value = if x % 2 == green {
            row[x]
        } else {
            let (left, right) = (if x == 0 { 1 } else { x - 1 }, if x == last { x - 1 } else { x + 1 });
            let sum = [above[x], below[x], row[left], row[right]].map(u16::from).iter().sum::<u16>();
            ((sum + 2) / 4) as u8
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every value beside every other, rows and columns not in step.
    fn picture(width: usize, height: usize) -> Vec<u8> {
        (0..width * height).map(|i| (i * 7 + i / width * 13) as u8).collect()
    }

    fn unpacked(unpack: Unpack, rows: &[Vec<u8>], padding: usize, width: usize) -> Vec<u8> {
        let padded: Vec<u8> =
            rows.iter().flat_map(|row| row.iter().copied().chain(vec![99; padding])).collect();
        let mut luma = vec![0; width * rows.len()];
        unpack.unpack(&padded, rows[0].len() + padding, width, &mut luma);
        luma
    }

    #[test]
    fn words_of_10_12_and_16_bits_give_their_high_bits_whatever_the_stride() {
        let picture = picture(31, 7);
        for (shift, noise) in [(2, 3), (4, 9), (8, 200)] {
            let rows: Vec<Vec<u8>> = picture
                .chunks(31)
                .map(|row| row.iter().flat_map(|&v| (u16::from(v) << shift | noise).to_le_bytes()).collect())
                .collect();
            assert_eq!(unpacked(Unpack::Words { shift }, &rows, 6, 31), picture);
        }
        assert_eq!(unpacked(Unpack::Words { shift: 2 }, &[vec![255, 255]], 0, 1), [255], "no wrap to black");
    }

    #[test]
    fn packed_values_of_10_bits_give_their_high_bits_also_in_an_odd_row() {
        for width in [4, 30, 31, 32, 33] {
            let picture = picture(width, 5);
            let pack = |group: &[u8]| {
                let mut bytes = [0, 0, 0, 0, 0b11_01_10_11];
                bytes[..group.len()].copy_from_slice(group);
                bytes
            };
            let rows: Vec<Vec<u8>> =
                picture.chunks(width).map(|row| row.chunks(4).flat_map(pack).collect()).collect();
            assert_eq!(unpacked(Unpack::Packed10, &rows, 3, width), picture, "{width}");
        }
    }

    #[test]
    fn green_pixels_of_a_mosaic_are_kept_and_the_others_are_the_mean_of_their_neighbours() {
        let picture = picture(8, 6);
        let rows: Vec<Vec<u8>> = picture.chunks(8).map(<[u8]>::to_vec).collect();
        for green in [0, 1] {
            let luma = unpacked(Unpack::Bayer { green }, &rows, 0, 8);
            for (i, value) in luma.iter().enumerate() {
                let (x, y) = (i % 8, i / 8);
                if (x + y) % 2 == green {
                    assert_eq!(*value, picture[i]);
                } else if (1..7).contains(&x) && (1..5).contains(&y) {
                    let around = [i - 8, i + 8, i - 1, i + 1].map(|j| u32::from(picture[j]));
                    assert_eq!(u32::from(*value), (around.iter().sum::<u32>() + 2) / 4);
                }
            }
        }
        let flat = vec![vec![77; 5]; 4];
        assert!(unpacked(Unpack::Bayer { green: 0 }, &flat, 2, 5).iter().all(|&value| value == 77));
    }
}
