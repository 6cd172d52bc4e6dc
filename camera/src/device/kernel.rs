//! The few calls to Video4Linux that the crate v4l does not make the way a loan needs them. All unsafe code of the driver's side.
//!
//! ```text
//! Port         an open device: asks, sets formats and rates
//! LoanQueue    USERPTR: the driver writes into loans, which lie in here until they come back filled
//! MappedQueue  MMAP: the driver writes into memory of its own, which is looked at between two calls
//! ```
//!
//! What makes it sound: every argument is a struct of the kernel's own header (by the crate v4l), whose size is held against the
//! request's; addresses in arguments are set in this file only; and memory that the driver may write to is owned by a queue,
//! which ends streaming and closes the device before it lets go of it.

use std::fs::{File, OpenOptions};
use std::io;
use std::mem;
use std::os::fd::AsRawFd;
use std::os::raw::{c_int, c_ulong, c_void};
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;
use std::ptr;
use std::slice;

use tagbus_message::frame::{Fourcc, MAX_PLANES};
use v4l::v4l_sys as sys;
use v4l::v4l2::{self, vidioc};

use crate::loan::Loan;
use crate::readiness::Readiness;

/// Planes that the kernel's interface allows a frame; a buffer's description always has room for all of them.
const KERNEL_PLANES: usize = sys::VIDEO_MAX_PLANES as usize;

/// Structs of numbers and of unions of numbers, which the kernel wants filled with zeros where nothing is said.
trait Plain: Copy {}
impl Plain for sys::v4l2_capability {}
impl Plain for sys::v4l2_fmtdesc {}
impl Plain for sys::v4l2_frmsizeenum {}
impl Plain for sys::v4l2_frmivalenum {}
impl Plain for sys::v4l2_format {}
impl Plain for sys::v4l2_streamparm {}
impl Plain for sys::v4l2_requestbuffers {}
impl Plain for sys::v4l2_buffer {}
impl Plain for sys::v4l2_plane {}
impl Plain for sys::v4l2_query_ext_ctrl {}
impl Plain for sys::v4l2_querymenu {}
impl Plain for sys::v4l2_control {}

fn zeroed<T: Plain>() -> T {
    // SAFETY: `Plain` is implemented above only, for structs of integers, of arrays and unions of integers, and of raw
    // pointers: zero is a value of each.
    unsafe { mem::zeroed() }
}

/// One call. Repeated when a signal came in between.
fn call<T>(file: &File, request: c_ulong, argument: &mut T) -> io::Result<()> {
    // The kernel reads and writes as many bytes as the request says.
    if (request >> 16) & 0x3fff != size_of::<T>() as c_ulong {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "a request and its argument differ in size"));
    }
    let argument: *mut c_void = ptr::from_mut(argument).cast();
    loop {
        // SAFETY: the descriptor is open as long as `file` lives; the argument is exclusively borrowed and has the size that
        // the request tells the kernel, as checked above; addresses within it are set in this file, each with its reason.
        match unsafe { v4l2::ioctl(file.as_raw_fd(), request, argument) } {
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            answer => return answer,
        }
    }
}

/// `None` where a list has ended.
fn listed<T>(answer: io::Result<T>) -> io::Result<Option<T>> {
    match answer {
        Ok(entry) => Ok(Some(entry)),
        // ENOTTY: the driver has no such list.
        Err(error) if matches!(error.raw_os_error(), Some(EINVAL | ENOTTY)) => Ok(None),
        Err(error) => Err(error),
    }
}

const EINVAL: i32 = rustix::io::Errno::INVAL.raw_os_error();
const ENOTTY: i32 = rustix::io::Errno::NOTTY.raw_os_error();

/// Text of a fixed field, up to its first zero.
fn text(field: &[u8]) -> String {
    let end = field.iter().position(|&byte| byte == 0).unwrap_or(field.len());
    String::from_utf8_lossy(&field[..end]).into_owned()
}

/// Which of the kernel's two ways to describe buffers a device uses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Planes {
    /// One memory a frame.
    Single,
    /// Each plane may lie in memory of its own.
    Multi,
}

