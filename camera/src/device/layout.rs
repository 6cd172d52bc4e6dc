//! Where the planes of a driver's frame lie, in memory of the driver and in a loan.
//!
//! ```text
//! one memory      | luma, rows `stride` apart | chroma | padding |        NV12, YU12, YUYV, GREY ...
//! several         | luma ... | and | chroma ... |                         NM12, YM12: one after the other in the loan
//! ```

use tagbus_message::frame::{Fourcc, MAX_PLANES, PICTURE_ALIGNMENT, Plane};

use super::kernel::{DriverFormat, MemoryPlace};
use crate::format::FrameShape;

/// Where everything lies.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Layout {
    /// The frame as it is published, with the bytes that a loan must have.
    pub(super) shape: FrameShape,
    /// Each of the driver's memories in a loan's picture, as long as the driver wants it.
    pub(super) places: Vec<MemoryPlace>,
    /// Bytes of each memory that a whole frame fills.
    pub(super) needed: [usize; MAX_PLANES],
}

/// Lays out a frame that is published as `format`, in the memories that the driver states.
pub(super) fn layout(format: Fourcc, driver: &DriverFormat) -> Result<Layout, String> {
    let (width, height) = (driver.width, driver.height);
    let shapes = format.planes(width as usize, height as usize);
    let shapes = shapes.ok_or_else(|| format!("{format} is not a format that is published"))?;
    if driver.count != 1 && driver.count != shapes.len() {
        return Err(format!("the driver states {} memories for {} planes", driver.count, shapes.len()));
    }
    let places = places(driver);
    let mut planes = [Plane::default(); MAX_PLANES];
    let mut needed = [0; MAX_PLANES];
    let mut end = 0;
    for (number, shape) in shapes.iter().enumerate() {
        let memory = if driver.count == 1 { 0 } else { number };
        let start = if memory == number { places[memory].offset } else { end };
        // Chroma planes of one memory have strides in the proportion of their rows to those of the luma.
        let first = shapes[memory].row_bytes;
        let stated = (driver.memories[memory].stride as usize).max(first);
        let stride = if memory == number { stated } else { (stated * shape.row_bytes).div_ceil(first) };
        planes[number] = Plane { offset: start as u32, stride: stride as u32 };
        needed[memory] = start + stride * (shape.rows - 1) + shape.row_bytes - places[memory].offset;
        end = start + stride * shape.rows;
    }
    for (number, place) in places.iter().enumerate() {
        if place.bytes < needed[number] {
            let (says, needs) = (place.bytes, needed[number]);
            return Err(format!(
                "the driver states {says} bytes for a memory, but {width}x{height} {format} needs {needs}"
            ));
        }
    }
    let bytes = places.last().map_or(0, |place| place.offset + place.bytes);
    let shape = FrameShape::placed(format, [width, height], planes, bytes);
    Ok(Layout { shape: shape.map_err(|error| error.to_string())?, places, needed })
}

/// The driver's memories one after the other, each at the start of a cache line.
fn places(driver: &DriverFormat) -> Vec<MemoryPlace> {
    let mut offset = 0;
    let memories = driver.memories[..driver.count.min(MAX_PLANES)].iter();
    let place = |memory: &super::kernel::MemoryPlane| {
        let place = MemoryPlace { offset, bytes: memory.bytes as usize };
        offset = (offset + place.bytes).next_multiple_of(PICTURE_ALIGNMENT);
        place
    };
    memories.map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::super::kernel::MemoryPlane;
    use super::*;
    use tagbus_message::frame::{GREY, NV12, YU12, YUYV};

    fn driver(size: [u32; 2], memories: &[[u32; 2]]) -> DriverFormat {
        let mut all = [MemoryPlane::default(); MAX_PLANES];
        for (memory, &[stride, bytes]) in all.iter_mut().zip(memories) {
            *memory = MemoryPlane { stride, bytes };
        }
        let [width, height] = size;
        DriverFormat { fourcc: GREY, width, height, progressive: true, count: memories.len(), memories: all }
    }

    fn planes(layout: &Layout) -> Vec<[u32; 2]> {
        let header = layout.shape.header();
        header.planes[..header.plane_count.into()].iter().map(|plane| [plane.offset, plane.stride]).collect()
    }

    #[test]
    fn rows_without_gaps_lie_as_in_a_packed_frame() {
        for format in [GREY, NV12, YU12, YUYV] {
            let packed = FrameShape::new(format, 64, 48).unwrap();
            let stride = if format == YUYV { 128 } else { 64 };
            let laid = layout(format, &driver([64, 48], &[[stride, packed.bytes() as u32]])).unwrap();
            assert_eq!(laid.shape, packed, "{format}");
            assert_eq!(laid.needed[0], packed.bytes());
        }
    }

    #[test]
    fn odd_strides_and_padding_at_the_end_are_kept() {
        let laid = layout(NV12, &driver([636, 480], &[[640, 500_000]])).unwrap();
        assert_eq!(planes(&laid), [[0, 640], [640 * 480, 640]]);
        assert_eq!((laid.shape.bytes(), laid.needed[0]), (500_000, 640 * 480 + 640 * 239 + 636));
        let laid = layout(YU12, &driver([636, 480], &[[640, 460_800]])).unwrap();
        assert_eq!(planes(&laid), [[0, 640], [640 * 480, 320], [640 * 480 + 320 * 240, 320]]);
        // No stride at all means rows without gaps.
        assert_eq!(planes(&layout(GREY, &driver([636, 480], &[[0, 636 * 480]])).unwrap()), [[0, 636]]);
    }

    #[test]
    fn memories_of_their_own_follow_each_other_at_cache_lines() {
        let laid = layout(NV12, &driver([30, 10], &[[32, 321], [32, 160]])).unwrap();
        assert_eq!(planes(&laid), [[0, 32], [384, 32]]);
        assert_eq!(laid.places[1], MemoryPlace { offset: 384, bytes: 160 });
        assert_eq!((laid.needed[0], laid.needed[1], laid.shape.bytes()), (32 * 9 + 30, 32 * 4 + 30, 544));
    }

    #[test]
    fn a_driver_that_states_too_little_is_refused_with_both_numbers() {
        let error = layout(GREY, &driver([64, 48], &[[64, 3071]])).unwrap_err();
        assert!(error.contains("3071") && error.contains("3072"), "{error}");
        let error = layout(YU12, &driver([64, 48], &[[64, 3072], [32, 768]])).unwrap_err();
        assert!(error.contains("2 memories for 3 planes"), "{error}");
        assert!(layout(GREY, &driver([1, 1], &[[1, 1]])).is_err());
    }
}
