//! Cameras that are Video4Linux devices.
//!
//! ```text
//! identity ─▶ kernel ─▶ agree ─▶ stream ─▶ stamps ─▶ outlet
//! which node  open      format   loans or  moment    header, send, notify
//!             and ask   and rate mappings  checked
//! ```

#[cfg(feature = "v4l")]
mod agree;
#[cfg(feature = "v4l")]
mod controls;
#[cfg(feature = "v4l")]
mod identity;
#[cfg(feature = "v4l")]
#[allow(unsafe_code, reason = "the one place that hands memory to the kernel's video drivers")]
mod kernel;
#[cfg(feature = "v4l")]
mod layout;
#[cfg(feature = "v4l")]
mod list;
#[cfg(feature = "v4l")]
mod refusal;
#[cfg(feature = "v4l")]
mod run;
#[cfg(feature = "v4l")]
mod stream;

mod transfer;

pub use transfer::Transfer;

#[cfg(feature = "v4l")]
pub(crate) use list::ask;
#[cfg(feature = "v4l")]
pub(crate) use run::publish;

/// A build without libclang has no devices, and says so.
#[cfg(not(feature = "v4l"))]
pub(crate) fn publish(
    _config: &crate::config::CameraConfig,
    path: &std::path::Path,
    _stop: &tagbus_message::stop::Stop,
    _report: &mut dyn FnMut(crate::run::CameraEvent),
) -> Result<crate::run::Summary, crate::run::CameraError> {
    let text = format!("{}: {}", path.display(), crate::devices::BUILD_ADVICE);
    Err(crate::source::OpenError::Device(text).into())
}

/// Says why formats are not known; a device without rights is named as such here too.
#[cfg(not(feature = "v4l"))]
pub(crate) fn ask(path: &std::path::Path) -> Result<crate::devices::Answer, String> {
    match std::fs::File::open(path) {
        Err(error) => Err(error.to_string()),
        Ok(_) => Err("built without the feature v4l".to_string()),
    }
}
