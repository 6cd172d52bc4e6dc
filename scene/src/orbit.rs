//! How the tags of a scene move: each in its own region of the picture, round and round.

use crate::camera::{Camera, Pose, Turn};
use crate::elementary::{sine_cosine, sine_of_turns};
use crate::homography::{Homography, Point};
use crate::random::Stream;
use crate::tag::Tag;
use std::f64::consts::{FRAC_PI_4, TAU};

/// Nests of tags have much smaller cells than single tags; from this many cells across the print they get more room.
const CELLS_OF_A_LARGE_PRINT: f64 = 20.0;
/// The share of the picture that large prints get when there are others.
const SHARE_OF_LARGE_PRINTS: f64 = 0.58;

/// A rectangle of the picture, in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Region {
    pub left: f64,
    pub top: f64,
    pub width: f64,
    pub height: f64,
}

impl Region {
    fn middle(&self) -> Point {
        [self.left + self.width / 2.0, self.top + self.height / 2.0]
    }

    /// The first `share` of the region and the rest, cut across its longer side.
    fn split(&self, share: f64) -> (Region, Region) {
        if self.width >= self.height {
            let first = Region { width: self.width * share, ..*self };
            (first, Region { left: self.left + first.width, width: self.width - first.width, ..*self })
        } else {
            let first = Region { height: self.height * share, ..*self };
            (first, Region { top: self.top + first.height, height: self.height - first.height, ..*self })
        }
    }

    /// At least `count` equal parts, in the rows and columns that leave the most room to each.
    fn grid(&self, count: usize) -> Vec<Region> {
        let side =
            |columns: usize| (self.width / columns as f64).min(self.height / count.div_ceil(columns) as f64);
        let columns = (1..=count).max_by(|&a, &b| side(a).total_cmp(&side(b))).unwrap_or(1);
        let (width, height) = (self.width / columns as f64, self.height / count.div_ceil(columns) as f64);
        let part = |index: usize| Region {
            left: self.left + width * (index % columns) as f64,
            top: self.top + height * (index / columns) as f64,
            width,
            height,
        };
        (0..count).map(part).collect()
    }
}

/// A region of the picture for each of the tags, in their order.
pub(crate) fn regions_for(tags: &[Tag], width: usize, height: usize) -> Vec<Region> {
    let frame = Region { left: 0.0, top: 0.0, width: width as f64, height: height as f64 };
    let large = tags.iter().filter(|tag| is_large(tag)).count();
    let (for_large, for_small) = match large {
        0 => (frame, frame),
        _ if large == tags.len() => (frame, frame),
        _ => frame.split(SHARE_OF_LARGE_PRINTS),
    };
    let mut large_regions = for_large.grid(large).into_iter();
    let mut small_regions = for_small.grid(tags.len() - large).into_iter();
    tags.iter()
        .filter_map(|tag| if is_large(tag) { large_regions.next() } else { small_regions.next() })
        .collect()
}

fn is_large(tag: &Tag) -> bool {
    tag.cells_across() > CELLS_OF_A_LARGE_PRINT
}

/// The limits of a tag's movement.
struct Limits {
    /// Largest angle between the tag's axis and the line of sight.
    tilt_rad: f64,
    /// Largest rotation to either side in the tag's own plane; `None` when the tag goes round and round.
    swing_rad: Option<f64>,
    /// Smallest size against the largest one.
    smallest: f64,
}

const SMALL_LIMITS: Limits = Limits { tilt_rad: 50.0 / 360.0 * TAU, swing_rad: None, smallest: 0.85 };
/// Large prints move less, because the tags in their holes have few pixels to lose.
const LARGE_LIMITS: Limits = Limits { tilt_rad: 30.0 / 360.0 * TAU, swing_rad: Some(0.3), smallest: 0.92 };

/// One quantity that swings to and fro: a whole number of times a round.
struct Swing {
    swings: f64,
    phase: f64,
}

impl Swing {
    fn new(stream: &mut Stream) -> Swing {
        Swing { swings: 1.0 + stream.below(3) as f64, phase: stream.unit() }
    }

