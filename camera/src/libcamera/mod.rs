//! Cameras of the system's libcamera: those of the Raspberry Pi's ribbon connector, and all others that it drives.
//!
//! ```text
//! library ─▶ agree ─────▶ session ─────────▶ plane ─▶ luma ─▶ outlet
//! which      format,      requests in the    dma-buf  the one header, send,
//! camera     size, rate   library's thread   mapped   copy    notify
//! ```

#[cfg(feature = "libcamera")]
mod agree;
#[cfg(feature = "libcamera")]
mod controls;
#[cfg(feature = "libcamera")]
mod library;
mod luma;
#[cfg(feature = "libcamera")]
#[allow(unsafe_code, reason = "the one place that borrows a buffer's descriptor from the library")]
mod plane;
#[cfg(feature = "libcamera")]
mod run;
#[cfg(feature = "libcamera")]
mod session;

#[cfg(feature = "libcamera")]
pub(crate) use library::list;
#[cfg(feature = "libcamera")]
pub(crate) use run::publish;

/// Nothing, in a build without the library.
#[cfg(not(feature = "libcamera"))]
pub(crate) fn list() -> Vec<crate::devices::DeviceInfo> {
    Vec::new()
}

/// A build without the library says so, and what works in its stead.
#[cfg(not(feature = "libcamera"))]
pub(crate) fn publish(
    _config: &crate::config::CameraConfig,
    _id: Option<&str>,
    _stop: &tagbus_message::stop::Stop,
    _report: &mut dyn FnMut(crate::run::CameraEvent),
) -> Result<crate::run::Summary, crate::run::CameraError> {
    let text = "this build is not linked with libcamera: build with `--features libcamera` (it needs libcamera-dev 0.4 or later), or use \
                --source rpicam";
    Err(crate::source::OpenError::Device(text.to_owned()).into())
}
