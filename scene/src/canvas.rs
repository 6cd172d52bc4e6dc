//! A rectangle of the picture in linear grey levels, on which tags and clutter are painted.

/// A rectangle of pixels: columns `left..left + width` and rows `top..top + height` of the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Window {
    pub left: usize,
    pub top: usize,
    pub width: usize,
    pub height: usize,
}

impl Window {
    /// The whole of a picture.
    pub(crate) fn whole(width: usize, height: usize) -> Window {
        Window { left: 0, top: 0, width, height }
    }

    /// The pixels that the polygon's bounding box touches, as far as they lie in this window. Empty when it misses
    /// the window or when a point is not finite.
    pub(crate) fn around(&self, polygon: &[[f64; 2]]) -> Window {
        let (left, width) = span(polygon.iter().map(|point| point[0]), self.left, self.width);
        let (top, height) = span(polygon.iter().map(|point| point[1]), self.top, self.height);
        Window { left, top, width, height }
    }

    /// This window with `reach` more pixels on every side, as far as they lie in `limit`.
    pub(crate) fn grown(&self, reach: usize, limit: &Window) -> Window {
        let left = self.left.saturating_sub(reach).max(limit.left);
        let top = self.top.saturating_sub(reach).max(limit.top);
        let right = (self.left + self.width + reach).min(limit.left + limit.width);
        let bottom = (self.top + self.height + reach).min(limit.top + limit.height);
        Window { left, top, width: right.saturating_sub(left), height: bottom.saturating_sub(top) }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.width == 0 || self.height == 0
    }

    /// The rows of the picture that the window covers.
    pub(crate) fn rows(&self) -> std::ops::Range<usize> {
        self.top..self.top + self.height
    }

    /// The columns of the picture that the window covers.
    pub(crate) fn columns(&self) -> std::ops::Range<usize> {
        self.left..self.left + self.width
    }
}

/// The whole pixels that the values span, within `start..start + length`, as start and length.
fn span(values: impl Iterator<Item = f64> + Clone, start: usize, length: usize) -> (usize, usize) {
    if !values.clone().all(f64::is_finite) {
        return (start, 0);
    }
    let inside = |value: f64| value.clamp(start as f64, (start + length) as f64) as usize;
    let low = inside(values.clone().fold(f64::INFINITY, f64::min).floor());
    let high = inside(values.fold(f64::NEG_INFINITY, f64::max).ceil());
    (low, high.saturating_sub(low))
}

/// The pixels of a window, row after row: 0 is black and 255 is white.
#[derive(Clone, Debug, Default)]
pub(crate) struct Canvas {
    pub window: Window,
    pub pixels: Vec<f32>,
}

impl Canvas {
    /// A canvas of one grey level.
    pub(crate) fn plain(window: Window, level: f32) -> Canvas {
        Canvas { window, pixels: vec![level; window.width * window.height] }
    }

    /// Takes on another window; what is on the canvas then is of no use.
    pub(crate) fn move_to(&mut self, window: Window) {
        self.window = window;
        self.pixels.resize(window.width * window.height, 0.0);
    }

    /// The part of a row of the picture that lies in `columns`, both counted in the picture.
    pub(crate) fn row(&self, y: usize, columns: std::ops::Range<usize>) -> &[f32] {
        let start = (y - self.window.top) * self.window.width;
        &self.pixels[start + columns.start - self.window.left..start + columns.end - self.window.left]
    }

    /// The same, to be painted.
    pub(crate) fn row_mut(&mut self, y: usize, columns: std::ops::Range<usize>) -> &mut [f32] {
        let start = (y - self.window.top) * self.window.width;
        &mut self.pixels[start + columns.start - self.window.left..start + columns.end - self.window.left]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_window_around_a_polygon_holds_every_pixel_it_touches() {
        let whole = Window::whole(20, 10);
        let around = whole.around(&[[2.5, 3.0], [7.0, -4.0], [5.0, 8.1]]);
        assert_eq!(around, Window { left: 2, top: 0, width: 5, height: 9 });
    }

    #[test]
    fn a_polygon_outside_or_without_finite_points_has_an_empty_window() {
        let whole = Window::whole(20, 10);
        assert!(whole.around(&[[30.0, 1.0], [40.0, 2.0]]).is_empty());
        assert!(whole.around(&[[-9.0, 1.0], [-4.0, 2.0]]).is_empty());
        assert!(whole.around(&[[f64::NAN, 1.0], [4.0, 2.0]]).is_empty());
    }

    #[test]
    fn a_grown_window_stays_in_its_limit() {
        let limit = Window::whole(20, 10);
        let grown = Window { left: 2, top: 5, width: 5, height: 4 }.grown(3, &limit);
        assert_eq!(grown, Window { left: 0, top: 2, width: 10, height: 8 });
    }
}
