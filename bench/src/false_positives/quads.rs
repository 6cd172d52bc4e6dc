//! What every quad of every picture shows: the paper's detector up to the sampled code.

use image::GrayImage;
use tagbus_family::Family;
use tagbus_paper::{Options, OptionsError, Pipeline};

use super::variants::{SCALES, TURNS_DEG, variant};
use crate::sweep::bar;

/// For each family the codes of the quads of each place, in all sizes and rotations of its pictures.
pub(super) fn read(
    families: &[Family],
    places: &[Vec<GrayImage>],
) -> Result<Vec<Vec<Vec<u64>>>, OptionsError> {
    let pipeline = Pipeline::new(families, Options::default())?;
    let mut codes = vec![vec![Vec::new(); places.len()]; families.len()];
    let bar = bar(places.iter().map(Vec::len).sum(), "pictures");
    for (place, pictures) in places.iter().enumerate() {
        for picture in pictures {
            for (family, code) in read_variants(&pipeline, picture) {
                codes[family][place].push(code);
            }
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    Ok(codes)
}

fn read_variants(pipeline: &Pipeline, picture: &GrayImage) -> impl Iterator<Item = (usize, u64)> {
    let variants =
        SCALES.into_iter().flat_map(|scale| TURNS_DEG.into_iter().map(move |turn_deg| (scale, turn_deg)));
    variants
        .filter_map(|(scale, turn_deg)| variant(picture, scale, turn_deg))
        .flat_map(|picture| pipeline.read_codes(&picture))
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::Luma;

    /// A white frame on a dark wall: to families whose border is white inside a tag of nothing but black bits.
    fn frame() -> GrayImage {
        let is_within = |at: u32, edge: u32| (edge..360 - edge).contains(&at);
        GrayImage::from_fn(360, 360, |x, y| match is_within(x, 140) && is_within(y, 140) {
            true if !is_within(x, 156) || !is_within(y, 156) => Luma([220]),
            _ => Luma([40]),
        })
    }

    #[test]
    fn a_frame_is_read_at_every_size_and_rotation_and_a_plain_wall_nowhere() {
        let families = ["tagCircle21h7", "tagStandard41h12"].map(|name| Family::published(name).unwrap());
        let wall = GrayImage::from_pixel(160, 160, Luma([90]));
        let codes = read(&families, &[vec![wall], vec![frame(), frame()]]).unwrap();
        for codes in &codes {
            assert!(codes[0].is_empty());
            let black = codes[1].iter().filter(|&&code| code == 0).count();
            assert_eq!(black, 2 * SCALES.len() * TURNS_DEG.len());
        }
    }
}