/// Whose memory the driver writes into.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Memory {
    /// The driver's own (MMAP).
    Drivers,
    /// Ours (USERPTR).
    Ours,
}

impl Memory {
    fn code(self) -> u32 {
        match self {
            Self::Drivers => sys::v4l2_memory_V4L2_MEMORY_MMAP,
            Self::Ours => sys::v4l2_memory_V4L2_MEMORY_USERPTR,
        }
    }
}

/// What a device says about itself.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct About {
    pub(super) driver: String,
    pub(super) card: String,
    /// How it captures; `None` for a device that does not capture pictures.
    pub(super) captures: Option<Planes>,
    /// Whether it hands over buffers, and not only bytes to read.
    pub(super) streams: bool,
}

/// One memory of a frame.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct MemoryPlane {
    /// Bytes from row to row; 0 where the driver does not say.
    pub(super) stride: u32,
    /// Bytes that a buffer must have.
    pub(super) bytes: u32,
}

/// A format as the driver states it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct DriverFormat {
    pub(super) fourcc: Fourcc,
    pub(super) width: u32,
    pub(super) height: u32,
    /// Whether a frame holds all rows of one moment.
    pub(super) progressive: bool,
    /// Memories in use.
    pub(super) count: usize,
    pub(super) memories: [MemoryPlane; MAX_PLANES],
}

/// Sizes or intervals: one of a list, or a range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Listed<T> {
    One(T),
    Range { min: T, max: T, step: T },
}

/// A frame as it comes back from the driver.
#[derive(Debug, Clone, Copy)]
pub(super) struct Dequeued {
    pub(super) index: usize,
    /// Bytes written to each memory.
    pub(super) bytes_used: [u32; MAX_PLANES],
    /// Whether the driver says that data was lost.
    pub(super) damaged: bool,
    /// The driver's number of the frame.
    pub(super) sequence: u32,
    /// The driver's stamp in nanoseconds.
    pub(super) stamp_ns: u64,
    /// Whether the stamp is of `CLOCK_MONOTONIC`.
    pub(super) monotonic: bool,
    /// Whether the stamp marks the start of exposure instead of the end of the frame.
    pub(super) start_of_exposure: bool,
}

/// What a control's values are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ControlKind {
    Number,
    Switch,
    /// One of a list of texts.
    Menu,
    /// One of a list of numbers.
    NumberMenu,
    /// Does something when it is written, and has no value.
    Button,
    /// A heading, a text, or a kind that does not concern us.
    Other,
}

/// A control as the driver describes it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct DriverControl {
    pub(super) id: u32,
    pub(super) kind: ControlKind,
    /// The driver's words for it.
    pub(super) title: String,
    pub(super) min: i64,
    pub(super) max: i64,
    pub(super) step: i64,
    pub(super) default: i64,
    /// Whether it cannot be written.
    pub(super) read_only: bool,
    /// Whether another control has its say at present, so that a value has no effect.
    pub(super) inactive: bool,
}

/// An open device.
#[derive(Debug)]
pub(super) struct Port {
    file: File,
    planes: Planes,
}

impl Port {
    /// Opens a device for reading and writing; no call on it waits.
    pub(super) fn open(path: &Path) -> io::Result<Port> {
        let nonblocking = rustix::fs::OFlags::NONBLOCK.bits() as i32;
        let file = OpenOptions::new().read(true).write(true).custom_flags(nonblocking).open(path)?;
        Ok(Port { file, planes: Planes::Single })
    }

    /// What wakes a wait set when a frame is filled or the device has gone.
    pub(super) fn readiness(&self) -> io::Result<Readiness> {
        Readiness::of(&self.file)
    }

