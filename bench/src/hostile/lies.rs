//! Messages that lie: right ones with some fields replaced by anything.

use tagbus_message::control::{CameraAsk, CameraRequest, DetectorAsk, DetectorRequest};
use tagbus_message::detection::{DETECTIONS_SCHEMA, DetectionsHeader, TagDetection};
use tagbus_message::frame::{FrameHeader, GREY, HeaderError, NV12, YUYV};
use tagbus_scene::Stream;

/// Width and height of what a hostile camera says its frames have.
pub(super) const SIZE: [u32; 2] = [160, 120];
/// Nominal time from frame to frame, nanoseconds.
const FRAME_TIME_NS: u64 = 5_000_000;

/// Numbers at which arithmetic breaks, and any number.
fn nasty(random: &mut Stream) -> u64 {
    let any = random.bits();
    let edges =
        [0, 1, 3, 63, 64, 1 << 16, u64::from(u32::MAX), u64::from(u32::MAX) - 7, u64::MAX, any >> 40, any];
    edges[random.below(edges.len() as u64) as usize]
}

/// A header of a frame as an honest camera writes it.
pub(super) fn honest_header(sequence: u64) -> Result<FrameHeader, HeaderError> {
    let [width, height] = SIZE;
    Ok(FrameHeader {
        sequence,
        epoch: 1,
        frame_time_ns: FRAME_TIME_NS,
        ..FrameHeader::packed(GREY, width, height)?
    })
}

/// A header with up to four lies.
pub(super) fn frame_header(honest: FrameHeader, random: &mut Stream) -> FrameHeader {
    let mut header = honest;
    for _ in 0..random.below(5) {
        let value = nasty(random);
        match random.below(16) {
            0 => header.width = value as u32,
            1 => header.height = value as u32,
            2 => header.data_offset = value as u32,
            3 => header.bytes_used = value,
            4 => header.planes[random.below(4) as usize].offset = value as u32,
            5 => header.planes[random.below(4) as usize].stride = value as u32,
            6 => header.plane_count = value as u8,
            7 => header.fourcc = [GREY.0, NV12.0, YUYV.0, value as u32][random.below(4) as usize],
            8 => header.rotation_degrees = value as u32,
            9 => header.schema = value as u32,
            10 => header.epoch = value,
            11 => header.sequence = value,
            12 => header.frame_time_ns = value,
            13 => (header.capture_ns, header.capture_clock) = (value, random.bits() as u32),
            14 => (header.dequeue_ns, header.publish_ns) = (value, random.bits()),
            _ => header.gain = f32::from_bits(value as u32),
        }
    }
    header
}

/// A header of detections whose counts say anything.
pub(super) fn detections_header(random: &mut Stream) -> DetectionsHeader {
    let mut header =
        DetectionsHeader { schema: DETECTIONS_SCHEMA, count: 2, found: 2, ..DetectionsHeader::default() };
    for _ in 0..random.below(6) {
        let value = nasty(random);
        match random.below(10) {
            0 => header.schema = value as u32,
            1 => header.count = value as u32,
            2 => header.found = value as u32,
            3 => header.flags = value as u32,
            4 => header.family_count = value as u32,
            5 => header.families[random.below(16) as usize] = [value as u8; 32],
            6 => (header.epoch, header.detector_epoch) = (value, random.bits()),
            7 => (header.sequence, header.message_number) = (value, random.bits()),
            8 => (header.skipped_total, header.control_number) = (value, random.bits()),
            _ => (header.decimation, header.hamming) = (f32::from_bits(value as u32), value as i32),
        }
    }
    header
}

/// A tag of any bytes that are numbers.
pub(super) fn tag(random: &mut Stream) -> TagDetection {
    let number = |random: &mut Stream| f64::from_bits(nasty(random));
    let mut tag = TagDetection { id: random.bits() as u32, ..TagDetection::default() };
    tag.family_name = [random.bits() as u8; 32];
    (tag.hamming, tag.flags) = (nasty(random) as u32, nasty(random) as u32);
    tag.center = [number(random), number(random)];
    tag.corners.iter_mut().flatten().for_each(|value| *value = number(random));
    tag.homography.iter_mut().for_each(|value| *value = number(random));
    tag
}

/// A request to a detector that is answered, but changes nothing.
pub(super) fn detector_request(random: &mut Stream) -> Option<DetectorRequest> {
    let mut request = DetectorRequest::of(&DetectorAsk::Get).ok()?;
    if random.below(4) > 0 {
        // Bits that name no parameter: a change that could be made would be one that a user wants.
        (request.kind, request.mask) = (nasty(random) as u32, nasty(random) as u32 | 1 << 31);
        let parameters = &mut request.parameters;
        (parameters.family_count, parameters.id_count) = (nasty(random) as u32, nasty(random) as u32);
        parameters.families[random.below(16) as usize] = [random.bits() as u8; 32];
        (parameters.decimation, parameters.hamming) =
            (f32::from_bits(random.bits() as u32), random.bits() as i32);
    }
    if random.below(8) == 0 {
        request.schema = nasty(random) as u32;
    }
    Some(request)
}

/// A request to a camera that is answered, but changes nothing.
pub(super) fn camera_request(random: &mut Stream) -> Option<CameraRequest> {
    let mut request = CameraRequest::of(&CameraAsk::Get).ok()?;
    if random.below(4) > 0 {
        (request.kind, request.count) = (nasty(random) as u32, nasty(random) as u32);
        request.schema = nasty(random) as u32;
    }
    Some(request)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_many_lies_some_are_refused_and_some_are_believed() {
        let mut random = Stream::new(7);
        let honest = honest_header(1).unwrap();
        let length = honest.bytes_used as usize;
        let taken = (0..1000).filter(|_| frame_header(honest, &mut random).validate(length).is_ok()).count();
        assert!((100..900).contains(&taken), "{taken} of 1000 frames");
        let taken = (0..1000).filter(|_| detections_header(&mut random).checked(2).is_ok()).count();
        assert!((100..900).contains(&taken), "{taken} of 1000 messages");
    }

    #[test]
    fn no_request_changes_anything() {
        let mut random = Stream::new(8);
        for _ in 0..1000 {
            let detector = detector_request(&mut random).unwrap().checked();
            assert!(!matches!(detector, Ok(DetectorAsk::Set(_))), "{detector:?}");
        }
    }
}
