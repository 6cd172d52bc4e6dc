//! kornia-apriltag.

use kornia_apriltag::family::TagFamilyKind;
use kornia_apriltag::{AprilTagDecoder, DecodeTagsConfig};
use kornia_image::{Image, ImageSize};
use tagbus_camera::picture::Picture;

use super::{Failure, Hit, Peer};

pub(super) struct Kornia {
    config: DecodeTagsConfig,
    /// Both belong to one size of pictures.
    ready: Option<(AprilTagDecoder, Image<u8, 1>)>,
}

impl Kornia {
    /// `None` for families that are not compared.
    pub(super) fn new(family: &str, factor: usize) -> Option<Self> {
        let kind = match family {
            "tag36h11" => TagFamilyKind::Tag36H11,
            "tagStandard41h12" => TagFamilyKind::TagStandard41H12,
            _ => return None,
        };
        let config = DecodeTagsConfig { downscale_factor: factor, ..DecodeTagsConfig::new(vec![kind]).ok()? };
        Some(Self { config, ready: None })
    }
}

impl Peer for Kornia {
    fn name(&self) -> String {
        "kornia-apriltag 0.2".to_owned()
    }

    fn factor(&self) -> f64 {
        self.config.downscale_factor as f64
    }

    fn variant(&self) -> String {
        String::new()
    }

    fn prepare(&mut self, picture: &Picture) -> Result<(), Failure> {
        let size = ImageSize { width: picture.width, height: picture.height };
        let image = Image::new(size, picture.luma.clone())?;
        let decoder = match self.ready.take() {
            Some((decoder, before)) if before.size() == size => decoder,
            _ => AprilTagDecoder::new(self.config.clone(), size)?,
        };
        self.ready = Some((decoder, image));
        Ok(())
    }

    fn detect(&mut self, _picture: &Picture, hits: &mut Vec<Hit>) {
        let Some((decoder, image)) = &mut self.ready else { return };
        if let Ok(found) = decoder.decode(image) {
            let corners = |tag: &kornia_apriltag::decoder::Detection| {
                tag.quad.corners.map(|corner| [f64::from(corner.x), f64::from(corner.y)])
            };
            hits.extend(found.iter().map(|tag| Hit { id: u32::from(tag.id), corners: corners(tag) }));
        }
        decoder.clear();
    }
}
