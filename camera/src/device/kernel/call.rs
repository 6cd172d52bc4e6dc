//! One call to a video driver, and the unions in the structs that go with it.

use std::fs::File;
use std::io;
use std::mem;
use std::os::fd::AsRawFd;
use std::os::raw::{c_ulong, c_void};
use std::ptr;

use v4l::v4l_sys as sys;
use v4l::v4l2;

/// Planes that the kernel's interface allows a frame; a buffer's description always has room for all of them.
pub(super) const KERNEL_PLANES: usize = sys::VIDEO_MAX_PLANES as usize;

/// Structs of numbers and of unions of numbers, which the kernel wants filled with zeros where nothing is said.
pub(super) trait Plain: Copy {}
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

pub(super) fn zeroed<T: Plain>() -> T {
    // SAFETY: `Plain` is implemented above only, for structs of integers, of arrays and unions of integers, and of raw
    // pointers: zero is a value of each.
    unsafe { mem::zeroed() }
}

/// One call. Repeated when a signal came in between.
pub(super) fn call<T>(file: &File, request: c_ulong, argument: &mut T) -> io::Result<()> {
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
pub(super) fn listed<T>(answer: io::Result<T>) -> io::Result<Option<T>> {
    match answer {
        Ok(entry) => Ok(Some(entry)),
        // ENOTTY: the driver has no such list.
        Err(error) if matches!(error.raw_os_error(), Some(EINVAL | ENOTTY)) => Ok(None),
        Err(error) => Err(error),
    }
}

pub(super) const EINVAL: i32 = rustix::io::Errno::INVAL.raw_os_error();
pub(super) const ENOTTY: i32 = rustix::io::Errno::NOTTY.raw_os_error();

/// Text of a fixed field, up to its first zero.
pub(super) fn text(field: &[u8]) -> String {
    let end = field.iter().position(|&byte| byte == 0).unwrap_or(field.len());
    String::from_utf8_lossy(&field[..end]).into_owned()
}

pub(super) fn pix(format: &sys::v4l2_format) -> sys::v4l2_pix_format {
    // SAFETY: the struct was made of zeros and filled by the kernel; every member of the union takes any bytes.
    unsafe { format.fmt.pix }
}

pub(super) fn pix_mp(format: &sys::v4l2_format) -> sys::v4l2_pix_format_mplane {
    // SAFETY: the struct was made of zeros and filled by the kernel; every member of the union takes any bytes.
    unsafe { format.fmt.pix_mp }
}

pub(super) fn capture_in(parameters: &sys::v4l2_streamparm) -> sys::v4l2_captureparm {
    // SAFETY: the struct was made of zeros and filled by the kernel; every member of the union takes any bytes.
    unsafe { parameters.parm.capture }
}

/// The size in an entry that holds one.
pub(super) fn one_size(entry: &sys::v4l2_frmsizeenum) -> sys::v4l2_frmsize_discrete {
    // SAFETY: every member of this union is made of integers.
    unsafe { entry.__bindgen_anon_1.discrete }
}

/// The sizes in an entry that holds a range.
pub(super) fn range_of_sizes(entry: &sys::v4l2_frmsizeenum) -> sys::v4l2_frmsize_stepwise {
    // SAFETY: every member of this union is made of integers.
    unsafe { entry.__bindgen_anon_1.stepwise }
}

/// The interval in an entry that holds one.
pub(super) fn one_interval(entry: &sys::v4l2_frmivalenum) -> sys::v4l2_fract {
    // SAFETY: every member of this union is made of integers.
    unsafe { entry.__bindgen_anon_1.discrete }
}

/// The intervals in an entry that holds a range.
pub(super) fn range_of_intervals(entry: &sys::v4l2_frmivalenum) -> sys::v4l2_frmival_stepwise {
    // SAFETY: every member of this union is made of integers.
    unsafe { entry.__bindgen_anon_1.stepwise }
}

/// The text of a menu's entry.
pub(super) fn menu_text(entry: sys::v4l2_querymenu) -> String {
    let said = entry.__bindgen_anon_1;
    // SAFETY: both members of this union are made of integers.
    text(&unsafe { said.name })
}

/// The number of an entry of a menu of numbers.
pub(super) fn menu_number(entry: sys::v4l2_querymenu) -> i64 {
    let said = entry.__bindgen_anon_1;
    // SAFETY: both members of this union are made of integers.
    unsafe { said.value }
}

/// Where a plane lies: an address, where the memory is ours.
pub(super) fn plane_address(plane: &sys::v4l2_plane) -> c_ulong {
    // SAFETY: every member of this union is made of integers.
    unsafe { plane.m.userptr }
}

/// Where a plane lies in the driver's memory.
pub(super) fn plane_offset(plane: &sys::v4l2_plane) -> u32 {
    // SAFETY: every member of this union is made of integers; the kernel wrote an offset.
    unsafe { plane.m.mem_offset }
}

/// What the kernel left in a buffer of one memory: its address, or the offset in the driver's.
pub(super) fn buffer_place(buffer: &sys::v4l2_buffer) -> c_ulong {
    // SAFETY: every member of this union is made of integers or is an address, which is a number here.
    unsafe { buffer.m.userptr }
}
