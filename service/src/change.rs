//! From a change that somebody asks for to the parameters that would be in force then, or to what is wrong with it.

use tagbus_detector::Decimation;
use tagbus_family::{Family, nearest_name};
use tagbus_message::control::{DetectorChange, DetectorParameters};

use crate::in_force::{self, Wish};
use crate::region;

/// The longest list of ids that is taken: more than any family has.
const MOST_IDS: u64 = 1 << 20;

/// What a change is judged by.
pub(crate) struct Circumstances<'a> {
    /// Families that the detector was started with, which may be the user's own.
    pub(crate) own_families: &'a [Family],
    /// Width and height of the last frame.
    pub(crate) frame_size: Option<(u32, u32)>,
}

/// The parameters in force with the change made. The error names the value and what is allowed.
pub(crate) fn apply(
    change: &DetectorChange,
    now: &Wish,
    circumstances: &Circumstances,
) -> Result<Wish, String> {
    let mut wish = now.clone();
    let settings = &mut wish.settings;
    if let Some(factor) = change.decimation {
        settings.decimation =
            Decimation::from_factor(f64::from(factor)).map_err(|error| error.to_string())?;
    }
    settings.sampling = change.sampling.map_or(settings.sampling, in_force::sampling);
    settings.search = change.search.map_or(settings.search, in_force::search);
    settings.refinement = change.refinement.map_or(settings.refinement, in_force::refinement);
    settings.threads = change.threads.map_or(settings.threads, |threads| threads as usize);
    settings.hamming = change.hamming.unwrap_or(settings.hamming);
    settings.sharpening = change.sharpening.unwrap_or(settings.sharpening);
    settings.min_margin = change.min_margin.unwrap_or(settings.min_margin);
    if let Some(ranges) = &change.ids {
        settings.ids = single_ids(ranges)?;
    }
    if let Some(names) = &change.families {
        wish.families = families(names, circumstances.own_families)?;
    }
    if let Some(wanted) = change.region {
        let refusal =
            wanted.zip(circumstances.frame_size).and_then(|(wanted, size)| region::refusal(wanted, size));
        match refusal {
            Some(text) => return Err(text),
            None => wish.region = wanted,
        }
    }
    Ok(wish)
}

fn single_ids(ranges: &[(u32, u32)]) -> Result<Vec<u32>, String> {
    let count: u64 = ranges.iter().map(|&(first, last)| u64::from(last - first) + 1).sum();
    if count > MOST_IDS {
        return Err(format!("{count} ids, but at most {MOST_IDS} are taken"));
    }
    Ok(ranges.iter().flat_map(|&(first, last)| first..=last).collect())
}

fn families(names: &[String], own: &[Family]) -> Result<Vec<Family>, String> {
    let mut found: Vec<Family> = Vec::new();
    for name in names {
        let family = family(name, own)?;
        if found.iter().any(|other| other.name() == family.name()) {
            return Err(format!(
                "family {} is named twice: detections could not be told apart",
                family.name()
            ));
        }
        found.push(family);
    }
    Ok(found)
}

fn family(name: &str, own: &[Family]) -> Result<Family, String> {
    if let Some(family) = own.iter().find(|family| family.name() == name) {
        return Ok(family.clone());
    }
    Family::published(name).map_err(|unknown| {
        let own: Vec<&str> = own.iter().map(Family::name).collect();
        let known: Vec<&str> = own.iter().copied().chain([unknown.nearest]).collect();
        let nearest = nearest_name(name, &known).unwrap_or(unknown.nearest);
        format!(
            "unknown family \"{name}\", did you mean {nearest}? a running detector knows the published families and those it was \
             started with ({})",
            own.join(", ")
        )
    })
}

/// Says where fewer bits are corrected than was asked for, and why; empty where all is as asked.
pub(crate) fn remarks(wish: &Wish) -> String {
    let asked = wish.settings.hamming.unwrap_or(0);
    let capped = wish.families.iter().filter(|family| asked > family.correctable());
    let remark = |family: &Family| {
        let (name, distance, most) = (family.name(), family.distance(), family.correctable());
        format!("{name} corrects {most} bits, not {asked}: its tags differ in {distance} bits")
    };
    capped.map(remark).collect::<Vec<_>>().join("; ")
}

/// What differs, as "decimate 2 -> 4, ids all -> 1-20".
pub(crate) fn difference(before: &DetectorParameters, after: &DetectorParameters) -> String {
    let pairs = before.named().into_iter().zip(after.named());
    let differing = pairs.filter(|((_, before), (_, after))| before != after);
    let words = differing.map(|((name, before), (_, after))| format!("{name} {before} -> {after}"));
    let words: Vec<String> = words.collect();
    if words.is_empty() { "everything is as it was".to_owned() } else { words.join(", ") }
}
