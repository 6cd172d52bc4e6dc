//! Pictures as the bytes of a pixel format.

use std::io::{self, Write};

use crate::Failure;
use crate::pictures::{COUNT, Pictures};

/// The value of chroma that is no colour.
const NO_COLOUR: u8 = 128;

/// Writes all pictures of a size in a format, one behind the other.
pub(crate) fn play(size: &str, format: &str, folder: &str) -> Result<(), Failure> {
    let pictures = Pictures::read(size, folder)?;
    let mut out = io::stdout().lock();
    for picture in 0..COUNT {
        let bytes = convert(pictures.luma(picture), format).ok_or("a format that is not known")?;
        out.write_all(&bytes)?;
    }
    Ok(())
}

/// One picture in a format; `None` for a format that is not known.
fn convert(luma: &[u8], format: &str) -> Option<Vec<u8>> {
    let with_chroma = || [luma, &vec![NO_COLOUR; luma.len() / 2]].concat();
    let words =
        |shift: u32| luma.iter().flat_map(|&value| (u16::from(value) << shift).to_le_bytes()).collect();
    Some(match format {
        // A mosaic of a grey world is that world.
        "GREY" | "GRBG" | "GBRG" | "RGGB" | "BA81" => luma.to_vec(),
        "NV12" | "NV21" | "YU12" | "NM12" | "NM21" | "YM12" => with_chroma(),
        "YUYV" => luma.iter().flat_map(|&value| [value, NO_COLOUR]).collect(),
        "UYVY" => luma.iter().flat_map(|&value| [NO_COLOUR, value]).collect(),
        "Y10" => words(2),
        "Y12" => words(4),
        "Y16" => words(8),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn luma_lies_where_the_format_says() {
        let luma = [10, 20, 30, 40];
        assert_eq!(convert(&luma, "YUYV").unwrap(), [10, 128, 20, 128, 30, 128, 40, 128]);
        assert_eq!(convert(&luma, "UYVY").unwrap()[1], 10);
        assert_eq!(convert(&luma, "NV12").unwrap(), [10, 20, 30, 40, 128, 128]);
        assert_eq!(convert(&luma, "Y10").unwrap()[..2], [40, 0]);
        assert_eq!(convert(&luma, "Y16").unwrap()[..2], [0, 10]);
        assert!(convert(&luma, "H264").is_none());
    }
}
