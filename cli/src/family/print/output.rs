//! The files of a print: all are known before the first is written.

use std::path::{Path, PathBuf};

use tagbus_family::print::{Block, Page, Resolution, to_pdf, to_png, to_svg};

use super::flags::{Format, PrintFlags};
use crate::new_file::{self, Existing};
use crate::outcome::Failure;

/// Deviations below this many millimetres are not worth a word.
const SILENT_MM: f64 = 0.001;

/// What is to be written.
pub(super) struct Output<'a> {
    path: &'a Path,
    format: Format,
    existing: Existing,
    files: Vec<(PathBuf, Vec<u8>)>,
    remark: Option<String>,
}

impl<'a> Output<'a> {
    pub(super) fn new(flags: &'a PrintFlags, format: Format) -> Result<Self, Failure> {
        let path = flags.output.as_deref().ok_or_else(|| Failure::new("give --output, the file to write"))?;
        let existing = if flags.force { Existing::Replace } else { Existing::Keep };
        Ok(Self { path, format, existing, files: Vec::new(), remark: None })
    }

    /// Adds the pages; `block` is one of those on them.
    pub(super) fn add_pages(&mut self, pages: &[Page], block: &Block) -> Result<(), Failure> {
        match self.format {
            Format::Pdf => self.add(self.path.to_owned(), to_pdf(pages)),
            Format::Svg => pages.iter().enumerate().try_for_each(|(place, page)| {
                self.add(self.numbered(place, pages.len()), to_svg(page).into_bytes())
            }),
            Format::Png => self.add_pictures(pages, block),
        }
    }

    fn add_pictures(&mut self, pages: &[Page], block: &Block) -> Result<(), Failure> {
        let Some(size) = pages.first().map(|page| page.size) else { return Ok(()) };
        let resolution = Resolution::of(block, size).ok_or_else(|| {
            Failure::new("the cells are too small for a PNG of at most 10000 pixels along a side: take SVG or PDF, or larger cells")
        })?;
        let off_mm = resolution.deviation * size[0].max(size[1]);
        self.remark = Some(format!(
            "{} pixels a cell, {:.1} dots an inch{}",
            resolution.pixels_a_cell,
            f64::from(resolution.pixels_a_metre) * 0.0254,
            if off_mm.abs() < SILENT_MM {
                String::new()
            } else {
                format!(", {off_mm:+.3} mm off along the longest side")
            }
        ));
        for (place, page) in pages.iter().enumerate() {
            self.add(self.numbered(place, pages.len()), to_png(page, &resolution)?)?;
        }
        Ok(())
    }

    pub(super) fn add_geometry(&mut self, path: &Path, text: String) -> Result<(), Failure> {
        self.add(path.to_owned(), text.into_bytes())
    }

    fn add(&mut self, path: PathBuf, content: Vec<u8>) -> Result<(), Failure> {
        new_file::check(&path, self.existing)?;
        if self.files.iter().any(|(other, _)| *other == path) {
            return Err(Failure::new(format!(
                "{} is both --output and --geometry: name two files",
                path.display()
            )));
        }
        self.files.push((path, content));
        Ok(())
    }

    /// `name-1.svg`, or the path itself where there is one page only.
    fn numbered(&self, place: usize, count: usize) -> PathBuf {
        if count == 1 {
            return self.path.to_owned();
        }
        let stem = self.path.file_stem().unwrap_or_default().to_string_lossy();
        let extension = self.path.extension().map(|extension| format!(".{}", extension.to_string_lossy()));
        self.path.with_file_name(format!("{stem}-{}{}", place + 1, extension.unwrap_or_default()))
    }

    /// Writes all files; gives what to say of them.
    pub(super) fn write(self) -> Result<Vec<String>, Failure> {
        let mut lines = Vec::new();
        for (path, content) in &self.files {
            new_file::write(path, content, self.existing)?;
            lines.push(format!("{}", path.display()));
        }
        lines.extend(self.remark);
        Ok(lines)
    }
}
