//! The part of a frame that is searched.

use tagbus_detector::{Decimation, Geometry, LumaView, MIN_SIDE};
use tagbus_message::control::Region;

/// A part of a frame, where it lies, and where in the frame it begins.
pub(crate) struct Part<'a> {
    pub(crate) view: LumaView<'a>,
    /// Column and row of its top-left pixel.
    pub(crate) origin: [f64; 2],
}

/// Full-resolution pixels after which the grid of decimation repeats itself.
fn step_of(decimation: Decimation) -> usize {
    match decimation {
        Decimation::Every(n) => n as usize,
        Decimation::ThreeToTwo => 3,
    }
}

/// Cuts `region` out of a frame; `None` when nothing of it lies there that could be searched.
///
/// A few columns and rows before it belong to the part too, so that decimation takes the same pixels as in the whole frame.
pub(crate) fn cut<'a>(
    frame: &LumaView<'a>,
    region: Option<Region>,
    decimation: Decimation,
) -> Option<Part<'a>> {
    let Some(region) = region else { return Some(Part { view: *frame, origin: [0.0; 2] }) };
    let step = step_of(decimation);
    let (left, width) = span(region.x, region.width, frame.width(), step)?;
    let (top, height) = span(region.y, region.height, frame.height(), step)?;
    let Geometry { offset, row_stride, pixel_step, .. } = frame.geometry();
    let offset = offset + top * row_stride + left * pixel_step;
    let geometry = Geometry { offset, width, height, row_stride, pixel_step };
    let view = LumaView::new(frame.bytes(), geometry).ok()?;
    Some(Part { view, origin: [left as f64, top as f64] })
}

/// Begin and length of what lies within `whole`, beginning on the grid.
fn span(first: u32, length: u32, whole: usize, step: usize) -> Option<(usize, usize)> {
    let begin = first as usize / step * step;
    let end = (first as usize + length as usize).min(whole);
    let length = end.checked_sub(begin)?;
    (length >= MIN_SIDE).then_some((begin, length))
}

/// Why nothing of a region could be searched in frames of this size.
pub(crate) fn refusal(region: Region, (width, height): (u32, u32)) -> Option<String> {
    let fits = |first: u32, length: u32, whole: u32| {
        span(first, length, whole as usize, 1).is_some_and(|(_, seen)| seen <= length as usize)
    };
    let is_inside = fits(region.x, region.width, width) && fits(region.y, region.height, height);
    (!is_inside).then(|| {
        format!(
            "region {region} has less than {MIN_SIDE} columns or rows within the frames, which are {width}x{height}: \
             use X,Y,WIDTHxHEIGHT that lie there"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: usize = 40;
    const HEIGHT: usize = 30;

    fn cut_of(region: Region, decimation: Decimation, pixel_step: usize) -> Option<([f64; 2], Vec<u8>)> {
        let stride = WIDTH * pixel_step + 6;
        let mut bytes = vec![0; 9 + HEIGHT * stride];
        for (y, x) in (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (y, x))) {
            bytes[9 + y * stride + x * pixel_step] = (7 * y + x) as u8;
        }
        let geometry = Geometry { offset: 9, width: WIDTH, height: HEIGHT, row_stride: stride, pixel_step };
        let part = cut(&LumaView::new(&bytes, geometry).unwrap(), Some(region), decimation)?;
        let g = part.view.geometry();
        let pixel = |y, x| bytes[g.offset + y * g.row_stride + x * g.pixel_step];
        let pixels = (0..g.height).flat_map(|y| (0..g.width).map(move |x| (y, x)));
        Some((part.origin, pixels.map(|(y, x)| pixel(y, x)).collect()))
    }

    fn expected(left: usize, top: usize, right: usize, bottom: usize) -> Vec<u8> {
        (top..bottom).flat_map(|y| (left..right).map(move |x| (7 * y + x) as u8)).collect()
    }

    #[test]
    fn a_part_holds_the_pixels_of_its_region_and_begins_on_the_grid_of_decimation() {
        let region = Region { x: 11, y: 8, width: 20, height: 10 };
        for pixel_step in [1, 2] {
            let (origin, pixels) = cut_of(region, Decimation::Every(1), pixel_step).unwrap();
            assert_eq!((origin, pixels), ([11.0, 8.0], expected(11, 8, 31, 18)));
            let (origin, pixels) = cut_of(region, Decimation::Every(4), pixel_step).unwrap();
            assert_eq!((origin, pixels), ([8.0, 8.0], expected(8, 8, 31, 18)));
            let (origin, pixels) = cut_of(region, Decimation::ThreeToTwo, pixel_step).unwrap();
            assert_eq!((origin, pixels), ([9.0, 6.0], expected(9, 6, 31, 18)));
        }
    }

    #[test]
    fn a_region_ends_where_the_frame_does_and_one_that_lies_elsewhere_is_none() {
        let huge = Region { x: 20, y: 20, width: u32::MAX, height: u32::MAX };
        let (origin, pixels) = cut_of(huge, Decimation::Every(1), 1).unwrap();
        assert_eq!((origin, pixels), ([20.0, 20.0], expected(20, 20, 40, 30)));
        for outside in [
            Region { x: 40, y: 0, width: 10, height: 10 },
            Region { x: 0, y: u32::MAX, width: 10, height: u32::MAX },
            Region { x: 38, y: 0, width: 10, height: 10 },
        ] {
            assert!(cut_of(outside, Decimation::Every(2), 1).is_none(), "{outside}");
            let text = refusal(outside, (WIDTH as u32, HEIGHT as u32)).unwrap();
            assert!(text.contains("40x30") && text.contains(&outside.to_string()), "{text}");
        }
        assert_eq!(refusal(huge, (WIDTH as u32, HEIGHT as u32)), None);
    }
}
