//! Who plays in a scene: the tags, their ids, their regions and their ways.

use crate::config::{SceneConfig, SceneError};
use crate::orbit::{Orbit, regions_for};
use crate::random::{Stream, key_for};
use crate::tag::Tag;
use tagbus_family::Family;

/// A tag with its way through the picture.
pub(crate) struct Actor {
    pub tag: Tag,
    pub orbit: Orbit,
    pub black: f32,
    pub white: f32,
}

/// Chooses the tags and gives each its region, its way and its grey levels.
pub(crate) fn cast(config: &SceneConfig) -> Result<Vec<Actor>, SceneError> {
    let mut stream = Stream::new(key_for(config.seed, 3));
    let mut taken = Vec::new();
    let tags = config.families.iter().map(|names| choose_tag(names, &mut stream, &mut taken));
    let tags = tags.collect::<Result<Vec<Tag>, SceneError>>()?;
    let regions = regions_for(&tags, config.width, config.height);
    let actors = tags.into_iter().zip(regions).map(|(tag, region)| Actor {
        orbit: Orbit::new(&tag, region, &mut stream),
        tag,
        black: stream.between(25.0, 45.0) as f32,
        white: stream.between(195.0, 220.0) as f32,
    });
    Ok(actors.collect())
}

/// A tag of the family named, or a nest of tags when there are several names.
fn choose_tag(names: &str, stream: &mut Stream, taken: &mut Vec<(String, u32)>) -> Result<Tag, SceneError> {
    let (outer, inner) = match names.split_once('/') {
        Some((outer, inner)) => (outer, Some(inner)),
        None => (names, None),
    };
    let family = Family::published(outer.trim()).map_err(SceneError::Family)?;
    let tag = Tag::new(&family, choose_id(&family, stream, taken)).map_err(SceneError::Tag)?;
    match inner {
        Some(inner) => tag.nest(choose_tag(inner, stream, taken)?).map_err(SceneError::Tag),
        None => Ok(tag),
    }
}

/// A random id that no other tag of the family has, as long as there are enough.
fn choose_id(family: &Family, stream: &mut Stream, taken: &mut Vec<(String, u32)>) -> u32 {
    let count = family.codes().len() as u32;
    let first = stream.below(u64::from(count)) as u32;
    let is_free = |id: &u32| !taken.iter().any(|(name, other)| name == family.name() && other == id);
    let id = (0..count).map(|step| (first + step) % count).find(is_free).unwrap_or(first);
    taken.push((family.name().to_owned(), id));
    id
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tag::{TagError, TrueTag};

    fn showing(families: &[&str]) -> SceneConfig {
        SceneConfig {
            families: families.iter().map(|&name| name.to_owned()).collect(),
            ..SceneConfig::default()
        }
    }

    fn truth_of(actors: &[Actor]) -> Vec<TrueTag> {
        const PLACE: [f64; 9] = [9.0, 0.0, 20.0, 0.0, 9.0, 20.0, 0.0, 0.0, 1.0];
        actors.iter().flat_map(|actor| actor.tag.truth(&PLACE, 40, 40)).collect()
    }

    #[test]
    fn the_tags_of_a_family_have_different_ids() {
        let actors = cast(&showing(&["tag16h5"; 30])).unwrap();
        let mut ids: Vec<u32> = truth_of(&actors).iter().map(|tag| tag.id).collect();
        ids.sort_unstable();
        assert_eq!(ids, (0..30).collect::<Vec<u32>>());
    }

    #[test]
    fn nested_names_make_nested_tags() {
        let actors = cast(&showing(&["tagCustom48h12/Custom48h12/36h11"])).unwrap();
        let truth = truth_of(&actors);
        let names: Vec<&str> = truth.iter().map(|tag| tag.family.as_str()).collect();
        assert_eq!(names, ["tagCustom48h12", "tagCustom48h12", "tag36h11"]);
    }

    #[test]
    fn families_that_do_not_exist_and_nests_that_do_not_fit_are_refused() {
        assert!(matches!(cast(&showing(&["tag36h12"])).err().unwrap(), SceneError::Family(_)));
        assert!(matches!(cast(&showing(&[""])).err().unwrap(), SceneError::Family(_)));
        let refused = cast(&showing(&["tag36h11/tag16h5"])).err().unwrap();
        assert_eq!(refused, SceneError::Tag(TagError::NoHole { family: "tag36h11".to_owned() }));
    }
}
