//! The frames on which phases are timed, all of the paper's size.

use std::f64::consts::TAU;
use std::path::Path;

use tagbus_camera::picture::Picture;
use tagbus_family::Family;
use tagbus_scene::{Background, Paper, Photo, Placement, Stream, Tag, Turn, View, homography_of, photograph};

use super::measure::Failure;
use crate::sets::{Renderer, named};
use crate::sweep::load_scaled;

/// One family of either polarity.
pub(super) const FAMILIES: [&str; 2] = ["tag36h11", "tagStandard41h12"];
const SIZE: [u32; 2] = [1296, 964];
/// Frames of a rendered set for each family, by number: distances from 20 to 200 cm, straight on and tilted.
const CHOSEN: [usize; 6] = [0, 3, 7, 10, 14, 18];
/// Columns and rows of the frame full of tags, and the pixels from one to the next.
const GRID: [u64; 2] = [8, 6];
const PITCH_PX: f64 = 160.0;

/// Frames that are counted together.
pub(super) struct Group {
    pub(super) name: &'static str,
    pub(super) frames: Vec<Frame>,
}

pub(super) struct Frame {
    pub(super) picture: Picture,
    /// The family of its tag, whose detectors search it; `None` for all.
    shows: Option<&'static str>,
}

impl Frame {
    /// Whether it is meant for a detector of these families, whose names are joined by `+`.
    pub(super) fn is_for(&self, families: &str) -> bool {
        self.shows.is_none_or(|shown| families.split('+').any(|family| family == shown))
    }
}

/// Natural pictures where there is a folder of them, then rendered frames.
pub(super) fn groups(natural: Option<&Path>) -> Result<Vec<Group>, Failure> {
    let mut groups = Vec::new();
    if let Some(folder) = natural {
        groups.push(Group {
            name: "natural",
            frames: load_scaled(folder, SIZE)?.into_iter().map(for_all).collect(),
        });
    }
    for name in ["textured", "wall"] {
        groups.push(Group { name, frames: of_set(name)? });
    }
    groups.push(Group { name: "many tags", frames: vec![for_all(many_tags()?)] });
    Ok(groups)
}

fn for_all(picture: Picture) -> Frame {
    Frame { picture, shows: None }
}

fn of_set(set: &str) -> Result<Vec<Frame>, Failure> {
    let frame = |(index, family): (usize, &'static str)| -> Result<Frame, Failure> {
        let picture = Renderer::new(named(set)?, Family::published(family)?, 1).frame(index)?.picture;
        Ok(Frame { picture, shows: Some(family) })
    };
    CHOSEN.into_iter().flat_map(|index| FAMILIES.map(|family| (index, family))).map(frame).collect()
}

/// 48 tags, half of each family, on white cards in a room full of things.
fn many_tags() -> Result<Picture, Failure> {
    let families = [Family::published(FAMILIES[0])?, Family::published(FAMILIES[1])?];
    let mut random = Stream::new(1);
    let mut tags = Vec::new();
    for row in 0..GRID[1] {
        for column in 0..GRID[0] {
            let family = &families[((row + column) % 2) as usize];
            let centre = [column, row].map(|at| (at as f64 + 0.5) * PITCH_PX + random.between(-3.0, 3.0));
            tags.push(tag_at(family, centre, &mut random)?);
        }
    }
    let [width, height] = SIZE.map(|side| side as usize);
    let photo = Photo {
        width,
        height,
        background: Background::FullRoom,
        blur_sigma: 0.6,
        noise_sigma: 2.5,
        ..Photo::default()
    };
    Ok(Picture { width, height, luma: photograph(&photo, &tags) })
}

fn tag_at(family: &Family, centre: [f64; 2], random: &mut Stream) -> Result<Placement, Failure> {
    let id = random.below(family.codes().len() as u64) as u32;
    let turn = Turn {
        rotation_rad: random.between(0.0, TAU),
        tilt_rad: random.between(0.0, 40_f64.to_radians()),
        tilt_direction_rad: random.between(0.0, TAU),
    };
    // The diagonal of a card of eleven or twelve cells stays within the pitch.
    let view = View { centre, cell_px: random.between(3.0, 8.0), turn, focal_px: 770.0 };
    let placement = Placement::new(Tag::new(family, id)?, homography_of(family.layout(), &view));
    Ok(Placement { paper: Paper::Sheet { margin_cells: 1.0 }, ..placement })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::peers;

    #[test]
    fn a_frame_with_a_tag_is_searched_for_its_family_and_others_for_all() {
        let picture = || Picture { width: 1, height: 1, luma: vec![0] };
        let frame = Frame { picture: picture(), shows: Some("tag36h11") };
        assert!(frame.is_for("tag36h11") && frame.is_for("tagStandard41h12+tag36h11"));
        assert!(!frame.is_for("tagStandard41h12") && !frame.is_for("tag36h1"));
        assert!(for_all(picture()).is_for("tagStandard41h12"));
    }

    #[test]
    fn every_tag_of_the_frame_full_of_tags_can_be_found() {
        let picture = many_tags().unwrap();
        let mut hits = Vec::new();
        peers::ours(&FAMILIES.join("+"), 1.0).unwrap().detect(&picture, &mut hits);
        assert_eq!(hits.len() as u64, GRID[0] * GRID[1]);
    }
}
