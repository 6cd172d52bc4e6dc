//! Pictures of tags with known truth.
#![forbid(unsafe_code)]

mod random;
pub use random::Stream;

mod elementary;

mod homography;
pub use homography::{Homography, Point, corners_of, project};

mod camera;
pub use camera::{Camera, Pose, Rotation, Turn, View, homography_of};

mod tag;
pub use tag::{Tag, TagError, TrueTag};

mod canvas;
mod coverage;

mod placement;
pub use placement::{Paper, Placement};

mod texture;
pub use texture::Background;

mod blur;

mod exposure;
pub use exposure::Light;

mod photo;
pub use photo::{Photo, photograph};

mod room;
mod orbit;

mod scene;
pub use scene::{Scene, SceneConfig, SceneError, Scratch};