    /// What the device is. From here on formats and buffers are described its way.
    pub(super) fn about(&mut self) -> io::Result<About> {
        let mut said: sys::v4l2_capability = zeroed();
        call(&self.file, vidioc::VIDIOC_QUERYCAP, &mut said)?;
        // A driver with several nodes says what this node can apart from what all can.
        let own = said.capabilities & sys::V4L2_CAP_DEVICE_CAPS != 0;
        let can = if own { said.device_caps } else { said.capabilities };
        let captures = match () {
            () if can & sys::V4L2_CAP_VIDEO_CAPTURE != 0 => Some(Planes::Single),
            () if can & sys::V4L2_CAP_VIDEO_CAPTURE_MPLANE != 0 => Some(Planes::Multi),
            () => None,
        };
        self.planes = captures.unwrap_or(Planes::Single);
        Ok(About {
            driver: text(&said.driver),
            card: text(&said.card),
            captures,
            streams: can & sys::V4L2_CAP_STREAMING != 0,
        })
    }

    fn buffer_type(&self) -> u32 {
        match self.planes {
            Planes::Single => sys::v4l2_buf_type_V4L2_BUF_TYPE_VIDEO_CAPTURE,
            Planes::Multi => sys::v4l2_buf_type_V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE,
        }
    }

    /// The format at a place of the driver's list, with its words for it.
    pub(super) fn format_at(&self, index: u32) -> io::Result<Option<(Fourcc, String)>> {
        let mut entry = sys::v4l2_fmtdesc { index, type_: self.buffer_type(), ..zeroed() };
        let answer = call(&self.file, vidioc::VIDIOC_ENUM_FMT, &mut entry);
        Ok(listed(answer)?.map(|()| (Fourcc(entry.pixelformat), text(&entry.description))))
    }

    /// The size at a place of the driver's list for a format.
    pub(super) fn size_at(&self, format: Fourcc, index: u32) -> io::Result<Option<Listed<[u32; 2]>>> {
        let mut entry = sys::v4l2_frmsizeenum { index, pixel_format: format.0, ..zeroed() };
        if listed(call(&self.file, vidioc::VIDIOC_ENUM_FRAMESIZES, &mut entry))?.is_none() {
            return Ok(None);
        }
        if entry.type_ == sys::v4l2_frmsizetypes_V4L2_FRMSIZE_TYPE_DISCRETE {
            // SAFETY: every member of this union is made of integers.
            let one = unsafe { entry.__bindgen_anon_1.discrete };
            return Ok(Some(Listed::One([one.width, one.height])));
        }
        // SAFETY: every member of this union is made of integers.
        let range = unsafe { entry.__bindgen_anon_1.stepwise };
        Ok(Some(Listed::Range {
            min: [range.min_width, range.min_height],
            max: [range.max_width, range.max_height],
            step: [range.step_width, range.step_height],
        }))
    }

    /// The frame interval, in seconds as numerator and denominator, at a place of the driver's list.
    pub(super) fn interval_at(
        &self,
        format: Fourcc,
        [width, height]: [u32; 2],
        index: u32,
    ) -> io::Result<Option<Listed<[u32; 2]>>> {
        let mut entry = sys::v4l2_frmivalenum { index, pixel_format: format.0, width, height, ..zeroed() };
        if listed(call(&self.file, vidioc::VIDIOC_ENUM_FRAMEINTERVALS, &mut entry))?.is_none() {
            return Ok(None);
        }
        let parts = |fraction: sys::v4l2_fract| [fraction.numerator, fraction.denominator];
        if entry.type_ == sys::v4l2_frmivaltypes_V4L2_FRMIVAL_TYPE_DISCRETE {
            // SAFETY: every member of this union is made of integers.
            return Ok(Some(Listed::One(parts(unsafe { entry.__bindgen_anon_1.discrete }))));
        }
        // SAFETY: every member of this union is made of integers.
        let range = unsafe { entry.__bindgen_anon_1.stepwise };
        Ok(Some(Listed::Range { min: parts(range.min), max: parts(range.max), step: parts(range.step) }))
    }

    /// The format that is in force.
    pub(super) fn format(&self) -> io::Result<DriverFormat> {
        let mut format = sys::v4l2_format { type_: self.buffer_type(), ..zeroed() };
        call(&self.file, vidioc::VIDIOC_G_FMT, &mut format)?;
        Ok(self.stated(&format))
    }

