//! A data set as files: one PNG a frame and one table of truth.

use std::path::Path;

use image::{ExtendedColorType, ImageFormat};
use serde_json::{Value, json};

use super::recipe::Bin;
use super::render::{Frame, Renderer};

/// Writes the first `count` frames and `truth.json` into the folder, which is made where it is missing.
pub(crate) fn write(
    renderer: &Renderer,
    count: usize,
    folder: &Path,
) -> Result<(), Box<dyn std::error::Error>> {
    std::fs::create_dir_all(folder)?;
    let mut frames = Vec::with_capacity(count);
    for index in 0..count {
        let frame = renderer.frame(index)?;
        let file = format!("{}-{index:05}.png", renderer.family().name());
        let (width, height) = (frame.picture.width as u32, frame.picture.height as u32);
        let path = folder.join(&file);
        image::save_buffer_with_format(
            path,
            &frame.picture.luma,
            width,
            height,
            ExtendedColorType::L8,
            ImageFormat::Png,
        )?;
        frames.push(truth(&file, &frame));
    }
    let recipe = renderer.recipe();
    let page = json!({
        "set": recipe.name,
        "about": recipe.about,
        "coordinates": "pixels, (0, 0) is the top-left corner of the top-left pixel; corners: bottom-left, bottom-right, \
                        top-right, top-left of the upright tag's border edge",
        "frames": frames,
    });
    let path = folder.join(format!("truth-{}.json", renderer.family().name()));
    Ok(std::fs::write(path, serde_json::to_string_pretty(&page)?)?)
}

/// One line a frame: what is in it and a hash of its pixels, to see whether two machines render the same.
pub(crate) fn list(renderer: &Renderer, count: usize) -> Result<String, Box<dyn std::error::Error>> {
    let mut text = String::new();
    for index in 0..count {
        let frame = renderer.frame(index)?;
        let tags: Vec<String> =
            frame.truth.iter().map(|tag| format!("{} {:.1?}", tag.id, tag.corners)).collect();
        let Bin { distance_cm, tilt_deg } = frame.bin;
        let hash = frame.hash();
        let name = renderer.family().name();
        text += &format!(
            "{name} {index}: {distance_cm} cm, {tilt_deg} degrees, {hash:016x}, {}\n",
            tags.join(", ")
        );
    }
    Ok(text)
}

fn truth(file: &str, frame: &Frame) -> Value {
    let tags: Vec<Value> = frame
        .truth
        .iter()
        .map(|tag| {
            json!({
                "family": tag.family, "id": tag.id, "corners": tag.corners, "homography": tag.homography,
                "cell_px": tag.cell_px,
            })
        })
        .collect();
    json!({
        "file": file, "distance_cm": frame.bin.distance_cm, "tilt_deg": frame.bin.tilt_deg, "tags": tags,
    })
}
