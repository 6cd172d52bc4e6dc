//! Frames that take a thread from a tenth of a millisecond to a tenth of a second.

use std::path::Path;

use tagbus_camera::picture::Picture;
use tagbus_scene::{Scene, SceneConfig, Stream};

use super::measure::Failure;
use crate::sweep::load_scaled;

/// Frames that are counted together.
pub(super) struct Group {
    pub(super) name: &'static str,
    pub(super) size: [usize; 2],
    pub(super) pictures: Vec<Picture>,
}

/// Sizes of natural pictures, in pixels.
const NATURAL: [[usize; 2]; 3] = [[640, 480], [1920, 1080], [3840, 2160]];
/// Frames of the moving scene.
const SCENE_FRAMES: [u64; 4] = [0, 30, 60, 90];

/// Natural pictures where there is a folder of them, then rendered and random frames.
pub(super) fn groups(natural: Option<&Path>) -> Result<Vec<Group>, Failure> {
    let mut groups = Vec::new();
    if let Some(folder) = natural {
        for size in NATURAL {
            let pictures = load_scaled(folder, size.map(|side| side as u32))?;
            groups.push(Group { name: "natural", size, pictures });
        }
    }
    for size in [[320, 240], [640, 480], [1920, 1080]] {
        groups.push(Group { name: "moving scene", size, pictures: of_scene(size)? });
    }
    let size = [1920, 1080];
    groups.push(Group { name: "uniform noise", size, pictures: vec![noise(size)] });
    Ok(groups)
}

fn of_scene([width, height]: [usize; 2]) -> Result<Vec<Picture>, Failure> {
    let scene = Scene::new(SceneConfig { width, height, ..SceneConfig::default() })?;
    let rendered = |frame| {
        let mut luma = vec![0; width * height];
        scene.render(frame, &mut luma);
        Picture { width, height, luma }
    };
    Ok(SCENE_FRAMES.map(rendered).into())
}

fn noise([width, height]: [usize; 2]) -> Picture {
    let mut random = Stream::new(1);
    Picture { width, height, luma: (0..width * height).map(|_| random.below(256) as u8).collect() }
}
