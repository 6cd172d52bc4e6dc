//! The room in which a scene plays: a wall, a floor, things that stand and hang about, and the structure of their
//! surfaces. Everything keeps its proportions whatever the size of the picture.

use crate::canvas::{Canvas, Window};
use crate::coverage::Coverage;
use crate::elementary::sine_cosine_of_turns;
use crate::homography::Point;
use crate::random::{Stream, key_for};
use crate::texture::Clouds;

/// Where the floor begins, as a share of the picture's height.
const HORIZON: f64 = 0.68;
const WALL_LEVEL: f32 = 145.0;
const FLOOR_LEVEL: f32 = 95.0;
const TEXTURE_AMPLITUDE: f32 = 45.0;

/// Things that lie and hang about in a lived-in room, of all sizes down to a few pixels.
const THINGS: usize = 700;
/// Sides of things as shares of the picture's height: small ones are many.
const THING_SIDES: [f64; 2] = [0.004, 0.13];
/// The carpet of a lived-in room: deviation of its grain from the floor, and its coarsest structure in pixels.
const CARPET_AMPLITUDE: f32 = 55.0;
const CARPET_GRAIN_PX: f32 = 12.0;

/// Paints the room and fills it: things of every size, tone and direction on walls and floor, and a carpet. What a
/// detector has to look at is many times as much as in the bare room.
pub(crate) fn paint_full_room(frame: Window, seed: u64) -> Canvas {
    let mut room = Painter {
        canvas: paint_room(frame, seed),
        coverage: Coverage::default(),
        stream: Stream::new(key_for(seed, 3)),
    };
    room.lay_carpet(key_for(seed, 4));
    room.scatter_things();
    room.canvas.pixels.iter_mut().for_each(|pixel| *pixel = pixel.clamp(0.0, 255.0));
    room.canvas
}

/// Paints the room, sharp.
pub(crate) fn paint_room(frame: Window, seed: u64) -> Canvas {
    let mut room = Painter {
        canvas: Canvas::plain(frame, WALL_LEVEL),
        coverage: Coverage::default(),
        stream: Stream::new(key_for(seed, 1)),
    };
    room.paint_floor();
    room.hang_pictures();
    room.place_boxes();
    room.lay_cables();
    add_texture(&mut room.canvas, key_for(seed, 2));
    room.canvas
}

/// Adds the structure of surfaces, so that nothing in the room is of one grey.
fn add_texture(canvas: &mut Canvas, seed: u64) {
    Clouds::new(seed, canvas.window.height as f32 / 4.0).add_to(canvas, TEXTURE_AMPLITUDE);
    canvas.pixels.iter_mut().for_each(|pixel| *pixel = pixel.clamp(0.0, 255.0));
}

/// A canvas on which positions are shares of the picture's width and height.
struct Painter {
    canvas: Canvas,
    coverage: Coverage,
    stream: Stream,
}

impl Painter {
    /// The floor, with joints that run towards a vanishing point in the middle of the picture.
    fn paint_floor(&mut self) {
        self.fill(&[[0.0, HORIZON], [0.0, 1.0], [1.0, 1.0], [1.0, HORIZON]], FLOOR_LEVEL);
        for joint in -6..=6 {
            let (far, near) = (0.5 + 0.06 * f64::from(joint), 0.5 + 0.19 * f64::from(joint));
            self.fill(
                &[[far - 0.001, HORIZON], [near - 0.003, 1.0], [near + 0.003, 1.0], [far, HORIZON]],
                60.0,
            );
        }
        self.fill(&[[0.0, HORIZON - 0.02], [0.0, HORIZON], [1.0, HORIZON], [1.0, HORIZON - 0.02]], 190.0);
    }

    /// Framed pictures on the wall, a little askew.
    fn hang_pictures(&mut self) {
        for _ in 0..7 {
            let middle = [self.stream.between(0.0, 1.0), self.stream.between(0.05, HORIZON - 0.15)];
            let size = [self.stream.between(0.05, 0.14), self.stream.between(0.06, 0.18)];
            let skew = self.stream.between(-0.04, 0.04);
            let (frame, picture) = (self.level(20.0, 90.0), self.level(90.0, 220.0));
            self.fill(&askew(middle, size, skew), frame);
            self.fill(&askew(middle, size.map(|length| 0.82 * length), skew), picture);
        }
    }

    /// Boxes on the floor: a front and a lighter top.
    fn place_boxes(&mut self) {
        for _ in 0..5 {
            let (left, foot) = (self.stream.between(-0.05, 0.95), self.stream.between(0.75, 1.0));
            let (width, height) = (self.stream.between(0.06, 0.18), self.stream.between(0.08, 0.22));
            let (right, top) = (left + width, foot - height);
            let (front, lid) = (self.level(40.0, 140.0), self.level(140.0, 210.0));
            self.fill(&[[left, top], [left, foot], [right, foot], [right, top]], front);
            self.fill(
                &[[left, top], [right, top], [right + 0.03, top - 0.03], [left + 0.03, top - 0.03]],
                lid,
            );
        }
    }

