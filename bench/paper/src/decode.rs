//! Which tag a quad shows (paper III-C 4 and III-D, figure 4 steps 7 and 8).

use tagbus_family::{Family, Layout};

use crate::grey_model::{GreyModel, centre_of};
use crate::homography::Homography;
use crate::picture::Picture;
use crate::sample::{Sampling, sample};
use crate::sharpen::sharpen;

/// A tag that was read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Reading {
    pub(crate) id: u32,
    pub(crate) hamming: u32,
    /// How often the tag in the picture must be turned counter-clockwise by 90 degrees to stand upright.
    pub(crate) turns: usize,
    /// Mean distance of bits from the threshold, grey levels; of white and of black bits the smaller one.
    pub(crate) margin: f64,
}

/// What is chosen about reading.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reader {
    pub(crate) sampling: Sampling,
    pub(crate) sharpening: f64,
    pub(crate) hamming: u32,
}

impl Reader {
    /// Reads the tag whose border edge has these corners (counter-clockwise as seen); `None` when it is none of the
    /// family, or not wholly in the picture.
    pub(crate) fn read(
        &self,
        picture: &Picture,
        corners: &[[f64; 2]; 4],
        family: &Family,
    ) -> Option<Reading> {
        let values = self.values(picture, corners, family.layout())?;
        let nearest = nearest(family, code_of(&values));
        let bearable = (family.distance() - 1) / 2;
        let margin = margin(&values);
        (nearest.hamming <= self.hamming.min(bearable)).then_some(Reading { margin, ..nearest })
    }

    /// The code that the quad shows, whether or not any family has it; `None` as for [`Reader::read`], but for codes that
    /// are none of the family.
    pub(crate) fn read_code(
        &self,
        picture: &Picture,
        corners: &[[f64; 2]; 4],
        layout: &Layout,
    ) -> Option<u64> {
        self.values(picture, corners, layout).map(|values| code_of(&values))
    }

    /// The value of each bit in the order of the code: grey levels above the threshold, sharpened.
    fn values(&self, picture: &Picture, corners: &[[f64; 2]; 4], layout: &Layout) -> Option<Vec<f64>> {
        let map = Homography::of_corners(corners)?;
        let model = GreyModel::read(picture, &map, layout, self.sampling)?;
        let width = layout.total_width();
        let place = |[x, y]: [i32; 2]| {
            let [x, y] = [x, y].map(|at| (at + layout.margin() as i32) as usize);
            y * width + x
        };
        let mut square = vec![0.0; width * width];
        for cell in layout.bits() {
            let point = centre_of(*cell, layout);
            let grey = sample(picture, map.project(point), self.sampling)?;
            square[place(*cell)] = grey - model.threshold(point);
        }
        let square = sharpen(&square, width, self.sharpening);
        Some(layout.bits().iter().map(|cell| square[place(*cell)]).collect())
    }
}

fn code_of(values: &[f64]) -> u64 {
    values.iter().fold(0, |code, value| code << 1 | u64::from(*value > 0.0))
}

/// The nearest code, never merely the first within reach: every tag of the family in every rotation is compared.
fn nearest(family: &Family, code: u64) -> Reading {
    let mut best = Reading { id: 0, hamming: u32::MAX, turns: 0, margin: 0.0 };
    let mut turned = code;
    for turns in 0..4 {
        for (id, known) in family.codes().iter().enumerate() {
            let hamming = (known ^ turned).count_ones();
            if hamming < best.hamming {
                best = Reading { id: id as u32, hamming, turns, margin: 0.0 };
            }
        }
        turned = family.layout().rotate90(turned);
    }
    best
}

fn margin(values: &[f64]) -> f64 {
    let mean = |is_white: bool| {
        let of_colour = values.iter().filter(|value| (**value > 0.0) == is_white);
        let count = of_colour.clone().count().max(1);
        of_colour.map(|value| value.abs()).sum::<f64>() / count as f64
    };
    mean(true).min(mean(false))
}

/// Corners in the order of the upright tag, bottom-left first, of a quad that was read with so many turns.
pub(crate) fn upright(corners: &[[f64; 2]; 4], turns: usize) -> [[f64; 2]; 4] {
    // Turned counter-clockwise once, the corner that was top-left is at the bottom left.
    [0, 1, 2, 3].map(|k| corners[(k + 4 - turns) % 4])
}

#[cfg(test)]
mod tests {
    use super::*;
    use tagbus_scene::{Photo, Placement, Stream, Tag, Turn, View, corners_of, homography_of, photograph};

    const READER: Reader = Reader { sampling: Sampling::Bilinear, sharpening: 0.25, hamming: 2 };

    #[test]
    fn tags_of_every_family_are_read_from_their_true_corners_wherever_these_begin() {
        let mut random = Stream::new(21);
        for name in Family::PUBLISHED {
            let family = Family::published(name).unwrap();
            for start in 0..4 {
                let id = random.below(family.codes().len() as u64) as u32;
                let turn = Turn {
                    rotation_rad: random.between(0.0, 7.0),
                    tilt_rad: random.between(0.0, 0.9),
                    tilt_direction_rad: random.between(0.0, 7.0),
                };
                let view = View { centre: [160.0, 120.0], cell_px: 9.0, turn, ..View::default() };
                let map = homography_of(family.layout(), &view);
                let placement = Placement::new(Tag::new(&family, id).unwrap(), map);
                let photo =
                    Photo { width: 320, height: 240, blur_sigma: 0.6, noise_sigma: 3.0, ..Photo::default() };
                let picture = Picture::new(320, 240, photograph(&photo, &[placement])).unwrap();
                let corners = corners_of(&map);
                let begun_elsewhere = [0, 1, 2, 3].map(|k| corners[(start + k) % 4]);
                let read = READER.read(&picture, &begun_elsewhere, &family).unwrap();
                assert_eq!((read.id, read.hamming), (id, 0), "{name}");
                assert_eq!(upright(&begun_elsewhere, read.turns), corners, "{name} begun at {start}");
            }
        }
    }

    #[test]
    fn the_nearest_code_wins_over_the_first_one_within_reach() {
        let layout = tagbus_family::Layout::classic(8).unwrap();
        let family =
            Family::new("pair", layout, vec![0b0000_1111_0101_1010, 0b0000_1111_0101_1101], 1).unwrap();
        let found = nearest(&family, 0b0000_1111_0101_1101);
        assert_eq!((found.id, found.hamming), (1, 0));
    }

    #[test]
    fn a_tag_that_is_partly_outside_is_not_read() {
        let family = Family::published("tag36h11").unwrap();
        let picture = Picture::computed(50, 50, |x, y| (x * y) as u8);
        assert_eq!(
            READER.read(&picture, &[[-8.0, 40.0], [20.0, 40.0], [20.0, 10.0], [-8.0, 10.0]], &family),
            None
        );
    }
}
