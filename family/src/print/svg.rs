//! Pages as SVG, in millimetres.

use super::page::{Ink, Mark, Page, Pattern};
use ::svg::Document;
use ::svg::node::element::{Circle, Line, Path, Text};
use std::fmt::Write;

/// The page as an SVG document whose unit is the millimetre.
pub fn to_svg(page: &Page) -> String {
    let [width, height] = page.size.map(number);
    let blank = Document::new()
        .set("width", format!("{width}mm"))
        .set("height", format!("{height}mm"))
        .set("viewBox", format!("0 0 {width} {height}"));
    page.marks.iter().fold(blank, add).to_string()
}

fn add(document: Document, mark: &Mark) -> Document {
    match mark {
        Mark::Pattern(pattern) => document.add(path(pattern)),
        Mark::Line { from, to, width, ink } => {
            let line = Line::new().set("stroke", colour(*ink)).set("stroke-width", *width);
            let line = line.set("x1", number(from[0])).set("y1", number(from[1]));
            document.add(line.set("x2", number(to[0])).set("y2", number(to[1])))
        }
        Mark::Circle { centre, radius, width, ink } => {
            let circle = Circle::new().set("fill", "none").set("stroke", colour(*ink));
            let circle = circle.set("stroke-width", *width).set("r", number(*radius));
            document.add(circle.set("cx", number(centre[0])).set("cy", number(centre[1])))
        }
        Mark::Text { at, size, text } => {
            let element = Text::new(text).set("font-family", "Helvetica, Arial, sans-serif");
            let element = element.set("font-size", number(*size));
            document.add(element.set("x", number(at[0])).set("y", number(at[1])))
        }
    }
}

fn path(pattern: &Pattern) -> Path {
    let mut data = String::new();
    for polygon in pattern.polygons() {
        for (place, [x, y]) in polygon.enumerate() {
            let command = if place == 0 { 'M' } else { 'L' };
            // Writing to a String cannot fail.
            let _ = write!(data, "{command}{} {}", number(x), number(y));
        }
        data.push('Z');
    }
    Path::new().set("fill", colour(pattern.ink)).set("fill-rule", "evenodd").set("d", data)
}

/// Rounded to tenths of a micrometre, which keeps files short.
fn number(mm: f64) -> f64 {
    (mm * 1e4).round() / 1e4
}

fn colour(ink: Ink) -> &'static str {
    match ink {
        Ink::Black => "#000",
        Ink::Grey => "#808080",
        Ink::White => "#fff",
    }
}

#[cfg(test)]
mod tests {
    use super::super::page::Outlines;
    use super::*;

    #[test]
    fn a_page_is_in_millimetres_and_its_text_is_escaped() {
        let loops = vec![vec![[0, 0], [2, 0], [2, 2]]];
        let part = Outlines { origin: [1.0, 2.0], step_mm: 0.5, loops };
        let pattern = Pattern { parts: vec![part], ink: Ink::Black };
        let text = Mark::Text { at: [1.0, 9.0], size: 3.0, text: "a<b & c".to_owned() };
        let page = Page { size: [215.9, 279.4], marks: vec![Mark::Pattern(pattern), text] };
        let svg = to_svg(&page);
        for part in [
            "width=\"215.9mm\"",
            "height=\"279.4mm\"",
            "viewBox=\"0 0 215.9 279.4\"",
            "M1 2L2 2L2 3Z",
            "a&lt;b &amp; c",
        ] {
            assert!(svg.contains(part), "{part} is not in {svg}");
        }
        assert_eq!(svg, to_svg(&page));
    }
}
