//! The pattern on a screen: drawn with blanks in a terminal, or into the frame buffer of a console.

use std::fs;
use std::io::{self, Write};
use std::os::unix::fs::FileExt as _;
use std::path::{Path, PathBuf};
use std::thread;
use std::time::Duration;

use tagbus_client::Stop;
use tagbus_family::{Grid, Paint};
use tagbus_message::clock::monotonic_ns;

use super::pattern::Pattern;
use crate::Failure;

/// Where a terminal does not say how large it is.
const TERMINAL: [usize; 2] = [80, 24];
/// White cells around the tag in a terminal, whose own background may be dark.
const BORDER: usize = 1;

/// Where the pattern is drawn.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Screen {
    /// This terminal.
    Terminal,
    /// A frame buffer: `/dev/fb0`.
    FrameBuffer(PathBuf),
}

impl Screen {
    /// Draws each tag when its time begins, until a stop is asked for.
    pub(crate) fn show(&self, pattern: &Pattern, stop: &Stop) -> Result<(), Failure> {
        let mut canvas = Canvas::open(self)?;
        canvas.begin()?;
        let outcome = show_on(&mut canvas, pattern, stop);
        canvas.end()?;
        Ok(outcome?)
    }
}

fn show_on(canvas: &mut Canvas, pattern: &Pattern, stop: &Stop) -> io::Result<()> {
    loop {
        let now_ns = monotonic_ns();
        let next_ns = pattern.next_ns(now_ns);
        if stop.wait(Duration::from_nanos(next_ns - now_ns)) {
            return Ok(());
        }
        // A sleep may end a little early by another clock's reckoning.
        while monotonic_ns() < next_ns {
            thread::yield_now();
        }
        if let Some(grid) = pattern.family().grid(pattern.id_at(next_ns)) {
            canvas.draw(&grid)?;
        }
    }
}

enum Canvas {
    Terminal { size: [usize; 2] },
    FrameBuffer { file: fs::File, shape: Shape, picture: Vec<u8> },
}

/// How pixels lie in a frame buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Shape {
    width: usize,
    height: usize,
    /// Bytes from row to row, and of a pixel.
    stride: usize,
    pixel: usize,
}

impl Canvas {
    fn open(screen: &Screen) -> Result<Self, Failure> {
        match screen {
            Screen::Terminal => {
                let size = rustix::termios::tcgetwinsize(io::stdout());
                let size = size.map(|size| [size.ws_col, size.ws_row].map(usize::from));
                Ok(Self::Terminal { size: size.ok().filter(|size| !size.contains(&0)).unwrap_or(TERMINAL) })
            }
            Screen::FrameBuffer(path) => {
                let shape = Shape::of(path)?;
                let file = fs::OpenOptions::new().write(true).open(path);
                let file = file.map_err(|error| format!("{}: {error}", path.display()))?;
                Ok(Self::FrameBuffer { file, shape, picture: vec![0; shape.stride * shape.height] })
            }
        }
    }

    fn begin(&self) -> io::Result<()> {
        self.write_if_terminal("\x1b[?1049h\x1b[?25l\x1b[2J")
    }

    fn end(&self) -> io::Result<()> {
        self.write_if_terminal("\x1b[0m\x1b[?25h\x1b[?1049l")
    }

    fn write_if_terminal(&self, text: &str) -> io::Result<()> {
        match self {
            Self::Terminal { .. } => {
                let mut out = io::stdout().lock();
                out.write_all(text.as_bytes())?;
                out.flush()
            }
            Self::FrameBuffer { .. } => Ok(()),
        }
    }

    fn draw(&mut self, grid: &Grid) -> io::Result<()> {
        match self {
            Self::Terminal { size } => {
                let text = terminal_text(grid, *size);
                self.write_if_terminal(&text)
            }
            Self::FrameBuffer { file, shape, picture } => {
                fill(picture, *shape, grid);
                file.write_all_at(picture, 0)
            }
        }
    }
}

/// A tag as blanks on black and white, two columns to a row, as large as fits.
fn terminal_text(grid: &Grid, [columns, rows]: [usize; 2]) -> String {
    let cells = grid.width() + 2 * BORDER;
    let scale = (columns / (2 * cells)).min(rows / cells).max(1);
    let mut text = String::from("\x1b[H");
    for y in 0..cells * scale {
        for x in 0..cells {
            let colour =
                if is_black(grid, x, y / scale) { "\x1b[48;2;0;0;0m" } else { "\x1b[48;2;255;255;255m" };
            text += colour;
            text.extend(std::iter::repeat_n(' ', 2 * scale));
        }
        text += "\x1b[0m\r\n";
    }
    text
}