    /// Between -1 and 1; `round` counts rounds.
    fn at(&self, round: f64) -> f64 {
        sine_of_turns(self.swings * round + self.phase)
    }
}

/// The closed curve of one tag through position, distance and attitude. A round takes all of it back to its start.
pub(crate) struct Orbit {
    region: Region,
    limits: &'static Limits,
    /// Half the width of the print in units of half the border edge.
    print_radius: f64,
    across: Swing,
    down: Swing,
    nearness: Swing,
    tilt: Swing,
    spin: Swing,
    /// Whole turns that the direction of the tilt and the rotation make in a round.
    tilt_turns: f64,
    spin_turns: f64,
}

impl Orbit {
    /// How much of its region a tag may fill; the rest absorbs the blur and the bend of perspective off the axis.
    const FILL: f64 = 0.93;

    pub(crate) fn new(tag: &Tag, region: Region, stream: &mut Stream) -> Orbit {
        Orbit {
            region,
            limits: if is_large(tag) { &LARGE_LIMITS } else { &SMALL_LIMITS },
            print_radius: tag.print_radius(),
            across: Swing::new(stream),
            down: Swing::new(stream),
            nearness: Swing::new(stream),
            tilt: Swing::new(stream),
            spin: Swing::new(stream),
            tilt_turns: if stream.below(2) == 0 { 1.0 } else { -1.0 },
            spin_turns: if stream.below(2) == 0 { 2.0 } else { -2.0 },
        }
    }

    /// Where the tag is after so many rounds.
    pub(crate) fn homography(&self, camera: &Camera, round: f64) -> Homography {
        let smallest = self.limits.smallest;
        let size = smallest + (1.0 - smallest) * (0.5 + 0.5 * self.nearness.at(round));
        let direction = camera.direction_of(self.centre(size, round));
        let length = direction.iter().map(|value| value * value).sum::<f64>().sqrt();
        // Seen off the axis, a tag is magnified by length^2 in the radial direction: keep that one as wanted.
        let nearer = camera.focal_px * length / (size * self.unit_px(camera));
        let pose = Pose {
            rotation: self.turn(round).rotation_towards(direction),
            translation: direction.map(|value| value * nearer),
        };
        camera.homography_of(&pose, 1.0)
    }

    /// The centre of a tag of this relative size: it swings as far as the region leaves room for it.
    fn centre(&self, size: f64, round: f64) -> Point {
        let [x, y] = self.region.middle();
        let radius = self.largest_radius_px() * size / Orbit::FILL;
        let room = |length: f64| length / 2.0 - radius;
        [
            x + room(self.region.width) * self.across.at(round),
            y + room(self.region.height) * self.down.at(round),
        ]
    }

    fn turn(&self, round: f64) -> Turn {
        let turns = |whole: f64, phase: f64| TAU * (whole * round + phase).fract();
        Turn {
            rotation_rad: match self.limits.swing_rad {
                Some(swing_rad) => swing_rad * self.spin.at(round),
                None => turns(self.spin_turns, self.spin.phase),
            },
            tilt_rad: self.limits.tilt_rad * (0.5 + 0.5 * self.tilt.at(round)),
            tilt_direction_rad: turns(self.tilt_turns, self.tilt.phase),
        }
    }

    /// How far from its centre a tag may reach, in pixels, along the picture's axes.
    fn largest_radius_px(&self) -> f64 {
        Orbit::FILL * self.region.width.min(self.region.height) / 2.0
    }

