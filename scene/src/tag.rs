//! What is printed, and what is known about it once it lies in a picture.

use crate::homography::{Homography, Point, after_scale_and_shift, corners_of, depth_of, smallest_scale};
use std::fmt;
use tagbus_family::{Family, Grid, Paint};

/// One printed tag, with another one in its hole if it has been nested.
#[derive(Clone, Debug)]
pub struct Tag {
    family: String,
    id: u32,
    grid: Grid,
    width_at_border: usize,
    hole_width: usize,
    inner: Option<Box<Tag>>,
}

/// Why a tag cannot be made.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum TagError {
    /// The family has fewer tags than that.
    Id {
        /// The family's name.
        family: String,
        /// The id asked for.
        id: u32,
        /// How many ids there are, starting from 0.
        count: usize,
    },
    /// A tag was to be nested in one that has no hole.
    NoHole {
        /// The outer family's name.
        family: String,
    },
}

impl fmt::Display for TagError {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        match self {
            TagError::Id { family, id, count } => {
                write!(formatter, "{family} has no id {id}: its {count} ids start from 0")
            }
            TagError::NoHole { family } => {
                write!(
                    formatter,
                    "{family} has no hole for another tag: nest in a family such as tagCustom48h12"
                )
            }
        }
    }
}

impl std::error::Error for TagError {}

impl Tag {
    /// The tag with this id.
    ///
    /// # Errors
    /// [`TagError::Id`] when the family has no such id.
    pub fn new(family: &Family, id: u32) -> Result<Tag, TagError> {
        let count = family.codes().len();
        let missing = || TagError::Id { family: family.name().to_owned(), id, count };
        let layout = family.layout();
        Ok(Tag {
            family: family.name().to_owned(),
            id,
            grid: family.grid(id).ok_or_else(missing)?,
            width_at_border: layout.width_at_border(),
            hole_width: layout.hole_width(),
            inner: None,
        })
    }

    /// This tag with `inner` in its hole: the whole print of the inner tag, upright, fills the hole exactly. The
    /// inner tag may have an inner tag itself.
    ///
    /// # Errors
    /// [`TagError::NoHole`] when no centred square of this tag's cells is left clear.
    pub fn nest(mut self, inner: Tag) -> Result<Tag, TagError> {
        if self.hole_width == 0 {
            return Err(TagError::NoHole { family: self.family });
        }
        self.inner = Some(Box::new(inner));
        Ok(self)
    }

    /// The family's name, for example `tag36h11`.
    pub fn family(&self) -> &str {
        &self.family
    }

    /// The tag's number in its family.
    pub fn id(&self) -> u32 {
        self.id
    }

    /// The print, cell by cell.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The tag in the hole.
    pub fn inner(&self) -> Option<&Tag> {
        self.inner.as_deref()
    }

    /// Half the width of the print in tag coordinates, in which half the border edge is 1.
    pub fn print_radius(&self) -> f64 {
        self.grid.width() as f64 / self.width_at_border as f64
    }

    /// How many cells of the smallest tag in this nest of tags the outermost print is wide.
    pub(crate) fn cells_across(&self) -> f64 {
        let width = self.grid.width() as f64;
        let nested = |inner: &Tag| inner.cells_across() * width / self.hole_width as f64;
        self.inner().map_or(width, |inner| width.max(nested(inner)))
    }

    /// What the cell (x, y) of the print shows, and `Clear` outside the print.
    pub(crate) fn paint_at(&self, x: i64, y: i64) -> Paint {
        let inside = 0..self.grid.width() as i64;
        if inside.contains(&x) && inside.contains(&y) {
            self.grid.get(x as usize, y as usize)
        } else {
            Paint::Clear
        }
    }

    /// From cells of the print, (0, 0) being the print's top-left corner, to where tag coordinates lead.
    pub(crate) fn cells_to_pixels(&self, homography: &Homography) -> Homography {
        after_scale_and_shift(homography, 2.0 / self.width_at_border as f64, -self.print_radius())
    }

    /// The homography of the inner tag when this one has the homography given.
    pub(crate) fn homography_in_hole(&self, inner: &Tag, homography: &Homography) -> Homography {
        let hole_radius = self.hole_width as f64 / self.width_at_border as f64;
        after_scale_and_shift(homography, hole_radius / inner.print_radius(), 0.0)
    }

    /// What is to be found of this tag and the tags nested in it, the outermost first, in a picture of that size.
    pub fn truth(&self, homography: &Homography, width: usize, height: usize) -> Vec<TrueTag> {
        let mut truth = vec![self.own_truth(homography, width, height)];
        if let Some(inner) = self.inner() {
            truth.extend(inner.truth(&self.homography_in_hole(inner, homography), width, height));
        }
        truth
    }