/// A cell of the tag with its border.
fn is_black(grid: &Grid, x: usize, y: usize) -> bool {
    let inside = |place: usize| place.checked_sub(BORDER).filter(|&place| place < grid.width());
    match (inside(x), inside(y)) {
        (Some(x), Some(y)) => grid.get(x, y) == Paint::Black,
        _ => false,
    }
}

impl Shape {
    /// As the kernel says it beside the device's name.
    fn of(path: &Path) -> Result<Self, Failure> {
        let name = path.file_name().ok_or("a frame buffer is a file such as /dev/fb0")?;
        let folder = Path::new("/sys/class/graphics").join(name);
        let read = |file: &str| {
            let path = folder.join(file);
            fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))
        };
        let shape = Self::parse(&read("virtual_size")?, &read("stride")?, &read("bits_per_pixel")?);
        Ok(shape.ok_or_else(|| {
            format!("{}: a frame buffer of 16 or 32 bits a pixel is needed", path.display())
        })?)
    }

    fn parse(size: &str, stride: &str, bits: &str) -> Option<Self> {
        let (width, height) = size.trim().split_once(',')?;
        let bits: usize = bits.trim().parse().ok()?;
        let shape = Self {
            width: width.parse().ok()?,
            height: height.parse().ok()?,
            stride: stride.trim().parse().ok()?,
            pixel: bits / 8,
        };
        (matches!(bits, 16 | 32) && shape.stride >= shape.width * shape.pixel).then_some(shape)
    }
}

/// White, and the tag in the middle; black and white are all zeros and all ones in every format.
fn fill(picture: &mut [u8], shape: Shape, grid: &Grid) {
    let cells = grid.width() + 2 * BORDER;
    let scale = (shape.width.min(shape.height) / cells).max(1);
    let corner = [shape.width, shape.height].map(|side| side.saturating_sub(cells * scale) / 2);
    for (y, row) in picture.chunks_exact_mut(shape.stride).enumerate() {
        row.fill(0xff);
        let Some(cell_y) = y.checked_sub(corner[1]).map(|y| y / scale).filter(|&y| y < cells) else {
            continue;
        };
        for cell_x in (0..cells).filter(|&x| is_black(grid, x, cell_y)) {
            let first = (corner[0] + cell_x * scale) * shape.pixel;
            let last = (first + scale * shape.pixel).min(shape.width * shape.pixel);
            row[first.min(last)..last].fill(0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tagbus_detector::{Detector, LumaView, Settings};
    use tagbus_family::Family;

    #[test]
    fn a_tag_in_a_frame_buffer_is_found_by_the_detector() {
        let family = Family::published("tag36h11").unwrap();
        let shape = Shape::parse("320,240\n", "1300\n", "32\n").unwrap();
        assert_eq!(shape, Shape { width: 320, height: 240, stride: 1300, pixel: 4 });
        let mut picture = vec![7; shape.stride * shape.height];
        fill(&mut picture, shape, &family.grid(123).unwrap());
        let luma: Vec<u8> = picture
            .chunks_exact(shape.stride)
            .flat_map(|row| row[..1280].chunks_exact(4).map(|pixel| pixel[0]))
            .collect();
        let mut detector = Detector::new(&[family], &Settings::default()).unwrap();
        let found = detector.detect(&LumaView::grey(&luma, 320, 240).unwrap());
        assert_eq!(found.iter().map(|tag| tag.id).collect::<Vec<_>>(), [123]);
        assert!(Shape::parse("320,240", "960", "24").is_none());
        assert!(Shape::parse("320,240", "100", "32").is_none());
    }

    #[test]
    fn a_tag_in_a_terminal_has_its_cells_and_fits() {
        let grid = Family::published("tag36h11").unwrap().grid(0).unwrap();
        let text = terminal_text(&grid, [80, 24]);
        let lines: Vec<&str> = text.trim_start_matches("\x1b[H").split_terminator("\r\n").collect();
        assert_eq!(lines.len(), 24);
        for (y, line) in lines.iter().enumerate() {
            let cells: Vec<bool> =
                line.split("\x1b[48;2;").skip(1).map(|cell| cell.starts_with("0;0;0m")).collect();
            let expected: Vec<bool> = (0..12).map(|x| is_black(&grid, x, y / 2)).collect();
            assert_eq!(cells, expected, "row {y}");
            assert_eq!(line.matches(' ').count(), 48);
        }
    }
}
