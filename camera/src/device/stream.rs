//! Frames from the driver into loans: written there by the driver itself, or copied once.
//!
//! ```text
//! lent    loan ─ QBUF ─▶ driver writes ─ DQBUF ─▶ the same loan, sent                    0 copies
//! mapped  driver's buffer ─ DQBUF ─▶ one pass (copied, or decoded) ─▶ loan, sent         1 copy
//! ```

use std::io;

use tagbus_message::frame::MAX_PLANES;
use tagbus_message::qos::FRAMES;

use super::agree::{Agreement, Content};
use super::kernel::{Dequeued, LoanQueue, MappedQueue, Port};
use super::layout::Layout;
use super::transfer::Transfer;
use crate::jpeg::{LumaDecoder, MarkerWalk, Walk};
use crate::loan::Loan;
use crate::outlet::Outlet;
use crate::run::{CameraError, CameraEvent};
use crate::source::{Damage, Filled};
use crate::stamps::Stamps;
use crate::unpack::Unpack;

/// Frames that wait in the driver's queue to be filled: all loans but the one that is being sent.
const QUEUED: usize = FRAMES.loans - 1;

/// Why no further frames come.
#[derive(Debug)]
pub(super) enum Broken {
    /// The device: it went, or a call on it failed.
    Device(io::Error),
    /// The camera itself cannot go on.
    Camera(CameraError),
}

impl From<io::Error> for Broken {
    fn from(error: io::Error) -> Self {
        Self::Device(error)
    }
}

impl From<CameraError> for Broken {
    fn from(error: CameraError) -> Self {
        Self::Camera(error)
    }
}

/// The one pass over a frame of the driver's memory.
enum Pass {
    Copy,
    /// With the stride of the driver's rows.
    Unpack(Unpack, usize),
    Decode(LumaDecoder),
}

impl Pass {
    fn of(agreed: &Agreement) -> Pass {
        match agreed.content {
            Content::Pixels => Self::Copy,
            Content::Packed(unpack) => {
                let (driver, memory) = (&agreed.driver, agreed.driver.memories[0]);
                Self::Unpack(unpack, (memory.stride as usize).max(unpack.row_bytes(driver.width as usize)))
            }
            Content::Jpeg => Self::Decode(LumaDecoder::default()),
        }
    }
}

/// A device that streams.
pub(super) struct Stream {
    queue: Queue,
    layout: Layout,
    stamps: Stamps,
    /// Re-pins that the user knows of.
    repins_told: u64,
}

enum Queue {
    Lent(LoanQueue),
    Mapped { queue: MappedQueue, pass: Pass },
}

impl Stream {
    /// Lends memory to the driver and begins.
    pub(super) fn lend(
        port: Port,
        agreed: &Agreement,
        outlet: &mut Outlet,
    ) -> io::Result<(Stream, Transfer)> {
        let places = agreed.layout.places.clone();
        let mut queue = LoanQueue::new(port, FRAMES.chunks() as u32, places)?;
        let numbers = queue.count();
        lend_memory(&mut queue, outlet)?;
        queue.start()?;
        Ok((Stream::new(Queue::Lent(queue), agreed), Transfer::Lent { numbers }))
    }

    /// Looks into the driver's own memory and begins.
    pub(super) fn map(port: Port, agreed: &Agreement, reason: String) -> io::Result<(Stream, Transfer)> {
        let queue = MappedQueue::new(port, QUEUED as u32, agreed.driver.count)?;
        queue.start()?;
        let buffers = queue.count();
        let pass = Pass::of(agreed);
        Ok((Stream::new(Queue::Mapped { queue, pass }, agreed), Transfer::Mapped { buffers, reason }))
    }

    fn new(queue: Queue, agreed: &Agreement) -> Stream {
        Stream {
            queue,
            layout: agreed.layout.clone(),
            stamps: Stamps::new(agreed.frame_time),
            repins_told: 0,
        }
    }

    /// The device, to wait for it.
    pub(super) fn port(&self) -> &Port {
        match &self.queue {
            Queue::Lent(queue) => queue.port(),
            Queue::Mapped { queue, .. } => queue.port(),
        }
    }

    /// How often memory was pinned anew.
    pub(super) fn repins(&self) -> u64 {
        match &self.queue {
            Queue::Lent(queue) => queue.repins(),
            Queue::Mapped { .. } => 0,
        }
    }

    /// Publishes what the driver has filled; says how many frames it had.
    pub(super) fn publish_filled(
        &mut self,
        outlet: &mut Outlet,
        damage: &mut Damage,
    ) -> Result<usize, Broken> {
        let mut frames = 0;
        while self.publish_one(outlet, damage)? {
            frames += 1;
        }
        self.tell_repins(outlet);
        Ok(frames)
    }