    /// Asks for a format; the answer is what the driver made of it.
    pub(super) fn set_format(&self, fourcc: Fourcc, width: u32, height: u32) -> io::Result<DriverFormat> {
        let mut format = sys::v4l2_format { type_: self.buffer_type(), ..zeroed() };
        let field = sys::v4l2_field_V4L2_FIELD_NONE;
        match self.planes {
            Planes::Single => {
                let pixelformat = fourcc.0;
                format.fmt.pix = sys::v4l2_pix_format { width, height, pixelformat, field, ..pix(&format) };
            }
            Planes::Multi => {
                let pixelformat = fourcc.0;
                format.fmt.pix_mp =
                    sys::v4l2_pix_format_mplane { width, height, pixelformat, field, ..pix_mp(&format) };
            }
        }
        call(&self.file, vidioc::VIDIOC_S_FMT, &mut format)?;
        Ok(self.stated(&format))
    }

    fn stated(&self, format: &sys::v4l2_format) -> DriverFormat {
        let none = sys::v4l2_field_V4L2_FIELD_NONE;
        let mut memories = [MemoryPlane::default(); MAX_PLANES];
        match self.planes {
            Planes::Single => {
                let pix = pix(format);
                memories[0] = MemoryPlane { stride: pix.bytesperline, bytes: pix.sizeimage };
                let (width, height) = (pix.width, pix.height);
                let (fourcc, progressive) = (Fourcc(pix.pixelformat), pix.field == none);
                DriverFormat { fourcc, width, height, progressive, count: 1, memories }
            }
            Planes::Multi => {
                let pix = pix_mp(format);
                let all = pix.plane_fmt;
                for (memory, said) in memories.iter_mut().zip(all) {
                    *memory = MemoryPlane { stride: said.bytesperline, bytes: said.sizeimage };
                }
                let (width, height) = (pix.width, pix.height);
                let (fourcc, progressive) = (Fourcc(pix.pixelformat), pix.field == none);
                DriverFormat { fourcc, width, height, progressive, count: pix.num_planes.into(), memories }
            }
        }
    }

    /// The time from frame to frame that is in force, in seconds as numerator and denominator; `None` where the driver has no say in it.
    pub(super) fn frame_time(&self) -> io::Result<Option<[u32; 2]>> {
        let mut parameters = sys::v4l2_streamparm { type_: self.buffer_type(), ..zeroed() };
        let answer = listed(call(&self.file, vidioc::VIDIOC_G_PARM, &mut parameters))?;
        Ok(answer.map(|()| interval_in(&parameters)))
    }

    /// Asks for a time from frame to frame; the answer is what the driver made of it, `None` where it has no say in it.
    pub(super) fn set_frame_time(&self, [numerator, denominator]: [u32; 2]) -> io::Result<Option<[u32; 2]>> {
        let mut parameters = sys::v4l2_streamparm { type_: self.buffer_type(), ..zeroed() };
        let timeperframe = sys::v4l2_fract { numerator, denominator };
        parameters.parm.capture = sys::v4l2_captureparm { timeperframe, ..capture_in(&parameters) };
        let answer = listed(call(&self.file, vidioc::VIDIOC_S_PARM, &mut parameters))?;
        Ok(answer.map(|()| interval_in(&parameters)))
    }

    /// The control with the next number after `id`.
    pub(super) fn control_after(&self, id: u32) -> io::Result<Option<DriverControl>> {
        let mut entry = sys::v4l2_query_ext_ctrl { id: id | sys::V4L2_CTRL_FLAG_NEXT_CTRL, ..zeroed() };
        if listed(call(&self.file, vidioc::VIDIOC_QUERY_EXT_CTRL, &mut entry))?.is_none() {
            return Ok(None);
        }
        let is = |flag: u32| entry.flags & flag != 0;
        Ok(Some(DriverControl {
            id: entry.id,
            kind: if is(sys::V4L2_CTRL_FLAG_DISABLED) {
                ControlKind::Other
            } else {
                control_kind(entry.type_)
            },
            title: text(&entry.name.map(|letter| letter as u8)),
            min: entry.minimum,
            max: entry.maximum,
            step: i64::try_from(entry.step).unwrap_or(i64::MAX),
            default: entry.default_value,
            read_only: is(sys::V4L2_CTRL_FLAG_READ_ONLY | sys::V4L2_CTRL_FLAG_GRABBED),
            inactive: is(sys::V4L2_CTRL_FLAG_INACTIVE),
        }))
    }

