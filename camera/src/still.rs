//! One picture, again and again.

use std::path::Path;

use crate::config::Repeat;
use crate::format::FrameShape;
use crate::picture;
use crate::source::{Damage, Filled, FrameError, FrameSource, OpenError};

/// One picture, decoded when it is opened. Each frame is a copy of it: 1 copy.
pub(crate) struct StillSource {
    luma: Vec<u8>,
    shape: FrameShape,
    repeat: Repeat,
    is_sent: bool,
}

impl StillSource {
    pub(crate) fn open(path: &Path, repeat: Repeat) -> Result<StillSource, OpenError> {
        let picture = picture::load_grey(path)?;
        let shape = FrameShape::grey(picture.width as u32, picture.height as u32);
        let shape = shape.map_err(|error| OpenError::Shape { path: path.into(), error })?;
        Ok(StillSource { luma: picture.luma, shape, repeat, is_sent: false })
    }
}

impl FrameSource for StillSource {
    fn largest(&self) -> FrameShape {
        self.shape
    }

    fn description(&self) -> &'static str {
        "one picture"
    }

    fn next(&mut self, into: &mut [u8], _damage: &mut Damage) -> Result<Option<Filled>, FrameError> {
        if self.is_sent && self.repeat == Repeat::Once {
            return Ok(None);
        }
        self.is_sent = true;
        into[..self.luma.len()].copy_from_slice(&self.luma);
        Ok(Some(Filled { shape: self.shape, copies: 1 }))
    }
}