    /// Says now and then that memory was pinned anew.
    fn tell_repins(&mut self, outlet: &mut Outlet) {
        let Queue::Lent(queue) = &self.queue else { return };
        let (total, numbers) = (queue.repins(), queue.count());
        if total > 2 * self.repins_told {
            self.repins_told = total;
            outlet.tell(CameraEvent::Repinned { total, numbers });
        }
    }

    fn publish_one(&mut self, outlet: &mut Outlet, damage: &mut Damage) -> Result<bool, Broken> {
        match &mut self.queue {
            Queue::Lent(queue) => {
                // Memory that could not be had last time is lent now.
                lend_memory(queue, outlet)?;
                let Some((loan, frame)) = queue.dequeue()? else { return Ok(false) };
                let moment = self.stamps.take_note(&frame.stamp, outlet);
                if let Some(reason) = what_is_missing(&frame, &self.layout) {
                    damage.note(reason);
                    outlet.note_damage(damage);
                    queue.queue(loan)?;
                } else {
                    outlet.send(loan, Filled { shape: self.layout.shape, copies: 0 }, moment)?;
                    lend_memory(queue, outlet)?;
                }
                Ok(true)
            }
            Queue::Mapped { queue, pass } => {
                let (layout, stamps) = (&self.layout, &mut self.stamps);
                let seen = queue.look(|frame, memories| {
                    let moment = stamps.take_note(&frame.stamp, outlet);
                    let written = write(outlet, layout, frame, memories, pass, damage);
                    outlet.note_damage(damage);
                    written.map(|loan| (loan, moment))
                })?;
                match seen {
                    None => Ok(false),
                    Some(None) => Ok(true),
                    // Sent when the driver has its buffer back.
                    Some(Some((loan, moment))) => {
                        outlet.send(loan, Filled { shape: self.layout.shape, copies: 1 }, moment)?;
                        Ok(true)
                    }
                }
            }
        }
    }
}

/// Lends memory until the driver has all it shall have, or there is none at the moment.
fn lend_memory(queue: &mut LoanQueue, outlet: &mut Outlet) -> io::Result<()> {
    while queue.lent() < QUEUED.min(queue.count()) {
        let Some(loan) = outlet.lendable() else { break };
        queue.queue(loan)?;
    }
    Ok(())
}

/// Why a frame is not whole; `None` when it is.
fn what_is_missing(frame: &Dequeued, layout: &Layout) -> Option<String> {
    if frame.damaged {
        return Some("the driver says that data was lost".to_string());
    }
    (0..MAX_PLANES).find(|&memory| (frame.bytes_used[memory] as usize) < layout.needed[memory]).map(
        |memory| {
            let (used, needed) = (frame.bytes_used[memory], layout.needed[memory]);
            format!("the driver filled {used} of {needed} bytes")
        },
    )
}

/// The one pass: a frame out of the driver's memories into a loan. `None` when the frame or the memory for it is missing.
fn write(
    outlet: &mut Outlet,
    layout: &Layout,
    frame: &Dequeued,
    memories: &[&[u8]],
    pass: &mut Pass,
    damage: &mut Damage,
) -> Option<Loan> {
    if let Some(reason) = what_is_missing(frame, layout) {
        damage.note(reason);
        return None;
    }
    let mut loan = outlet.loan()?;
    let first = memories.first().copied().unwrap_or_default();
    let written = match pass {
        Pass::Copy => copy(memories, layout, loan.picture()),
        Pass::Unpack(unpack, stride) => {
            let (width, bytes) = (layout.shape.width() as usize, layout.shape.bytes());
            first.get(..layout.needed[0]).ok_or_else(shorter).map(|from| {
                unpack.unpack(from, *stride, width, &mut loan.picture()[..bytes]);
            })
        }
        Pass::Decode(decoder) => {
            let jpeg = first.get(..frame.bytes_used[0] as usize).unwrap_or(first);
            decode(decoder, jpeg, layout, loan.picture())
        }
    };
    match written {
        Ok(()) => Some(loan),
        Err(reason) => {
            damage.note(reason);
            None
        }
    }
}

fn shorter() -> String {
    "the driver's buffer is shorter than its frame".to_string()
}

fn copy(memories: &[&[u8]], layout: &Layout, into: &mut [u8]) -> Result<(), String> {
    for ((memory, place), &needed) in memories.iter().zip(&layout.places).zip(&layout.needed) {
        let from = memory.get(..needed).ok_or_else(shorter)?;
        into[place.offset..][..needed].copy_from_slice(from);
    }
    Ok(())
}

