//! Parameters as people write them: the names are those of the flags of `tagbus service`.

use std::fmt;
use std::str::FromStr;

use super::parameters::{DetectorParameters, Region};

impl DetectorParameters {
    /// Each parameter's name and value, in the order of the flags of `tagbus service`.
    #[must_use]
    pub fn named(&self) -> [(&'static str, String); 11] {
        let hamming = self.hamming.map_or("default".to_owned(), |bits| bits.to_string());
        let region = self.region.map_or("none".to_owned(), |region| region.to_string());
        [
            ("family", self.families.join(",")),
            ("decimate", self.decimation.to_string()),
            ("sampling", self.sampling.name().to_owned()),
            ("search", self.search.name().to_owned()),
            ("threads", self.threads.to_string()),
            ("hamming", hamming),
            ("refine", self.refinement.name().to_owned()),
            ("sharpening", self.sharpening.to_string()),
            ("ids", ids_text(&self.ids)),
            ("min-margin", self.min_margin.to_string()),
            ("region", region),
        ]
    }
}

fn ids_text(ranges: &[(u32, u32)]) -> String {
    let one = |&(first, last): &(u32, u32)| {
        if first == last { first.to_string() } else { format!("{first}-{last}") }
    };
    match ranges {
        [] => "all".to_owned(),
        ranges => ranges.iter().map(one).collect::<Vec<_>>().join(","),
    }
}

impl fmt::Display for Region {
    /// `X,Y,WIDTHxHEIGHT`, from which it is read back.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { x, y, width, height } = self;
        write!(f, "{x},{y},{width}x{height}")
    }
}

impl FromStr for Region {
    type Err = RegionTextError;

    fn from_str(text: &str) -> Result<Self, RegionTextError> {
        let number = |text: &str| text.trim().parse().ok();
        let parse = || {
            let mut parts = text.split(',');
            let (x, y, size) = (parts.next()?, parts.next()?, parts.next()?);
            let (width, height) = size.split_once('x')?;
            let region =
                Self { x: number(x)?, y: number(y)?, width: number(width)?, height: number(height)? };
            (parts.next().is_none() && region.width > 0 && region.height > 0).then_some(region)
        };
        parse().ok_or_else(|| RegionTextError(text.to_owned()))
    }
}

/// A text that is no region.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RegionTextError(pub String);

impl fmt::Display for RegionTextError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "\"{}\" is no region: write it as X,Y,WIDTHxHEIGHT in pixels, such as 100,50,640x360",
            self.0
        )
    }
}

impl std::error::Error for RegionTextError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_region_is_read_back_from_what_it_prints_and_other_texts_are_refused() {
        let region = Region { x: 100, y: 50, width: 640, height: 360 };
        assert_eq!(region.to_string(), "100,50,640x360");
        assert_eq!(region.to_string().parse(), Ok(region));
        for text in ["", "1,2", "1,2,3", "1,2,0x5", "1,2,5x0", "-1,2,3x4", "1,2,3x4,5", "1,2,3x99999999999"] {
            let error = text.parse::<Region>().unwrap_err().to_string();
            assert!(error.contains("WIDTHxHEIGHT"), "{error}");
        }
    }
}