    /// Pixels of half a border edge when the tag is nearest: what reaches out farthest, a corner of the print coming
    /// nearer by the tilt, still keeps within the largest radius.
    fn unit_px(&self, camera: &Camera) -> f64 {
        let (sine, cosine) =
            sine_cosine(self.limits.swing_rad.map_or(FRAC_PI_4, |swing| swing.min(FRAC_PI_4)));
        let reach = self.print_radius * (sine + cosine);
        let corner = self.print_radius * std::f64::consts::SQRT_2;
        let (tilt, _) = sine_cosine(self.limits.tilt_rad);
        let largest = self.largest_radius_px();
        largest / (reach + largest * corner * tilt / camera.focal_px)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::homography::project;
    use tagbus_family::Family;

    fn single(name: &str) -> Tag {
        Tag::new(&Family::published(name).unwrap(), 0).unwrap()
    }

    fn nest() -> Tag {
        single("tagCustom48h12").nest(single("tagStandard41h12")).unwrap()
    }

    fn print_corners(tag: &Tag, homography: &Homography) -> [Point; 4] {
        let radius = tag.print_radius();
        [[-radius, -radius], [radius, -radius], [radius, radius], [-radius, radius]]
            .map(|corner| project(homography, corner))
    }

    fn contains(region: &Region, [x, y]: Point) -> bool {
        (region.left..=region.left + region.width).contains(&x)
            && (region.top..=region.top + region.height).contains(&y)
    }

    fn overlap(a: &Region, b: &Region) -> bool {
        const ROUNDING: f64 = 1e-6;
        a.left + a.width > b.left + ROUNDING
            && b.left + b.width > a.left + ROUNDING
            && a.top + a.height > b.top + ROUNDING
            && b.top + b.height > a.top + ROUNDING
    }

    #[test]
    fn every_print_stays_in_its_region_on_its_whole_way() {
        let mut stream = Stream::new(61);
        for case in 0..60 {
            let size = [16 + stream.below(2000) as usize, 16 + stream.below(2000) as usize];
            let tags: Vec<Tag> = (0..1 + stream.below(9))
                .map(|_| match stream.below(10) {
                    9 => nest(),
                    index => single(Family::PUBLISHED[index as usize]),
                })
                .collect();
            let camera = Camera::with_field_of_view(size[0], size[1], TAU / 6.0);
            for (tag, region) in tags.iter().zip(regions_for(&tags, size[0], size[1])) {
                let orbit = Orbit::new(tag, region, &mut stream);
                for step in 0..300 {
                    let corners = print_corners(tag, &orbit.homography(&camera, f64::from(step) / 300.0));
                    let inside = corners.iter().all(|&corner| contains(&region, corner));
                    assert!(inside, "case {case}, step {step}, {size:?}: {corners:?} in {region:?}");
                }
            }
        }
    }

    #[test]
    fn regions_do_not_overlap_and_nests_get_more_room() {
        for count in 1..12 {
            let mut tags: Vec<Tag> = (0..count).map(|_| single("tag16h5")).collect();
            tags.insert(count / 2, nest());
            let regions = regions_for(&tags, 640, 480);
            assert_eq!(regions.len(), tags.len());
            for (index, region) in regions.iter().enumerate() {
                assert!(regions[..index].iter().all(|other| !overlap(region, other)));
            }
            assert!(regions[count / 2].width > 0.5 * 640.0);
        }
        assert!(regions_for(&[], 640, 480).is_empty());
    }

    #[test]
    fn after_a_round_a_tag_is_back_and_in_between_it_moves_smoothly() {
        let camera = Camera::with_field_of_view(640, 480, TAU / 6.0);
        let tag = single("tag36h11");
        let region = Region { left: 0.0, top: 0.0, width: 200.0, height: 160.0 };
        let orbit = Orbit::new(&tag, region, &mut Stream::new(62));
        let at = |round: f64| print_corners(&tag, &orbit.homography(&camera, round));
        let farthest = |a: [Point; 4], b: [Point; 4]| {
            let distances = a.iter().zip(&b).map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1]));
            distances.fold(0.0, f64::max)
        };
        assert!(farthest(at(0.0), at(1.0)) < 1e-6);
        assert!(farthest(at(0.0), at(0.5)) > 5.0);
        for step in 0..2400 {
            let round = f64::from(step) / 2400.0;
            assert!(farthest(at(round), at(round + 1.0 / 2400.0)) < 3.0, "jump at {round}");
        }
    }
}
