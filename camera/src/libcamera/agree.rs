//! Format and size: asked of the library, taken as it gives them, and what it changed is reported.

use ::libcamera::camera::{ActiveCamera, CameraConfigurationStatus};
use ::libcamera::geometry::Size;
use ::libcamera::pixel_format::PixelFormat;
use ::libcamera::stream::{Stream, StreamRole};
use tagbus_message::frame::Fourcc;

use super::luma::{Luma, USABLE};
use crate::config::SourceOptions;
use crate::format::FrameShape;

/// Requests under way: one is filled, one waits, one is read from, and one is on its way back.
const BUFFERS: u32 = 4;

/// What was agreed with a camera.
pub(super) struct Agreement {
    pub(super) stream: Stream,
    /// The library's format.
    pub(super) format: Fourcc,
    /// What is published.
    pub(super) shape: FrameShape,
    pub(super) luma: Luma,
    /// Bytes from row to row of the first plane.
    pub(super) stride: usize,
    /// What was asked for and is not so.
    pub(super) changed: Vec<String>,
}

/// Asks for what the options say and sets it.
pub(super) fn agree(camera: &mut ActiveCamera<'_>, options: &SourceOptions) -> Result<Agreement, String> {
    let mut configuration =
        camera.generate_configuration(&[StreamRole::VideoRecording]).ok_or("it has no video to give")?;
    let (wanted, asked) = {
        let mut stream = configuration.get_mut(0).ok_or("it has no stream to give")?;
        let wanted = choose(options.format, &offered(&stream.formats()))?;
        let before = stream.get_size();
        let asked = Size {
            width: options.width.unwrap_or(before.width),
            height: options.height.unwrap_or(before.height),
        };
        FrameShape::grey(asked.width, asked.height).map_err(|error| error.to_string())?;
        stream.set_pixel_format(PixelFormat::new(wanted.0, 0));
        stream.set_size(asked);
        stream.set_buffer_count(BUFFERS);
        (wanted, asked)
    };
    if let CameraConfigurationStatus::Invalid = configuration.validate() {
        return Err(format!("it cannot give {wanted} of {}x{}", asked.width, asked.height));
    }
    camera.configure(&mut configuration).map_err(|error| format!("it cannot be configured: {error}"))?;
    let stream = configuration.get(0).ok_or("its stream is gone")?;
    let (given, size) = (Fourcc(stream.get_pixel_format().fourcc()), stream.get_size());
    let mut changed = Vec::new();
    if given != wanted {
        changed.push(format!("{given} instead of {wanted}"));
    }
    if (size.width, size.height) != (asked.width, asked.height) {
        changed.push(format!("{}x{} instead of {}x{}", size.width, size.height, asked.width, asked.height));
    }
    let shape = FrameShape::grey(size.width, size.height).map_err(|error| error.to_string())?;
    let luma = luma_of(given).ok_or_else(|| format!("it gives {given}, which cannot be used"))?;
    let stride = (stream.get_stride() as usize).max(luma.row_bytes(size.width as usize));
    let stream = stream.stream().ok_or("its stream has no name")?;
    Ok(Agreement { stream, format: given, shape, luma, stride, changed })
}

fn luma_of(format: Fourcc) -> Option<Luma> {
    USABLE.into_iter().find(|(code, _)| Fourcc::new(*code) == format).map(|(_, luma)| luma)
}

/// Formats that lie row by row; others are arranged in tiles or compressed.
fn offered(formats: &::libcamera::stream::StreamFormatsRef<'_>) -> Vec<Fourcc> {
    let known = formats.pixel_formats();
    known.into_iter().filter(|format| format.modifier() == 0).map(|format| Fourcc(format.fourcc())).collect()
}

/// The best of the offered formats, or the one that is asked for.
fn choose(asked: Option<Fourcc>, offered: &[Fourcc]) -> Result<Fourcc, String> {
    let usable = USABLE.into_iter().map(|(code, _)| Fourcc::new(code));
    let mut fitting =
        usable.filter(|format| offered.contains(format) && asked.is_none_or(|asked| asked == *format));
    fitting.next().ok_or_else(|| {
        let list = offered.iter().map(ToString::to_string).collect::<Vec<_>>().join(" ");
        match asked {
            Some(asked) => format!("it does not offer {asked}; it offers {list}"),
            None => format!("none of the formats that it offers can be used ({list})"),
        }
    })
}
