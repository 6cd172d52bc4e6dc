//! The library itself, of which a process may start one only.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};

use ::libcamera::camera::Camera;
use ::libcamera::camera_manager::CameraManager;
use ::libcamera::properties;
use ::libcamera::stream::StreamRole;
use tagbus_message::frame::Fourcc;

use super::controls;
use crate::devices::{DeviceInfo, FormatInfo, SizeInfo};

/// A second manager in a process ends it, so the second one is refused here.
static IS_STARTED: AtomicBool = AtomicBool::new(false);

/// The library, started; at its end it is stopped.
pub(super) struct Library {
    manager: CameraManager,
}

impl Library {
    /// Starts it.
    pub(super) fn start() -> Result<Library, String> {
        if IS_STARTED.swap(true, Ordering::AcqRel) {
            return Err("libcamera: a process can have one camera of libcamera only: use a process for each"
                .to_owned());
        }
        let manager = CameraManager::new().map_err(|error| {
            IS_STARTED.store(false, Ordering::Release);
            format!("libcamera cannot be started: {error}")
        })?;
        Ok(Library { manager })
    }

    /// The camera of that id, or the first one.
    pub(super) fn find(&self, id: Option<&str>) -> Result<Camera<'static>, String> {
        let found = match id {
            Some(id) => self.manager.get(id),
            None => self.manager.cameras().get(0),
        };
        found.ok_or_else(|| {
            let ids = self.ids();
            let there = if ids.is_empty() { "it knows of no camera".to_owned() } else { format!("cameras: {}", ids.join(" ")) };
            match id {
                Some(id) => format!("libcamera has no camera '{id}'; {there}"),
                None => "libcamera knows of no camera: is it connected, and does its user belong to the group video?".to_owned(),
            }
        })
    }

    fn ids(&self) -> Vec<String> {
        let cameras = self.manager.cameras();
        (0..cameras.len())
            .filter_map(|place| cameras.get(place))
            .map(|camera| camera.id().to_owned())
            .collect()
    }

    /// Its version, as it says it.
    pub(super) fn version(&self) -> &str {
        self.manager.version()
    }
}

impl Drop for Library {
    fn drop(&mut self) {
        // The manager goes after this, and no thread of ours starts another meanwhile: there is one camera in a process.
        let _ = self.manager.stop();
        IS_STARTED.store(false, Ordering::Release);
    }
}

/// What the camera is called by its maker.
pub(super) fn model(camera: &Camera<'_>) -> String {
    camera.properties().get::<properties::Model>().map_or_else(|_| camera.id().to_owned(), |model| model.0)
}

/// Every camera of the library; none when it cannot be started.
pub(crate) fn list() -> Vec<DeviceInfo> {
    let Ok(library) = Library::start() else { return Vec::new() };
    let version = library.version().to_owned();
    let camera = |id: String| library.manager.get(&id).map(|camera| describe(&camera, &version));
    library.ids().into_iter().filter_map(camera).collect()
}

fn describe(camera: &Camera<'_>, version: &str) -> DeviceInfo {
    DeviceInfo {
        path: PathBuf::from(format!("libcamera:{}", camera.id())),
        name: model(camera),
        driver: format!("libcamera {version}"),
        links: Vec::new(),
        formats: formats(camera).ok_or_else(|| "it offers no video".to_owned()),
        controls: controls::list(camera.controls()),
    }
}

fn formats(camera: &Camera<'_>) -> Option<Vec<FormatInfo>> {
    let configuration = camera.generate_configuration(&[StreamRole::VideoRecording])?;
    let stream = configuration.get(0)?;
    let formats = stream.formats();
    let size = |size: ::libcamera::geometry::Size| {
        let pair = (size.width, size.height);
        SizeInfo { min: pair, max: pair, step: (0, 0), rates: Vec::new() }
    };
    let known = formats.pixel_formats();
    let described = known.into_iter().map(|format| FormatInfo {
        format: Fourcc(format.fourcc()),
        description: format!("{format}"),
        sizes: formats.sizes(format).into_iter().map(size).collect(),
    });
    Some(described.collect())
}