    fn own_truth(&self, homography: &Homography, width: usize, height: usize) -> TrueTag {
        let corners = corners_of(homography);
        let inside = |[x, y]: &Point| (0.0..=width as f64).contains(x) && (0.0..=height as f64).contains(y);
        let in_front = self.in_front_of_camera(homography);
        TrueTag {
            family: self.family.clone(),
            id: self.id,
            corners,
            homography: *homography,
            visible: in_front && corners.iter().all(inside),
            cell_px: smallest_scale(homography) * 2.0 / self.width_at_border as f64,
        }
    }

    /// Whether the whole print lies in front of the camera; otherwise it has no picture.
    pub(crate) fn in_front_of_camera(&self, homography: &Homography) -> bool {
        let radius = self.print_radius();
        let corners = [[-radius, -radius], [radius, -radius], [radius, radius], [-radius, radius]];
        homography.iter().all(|entry| entry.is_finite())
            && corners.iter().all(|&corner| depth_of(homography, corner) > 0.0)
    }
}

/// A tag that is in the picture, and where exactly.
#[derive(Clone, Debug, PartialEq)]
pub struct TrueTag {
    /// The family's name, for example `tag36h11`.
    pub family: String,
    /// The tag's number in its family.
    pub id: u32,
    /// The corners of the border edge in pixels, in the order of [`corners_of`].
    pub corners: [Point; 4],
    /// From the border square [-1, 1]^2 to pixels.
    pub homography: Homography,
    /// Whether all four corners lie inside the picture.
    pub visible: bool,
    /// The smallest width of a cell in pixels: across the slant, at the farthest corner.
    pub cell_px: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    const UPRIGHT: Homography = [60.0, 0.0, 100.0, 0.0, 60.0, 100.0, 0.0, 0.0, 1.0];

    fn tag(family: &str, id: u32) -> Tag {
        Tag::new(&Family::published(family).unwrap(), id).unwrap()
    }

    #[test]
    fn the_inner_tag_fills_the_hole_exactly() {
        let nested = tag("tagCustom48h12", 5).nest(tag("tagStandard41h12", 9)).unwrap();
        let truth = nested.truth(&UPRIGHT, 200, 200);
        assert_eq!((truth[1].family.as_str(), truth[1].id), ("tagStandard41h12", 9));
        // Border 6 cells of 20 px; the hole is 2 cells wide, of which the inner border edge takes 5/9.
        let half_side = 20.0 * 5.0 / 9.0;
        let expected = [[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]];
        for (corner, sign) in truth[1].corners.iter().zip(expected) {
            assert!((corner[0] - (100.0 + sign[0] * half_side)).abs() < 1e-9);
            assert!((corner[1] - (100.0 + sign[1] * half_side)).abs() < 1e-9);
        }
        assert!((truth[1].cell_px - 40.0 / 9.0).abs() < 1e-9);
        assert!((nested.cells_across() - 45.0).abs() < 1e-9);
    }

    #[test]
    fn nests_may_be_deeper_than_two() {
        let middle = tag("tagCustom48h12", 1).nest(tag("tag36h11", 2)).unwrap();
        let nested = tag("tagCustom48h12", 0).nest(middle).unwrap();
        let ids: Vec<u32> = nested.truth(&UPRIGHT, 200, 200).iter().map(|tag| tag.id).collect();
        assert_eq!(ids, [0, 1, 2]);
    }

    #[test]
    fn a_tag_without_a_hole_takes_no_inner_tag() {
        let refused = tag("tag36h11", 0).nest(tag("tag16h5", 0)).unwrap_err();
        assert_eq!(refused, TagError::NoHole { family: "tag36h11".to_owned() });
        assert!(refused.to_string().contains("tag36h11 has no hole"));
    }

    #[test]
    fn an_id_that_does_not_exist_is_an_error_that_says_how_many_there_are() {
        let refused = Tag::new(&Family::published("tag16h5").unwrap(), 30).unwrap_err();
        assert_eq!(refused.to_string(), "tag16h5 has no id 30: its 30 ids start from 0");
    }

    #[test]
    fn a_tag_with_a_corner_outside_the_picture_is_not_visible() {
        let tag = tag("tag36h11", 0);
        assert!(tag.truth(&UPRIGHT, 200, 200)[0].visible);
        assert!(!tag.truth(&UPRIGHT, 159, 200)[0].visible);
    }
}