    /// Thin dark lines across everything.
    fn lay_cables(&mut self) {
        for _ in 0..6 {
            let (left, right) = (self.stream.between(0.0, 1.0), self.stream.between(0.0, 1.0));
            let (start, end) = (self.stream.between(-0.3, 0.7), self.stream.between(0.3, 1.3));
            let level = self.level(25.0, 80.0);
            self.fill(&[[start, left], [start, left + 0.006], [end, right + 0.006], [end, right]], level);
        }
    }

    /// Grain on everything below the horizon.
    fn lay_carpet(&mut self, seed: u64) {
        let window = self.canvas.window;
        let mut grain = Canvas::plain(window, 0.0);
        Clouds::new(seed, CARPET_GRAIN_PX).add_to(&mut grain, CARPET_AMPLITUDE);
        let horizon = (HORIZON * window.height as f64) as usize;
        for y in window.rows().skip(horizon) {
            let pixels = self.canvas.row_mut(y, window.columns());
            for (pixel, grain) in pixels.iter_mut().zip(grain.row(y, window.columns())) {
                *pixel += grain;
            }
        }
    }

    /// Rectangles everywhere, turned at random.
    fn scatter_things(&mut self) {
        let shape = self.canvas.window.width as f64 / self.canvas.window.height as f64;
        for _ in 0..THINGS {
            let middle = [self.stream.unit(), self.stream.unit()];
            let [width, height] = [0, 1].map(|_| {
                let share = self.stream.unit();
                THING_SIDES[0] + (THING_SIDES[1] - THING_SIDES[0]) * share * share * share
            });
            let level = self.level(10.0, 240.0);
            let corners = turned(middle, [width, height], self.stream.unit(), shape);
            self.fill(&corners, level);
        }
    }

    fn level(&mut self, low: f64, high: f64) -> f32 {
        self.stream.between(low, high) as f32
    }

    /// Fills a polygon with a grey level.
    fn fill(&mut self, corners: &[Point; 4], level: f32) {
        let frame = self.canvas.window;
        let in_pixels = corners.map(|[x, y]| [x * frame.width as f64, y * frame.height as f64]);
        let window = frame.around(&in_pixels);
        self.coverage.clear_to(window);
        self.coverage.add_polygon(&in_pixels, [1.0, 0.0]);
        for y in window.rows() {
            let pixels = self.canvas.row_mut(y, window.columns());
            for (pixel, [share, _]) in pixels.iter_mut().zip(self.coverage.row(y)) {
                *pixel += share * (level - *pixel);
            }
        }
    }
}

/// A rectangle around `middle`, its upper side moved to the right by `skew` of its height and so on round.
fn askew([x, y]: Point, [width, height]: [f64; 2], skew: f64) -> [Point; 4] {
    let (w, h) = (width / 2.0, height / 2.0);
    let corner = |right: f64, down: f64| [x + right * w - down * skew * h, y + down * h + right * skew * w];
    [corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)]
}

/// A rectangle turned by a part of a whole turn. Lengths are shares of the picture's height, `shape` being its width
/// divided by its height.
fn turned([x, y]: Point, [width, height]: [f64; 2], turns: f64, shape: f64) -> [Point; 4] {
    let (sine, cosine) = sine_cosine_of_turns(turns);
    let corner = |right: f64, down: f64| {
        let (right, down) = (right * width / 2.0, down * height / 2.0);
        [x + (right * cosine - down * sine) / shape, y + right * sine + down * cosine]
    };
    [corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_room_has_structure_everywhere_and_stays_in_range() {
        let room = paint_room(Window::whole(160, 120), 1);
        assert!(room.pixels.iter().all(|pixel| (0.0..=255.0).contains(pixel)));
        for block in room.pixels.chunks_exact(160 * 12) {
            let mean = block.iter().sum::<f32>() / block.len() as f32;
            let variance = block.iter().map(|pixel| (pixel - mean).powi(2)).sum::<f32>() / block.len() as f32;
            assert!(variance > 10.0, "variance {variance}");
        }
    }

    #[test]
    fn every_seed_has_its_own_room() {
        let [one, other] = [1, 2].map(|seed| paint_room(Window::whole(80, 60), seed).pixels);
        assert_ne!(one, other);
    }

    #[test]
    fn a_full_room_has_many_more_edges_than_a_bare_one() {
        let edges =
            |room: &Canvas| room.pixels.windows(2).filter(|pair| (pair[0] - pair[1]).abs() > 20.0).count();
        let frame = Window::whole(320, 240);
        let (bare, full) = (paint_room(frame, 1), paint_full_room(frame, 1));
        assert!(edges(&full) > 3 * edges(&bare), "{} against {}", edges(&full), edges(&bare));
        assert!(full.pixels.iter().all(|pixel| (0.0..=255.0).contains(pixel)));
    }
}