    /// What a menu's value means; `None` for a value that the menu does not have.
    pub(super) fn menu_entry(&self, control: &DriverControl, value: i64) -> Option<String> {
        let index = u32::try_from(value).ok()?;
        let mut entry = sys::v4l2_querymenu { id: control.id, index, ..zeroed() };
        call(&self.file, vidioc::VIDIOC_QUERYMENU, &mut entry).ok()?;
        let said = entry.__bindgen_anon_1;
        Some(match control.kind {
            // SAFETY: both members of this union are made of integers.
            ControlKind::NumberMenu => unsafe { said.value }.to_string(),
            // SAFETY: both members of this union are made of integers.
            _ => text(&unsafe { said.name }),
        })
    }

    /// The value of a control.
    pub(super) fn control(&self, id: u32) -> io::Result<i64> {
        let mut control = sys::v4l2_control { id, ..zeroed() };
        call(&self.file, vidioc::VIDIOC_G_CTRL, &mut control)?;
        Ok(control.value.into())
    }

    /// Gives a control a value; the driver may take another.
    pub(super) fn set_control(&self, id: u32, value: i32) -> io::Result<()> {
        call(&self.file, vidioc::VIDIOC_S_CTRL, &mut sys::v4l2_control { id, value })
    }

    /// Whether the driver writes into memory of ours.
    pub(super) fn takes_our_memory(&self) -> io::Result<bool> {
        let said = self.request(Memory::Drivers, 0)?.capabilities;
        if said != 0 {
            return Ok(said & sys::V4L2_BUF_CAP_SUPPORTS_USERPTR != 0);
        }
        // Kernels before 4.20 do not say; asking for none of such buffers is an error where there can be none.
        Ok(self.request(Memory::Ours, 0).is_ok())
    }

    fn request(&self, memory: Memory, count: u32) -> io::Result<sys::v4l2_requestbuffers> {
        let type_ = self.buffer_type();
        let mut buffers = sys::v4l2_requestbuffers { count, type_, memory: memory.code(), ..zeroed() };
        call(&self.file, vidioc::VIDIOC_REQBUFS, &mut buffers)?;
        Ok(buffers)
    }

    fn stream(&self, on: bool) -> io::Result<()> {
        let mut kind = self.buffer_type() as c_int;
        call(&self.file, if on { vidioc::VIDIOC_STREAMON } else { vidioc::VIDIOC_STREAMOFF }, &mut kind)
    }

    /// A call about one buffer. With several planes their descriptions lie in `planes`, which outlives the call.
    fn buffer_call(
        &self,
        request: c_ulong,
        memory: Memory,
        index: usize,
        planes: &mut [sys::v4l2_plane; KERNEL_PLANES],
    ) -> io::Result<sys::v4l2_buffer> {
        let mut buffer: sys::v4l2_buffer = zeroed();
        buffer.index = index as u32;
        buffer.type_ = self.buffer_type();
        buffer.memory = memory.code();
        match self.planes {
            Planes::Single => {
                buffer.length = planes[0].length;
                // An address where the memory is ours; where it is the driver's this is 0 and not read.
                // SAFETY: every member of this union is made of integers.
                buffer.m.userptr = unsafe { planes[0].m.userptr };
            }
            Planes::Multi => {
                buffer.length = KERNEL_PLANES as u32;
                // The kernel reads and writes as many descriptions as `length` says, and so many there are.
                buffer.m.planes = planes.as_mut_ptr();
            }
        }
        call(&self.file, request, &mut buffer)?;
        if self.planes == Planes::Single {
            // SAFETY: as above; the kernel fills in an offset or leaves the address.
            planes[0].m.userptr = unsafe { buffer.m.userptr };
            (planes[0].length, planes[0].bytesused) = (buffer.length, buffer.bytesused);
        }
        Ok(buffer)
    }

