//! The limits of the fit. Each was varied on real and rendered pictures; a limit at which no tag is lost any more was
//! doubled where that costs no time. Lengths are pixels of the search grid.

/// Components whose box is narrower and lower than this together are followed along their contour: re-splitting a
/// contour still works where a side has only a few rows.
pub(super) const CONTOUR_BELOW: usize = 64;

/// The least grey-level difference of the two pixels of an edge.
pub(super) const LEAST_STEP: i32 = 2;

/// A convex outline is as long as its box, 2 (w + h). Blobs with arms are longer.
pub(super) fn longest_outline(width: usize, height: usize) -> f32 {
    (1.35 * 2.0 * (width + height) as f32).trunc() + 8.0
}

/// The largest share of its outline that a black component may fill: inside of a tag's border there is white. None of some
/// 4,000 rendered tags (blur, noise, tilt, motion; decimation 1 to 3) and 488 real ones is lost; at 0.97 two are, at 0.93 a
/// hundredth of them.
pub(super) const FULLEST: f32 = 0.985;
/// Width and height together of a box in which white components are held to that too. Of 1,520 rendered tags at each of the
/// decimations 1, 1.5 and 2 none is lost; at 24 two are, blurred ones.
pub(super) const CELLS_ARE_SEEN_FROM: usize = 32;
/// With more than one component for so many pixels a frame is no picture but a pattern or noise: natural pictures have half as
/// many.
pub(super) const PIXELS_A_COMPONENT: usize = 640;

/// How much is borne of an outline before a side is fitted to pixels.
pub(super) struct Rough {
    /// Share of the shortest side of a tag that the sides between four points of the outline must have: fitting moves a corner
    /// by a pixel or two.
    pub(super) side: f32,
    /// Share of the square on that shortest side that the outline must hold.
    pub(super) area: f32,
    /// Factor of [`longest_outline`].
    pub(super) length: f32,
    /// Factor of [`outline_distance`].
    pub(super) distance: f32,
}

/// Spares two thirds of the fits in noise.
pub(super) const IN_PICTURES: Rough = Rough { side: 0.6, area: 0.25, length: 1.0, distance: 1.0 };
/// In crowded frames: spares another half of the fits in noise. If all frames were taken for crowded, 6 of 1,003 tags would be
/// lost at decimation 1, and 19 of 1,954 at 1.5 to 3.
pub(super) const IN_CROWDS: Rough = Rough { side: 0.8, area: 0.5, length: 0.8, distance: 0.75 };
/// In crowded frames of a search that asks for hardly more contrast than there is noise: there outlines of tags are as rough as others.
pub(super) const IN_NOISE: Rough = Rough { side: 0.8, area: 0.25, length: 1.0, distance: 1.0 };

/// How far the area of the outline may be from that of the quad of its extreme points.
pub(super) fn area_tolerance(area: f32, width: usize, height: usize) -> f32 {
    0.15 * area + 0.25 * (width + height) as f32 + 4.0
}

/// The largest mean distance of the outline's points from the sides of the extreme points' quad.
pub(super) fn outline_distance(area: f32) -> f32 {
    0.8 + 0.02 * area.sqrt()
}

/// The largest root mean square distance of a side's edge points from its line.
pub(super) fn side_error(length: f32) -> f32 {
    1.5 + 0.015 * length
}

/// How far an edge point may lie from where the side is expected: wide at first, narrow once lines are known.
pub(super) fn search_width(first_round: bool, length: f32) -> f32 {
    if first_round { 2.5 + 0.08 * length } else { 1.5 + 0.04 * length }
}

/// Share of a side's points that must be edges, and of all four sides' points together.
pub(super) const EDGE_SHARE_OF_SIDE: f32 = 0.5;
/// See [`EDGE_SHARE_OF_SIDE`].
pub(super) const EDGE_SHARE_OF_ALL: f32 = 0.55;
/// Share of a small contour's points that must be edges.
pub(super) const EDGE_SHARE_OF_CONTOUR: f32 = 0.6;
/// Fewest edge points of a small contour.
pub(super) const LEAST_CONTOUR: usize = 16;

/// Rounds of fitting lines and moving corners.
pub(super) const ROUNDS: usize = 3;
/// Corners that move less than this have settled.
pub(super) const SETTLED: f32 = 0.25;

/// Cosine of the sharpest corner (15 degrees): the paper's critical angle.
pub(super) const SHARPEST_COSINE: f64 = 0.966;
/// Sine of the angle below which two neighbouring sides count as parallel (10 degrees).
pub(super) const PARALLEL_SINE: f64 = 0.17;

/// How far corners may lie outside the component's box: this share of the box and these pixels.
pub(super) const BOX_SLACK: (f64, f64) = (0.05, 3.0);
