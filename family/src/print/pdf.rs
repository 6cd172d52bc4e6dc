//! Pages as PDF.

use super::page::{Ink, Mark, Page, Pattern};
use pdf_writer::{Content, Finish, Name, Pdf, Rect, Ref, Str};

/// Points of a millimetre.
const POINT: f64 = 72.0 / 25.4;
/// How far the handles of a Bezier curve lie from its ends for a quarter of a circle of radius 1.
const QUARTER: f64 = 0.552_284_75;
const FONT: Name = Name(b"F");
/// Numbers of the objects before the pages.
const CATALOG: i32 = 1;
const TREE: i32 = 2;
const HELVETICA: i32 = 3;

/// The pages as a PDF document, which asks viewers not to scale what they print.
pub fn to_pdf(pages: &[Page]) -> Vec<u8> {
    let mut pdf = Pdf::new();
    let mut catalog = pdf.catalog(Ref::new(CATALOG));
    catalog.pages(Ref::new(TREE));
    catalog.viewer_preferences().pair(Name(b"PrintScaling"), Name(b"None"));
    catalog.finish();
    let page_refs = (0..pages.len()).map(|place| Ref::new(page_number(place)));
    pdf.pages(Ref::new(TREE)).kids(page_refs).count(pages.len() as i32);
    pdf.type1_font(Ref::new(HELVETICA))
        .base_font(Name(b"Helvetica"))
        .encoding_predefined(Name(b"WinAnsiEncoding"));
    for (place, page) in pages.iter().enumerate() {
        add_page(&mut pdf, page_number(place), page);
    }
    pdf.finish()
}

/// The object of a page; its content is the next one.
fn page_number(place: usize) -> i32 {
    HELVETICA + 1 + 2 * place as i32
}

fn add_page(pdf: &mut Pdf, number: i32, page: &Page) {
    let [width, height] = page.size.map(|side| (side * POINT) as f32);
    let mut object = pdf.page(Ref::new(number));
    object.parent(Ref::new(TREE)).media_box(Rect::new(0.0, 0.0, width, height));
    object.contents(Ref::new(number + 1));
    object.resources().fonts().pair(FONT, Ref::new(HELVETICA));
    object.finish();
    let mut canvas = Canvas { content: Content::new(), height_mm: page.size[1] };
    page.marks.iter().for_each(|mark| canvas.add(mark));
    pdf.stream(Ref::new(number + 1), &canvas.content.finish());
}

/// A page's content. PDF counts upwards from the bottom of the page, in points.
struct Canvas {
    content: Content,
    height_mm: f64,
}

impl Canvas {
    fn point(&self, [x, y]: [f64; 2]) -> [f32; 2] {
        [x, self.height_mm - y].map(|mm| (mm * POINT) as f32)
    }

    fn add(&mut self, mark: &Mark) {
        match mark {
            Mark::Pattern(pattern) => self.fill(pattern),
            Mark::Line { from, to, width, ink } => {
                self.pen(*width, *ink);
                self.move_to(*from);
                self.line_to(*to);
                self.content.stroke();
            }
            Mark::Circle { centre, radius, width, ink } => {
                self.pen(*width, *ink);
                self.circle(*centre, *radius);
                self.content.stroke();
            }
            Mark::Text { at, size, text } => self.text(*at, *size, text),
        }
    }

    fn fill(&mut self, pattern: &Pattern) {
        self.content.set_fill_gray(grey(pattern.ink));
        for polygon in pattern.polygons() {
            for (place, corner) in polygon.enumerate() {
                if place == 0 { self.move_to(corner) } else { self.line_to(corner) }
            }
            self.content.close_path();
        }
        self.content.fill_even_odd();
    }

    fn circle(&mut self, [x, y]: [f64; 2], radius: f64) {
        let at = |dx: f64, dy: f64| [x + dx * radius, y + dy * radius];
        self.move_to(at(1.0, 0.0));
        for [dx, dy] in [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]] {
            // A quarter turn leads from (dx, dy) to (-dy, dx).
            let [x1, y1] = self.point(at(dx - dy * QUARTER, dy + dx * QUARTER));
            let [x2, y2] = self.point(at(-dy + dx * QUARTER, dx + dy * QUARTER));
            let [x3, y3] = self.point(at(-dy, dx));
            self.content.cubic_to(x1, y1, x2, y2, x3, y3);
        }
    }

    fn text(&mut self, at: [f64; 2], size: f64, text: &str) {
        let [x, y] = self.point(at);
        self.content.set_fill_gray(grey(Ink::Black)).begin_text();
        self.content.set_font(FONT, (size * POINT) as f32).next_line(x, y);
        self.content.show(Str(&latin(text))).end_text();
    }

    fn pen(&mut self, width: f64, ink: Ink) {
        self.content.set_line_width((width * POINT) as f32).set_stroke_gray(grey(ink));
    }

    fn move_to(&mut self, at: [f64; 2]) {
        let [x, y] = self.point(at);
        self.content.move_to(x, y);
    }

    fn line_to(&mut self, at: [f64; 2]) {
        let [x, y] = self.point(at);
        self.content.line_to(x, y);
    }
}

fn grey(ink: Ink) -> f32 {
    f32::from(ink.level()) / 255.0
}

/// The letters that the built-in font has; others, in names of one's own families, become question marks.
fn latin(text: &str) -> Vec<u8> {
    let byte = |letter: char| match u32::from(letter) {
        code @ (0x20..0x7f | 0xa0..0x100) => code as u8,
        _ => b'?',
    };
    text.chars().map(byte).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_document_has_its_pages_in_points_and_forbids_scaling() {
        let text = Mark::Text { at: [1.0, 9.0], size: 3.0, text: "(é→".to_owned() };
        let pages =
            [Page { size: [210.0, 297.0], marks: vec![text] }, Page { size: [25.4, 50.8], marks: vec![] }];
        let bytes = to_pdf(&pages);
        let pdf = String::from_utf8_lossy(&bytes);
        for part in [
            "/PrintScaling /None",
            "/Count 2",
            "[0 0 595.2756 841.8898]",
            "[0 0 72 144]",
            "/BaseFont /Helvetica",
        ] {
            assert!(pdf.contains(part), "{part} is not in {pdf}");
        }
        assert_eq!(latin("(é→"), b"(\xe9?");
    }
}
