//! The built-in scene as a source.

use tagbus_scene::{Scene, SceneConfig, Scratch};

use crate::config::{DEFAULT_FRAMERATE, SourceOptions};
use crate::format::FrameShape;
use crate::source::{Damage, Filled, FrameError, FrameSource, OpenError};

/// Frames of the built-in scene, rendered straight into their place: 0 copies.
pub(crate) struct SceneSource {
    scene: Scene,
    scratch: Scratch,
    shape: FrameShape,
    frame: u64,
}

impl SceneSource {
    /// Makes the scene with the given seed, in the size and at the rate of the options.
    pub(crate) fn open(seed: u64, options: &SourceOptions) -> Result<SceneSource, OpenError> {
        let defaults = SceneConfig::default();
        let width = options.width.unwrap_or(defaults.width as u32);
        let height = options.height.unwrap_or(defaults.height as u32);
        let shape = FrameShape::grey(width, height);
        let shape = shape.map_err(|error| OpenError::Shape { path: "scene".into(), error })?;
        let framerate = options.pace.framerate().unwrap_or(DEFAULT_FRAMERATE);
        let config =
            SceneConfig { width: width as usize, height: height as usize, framerate, seed, ..defaults };
        let scene = Scene::new(config).map_err(OpenError::Scene)?;
        Ok(SceneSource { scene, scratch: Scratch::default(), shape, frame: 0 })
    }
}

impl FrameSource for SceneSource {
    fn largest(&self) -> FrameShape {
        self.shape
    }

    fn description(&self) -> &'static str {
        "built-in scene"
    }

    fn next(&mut self, into: &mut [u8], _damage: &mut Damage) -> Result<Option<Filled>, FrameError> {
        self.scene.render_with(self.frame, &mut self.scratch, &mut into[..self.shape.bytes()]);
        self.frame += 1;
        Ok(Some(Filled { shape: self.shape, copies: 0 }))
    }
}