/// One JPEG picture of the agreed size, decoded into its place.
fn decode(decoder: &mut LumaDecoder, jpeg: &[u8], layout: &Layout, into: &mut [u8]) -> Result<(), String> {
    let mut walk = MarkerWalk::default();
    let Walk::Complete(end) = walk.advance(jpeg) else { return Err("a JPEG frame breaks off".to_string()) };
    let shape = layout.shape;
    if walk.size != Some((shape.width(), shape.height())) {
        return Err(format!("a JPEG frame is not {shape} as agreed"));
    }
    let decoded = decoder.decode(&jpeg[..end], &walk, &mut into[..shape.bytes()]);
    decoded.map_err(|error| format!("damaged JPEG frame: {error}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use tagbus_message::frame::{CaptureKind, Fourcc, NV12};

    use super::super::kernel::{DriverFormat, MemoryPlane};
    use super::super::layout::layout;
    use crate::format::FrameShape;
    use crate::stamps::DriverStamp;
    use image::ExtendedColorType;
    use image::codecs::jpeg::JpegEncoder;

    fn frame(bytes_used: &[u32]) -> Dequeued {
        let mut all = [0; MAX_PLANES];
        all[..bytes_used.len()].copy_from_slice(bytes_used);
        let stamp = DriverStamp { sequence: 0, stamp_ns: 0, monotonic: true, kind: CaptureKind::EndOfFrame };
        Dequeued { index: 0, bytes_used: all, damaged: false, stamp }
    }

    /// NV12 of 16x8 pixels with rows 20 bytes apart, each plane in a memory of its own.
    fn apart() -> Layout {
        let mut memories = [MemoryPlane::default(); MAX_PLANES];
        memories[0] = MemoryPlane { stride: 20, bytes: 160 };
        memories[1] = MemoryPlane { stride: 20, bytes: 80 };
        let fourcc = Fourcc::new(*b"NM12");
        let driver = DriverFormat { fourcc, width: 16, height: 8, progressive: true, count: 2, memories };
        layout(NV12, &driver).unwrap()
    }

    #[test]
    fn a_frame_is_whole_when_each_memory_is_filled_to_its_last_pixel_and_nothing_was_lost() {
        let layout = apart();
        assert_eq!(what_is_missing(&frame(&[156, 76]), &layout), None);
        let cut = what_is_missing(&frame(&[156, 75]), &layout).unwrap();
        assert!(cut.contains("75 of 76 bytes"), "{cut}");
        let lost = what_is_missing(&Dequeued { damaged: true, ..frame(&[160, 80]) }, &layout).unwrap();
        assert!(lost.contains("data was lost"), "{lost}");
    }

    #[test]
    fn planes_are_copied_to_their_places_and_a_short_buffer_is_refused() {
        let layout = apart();
        let (luma, chroma) = ([7; 160], [9; 80]);
        let mut into = vec![0; layout.shape.bytes()];
        copy(&[&luma, &chroma], &layout, &mut into).unwrap();
        let header = layout.shape.header();
        let checked = header.validate(into.len()).unwrap();
        assert!((0..8).all(|y| into[checked.offset + y * checked.row_stride..][..16] == [7; 16]));
        assert_eq!(into[header.planes[1].offset as usize..][..76], [9; 76]);
        assert!(copy(&[&luma, &chroma[..75]], &layout, &mut into).is_err());
    }

    #[test]
    fn a_jpeg_frame_is_decoded_and_one_that_is_cut_or_of_another_size_is_refused() {
        let mut jpeg = Vec::new();
        let pixels: Vec<u8> = (0..64 * 48).map(|i| (i % 64 * 3) as u8).collect();
        JpegEncoder::new(&mut jpeg).encode(&pixels, 64, 48, ExtendedColorType::L8).unwrap();
        let of_size = |width, height| {
            let shape = FrameShape::grey(width, height).unwrap();
            Layout { shape, places: Vec::new(), needed: [0; MAX_PLANES] }
        };
        let mut decoder = LumaDecoder::default();
        let mut luma = vec![0; 64 * 48];
        // Drivers pad with zeros, and the frame ends before them.
        let padded = [&jpeg[..], &[0; 100]].concat();
        decode(&mut decoder, &padded, &of_size(64, 48), &mut luma).unwrap();
        assert!(luma.iter().zip(&pixels).all(|(seen, painted)| seen.abs_diff(*painted) < 10));
        let mut try_one = |jpeg: &[u8], layout: &Layout| decode(&mut decoder, jpeg, layout, &mut luma);
        for cut in [0, 1, 20, jpeg.len() / 2, jpeg.len() - 1] {
            assert!(try_one(&jpeg[..cut], &of_size(64, 48)).is_err(), "{cut}");
        }
        let other = try_one(&jpeg, &of_size(64, 40)).unwrap_err();
        assert!(other.contains("64x40"), "{other}");
        // Bytes of zeros, as of a frame that never arrived.
        assert!(try_one(&[0; 4000], &of_size(64, 48)).is_err());
    }
}