    /// The next filled buffer; `None` when there is none yet.
    fn dequeue(&self, memory: Memory) -> io::Result<Option<Dequeued>> {
        let mut planes = [zeroed(); KERNEL_PLANES];
        match self.buffer_call(vidioc::VIDIOC_DQBUF, memory, 0, &mut planes) {
            Ok(buffer) => Ok(Some(dequeued(&buffer, &planes))),
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => Ok(None),
            Err(error) => Err(error),
        }
    }
}

fn control_kind(kind: u32) -> ControlKind {
    match kind {
        sys::v4l2_ctrl_type_V4L2_CTRL_TYPE_INTEGER | sys::v4l2_ctrl_type_V4L2_CTRL_TYPE_BITMASK => {
            ControlKind::Number
        }
        sys::v4l2_ctrl_type_V4L2_CTRL_TYPE_BOOLEAN => ControlKind::Switch,
        sys::v4l2_ctrl_type_V4L2_CTRL_TYPE_MENU => ControlKind::Menu,
        sys::v4l2_ctrl_type_V4L2_CTRL_TYPE_INTEGER_MENU => ControlKind::NumberMenu,
        sys::v4l2_ctrl_type_V4L2_CTRL_TYPE_BUTTON => ControlKind::Button,
        _ => ControlKind::Other,
    }
}

fn pix(format: &sys::v4l2_format) -> sys::v4l2_pix_format {
    // SAFETY: the struct was made of zeros and filled by the kernel; every member of the union takes any bytes.
    unsafe { format.fmt.pix }
}

fn pix_mp(format: &sys::v4l2_format) -> sys::v4l2_pix_format_mplane {
    // SAFETY: the struct was made of zeros and filled by the kernel; every member of the union takes any bytes.
    unsafe { format.fmt.pix_mp }
}

fn capture_in(parameters: &sys::v4l2_streamparm) -> sys::v4l2_captureparm {
    // SAFETY: the struct was made of zeros and filled by the kernel; every member of the union takes any bytes.
    unsafe { parameters.parm.capture }
}

fn interval_in(parameters: &sys::v4l2_streamparm) -> [u32; 2] {
    let interval = capture_in(parameters).timeperframe;
    [interval.numerator, interval.denominator]
}

fn dequeued(buffer: &sys::v4l2_buffer, planes: &[sys::v4l2_plane; KERNEL_PLANES]) -> Dequeued {
    let mut bytes_used = [0; MAX_PLANES];
    for (used, plane) in bytes_used.iter_mut().zip(planes) {
        *used = plane.bytesused;
    }
    let seconds = u64::try_from(buffer.timestamp.tv_sec).unwrap_or(0);
    let micros = u64::try_from(buffer.timestamp.tv_usec).unwrap_or(0);
    let clock = buffer.flags & sys::V4L2_BUF_FLAG_TIMESTAMP_MASK;
    let source = buffer.flags & sys::V4L2_BUF_FLAG_TSTAMP_SRC_MASK;
    Dequeued {
        index: buffer.index as usize,
        bytes_used,
        damaged: buffer.flags & sys::V4L2_BUF_FLAG_ERROR != 0,
        sequence: buffer.sequence,
        stamp_ns: seconds.saturating_mul(1_000_000_000).saturating_add(micros.saturating_mul(1000)),
        monotonic: clock == sys::V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC,
        start_of_exposure: source == sys::V4L2_BUF_FLAG_TSTAMP_SRC_SOE,
    }
}

/// Where one memory of a frame begins in a loan's picture, and its bytes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct MemoryPlace {
    pub(super) offset: usize,
    pub(super) bytes: usize,
}

/// One number of the driver's queue.
struct Slot {
    /// The address that the kernel knows by this number; 0 before the first.
    address: usize,
    loan: Option<Loan>,
}

/// A queue of loans that the driver fills.
pub(super) struct LoanQueue {
    // Dropped first: a closed device writes nowhere, whatever calls before it said.
    port: Port,
    slots: Vec<Slot>,
    places: Vec<MemoryPlace>,
    repins: u64,
}

impl LoanQueue {
    /// Asks the driver for `count` numbers. `places` are the memories of a frame in a loan's picture.
    pub(super) fn new(port: Port, count: u32, places: Vec<MemoryPlace>) -> io::Result<LoanQueue> {
        let granted = port.request(Memory::Ours, count)?.count;
        let slots = (0..granted).map(|_| Slot { address: 0, loan: None }).collect();
        Ok(LoanQueue { port, slots, places, repins: 0 })
    }

    /// The device, to wait for it.
    pub(super) fn port(&self) -> &Port {
        &self.port
    }

    /// Numbers that the driver granted.
    pub(super) fn count(&self) -> usize {
        self.slots.len()
    }

    /// Loans that the driver has.
    pub(super) fn lent(&self) -> usize {
        self.slots.iter().filter(|slot| slot.loan.is_some()).count()
    }

    /// How often memory got a number under which the kernel knew other memory, which it then had to pin anew.
    pub(super) fn repins(&self) -> u64 {
        self.repins
    }

    /// Begins; to be called with loans in the queue.
    pub(super) fn start(&self) -> io::Result<()> {
        self.port.stream(true)
    }

    /// Hands a loan to the driver. It stays here until it is dequeued. Returns the address that the driver writes to.
    pub(super) fn queue(&mut self, mut loan: Loan) -> io::Result<usize> {
        // Exposed, because it is the kernel that writes through it.
        let address = loan.picture().as_mut_ptr().expose_provenance();
        let room = loan.picture().len();
        let fits = |place: &MemoryPlace| place.offset.checked_add(place.bytes).is_some_and(|end| end <= room);
        if !self.places.iter().all(fits) {
            return Err(io::Error::new(
                io::ErrorKind::InvalidInput,
                "a loan is smaller than the driver's frame",
            ));
        }
        let index = self.number_for(address)?;
        let mut planes = [zeroed::<sys::v4l2_plane>(); KERNEL_PLANES];
        for (plane, place) in planes.iter_mut().zip(&self.places) {
            // Within the loan, as checked above; the loan is kept below until the driver gives the number back.
            plane.m.userptr = (address + place.offset) as c_ulong;
            plane.length = place.bytes as u32;
        }
        self.port.buffer_call(vidioc::VIDIOC_QBUF, Memory::Ours, index, &mut planes)?;
        let slot = &mut self.slots[index];
        self.repins += u64::from(slot.address != address && slot.address != 0);
        slot.address = address;
        slot.loan = Some(loan);
        Ok(address)
    }

    /// The number under which the kernel knows this memory; else one that was never used; else any that is free.
    fn number_for(&self, address: usize) -> io::Result<usize> {
        let free = |wanted: &dyn Fn(&Slot) -> bool| {
            self.slots.iter().position(|slot| slot.loan.is_none() && wanted(slot))
        };
        free(&|slot| slot.address == address)
            .or_else(|| free(&|slot| slot.address == 0))
            .or_else(|| free(&|_| true))
            .ok_or_else(|| {
                io::Error::new(io::ErrorKind::InvalidInput, "every buffer is in the driver's queue")
            })
    }

    /// The next filled loan; `None` when there is none yet.
    pub(super) fn dequeue(&mut self) -> io::Result<Option<(Loan, Dequeued)>> {
        let Some(frame) = self.port.dequeue(Memory::Ours)? else { return Ok(None) };
        let loan = self.slots.get_mut(frame.index).and_then(|slot| slot.loan.take());
        let loan =
            loan.ok_or_else(|| io::Error::other(format!("the driver gave back buffer {}", frame.index)))?;
        Ok(Some((loan, frame)))
    }
}

impl Drop for LoanQueue {
    /// Takes every loan back from the driver, before the loans themselves go.
    fn drop(&mut self) {
        // On a device that has gone these fail, and closing it does the same.
        let _ = self.port.stream(false);
        let _ = self.port.request(Memory::Ours, 0);
    }
}

/// A part of the driver's memory in our address space.
#[derive(Debug)]
struct Mapping {
    start: *mut c_void,
    bytes: usize,
}

impl Mapping {
    fn new(port: &Port, bytes: usize, offset: u32) -> io::Result<Mapping> {
        let shared = rustix::mm::MapFlags::SHARED.bits() as i32;
        // Some drivers refuse a mapping that cannot be written.
        let access = (rustix::mm::ProtFlags::READ | rustix::mm::ProtFlags::WRITE).bits() as i32;
        // SAFETY: a new mapping at an address of the kernel's choice touches no memory that exists.
        let start = unsafe {
            v4l2::mmap(ptr::null_mut(), bytes, access, shared, port.file.as_raw_fd(), offset.into())
        }?;
        Ok(Mapping { start, bytes })
    }

    /// The bytes. To be called only while the buffer is ours, between taking it from the driver and giving it back.
    fn bytes(&self) -> &[u8] {
        // SAFETY: the mapping has this length and lives as long as `self`; bytes of a mapping are initialised; the driver
        // does not write between DQBUF and QBUF, and that is the only time when this is called.
        unsafe { slice::from_raw_parts(self.start.cast(), self.bytes) }
    }
}

impl Drop for Mapping {
    fn drop(&mut self) {
        // SAFETY: this is the mapping that `new` made; slices of it are bound to `self`, which nobody borrows any more.
        let _ = unsafe { v4l2::munmap(self.start, self.bytes) };
    }
}

/// A queue of the driver's own buffers.
pub(super) struct MappedQueue {
    port: Port,
    buffers: Vec<Vec<Mapping>>,
}

impl MappedQueue {
    /// Asks for buffers with so many memories each, and queues all of them.
    pub(super) fn new(port: Port, count: u32, memories: usize) -> io::Result<MappedQueue> {
        let granted = port.request(Memory::Drivers, count)?.count as usize;
        let mut queue = MappedQueue { port, buffers: Vec::new() };
        for index in 0..granted {
            let mut planes = [zeroed::<sys::v4l2_plane>(); KERNEL_PLANES];
            queue.port.buffer_call(vidioc::VIDIOC_QUERYBUF, Memory::Drivers, index, &mut planes)?;
            let map = |plane: &sys::v4l2_plane| {
                // SAFETY: every member of this union is made of integers; the kernel wrote an offset.
                Mapping::new(&queue.port, plane.length as usize, unsafe { plane.m.mem_offset })
            };
            let mapped: io::Result<_> = planes.iter().take(memories.max(1)).map(map).collect();
            queue.buffers.push(mapped?);
            queue.give_back(index)?;
        }
        Ok(queue)
    }

    /// The device, to wait for it.
    pub(super) fn port(&self) -> &Port {
        &self.port
    }

    /// Buffers that the driver granted.
    pub(super) fn count(&self) -> usize {
        self.buffers.len()
    }

    /// Begins.
    pub(super) fn start(&self) -> io::Result<()> {
        self.port.stream(true)
    }

    /// Shows the next filled buffer's memories to `look`, then gives it back; `None` when there is none yet.
    pub(super) fn look<R>(&mut self, look: impl FnOnce(&Dequeued, &[&[u8]]) -> R) -> io::Result<Option<R>> {
        let Some(frame) = self.port.dequeue(Memory::Drivers)? else { return Ok(None) };
        let Some(buffer) = self.buffers.get(frame.index) else {
            return Err(io::Error::other(format!("the driver gave back buffer {}", frame.index)));
        };
        let mut memories: [&[u8]; MAX_PLANES] = [&[]; MAX_PLANES];
        for (memory, mapping) in memories.iter_mut().zip(buffer) {
            *memory = mapping.bytes();
        }
        let seen = look(&frame, &memories[..buffer.len().min(MAX_PLANES)]);
        self.give_back(frame.index)?;
        Ok(Some(seen))
    }

    fn give_back(&self, index: usize) -> io::Result<()> {
        let mut planes = [zeroed(); KERNEL_PLANES];
        self.port.buffer_call(vidioc::VIDIOC_QBUF, Memory::Drivers, index, &mut planes).map(drop)
    }
}

impl Drop for MappedQueue {
    fn drop(&mut self) {
        // On a device that has gone this fails, and closing it does the same.
        let _ = self.port.stream(false);
    }
}
